"""Every function that takes a Solution takes a result that one state stands for, and says what to give for others."""

import warnings
from dataclasses import replace

import numpy as np
import pytest

import skancf as sk
from skancf import output
from skancf.errors import OutOfDepth, SkancfError
from skancf.output.rendering import check_rendering
from skancf.solving import Status
from skancf.statics.newton import OPEN

TIP = (1.0, 0.5)
SURFACE = sk.Rectangle(1.0, 1.0)
PROBLEM = sk.Problem(
    SURFACE, 0.02, sk.Isotropic(1e7, 0.3, 1e3), [sk.Clamp("left")], [sk.EdgeLoad("right", (-1.0, 0.0, 0.2))]
)


@pytest.fixture(scope="module")
def system():
    return PROBLEM.on(sk.meshes.quadtree(sk.meshes.uniform(SURFACE, 2, 2)), theory="kirchhoff")


@pytest.fixture(scope="module")
def results(system):
    """Results with the state that each stands for."""
    static, path = sk.solve(system), sk.trace(system, until=1.0)
    adaptive = sk.adapt(PROBLEM, sk.Displacement(TIP), rtol=0.5, mesh=system.mesh)
    assert adaptive.ok and len(path.solutions) > 1
    return {"static": (static, static.solution), "path": (path, path.solution), "adaptive": (adaptive, adaptive.solution)}


def on_finer(state):
    return PROBLEM.on(state.system.mesh.refined(), theory="kirchhoff")


def file_of(write):
    """What a function writes."""

    def asked(state, given, folder):
        return write(given, folder).read_bytes()

    return asked


def vtu(given, folder):
    return output.write(given, folder / "state.vtu", subdivisions=1)


def picture(given, folder):
    return output.picture(given, folder / "state.png", size=(80, 60))


def plot(state, given, folder):
    plotter = output.plot(given, off_screen=True, size=(80, 60))
    points = max((mesh.points for mesh in plotter.meshes), key=len)
    plotter.close()
    return points


TIPS = sk.Displacement(TIP)
FUNCTIONS = {
    "sample": lambda state, given, folder: output.sample(given, 2).points,
    "write": file_of(vtu),
    "picture": file_of(picture),
    "plot": plot,
    "nodal_measure": lambda state, given, folder: sk.nodal_measure(given, z="top"),
    "stress_indicator": lambda state, given, folder: sk.stress_indicator(given, z="top"),
    "stress_regions": lambda state, given, folder: np.array([r.ratio for r in sk.stress_regions(given, z="top")]),
    "recovery_indicator": lambda state, given, folder: sk.recovery_indicator(given),
    "residual_indicator": lambda state, given, folder: sk.residual_indicator(given),
    "goal_estimate": lambda state, given, folder: sk.goal_estimate(given, TIPS).error,
    "theory_error": lambda state, given, folder: sk.theory_error(given, TIPS).value,
    "transfer": lambda state, given, folder: sk.transfer(given, on_finer(state)).q,
    "remap": lambda state, given, folder: sk.remap(given, on_finer(state)).q,
    "value of a quantity": lambda state, given, folder: sk.StrainEnergy().value(given),
    "gradient of a quantity": lambda state, given, folder: TIPS.gradient(given),
    "value of a reaction": lambda state, given, folder: sk.Reaction("left").value(given),
    "start of solve": lambda state, given, folder: sk.solve(state.system, load_factor=1.1, start=given).solution.q,
    "start of trace": lambda state, given, folder: sk.trace(state.system, until=1.2, start=given).solution.q,
    "start of simulate": lambda state, given, folder: (
        sk.simulate(state.system, 2e-3, dt=1e-3, start=given, progress=False).q
    ),
    "state of modes": lambda state, given, folder: sk.modes(state.system, 2, state=given).frequencies,
}


def drawn(name: str) -> None:
    if name in ("picture", "plot"):
        try:
            check_rendering()
        except SkancfError:
            pytest.skip("this machine cannot draw")


@pytest.mark.filterwarnings("ignore::skancf.errors.OutOfDepth")
@pytest.mark.parametrize("kind", ["static", "path", "adaptive"])
@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_result_is_its_state(name, kind, results, tmp_path):
    drawn(name)
    result, state = results[kind]
    if kind == "path" and name == "write":
        return  # the whole path is written, see below
    asked = FUNCTIONS[name]
    first, second = asked(state, result, tmp_path), asked(state, state, tmp_path)
    same = first == second if isinstance(first, bytes) else np.allclose(first, second, rtol=1e-9, atol=1e-12)
    assert same


def failed(static):
    attempts = static.attempts
    return replace(static, status=Status.DIVERGED, message="newton: the residual grew.", attempts=attempts)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_result_that_did_not_arrive_is_refused_with_its_message(name, results, tmp_path):
    static, state = results["static"]
    with pytest.raises(
        sk.InputError, match=r"this StaticResult did not arrive: newton: the residual grew\. Give its \.solution"
    ):
        FUNCTIONS[name](state, failed(static), tmp_path)


@pytest.mark.filterwarnings("ignore::skancf.errors.OutOfDepth")
@pytest.mark.parametrize("name", FUNCTIONS)
def test_results_of_several_states_are_refused_with_a_way_to_choose(name, system, results, tmp_path):
    state = results["static"][1]
    motion = sk.simulate(system, 2e-3, dt=1e-3, progress=False)
    several = {
        r"modes\.shape\(0\)": sk.modes(system, 2), r"result\.shape\(0\)": sk.buckling(system, 1),
        r"motion\.at\(0\.002\)": motion,
    }  # fmt: skip
    if name == "write":
        del several[r"motion\.at\(0\.002\)"]  # all states of a motion are written
    for way, result in several.items():
        with pytest.raises(sk.InputError, match=way):
            FUNCTIONS[name](state, result, tmp_path)


def test_an_adaptive_result_that_is_not_accurate_warns(results):
    adaptive, state = results["adaptive"]
    short = replace(adaptive, status=Status.BUDGET, message="more unknowns than max_dofs")
    with pytest.warns(OutOfDepth, match="not as accurate as asked: more unknowns than max_dofs"):
        assert sk.StrainEnergy().value(short) == sk.StrainEnergy().value(state)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert sk.StrainEnergy().value(adaptive) == sk.StrainEnergy().value(state)


def test_rounding_that_leaves_little_open_warns_as_unwrap_does(results):
    static, state = results["static"]
    (factor, last), *_ = static.attempts[::-1]
    open_ = replace(static, status=Status.ROUNDING, message="rounding", attempts=((factor, replace(last, bound=OPEN / 2)),))
    with pytest.warns(OutOfDepth, match="rounding"):
        assert sk.StrainEnergy().value(open_) == sk.StrainEnergy().value(state)


def test_motions_and_paths_are_written_and_drawn_whole(system, results, tmp_path):
    path = results["path"][0]
    motion = sk.simulate(system, 2e-3, dt=1e-3, outputs=3, progress=False)
    for name, result, n in (("motion", motion, 3), ("path", path, len(path.solutions))):
        output.write(result, tmp_path / f"{name}.pvd", subdivisions=1)
        assert len(output.read(tmp_path / f"{name}.pvd")) == n
    drawn("picture")
    assert output.animation(path, tmp_path / "path.gif", size=(80, 60)).stat().st_size > 0


def test_what_is_no_result_is_named():
    with pytest.raises(sk.InputError, match=r"state = 3: give a Solution"):
        sk.StrainEnergy().value(3)
    with pytest.raises(sk.InputError, match=r"this is the class StaticResult"):
        sk.StrainEnergy().value(sk.StaticResult)

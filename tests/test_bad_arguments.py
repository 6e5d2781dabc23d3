"""Ordinary mistakes in every argument of every public function: named by an error of the library, never a raw exception.

Surfaces, supports and loads are used too, on a mesh: what is wrong with a function or a place shows only there.
"""

import inspect
from typing import Any

import numpy as np
import pytest
from mistakes import Call, Fault, Scene, answer, calls, fault, faults, mistakes, parameters

import skancf as sk
from skancf.output.style import Style

LEAST = 1500


@pytest.fixture(autouse=True)
def elsewhere(tmp_path, monkeypatch) -> None:
    """Names of files and folders by mistake are those of a folder that nobody misses."""
    monkeypatch.chdir(tmp_path)


@pytest.fixture(scope="module")
def scene(tmp_path_factory) -> Scene:
    return Scene(tmp_path_factory.mktemp("mistakes"))


def test_every_mistake_is_named(scene, capsys):
    number, wrong = faults(scene)
    assert number > 10 * LEAST
    assert not wrong, "\n".join(map(str, wrong))


def test_valid_calls_succeed(scene, capsys):
    for name, call in calls(scene).items():
        _, error = answer(call)
        assert error is None, f"{name}: {error!r}"


ELSEWHERE = {
    # Results, which the library makes.
    "AdaptiveResult", "BucklingResult", "Check", "Ledger", "Modes", "Motion", "PathResult", "Progress", "RemapChange",
    "Remapped", "Spectrum", "TheoryError", "StaticResult", "Samples", "MeshQuadTree", "Status", "Envelope", "Utilisation",
    "CalculixDeck", "Printed",
    "FileRun", "ProblemFile", "StoredFields", "StoredState",
    # Without arguments.
    "info", "AllElements", "EnergyMomentum", "ImplicitMidpoint", "Never", "StrainEnergy", "Trapezoidal", "ElementQuadANCF",
    "ElementQuadHermite", "Plane",
    # Its functions are asked on a mesh, see test_forms.py.
    "FormTerm",
    # By the arguments of Style.
    "picture", "animation",
    # It opens windows, from the arguments of write_html.
    "view",
}  # fmt: skip


def qualified_name(call: Call) -> str:
    return getattr(call.function, "__qualname__", type(call.function).__name__ + ".__call__")


def test_no_public_function_is_left_out(scene):
    tried = {qualified_name(call).split(".")[0] for call in calls(scene).values()}
    for room in (sk, sk.meshes, sk.output, sk.storage, sk.export):
        for name in room.__all__:
            public = getattr(room, name)
            if not callable(public) or (isinstance(public, type) and issubclass(public, Exception)):
                continue
            assert name in tried | ELSEWHERE, f"{name}: give it a valid call in tests/mistakes.py"


def test_no_argument_is_left_out(scene):
    """Of functions; of methods those that are called, by all names that they have."""
    given: dict[str, set[str]] = {}
    known: dict[str, set[str]] = {}
    for call in calls(scene).values():
        name = qualified_name(call)
        given.setdefault(name, set()).update(call.arguments)
        known[name] = parameters(call.function)
    left = {name: known[name] - given[name] for name in known}
    allowed = {"simulate": {"rho_inf"}, "find_regions": set()}
    assert {n: a - allowed.get(n, set()) for n, a in left.items() if a - allowed.get(n, set())} == {}


# ---------------------------------------------------------------------------------- the search itself can find something


def loose(n: int = 1, at: tuple[float, float] = (0.0, 0.0)) -> float:
    """A function with the faults that are looked for."""
    return float("nan") if float(n) < 0 else float(n) * at[0]


@pytest.mark.parametrize(
    ("mistake", "what"),
    [("none", "raw TypeError"), ("text", "was taken"), ("inf", "was taken"), ("minus", "not finite"), ("half", None)],
)
def test_the_search_finds(scene, mistake, what):
    call = Call(loose, {"n": 1, "at": (1.0, 1.0)}, kinds={"n": "number"})
    found = fault("loose", call, "n", mistake, mistakes(scene)[mistake])
    assert (found is None) is (what is None)
    assert what is None or what in found.what


def test_a_message_must_name_the_argument(scene):
    def unnamed(n: int) -> None:
        raise sk.InputError("something is wrong with it")

    found = fault("unnamed", Call(unnamed, {"n": 1}), "n", "none", None)
    assert isinstance(found, Fault)
    assert "does not name" in found.what


def test_what_a_user_s_function_raises_must_come_with_a_note(scene):
    def noted(history: Any) -> None:
        try:
            history()
        except Exception as wrong:
            wrong.add_note("raised by the function given as history")
            raise

    raises = mistakes(scene)["raises"]
    assert fault("noted", Call(noted, {"history": abs}), "history", "raises", raises) is None
    found = fault("bare", Call(lambda history: history(), {"history": abs}), "history", "raises", raises)
    assert found is not None
    assert "OwnFault" in found.what


# ------------------------------------------------------------------------------------------- what a message should say


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda s: sk.modes(s.system, state=s.modes), r"state: modes .*modes\.shape\(0\)"),
        (lambda s: sk.solve(s.problem), r"system = .*problem\.on\(mesh\)"),
        (lambda s: sk.solve(s.solution), r"system = .*has one as its \.system"),
        (lambda s: sk.solve(sk.Problem), r"system = .*class Problem"),
        (lambda s: s.problem.on(s.system), r"mesh = .*has one as its \.mesh"),
        (lambda s: sk.recovery_indicator(s.system), r"solution = .*"),
        (lambda s: sk.adapt(s.system, sk.Displacement((0.5, 0.5))), r"problem = .*has one as its \.problem"),
        (lambda s: sk.Isotropic("0.01", 0.3, 1.0), r"young = '0\.01': not a number, but text"),
        (lambda s: sk.Isotropic(1e6, 0.3, np.ma.array(1.0, mask=True)), "density.*masked"),
        (lambda s: sk.Isotropic(10**400, 0.3, 1.0), "young = 1000.*too large"),
        (lambda s: sk.simulate(s.system, 1.0, velocity=sk.RigidVelocity), "velocity"),
        (lambda s: sk.output.picture(s.system, s.folder / "p.png"), "solution = .*"),
        (lambda s: sk.output.animation(s.solution, s.folder / "p.gif"), "states = .*motion.states"),
        (lambda s: sk.output.animation([s.system], s.folder / "p.gif"), "solution = .*"),
        (lambda s: Style(size=(10**6, 10)), "size = .*16384"),
        (lambda s: sk.output.read(b"kept.vtu"), "file = b'kept.vtu'"),
        (lambda s: sk.meshes.load("a\0b"), "no path"),
        (lambda s: s.solution.reactions("lefft"), r"where = 'lefft': no boundary 'lefft' on this mesh; it has .*'left'"),
        (lambda s: s.solution.reactions(["left", None]), r"where = \['left', None\]: place None: give the name"),
        (lambda s: s.solution.reactions(np.array(1.0)), r"where = array\(1\.\): place"),
        (lambda s: s.solution.reactions(lambda x, y: x), r"where = .*must return True or False"),
        (lambda s: sk.SurfaceLoad(sk.Ramp), "force = <class .*Ramp"),
        (lambda s: sk.Cone(1.0, 2.0, 1.0, 1.0, start=1e12), "start = 1000000000000.0, angle = 1.0"),
        (lambda s: sk.meshes.uniform(sk.Rectangle(1e12, 1.0), 2, 2), r"length_x=1000000000000\.0.*span 1e\+12 by 1"),
    ],
)  # fmt: skip
def test_messages_name_value_and_way_out(scene, call, says):
    with pytest.raises(sk.InputError, match=f"(?s){says}"):
        call(scene)


def test_numbers_of_many_kinds_are_numbers():
    """What is refused is text, not exactness: fractions, decimals, small floats and integers of numpy."""
    from decimal import Decimal
    from fractions import Fraction

    for one in (1, 1.0, Fraction(2, 2), Decimal("1.0"), np.float32(1), np.int8(1), np.array(1.0)):
        assert sk.Ramp(one).duration == one
    assert sk.meshes.Region([Fraction(1, 2), 0], np.ones(2)).centre == [0.5, 0]


@pytest.mark.parametrize("value", [None, "1", [1.0, 2.0], float("nan"), 1j])
def test_a_history_that_gives_no_number(scene, value):
    def history(time: float) -> Any:
        return value

    pulled = sk.Problem(scene.surface, 0.01, scene.material, [sk.Clamp("left")], [sk.Gravity(history=history)])
    motion = None
    with pytest.raises(sk.InputError, match="history at t = 0"):
        motion = sk.simulate(pulled.on(scene.mesh, "kirchhoff"), 0.01, dt=0.01, progress=False)
    assert motion is None


def test_unexpected_names_are_python_s_own_error(scene):
    with pytest.raises(TypeError, match="loadfactor"):
        sk.solve(scene.system, loadfactor=1.0)
    with pytest.raises(TypeError, match="'radus'"):
        sk.stress_regions(scene.solution, radus=1.0)
    assert "radius" in inspect.signature(sk.find_regions).parameters

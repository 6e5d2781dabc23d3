"""Too large for the memory, too many, too small, too large to compute with: refused before any work, within a second."""

import math
import time
import tracemalloc

import numpy as np
import pytest
import skfem

import skancf as sk
from skancf import memory
from skancf.output.style import Style
from skancf.theories import theory_named

GIGABYTE = 10**9
SURFACE = sk.Rectangle(1.0, 1.0)
REGION = sk.meshes.Region((0.5, 0.5), (0.1, 0.1))


def cantilever(length=1.0, young=1e7, density=1e3, thickness=0.02, force=1e-6, **mesh):
    """A square plate held along a side, with a force at a corner, all in proportion to the units of length and stress."""
    surface = sk.Rectangle(length, length)
    problem = sk.Problem(
        surface, thickness * length, sk.Isotropic(young, 0.3, density), [sk.Clamp("left")],
        [sk.PointForce((length, length), (0.0, 0.0, force * young * length**2))],
    )  # fmt: skip
    return problem.on(sk.meshes.quadtree(sk.meshes.uniform(surface, 2, 2)), mesh.get("theory", "kirchhoff"))


@pytest.fixture(scope="module")
def system():
    return cantilever()


@pytest.fixture
def little(monkeypatch):
    """A machine with a gigabyte."""
    monkeypatch.setattr(memory, "available", lambda: GIGABYTE)


def tree(n=2):
    return sk.meshes.quadtree(sk.meshes.uniform(SURFACE, n, n))


TIMES = np.linspace(0.0, 1.0, 1000)
TOO_MUCH = {
    "uniform": lambda s: sk.meshes.uniform(SURFACE, 4000, 2500),
    "uniform, astronomical": lambda s: sk.meshes.uniform(SURFACE, 10**14, 10**14),
    "uniform with openings": lambda s: sk.meshes.uniform(SURFACE, 10**5, 10**5, openings=[((0.0, 0.5), (0.0, 0.5))]),
    "tensor": lambda s: sk.meshes.tensor(SURFACE, np.linspace(0, 1, 10**4), np.linspace(0, 1, 10**4)),
    "graded by nodes": lambda s: sk.meshes.graded(SURFACE, [REGION], nodes=10**9),
    "graded by shape": lambda s: sk.meshes.graded(SURFACE, [REGION], shape=(10**6, 10**3)),
    "graded by length": lambda s: sk.meshes.graded(SURFACE, [REGION], coarse=1e-9),
    "refined in, levels": lambda s: sk.meshes.refined_in(tree(), [REGION], levels=18),
    "refined in, length": lambda s: sk.meshes.refined_in(tree(), [REGION], coarse=1e-6),
    "refined": lambda s: tree().refined(12),
    "refined again": lambda s: tree(60).refined(3).refined(np.arange(100_000)),
    "progression": lambda s: sk.meshes.progression(1e-12, 1e-12, 1.0),
    "a mesh of the user": lambda s: s.problem.on(skfem.MeshQuad.init_tensor(*2 * (np.linspace(0, 1, 401),)), "full"),
    "outputs": lambda s: sk.simulate(s, 1.0, outputs=10**8, progress=False),
    "steps": lambda s: sk.simulate(s, 1.0, dt=1e-9, progress=False),
    "short steps": lambda s: sk.simulate(s, 1.0, steps=sk.LocalError(largest=1e-12), progress=False),
    "spectrum": lambda s: sk.spectrum(TIMES, TIMES**2, padding=10**6),
    "points of a picture": lambda s: sk.output.sample(sk.Solution(s, s.undeformed), 10**4),
}


@pytest.mark.parametrize("what", TOO_MUCH)
def test_what_does_not_fit_is_refused_at_once(what, system, little):
    begun = time.process_time()
    with pytest.raises(sk.NotEnoughMemory, match=r"needs [\d.e+]+ GB, and 1 GB are available; \w+"):
        TOO_MUCH[what](system)
    assert time.process_time() - begun < 1.0


def test_with_enough_memory_the_same_is_made(monkeypatch):
    """The bound is what is measured, to half: not a guard that refuses what would fit."""
    for n, theory in ((40, "kirchhoff"), (40, "full")):
        needed = n * n * theory_named(theory).bytes_per_element
        problem = cantilever().problem
        mesh = sk.meshes.uniform(SURFACE, n, n)
        monkeypatch.setattr(memory, "SMALL", 0)
        monkeypatch.setattr(memory, "available", lambda needed=needed: needed - 1)
        with pytest.raises(sk.NotEnoughMemory, match=f"{n * n} elements"):
            problem.on(mesh, theory)
        monkeypatch.setattr(memory, "available", lambda needed=needed: 40 * needed)
        assert problem.on(mesh, theory).n_dofs == 12 * (n + 1) ** 2
        monkeypatch.undo()


@pytest.mark.parametrize("theory", ["kirchhoff", "full"])
def test_memory_of_a_set_up_is_what_is_predicted(theory):
    """The peak of what is allocated, within two thirds and three halves of the prediction."""
    problem, n = cantilever().problem, 60
    problem.on(sk.meshes.uniform(SURFACE, 2, 2), theory)
    tracemalloc.start()
    try:
        problem.on(sk.meshes.uniform(SURFACE, n, n), theory)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert 2 / 3 < peak / (n * n * theory_named(theory).bytes_per_element) < 3 / 2


def test_elements_of_many_shapes_need_more(monkeypatch):
    """Each has a law of its own while a system of theory 'full' is set up."""
    rng = np.random.default_rng(3)
    x = np.concatenate([[0.0], np.cumsum(rng.uniform(0.5, 1.5, 30))])
    mesh, problem = sk.meshes.tensor(SURFACE, x / x[-1], x / x[-1]), cantilever().problem
    monkeypatch.setattr(memory, "available", lambda: 10**8)
    with pytest.raises(sk.NotEnoughMemory, match=r"900 elements of different shapes.*uniform"):
        problem.on(mesh, "full")
    assert problem.on(sk.meshes.uniform(SURFACE, 30, 30), "full").n_dofs == 12 * 31**2


@pytest.mark.parametrize("size", [(10**5, 10), (10, 10**9), (0, 10), (10.5, 10), (10,)])
def test_pictures_have_a_size_that_can_be_drawn(size):
    with pytest.raises(sk.InputError, match="size"):
        Style(size=size)


def test_modes_as_many_as_there_are(system):
    with pytest.raises(sk.InputError, match=r"n = 1000000.* at most the"):
        sk.modes(system, 10**6)


# ------------------------------------------------------------------------------------------ very small and very large


@pytest.mark.parametrize("theory", ["kirchhoff", "full"])
@pytest.mark.parametrize(
    "units", [{"length": 1e-24}, {"length": 1e11}, {"young": 1e67}, {"young": 1e-60}, {"density": 1e-60}, {"density": 1e70}],
)  # fmt: skip
def test_units_do_not_matter(theory, units):
    """As far as numbers are taken at all, answers are the same in any unit: to 1e-6, the tolerance of Newton's method."""
    scale = {"length": 1.0, "young": 1e7, "density": 1e3} | units
    seconds = scale["length"] * math.sqrt(scale["density"] / scale["young"])

    def numbers(system, length, seconds):
        corner = (length, length)
        linear = sk.solve_linear(system)
        energy = linear.strain_energy / (system.problem.material.young * length**3)
        moved = [state.displacement(corner)[2] / length for state in (linear, sk.solve(system).unwrap())]
        return [*moved, energy, sk.modes(system, 1).frequencies[0] * seconds]

    plain = numbers(cantilever(theory=theory), 1.0, math.sqrt(1e3 / 1e7))
    assert numbers(cantilever(theory=theory, **scale), scale["length"], seconds) == pytest.approx(plain, rel=1e-6)
    assert min(plain) > 0


BEYOND = {
    "thickness = 1e\\+300": lambda: sk.Problem(SURFACE, 1e300, sk.Isotropic(1e7, 0.3, 1e3)),
    "thickness = 1e-300": lambda: sk.Problem(SURFACE, 1e-300, sk.Isotropic(1e7, 0.3, 1e3)),
    "thickness = 1e-30:.*bending stiffness": lambda: sk.Problem(SURFACE, 1e-30, sk.Isotropic(1e7, 0.3, 1e3)),
    "thickness = 1e\\+30:.*bending stiffness": lambda: sk.Problem(SURFACE, 1e30, sk.Isotropic(1e7, 0.3, 1e3)),
    "young = 1e\\+300": lambda: sk.Isotropic(1e300, 0.3, 1e3),
    "young = 1e-300": lambda: sk.Isotropic(1e-300, 0.3, 1e3),
    "membrane stiffness": lambda: sk.Problem(SURFACE, 1.0, sk.Isotropic(1e90, 0.3, 1e3)),
    "mass per area": lambda: sk.Problem(SURFACE, 1.0, sk.Isotropic(1e7, 0.3, 1e-90)),
    "density = 1e\\+300": lambda: sk.Isotropic(1e7, 0.3, 1e300),
    "matrix": lambda: sk.Anisotropic(1e200 * np.eye(6), 1.0),
    "extends over": lambda: cantilever(length=1e-26),
    "extends over 1e\\+13": lambda: cantilever(length=1e13),
    "t_end": lambda: sk.simulate(cantilever(), 1e300),
    "tolerance": lambda: sk.modes(cantilever(), tolerance=1e300),
    "rtol": lambda: sk.solve(cantilever(), rtol=1e-300),
    "load_factor": lambda: sk.solve(cantilever(), load_factor=1e300),
}


@pytest.mark.parametrize("rule", BEYOND)
def test_numbers_that_cannot_be_computed_with_are_refused(rule):
    with pytest.raises(sk.InputError, match=f"(?s){rule}.*give|{rule}.*units"):
        BEYOND[rule]()


@pytest.mark.parametrize("factor", [1e40, 1e99, -1e99])
@pytest.mark.parametrize("theory", ["kirchhoff", "full"])
def test_an_answer_that_overflows_says_so(theory, factor):
    """Absurd loads stretch the plate absurdly, which is an equilibrium of theory 'full'; squares of larger ones overflow."""
    system = cantilever(theory=theory, force=1e80)
    result = sk.solve(system, load_factor=factor)
    assert np.isfinite(result.solution.q).all()
    assert np.isfinite(result.solution.strain_energy)
    assert result.message
    if abs(factor) == 1e99:
        assert result.status.value != "converged"

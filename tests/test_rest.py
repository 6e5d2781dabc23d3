"""Assumed membrane strains leave motions to single elements that hardly cost energy; an answer that these rule says so."""

import warnings

import numpy as np
import pytest

import skancf as sk
from skancf.system.unstressed import unstressed

MATERIAL = sk.Isotropic(5e9, 0.3, 1000.0)
RING, PLATE, CONE = sk.AnnulusSector(0.5, 1.2, 1.3), sk.Rectangle(1.4, 1.0), sk.Cone(0.5, 1.0, 0.9, 1.1)
PLAIN = sk.Kirchhoff(assumed=False)


def answer(surface, supports, loads, h, n, theory="kirchhoff"):
    """The small-deflection answer and what it warns of."""
    problem = sk.Problem(surface, h, MATERIAL, supports, loads)
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        found = sk.solve_linear(problem.on(sk.meshes.uniform(surface, n, n), theory))
    return found, [w for w in said if "assumed ones" in str(w.message)]


CASES = {
    "a ring with a force per area in its plane": (RING, [sk.Clamp("outer")], [sk.SurfaceLoad((80.0, -50.0, 0.0))]),
    "a plate held by its corners": (PLATE, [sk.Pin("corners")], [sk.SurfaceLoad((80.0, -50.0, 0.0))]),
    "a cone under weight": (CONE, [sk.Clamp(CONE.sides[0])], [sk.SurfaceLoad((0.0, 0.0, -80.0))]),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_an_answer_that_is_far_too_soft_says_so(name):
    surface, supports, loads = CASES[name]
    converged, _ = answer(surface, supports, loads, 1e-3, 16, PLAIN)
    coarse, said = answer(surface, supports, loads, 1e-3, 2)
    assert coarse.strain_energy > 1.5 * converged.strain_energy
    assert len(said) == 1 and said[0].filename == __file__
    assert answer(surface, supports, loads, 1e-3, 2, PLAIN)[1] == answer(surface, supports, loads, 0.1, 2, "full")[1] == []


@pytest.mark.parametrize("h", [1e-2, 1e-5])
def test_good_answers_do_not(h):
    for surface, supports, loads in (
        (PLATE, [sk.Clamp("boundary")], [sk.SurfaceLoad((0.0, 0.0, -1.0))]),
        (PLATE, [sk.Clamp("left")], [sk.EdgeLoad("right", (1.0, 0.0, 0.0))]),
        (sk.CylinderSector(1.0, 1.4, 1.2), [sk.Clamp("left")], [sk.EdgeLoad("right", (1.0, 0.0, 0.0))]),
    ):
        converged, _ = answer(surface, supports, loads, h, 12, PLAIN)
        found, said = answer(surface, supports, loads, h, 4)
        assert said == [] and abs(found.strain_energy - converged.strain_energy) < 0.02 * converged.strain_energy
    # The ring again, on a mesh that is fine for its thickness.
    surface, supports, loads = CASES["a ring with a force per area in its plane"]
    converged, _ = answer(surface, supports, loads, 1e-2, 12, PLAIN)
    found, said = answer(surface, supports, loads, 1e-2, 6)
    assert said == [] and abs(found.strain_energy - converged.strain_energy) < 0.02 * converged.strain_energy


@pytest.mark.filterwarnings("ignore::skancf.OutOfDepth")
def test_the_share_is_what_the_stiffness_loses_without_the_rest():
    surface, supports, loads = CASES["a ring with a force per area in its plane"]
    found, _ = answer(surface, supports, loads, 4e-3, 3)
    system, u = found.system, found.change
    parts = system.assembly._elements
    whole = u @ (system.stiffness() @ u)
    system.assembly._elements = parts._replace(rest=np.zeros_like(parts.rest))
    without = u @ (unstressed(system) @ u)
    system.assembly._elements = parts
    assert found.rest_share > 0.05 and abs(found.rest_share - (1 - without / whole)) < 1e-6
    small = sk.solve(system, load_factor=1e-3, rtol=1e-9).solution
    assert abs(small.rest_share - found.rest_share) < 1e-3


def test_loads_that_do_no_work_have_no_share():
    found, said = answer(PLATE, [sk.Clamp("boundary")], [sk.EdgeMoment("left", (0.0, 0.0, 1e6))], 1e-3, 2)
    assert found.rest_share == 0.0 and said == []
    system = found.system
    assert sk.solve(system).solution.rest_share == 0.0

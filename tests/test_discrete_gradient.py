"""Forces between two states: they do the work of the stresses exactly and have no moment."""

import numpy as np
import pytest

import skancf as sk
from skancf.theories.kirchhoff import point

# Sums of some hundred products, relative to the sum of their sizes.
SUMS = 1e-12
UNIT = sk.Rectangle(1.0, 0.8)
PLY = sk.Orthotropic(young=(5e5, 1e5, 1e5), poisson=(0.2, 0.1, 0.3), shear=(6e4, 5e4, 4e4), density=2000.0)
LAWS = {
    "isotropic": (0.1, sk.Isotropic(2e5, 0.3, 2000.0)),
    "laminate": (None, sk.Laminate([sk.Layer(PLY, 0.06, 0.3), sk.Layer(PLY, 0.04, -1.1)], offset=0.01)),
}
CYLINDER = sk.CylinderSector(1.0, 1.5, 1.0)
MESHES = {
    "flat": (UNIT, sk.meshes.uniform(UNIT, 3, 2)),
    "curved": (CYLINDER, sk.meshes.uniform(CYLINDER, 2, 3)),
    "hanging nodes": (UNIT, sk.meshes.quadtree(sk.meshes.uniform(UNIT, 2, 2)).refined([0])),
}
bodies = pytest.mark.parametrize("body", MESHES)
laws = pytest.mark.parametrize("law", LAWS)
theories = pytest.mark.parametrize("theory", ["kirchhoff", "full", sk.Full(assumed=False)], ids=["thin", "full", "plain"])


# --- at a point ------------------------------------------------------------------------------------------------------


def jets(rng, amount=1.0, n=200):
    """Two states far from flat and from orthogonal, which differ by ``amount``."""
    jet = rng.normal(size=(5, 3, n))
    jet[0, 0] += 2
    jet[1, 1] += 2
    change = rng.normal(size=jet.shape)
    keep = np.linalg.norm(np.cross(jet[0], jet[1], axis=0), axis=0) > 0.5
    other = jet + amount * change
    keep &= np.linalg.norm(np.cross(other[0], other[1], axis=0), axis=0) > 0.5
    return jet[:, :, keep], other[:, :, keep]


def sums(gradient, jet):
    """What the gradients do on a change of the jet, and the sum of the sizes of the terms."""
    terms = gradient * jet
    return terms.sum(axis=(1, 2)), np.abs(terms).sum(axis=(1, 2))


@pytest.mark.parametrize("amount", [1.0, 1e-3, 1e-9])
def test_changes_of_the_strains_are_exact(amount, rng):
    one, two = jets(rng, amount)
    assert one.shape[2] > 100
    found, size = sums(point.discrete_gradient(one, two), two - one)
    exact = point.strain(two) - point.strain(one)
    # Strains of nearly equal states differ by rounding of their own size, however small their change is.
    assert np.abs(found - exact).max() < SUMS * max(size.max(), np.abs(point.strain(one)).max())
    middle, _ = sums(point.gradient(0.5 * (one + two)), two - one)
    if amount == 1.0:
        assert np.abs(middle - exact)[3:].max() > 1e-2 * np.abs(exact[3:]).max(), "the gradient in the middle does not do"
        assert np.abs(middle - exact)[:3].max() < SUMS * size.max(), "but for strains that are quadratic"


@pytest.mark.parametrize("amount", [1.0, 1e-3])
def test_forces_have_no_moment(amount, rng):
    one, two = jets(rng, amount)
    gradient = point.discrete_gradient(one, two)
    for axis in np.eye(3):
        turned = np.cross(axis[:, None], 0.5 * (one + two), axisb=1, axisa=0, axisc=1)
        found, size = sums(gradient, turned)
        assert np.abs(found).max() < SUMS * size.max()
    along_one, size = sums(gradient, np.cross(axis[:, None], one, axisb=1, axisa=0, axisc=1))
    assert np.abs(along_one).max() > 1e-5 * size.max(), "about one of the ends they have a moment"


def test_it_is_the_same_both_ways_and_the_gradient_of_equal_states(rng):
    one, two = jets(rng)
    there, back = point.discrete_gradient(one, two), point.discrete_gradient(two, one)
    assert np.abs(there - back).max() < SUMS * np.abs(there).max()
    assert np.abs(point.discrete_gradient(one, one) - point.gradient(one)).max() < SUMS * np.abs(there).max()
    # The middle is better by one order than either end, so that the rule has order two.
    one, _ = jets(rng)
    change, errors = rng.normal(size=one.shape), []
    for step in (1e-2, 5e-3):
        middle = point.gradient(one + 0.5 * step * change)
        errors.append(np.median(np.abs(point.discrete_gradient(one, one + step * change) - middle).max(axis=(0, 1, 2))))
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2, abs=0.1)


# --- of a system -----------------------------------------------------------------------------------------------------


def system_on(body, law, theory, supports=()):
    surface, mesh = MESHES[body]
    thickness, material = LAWS[law]
    return sk.Problem(surface, thickness, material, list(supports)).on(mesh, theory)


def two_states(system, rng, amount=0.05):
    return tuple(system.undeformed + amount * rng.normal(size=system.n_dofs) for _ in range(2))


@bodies
@laws
def test_compiled_thin_forces_are_those_of_the_plain_twin(body, law, rng):
    """f . u is the sum of stress times discrete gradient times the jets of u, for any u."""
    system = system_on(body, law, "kirchhoff")
    geometry, points = system.geometry, system.geometry.theory.quadrature[0]

    def jet(q):
        return geometry.theory.jets(geometry.local(q.reshape(-1, 4, 3)), points)

    for amount in (0.05, 1e-8, 0.0):
        one, two = two_states(system, rng, 0.05)
        two = one + amount * (two - one) / 0.05
        stresses = rng.normal(size=system.stresses(one).shape)
        force = system.shell.force_between(one, two, stresses)
        gradient = point.discrete_gradient(jet(one), jet(two))
        for u in rng.normal(size=(3, system.n_dofs)):
            terms = np.einsum("ekp,kviep,viep->ekp", stresses, gradient, jet(u))
            assert abs(force @ u - terms.sum()) < SUMS * np.abs(terms).sum()


@bodies
@laws
@theories
def test_work_is_the_change_of_the_energy(theory, body, law, rng):
    system = system_on(body, law, theory, [sk.Spring("corners", (3.0, 4.0, 5.0)), sk.Foundation(100.0)])
    assert system.foundation is not None
    for amount in (1.0, 1e-6):
        one, two = two_states(system, rng)
        two = one + amount * (two - one)
        mean = 0.5 * (system.stresses(one) + system.stresses(two))
        energies = [system.strain_energy(q) for q in (one, two)]
        force = system.shell.force_between(one, two, mean) + system.others.between(one, two, None, sk.Case())
        assert abs(force @ (two - one) - (energies[1] - energies[0])) < SUMS * max(energies)
    one, two = two_states(system, rng)
    change = system.strain_energy(two) - system.strain_energy(one)
    assert abs(system.internal_force(0.5 * (one + two)) @ (two - one) - change) > 1e-3 * abs(change), "not so at the middle"


@bodies
@theories
def test_no_force_and_no_moment_in_all(theory, body, rng):
    system = system_on(body, "laminate", theory)
    one, two = two_states(system, rng)
    force = system.shell.force_between(one, two, system.stresses(one)).reshape(-1, 4, 3)
    middle = 0.5 * (one + two).reshape(-1, 4, 3)
    assert np.abs(force[:, 0].sum(axis=0)).max() < SUMS * np.abs(force[:, 0]).sum()
    assert np.abs(np.cross(middle, force).sum(axis=(0, 1))).max() < SUMS * np.abs(np.cross(middle, force)).sum()


def test_springs_are_taken_at_the_middle(rng):
    bare, held = (system_on("flat", "isotropic", "kirchhoff", s) for s in ([], [sk.Spring((1.0, 0.4), (3.0, 4.0, 5.0))]))
    one, two = two_states(bare, rng)
    stresses = bare.stresses(one)
    springs = held.others.between(one, two, None, sk.Case())
    assert np.array_equal(held.shell.force_between(one, two, stresses), bare.shell.force_between(one, two, stresses))
    moved = 0.5 * (sk.Solution(bare, one).displacement((1.0, 0.4)) + sk.Solution(bare, two).displacement((1.0, 0.4)))
    total = springs.reshape(-1, 4, 3)[:, 0].sum(axis=0)
    assert np.allclose(total, [3.0, 4.0, 5.0] * moved, rtol=1e-8)

"""The compiled thin theory against a plain twin, scikit-fem forms, differences and rigid motions."""

import numpy as np
import pytest
import skfem
from reference import quads, thin_twin

import skancf as sk
from skancf.elements import ElementQuadHermite
from skancf.elements.quad_ancf import square_quadrature
from skancf.theories.kirchhoff import point

# Sums of some hundred products, 1e-13 as found; relative to the largest entry.
SUMS = 1e-12
THICKNESS = 0.1
PLY = sk.Orthotropic(young=(5e5, 1e5, 1e5), poisson=(0.2, 0.1, 0.3), shear=(6e4, 5e4, 4e4), density=2000.0)
LAWS = {
    "isotropic": (sk.Isotropic(2e5, 0.3, 2000.0), THICKNESS),
    "laminate": (sk.Laminate([sk.Layer(PLY, 0.06, 0.3), sk.Layer(PLY, 0.04, -1.1)], offset=0.01), None),
}
laws = pytest.mark.parametrize("law", LAWS)
assumed_or_plain = pytest.mark.parametrize("assumed", [True, False], ids=["assumed", "plain"])


def mixed(mesh):
    """Every second element numbered clockwise, and started at another corner."""
    t = np.stack([np.roll(c[::-1] if e % 2 else c, e) for e, c in enumerate(mesh.t.T)], axis=1)
    return skfem.MeshQuad(mesh.p, t, sort_t=False)


def patch(surface, n=2, m=None):
    return surface, mixed(sk.meshes.uniform(surface, n, n if m is None else m))


BODIES = {
    **{f"flat, {name}": (sk.Plane(), mesh) for name, mesh in quads.ALIGNED.items()},
    "flat, mixed": (sk.Plane(), mixed(quads.uneven())),
    "cylinder": patch(sk.CylinderSector(1.0, 1.5, 1.0)),
    "sphere": patch(sk.SphereSector(1.0, (0.6, 1.4), 0.9)),
    "saddle": patch(sk.HyperbolicParaboloid(1.0, 1.4, 0.4)),
    "annulus": patch(sk.AnnulusSector(0.5, 1.0, 1.0)),
}
bodies = pytest.mark.parametrize("body", BODIES)


def system_on(body, law="isotropic", assumed=True):
    surface, mesh = BODIES[body]
    material, thickness = LAWS[law]
    return sk.Problem(surface, thickness, material).on(mesh, sk.Kirchhoff(assumed=assumed))


def disturbed(system, rng, amount=0.05):
    """A state with strains of any sign, far from the undeformed one."""
    return system.undeformed + amount * rng.normal(size=system.n_dofs)


def close(found, expected, tolerance=SUMS):
    return np.abs(found - expected).max() < tolerance * np.abs(expected).max()


# --- at a point ------------------------------------------------------------------------------------------------------


def some_jets(rng, n=7):
    """Far from flat and from orthogonal."""
    jet = rng.normal(size=(5, 3, n))
    jet[0, 0] += 2
    jet[1, 1] += 2
    return jet


def test_gradient_is_the_derivative_of_the_strains(rng):
    jet, step = some_jets(rng), 1e-30
    for k, i in np.ndindex(5, 3):
        moved = jet.astype(complex)
        moved[k, i] += 1j * step
        # A complex step has no other error than rounding.
        assert np.abs(point.strain(moved).imag / step - point.gradient(jet)[:, k, i]).max() < 1e-13


def test_second_derivative_is_that_of_the_strains(rng):
    jet, stress, eps = some_jets(rng), rng.normal(size=(6, 7)), 1e-5
    second = point.second_derivative(jet, stress)
    for k, i in np.ndindex(5, 3):
        step = np.zeros_like(jet)
        step[k, i] = eps
        change = point.gradient(jet + step) - point.gradient(jet - step)
        numeric = np.einsum("s...,sli...->li...", stress, change) / (2 * eps)
        # Central difference: eps^2 times a fourth derivative of some hundred, and rounding 1e-16 over eps.
        assert np.abs(second[k, i] - numeric).max() < 1e-7
    assert np.abs(second - np.moveaxis(second, (0, 1), (2, 3))).max() < 1e-14
    without_bending = point.second_derivative(jet, stress * (np.arange(6) < 3)[:, None])
    assert np.abs(second - without_bending).max() > 0.1


# --- the twin --------------------------------------------------------------------------------------------------------


def twins(system, assumed, **kwargs):
    """Nodes and twin of each element."""
    geometry, section = system.geometry, system.problem.section
    undeformed = system.undeformed.reshape(-1, 4, 3)
    for nodes in system.mesh.t.T:
        yield nodes, thin_twin.Element(
            system.mesh.p[:, nodes].T, undeformed[nodes], geometry.surface, section, assumed, **kwargs)  # fmt: skip


@laws
@assumed_or_plain
@bodies
def test_energy_force_and_tangents_are_those_of_the_twin(body, assumed, law, rng):
    system = system_on(body, law, assumed)
    q, change = disturbed(system, rng), disturbed(system, rng, 0.1) - system.undeformed
    nodal, moved = q.reshape(-1, 4, 3), change.reshape(-1, 4, 3)
    own, ahead = system.stresses(q), system.stresses(q, change)
    energy, force = 0.0, np.zeros_like(nodal)
    tangent, mixed_tangent = np.zeros((2, system.n_dofs, system.n_dofs))
    for e, (nodes, element) in enumerate(twins(system, assumed)):
        places = (12 * nodes[:, None] + np.arange(12)).ravel()
        energy += element.energy(nodal[nodes])
        force[nodes] += element.force(nodal[nodes])
        stresses, later = element.stresses(nodal[nodes]), element.stresses(nodal[nodes], moved[nodes])
        assert close(own[e], stresses) and close(ahead[e], later)
        tangent[np.ix_(places, places)] += element.tangent(nodal[nodes], stresses)
        mixed_tangent[np.ix_(places, places)] += element.tangent(nodal[nodes], later)
    assert np.isclose(system.strain_energy(q), energy, rtol=SUMS)
    assert close(system.internal_force(q), force.ravel())
    assert close(system.tangent(q).to_scipy().toarray(), tangent)
    assert close(system.tangent(q, stresses=ahead).to_scipy().toarray(), mixed_tangent)
    assert not close(tangent, mixed_tangent, 1e-3), "the two tangents differ in this state"


@bodies
def test_what_the_twin_would_notice(body, rng):
    system = system_on(body)
    nodal = disturbed(system, rng).reshape(-1, 4, 3)

    def energy(assumed=True, **kwargs):
        return sum(element.energy(nodal[nodes]) for nodes, element in twins(system, assumed, **kwargs))

    assert not np.isclose(energy(), energy(assumed=False), rtol=1e-3)
    assert not np.isclose(energy(), energy(thickness=0.99 * THICKNESS), rtol=1e-6), "the factor of the rest"


# --- the formulas, as a scikit-fem form ------------------------------------------------------------------------------


def internal_form(abd):
    """Virtual work of a plate that is flat in the undeformed state."""

    def voigt(T):
        return np.stack([T[0, 0], T[1, 1], T[0, 1] + T[1, 0]])

    def form(v, w):
        F, H, dF, dH = w["r"].grad, w["r"].hess, v.grad, v.hess
        (a, b), (da, db) = np.moveaxis(F, 1, 0), np.moveaxis(dF, 1, 0)
        cross = np.cross(a, b, axis=0)
        n, area = cross / np.sqrt((cross**2).sum(axis=0)), np.sqrt((cross**2).sum(axis=0))
        turning = np.cross(da, b, axis=0) + np.cross(a, db, axis=0)
        dn = (turning - n * (n * turning).sum(axis=0)) / area
        E = (np.einsum("ia...,ib...->ab...", F, F) - np.eye(2)[:, :, None, None]) / 2
        dE = np.einsum("ia...,ib...->ab...", F, dF)
        kappa, change = -np.einsum("i...,iab...->ab...", n, H), -(
            np.einsum("i...,iab...->ab...", dn, H) + np.einsum("i...,iab...->ab...", n, dH))  # fmt: skip
        stress = np.tensordot(abd, np.concatenate([voigt(E), voigt(kappa)]), 1)
        return (stress * np.concatenate([voigt(dE), voigt(change)])).sum(axis=0)

    return skfem.LinearForm(form)


@laws
@pytest.mark.parametrize("mesh", quads.ALIGNED)
def test_plain_force_is_that_of_the_form(mesh, law, rng):
    system = system_on(f"flat, {mesh}", law, assumed=False)
    q, abd = disturbed(system, rng), system.problem.section.abd()
    basis = skfem.Basis(system.mesh, skfem.ElementVector(ElementQuadHermite(), 3), quadrature=square_quadrature(4))
    expected = internal_form(abd).assemble(basis, r=basis.interpolate(q))
    assert close(system.internal_force(q), expected)
    stiffer = abd + np.diag([0, 0, 0, 1, 1, 1]) * 1e-3 * abd
    other = internal_form(stiffer).assemble(basis, r=basis.interpolate(q))
    assert not close(system.internal_force(q), other, 1e-6), "a thousandth of the bending stiffness shows"


def test_mass_is_that_of_the_form(rng):
    for name in quads.ALIGNED:
        system = system_on(f"flat, {name}", "laminate")
        basis = skfem.Basis(system.mesh, skfem.ElementVector(ElementQuadHermite(), 3), intorder=7)
        expected = skfem.BilinearForm(lambda u, v, w: 2000.0 * 0.1 * (u * v).sum(axis=0)).assemble(basis)
        assert abs(system.mass.to_scipy() - expected).max() < SUMS * abs(expected).max()


# --- consistency -----------------------------------------------------------------------------------------------------


@laws
@assumed_or_plain
@pytest.mark.parametrize("body", ["flat, mixed", "sphere"])
def test_force_is_the_derivative_of_the_energy_and_tangent_that_of_the_force(body, assumed, law, rng):
    system = system_on(body, law, assumed)
    q, eps = disturbed(system, rng, 0.02), 1e-6
    unit, force = eps * np.eye(system.n_dofs), system.internal_force(q)
    by_energy = np.array([system.strain_energy(q + e) - system.strain_energy(q - e) for e in unit]) / (2 * eps)
    by_force = np.array([system.internal_force(q + e) - system.internal_force(q - e) for e in unit]).T / (2 * eps)
    tangent = system.tangent(q).to_scipy().toarray()
    # Rounding over the step, 1e-16 / 1e-6 with some hundred terms; the truncation is eps^2 times (1 / element size)^2.
    assert close(force, by_energy, 1e-7) and close(tangent, by_force, 1e-7)
    assert np.abs(tangent - tangent.T).max() == 0
    assert not close(system.tangent(system.undeformed).to_scipy().toarray(), by_force, 1e-3)


def rotation(axis, angle):
    a = np.asarray(axis) / np.linalg.norm(axis)
    W = np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])
    return np.eye(3) + np.sin(angle) * W + (1 - np.cos(angle)) * W @ W


def turned(q, Q, shift=(0.0, 0.0, 0.0)):
    """The body in that state turned by Q and moved."""
    out = q.reshape(-1, 4, 3) @ Q.T
    out[:, 0] += shift
    return out.ravel()


@laws
@bodies
def test_a_rigid_motion_changes_nothing(body, law, rng):
    """Energy the same, forces turned with the body."""
    system, Q, shift = system_on(body, law), rotation([1, 2, 3], 2.0), (0.3, -0.2, 0.9)
    q = disturbed(system, rng)
    moved = turned(q, Q, shift)
    assert np.isclose(system.strain_energy(moved), system.strain_energy(q), rtol=SUMS)
    assert close(system.internal_force(moved), turned(system.internal_force(q), Q))
    forgotten = q.reshape(-1, 4, 3) @ Q.T
    forgotten[:, 3] = q.reshape(-1, 4, 3)[:, 3]
    assert not np.isclose(system.strain_energy(forgotten), system.strain_energy(q), rtol=1e-6), "r_xy turns too"
    rigid = turned(system.undeformed, Q, shift)
    scale = np.abs(system.internal_force(turned(1.001 * system.undeformed, Q))).max()  # a strain of one in a thousand
    assert np.abs(system.internal_force(rigid)).max() < 1e-10 * scale
    assert system.strain_energy(rigid) < 1e-20 * system.strain_energy(2.0 * rigid)


# --- zero modes ------------------------------------------------------------------------------------------------------

FLAT = sk.Rectangle(1.0, 1.0)
SURFACES = {
    "flat": FLAT,
    "cylinder": sk.CylinderSector(1.0, 1.0, 1.0),
    "sphere": sk.SphereSector(1.0, (0.6, 1.4), 0.9),
    "annulus": sk.AnnulusSector(0.5, 1.0, 1.0),
    "saddle": sk.HyperbolicParaboloid(1.0, 1.0, 0.3),
}


def eigenvalues(surface, n, thickness, rest=1.0):
    """Of the tangent of a free patch, scaled by the diagonal so that slopes and positions compare, from small to large."""
    system = sk.Problem(surface, thickness, LAWS["isotropic"][0]).on(sk.meshes.uniform(surface, n, n), "kirchhoff")
    elements = system.assembly._elements
    system.assembly._elements = elements._replace(rest=rest * elements.rest)
    tangent = system.tangent(system.undeformed).to_scipy().toarray()
    scale = 1 / np.sqrt(tangent.diagonal())
    return np.sort(np.abs(np.linalg.eigvalsh(scale[:, None] * tangent * scale)))


@pytest.mark.parametrize("thickness", [0.1, 1e-2, 1e-3])
@pytest.mark.parametrize("n", [1, 2, 3])
@pytest.mark.parametrize("name", SURFACES)
def test_free_patches_have_six_zero_eigenvalues(name, n, thickness):
    """The softest deformation goes with thickness squared: 4e-8 for one element of thickness 1e-3.

    Rounding of the membrane stress of a flat plate, 1e-16, against bending makes zeros of up to 1e-18 over thickness
    squared: four digits lie between the two at worst.
    """
    values = eigenvalues(SURFACES[name], n, thickness)
    assert values[5] < 1e-16 * (100 + 0.1 / thickness**2)
    assert values[6] > 0.03 * thickness**2
    assert values[6] > 1e4 * values[5]


@pytest.mark.parametrize("name", ["flat", "cylinder", "annulus"])
def test_without_the_rest_of_the_membrane_strains_more_is_free(name):
    """The counts above can fail: on lines that are straight, or in the plane, motions remain that no assumed strain sees."""
    for n in (1, 2, 3):
        assert (eigenvalues(SURFACES[name], n, 0.1, rest=0.0) < 1e-13).sum() > 6


# --- classes and threads ---------------------------------------------------------------------------------------------


def test_equal_elements_share_their_sections():
    def n_classes(surface, nx, ny):
        mesh = sk.meshes.uniform(surface, nx, ny)
        return sk.Problem(surface, 0.01, LAWS["isotropic"][0]).on(mesh, "kirchhoff").assembly.sections.shape.max() + 1

    assert n_classes(FLAT, 5, 4) == 1 and n_classes(sk.CylinderSector(1.0, 2.0, 1.0), 5, 4) == 1
    assert n_classes(SURFACES["annulus"], 3, 7) == 3 and n_classes(SURFACES["sphere"], 3, 7) == 3


def test_threads_do_not_change_a_bit(monkeypatch, rng):
    material, thickness = LAWS["laminate"]
    surface = SURFACES["sphere"]
    system = sk.Problem(surface, thickness, material).on(sk.meshes.uniform(surface, 18, 16), "kirchhoff")
    assert max(len(phase) for phase in system.assembly.schedule.phases) > 1, "nothing would run at the same time"
    q = disturbed(system, rng, 1e-3)
    results = []
    for threads in ("1", "2"):
        monkeypatch.setenv("SKANCF_THREADS", threads)
        results.append((system.internal_force(q), system.tangent(q).values, system.stresses(q)))
    for one, two in zip(*results, strict=True):
        assert np.array_equal(one, two)

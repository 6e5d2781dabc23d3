"""The compiled element against scikit-fem forms that read like the paper, and against a slow twin."""

import numpy as np
import pytest
import skfem
from reference import quads, twin

import skancf as sk
from skancf.elements import ElementQuadANCF, through_thickness

# Sums of about a thousand products; relative to the largest entry.
SUMS = 1e-12
ROUNDING = 1e-13
THICKNESS = 0.1
VOIGT = [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)]


def any_law() -> sk.Anisotropic:
    """Symmetric positive definite with all 21 entries different."""
    root = np.random.default_rng(5).normal(size=(6, 6))
    return sk.Anisotropic(1e5 * (root @ root.T + 3 * np.eye(6)), 2000.0, angle=0.4, kind="3d")


LAWS = {
    "plane stress": sk.Isotropic(2e5, 0.3, 2000.0),
    "3d": sk.Isotropic(2e5, 0.3, 2000.0, kind="3d"),
    "anisotropic": any_law(),
}
laws = pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
assumed_or_plain = pytest.mark.parametrize("assumed", [True, False], ids=["assumed", "plain"])
meshes = pytest.mark.parametrize("mesh", quads.ALL.values(), ids=quads.ALL)


def system_on(mesh, law=LAWS["plane stress"], assumed=True, surface=None, **theory):
    return sk.Problem(surface or sk.Plane(), THICKNESS, law).on(mesh, sk.Full(assumed=assumed, **theory))


def disturbed(system, rng, amount=0.05):
    """A state with strains of any sign, far from the undeformed one."""
    return system.undeformed + amount * rng.normal(size=system.n_dofs)


def rotation(axis, angle):
    a = np.asarray(axis) / np.linalg.norm(axis)
    W = np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])
    return np.eye(3) + np.sin(angle) * W + (1 - np.cos(angle)) * W @ W


def turned(q, Q, shift=(0.0, 0.0, 0.0)):
    """The body in that state turned by Q and moved."""
    out = q.reshape(-1, 4, 3) @ Q.T
    out[:, 0] += shift
    return out.ravel()


# --- the paper's formulas, as scikit-fem forms -----------------------------------------------------------------------


def product(a, b):
    return np.einsum("ij...,jk...->ik...", a, b)


def transposed(a):
    return np.einsum("ij...->ji...", a)


def stress(E, C):
    """S = C : E, Voigt order 11, 22, 33, 23, 13, 12 with doubled shear strains."""
    voigt = np.stack([E[i, j] if i == j else E[i, j] + E[j, i] for i, j in VOIGT])
    S = np.empty_like(E)
    for value, (i, j) in zip(np.tensordot(C, voigt, 1), VOIGT, strict=True):
        S[i, j] = S[j, i] = value
    return S


def green_lagrange(F):
    return (product(transposed(F), F) - np.eye(3)[:, :, None, None]) / 2


def work(P, grad):
    return np.einsum("ij...,ij...->...", P, grad)


def plain_basis(mesh, n_z=3):
    return skfem.Basis(mesh, skfem.ElementVector(ElementQuadANCF(), 3), **through_thickness(mesh, THICKNESS, 4, n_z))


def force_by_forms(mesh, q, C):
    basis = plain_basis(mesh)

    @skfem.LinearForm
    def internal(v, w):
        F = w["r"].grad
        return work(product(F, stress(green_lagrange(F), C)), v.grad)

    return internal.assemble(basis, r=basis.interpolate(q))


def tangent_by_forms(mesh, q, C):
    basis = plain_basis(mesh)

    @skfem.BilinearForm
    def stiffness(u, v, w):
        F, dF = w["r"].grad, u.grad
        S = stress(green_lagrange(F), C)
        dE = (product(transposed(dF), F) + product(transposed(F), dF)) / 2
        return work(product(dF, S) + product(F, stress(dE, C)), v.grad)

    return stiffness.assemble(basis, r=basis.interpolate(q)).toarray()


@laws
@meshes
def test_plain_force_is_that_of_the_forms(mesh, law, rng):
    system = system_on(mesh, law, assumed=False)
    q = disturbed(system, rng)
    expected = force_by_forms(mesh, q, law.stiffness())
    assert np.abs(system.internal_force(q) - expected).max() < SUMS * np.abs(expected).max()
    softer = force_by_forms(mesh, q, 0.999 * law.stiffness())
    assert np.abs(system.internal_force(q) - softer).max() > 1e-4 * np.abs(expected).max(), "one in a thousand shows"


@pytest.mark.parametrize("case", [("distorted", "anisotropic"), ("quarter turns, mirrored", "plane stress")])
def test_plain_tangent_is_that_of_the_forms(case, rng):
    mesh, law = quads.ALL[case[0]], LAWS[case[1]]
    mesh = mesh.restrict(np.arange(2))
    system = system_on(mesh, law, assumed=False)
    q = disturbed(system, rng)
    expected = tangent_by_forms(mesh, q, law.stiffness())
    tangent = system.tangent(q).to_scipy().toarray()
    assert np.abs(tangent - expected).max() < SUMS * np.abs(expected).max()


@meshes
def test_mass_is_that_of_the_form_and_constant(mesh, rng):
    system, basis = system_on(mesh), plain_basis(mesh, n_z=2)
    expected = skfem.BilinearForm(lambda u, v, w: 2000.0 * (u * v).sum(axis=0)).assemble(basis)
    mass = system.mass.to_scipy()
    assert abs(mass - expected).max() < SUMS * abs(expected).max()
    rigid = np.zeros((mesh.nvertices, 4, 3))
    rigid[:, 0] = [1, 2, 3]
    energy = rigid.ravel() @ (mass @ rigid.ravel())
    assert np.isclose(energy, 14 * 2000.0 * THICKNESS * quads.area(mesh), rtol=SUMS)


def test_mass_of_a_sector():
    surface = sk.AnnulusSector(0.5, 1.0, 1.0)
    rigid = {n: np.zeros(((n + 1) ** 2, 4, 3)) for n in (4, 8)}
    errors = []
    for n, velocity in rigid.items():
        velocity[:, 0] = [1, 2, 3]
        mass = system_on(sk.meshes.uniform(surface, n, n), surface=surface).mass
        errors.append(abs(velocity.ravel() @ (mass @ velocity.ravel()) / (14 * 2000.0 * THICKNESS * 0.375) - 1))
    assert errors[1] < 1e-6 and errors[0] / errors[1] > 12, "arcs are made of cubics: order 4"


# --- the slow twin ---------------------------------------------------------------------------------------------------

SECTOR = sk.AnnulusSector(0.5, 1.0, 1.0)
BODIES = {
    "rectangles": (sk.Plane(), quads.renumbered(quads.uneven(), turns=1).restrict(np.arange(2)), twin.flat),
    "distorted": (sk.Plane(), quads.GENERAL["distorted, mirrored"].restrict(np.arange(2)), twin.flat),
    "annulus": (SECTOR, sk.meshes.uniform(SECTOR, 1, 1), twin.polar),
}


@laws
@assumed_or_plain
@pytest.mark.parametrize("body", BODIES)
def test_energy_and_force_are_those_of_the_twin(body, assumed, law, rng):
    surface, mesh, frame = BODIES[body]
    system = system_on(mesh, law, assumed, surface)
    q = disturbed(system, rng)
    nodal, undeformed = q.reshape(-1, 4, 3), system.undeformed.reshape(-1, 4, 3)
    energy, wrong, force = 0.0, 0.0, np.zeros_like(nodal)
    for nodes in mesh.t.T:
        element = twin.Element(mesh.p[:, nodes].T, undeformed[nodes], assumed)
        energy += element.energy(nodal[nodes], law.stiffness(), THICKNESS, frame).real
        force[nodes] += element.force(nodal[nodes], law.stiffness(), THICKNESS, frame)
        element.assumed = not assumed
        wrong += element.energy(nodal[nodes], law.stiffness(), THICKNESS, frame).real
    assert np.isclose(system.strain_energy(q), energy, rtol=SUMS)
    assert np.abs(system.internal_force(q) - force.ravel()).max() < SUMS * np.abs(force).max()
    assert abs(wrong / energy - 1) > 1e-3, "assumed and plain strains differ in this state"


# --- consistency -----------------------------------------------------------------------------------------------------


@laws
@assumed_or_plain
@pytest.mark.parametrize("body", BODIES)
def test_tangent_is_the_derivative_of_the_force_and_symmetric(body, assumed, law, rng):
    surface, mesh, _ = BODIES[body]
    system = system_on(mesh, law, assumed, surface)
    q, eps = disturbed(system, rng), 1e-5
    tangent = system.tangent(q).to_scipy().toarray()
    unit = eps * np.eye(system.n_dofs)
    numeric = np.array([system.internal_force(q + e) - system.internal_force(q - e) for e in unit]).T / (2 * eps)
    # The force is cubic: the error of a central difference is eps^2 of it, and rounding over the step 1e-16 / eps.
    assert np.abs(tangent - numeric).max() < 1e-8 * np.abs(tangent).max()
    assert np.abs(tangent - tangent.T).max() < ROUNDING * np.abs(tangent).max()
    linear = system.tangent(system.undeformed).to_scipy().toarray()
    assert np.abs(linear - numeric).max() > 1e-3 * np.abs(tangent).max(), "the state is far from the undeformed one"


@assumed_or_plain
def test_energy_is_the_work_of_the_force_along_a_path(assumed, rng):
    system = system_on(quads.GENERAL["distorted"], any_law(), assumed)
    start, end = disturbed(system, rng), disturbed(system, rng, 0.2)
    # Along a straight path the force is cubic in the parameter, so two Gauss points are exact and one is not.
    work_of = {}
    for n in (1, 2):
        s, w = np.polynomial.legendre.leggauss(n)
        at = [start + (x + 1) / 2 * (end - start) for x in s]
        work_of[n] = sum(wk / 2 * system.internal_force(q) @ (end - start) for q, wk in zip(at, w, strict=True))
    difference = system.strain_energy(end) - system.strain_energy(start)
    assert np.isclose(work_of[2], difference, rtol=SUMS)
    assert not np.isclose(work_of[1], difference, rtol=1e-3)


@assumed_or_plain
def test_stresses_are_extrapolated_linearly(assumed, rng):
    system = system_on(quads.GENERAL["distorted"], any_law(), assumed)
    q, change = disturbed(system, rng), 0.1 * rng.normal(size=system.n_dofs)
    ahead, behind, here = system.stresses(q + change), system.stresses(q - change), system.stresses(q)
    # Strains are quadratic in q: half the difference of both sides is the derivative exactly.
    expected = here + (ahead - behind) / 2
    assert np.abs(system.stresses(q, change) - expected).max() < SUMS * np.abs(expected).max()
    assert np.abs(ahead - expected).max() > 1e-3 * np.abs(expected).max()


# --- rigid motions, zero modes, patches ------------------------------------------------------------------------------


@assumed_or_plain
@pytest.mark.parametrize("body", BODIES)
def test_rigid_motions_give_no_strain(body, assumed):
    surface, mesh, _ = BODIES[body]
    system = system_on(mesh, any_law(), assumed, surface)
    q = turned(system.undeformed, rotation([1, 2, 3], 2.0), (0.3, -0.2, 0.9))
    points = np.random.default_rng(2).uniform(0, 1, (2, 5))
    for z in (-THICKNESS / 2, 0.0, THICKNESS / 3):
        assert np.abs(sk.Solution(system, q).strains(points, z)).max() < ROUNDING
    # Stresses carry the law and the area of a point; both bounded by those of a state of unit strain.
    unit = np.abs(system.stresses(2 * system.undeformed)).max()
    assert np.abs(system.stresses(q)).max() < ROUNDING * unit
    if surface == sk.Plane():
        F = plain_basis(mesh).interpolate(q).grad
        small = (F + transposed(F)) / 2 - np.eye(3)[:, :, None, None]
        assert np.abs(small).max() > 0.1, "a strain that is linear in the displacement sees this rotation"


@assumed_or_plain
@pytest.mark.parametrize("body", BODIES)
def test_undeformed_state_is_free_of_force(body, assumed):
    surface, mesh, _ = BODIES[body]
    system = system_on(mesh, any_law(), assumed, surface)
    scale = np.abs(system.internal_force(1.001 * system.undeformed)).max()  # a strain of one in a thousand
    assert np.abs(system.internal_force(system.undeformed)).max() < 1e-10 * scale
    assert np.abs(sk.Solution(system, system.undeformed).strains(np.array([[0.2], [0.7]]), 0.01)).max() == 0


def zero_eigenvalues(system):
    """How many eigenvalues vanish, scaled by the diagonal so that slopes and positions compare."""
    tangent = system.tangent(system.undeformed).to_scipy().toarray()
    scale = 1 / np.sqrt(tangent.diagonal())
    values = np.abs(np.linalg.eigvalsh(scale[:, None] * tangent * scale))
    assert not ((values > 1e-12) & (values < 1e-7)).any(), "a gap between rounding and the softest deformation"
    return int((values < 1e-12).sum())


PATCHES = {
    "one element": skfem.MeshQuad(),
    "one distorted element": quads.distorted(skfem.MeshQuad(), 0.3),
    "patch": skfem.MeshQuad().refined(1),
    "distorted patch": quads.distorted(skfem.MeshQuad().refined(1), 0.3),
}


@assumed_or_plain
@pytest.mark.parametrize("patch", PATCHES)
def test_free_patches_have_six_zero_eigenvalues(patch, assumed):
    assert zero_eigenvalues(system_on(PATCHES[patch], assumed=assumed)) == 6


@assumed_or_plain
def test_free_sectors_have_six_zero_eigenvalues(assumed):
    for n in (1, 2):
        assert zero_eigenvalues(system_on(sk.meshes.uniform(SECTOR, n, n), assumed=assumed, surface=SECTOR)) == 6


def test_one_point_through_the_thickness_leaves_more():
    """The count above can fail: without a second depth nothing resists bending."""
    assert zero_eigenvalues(system_on(PATCHES["patch"], n_thickness=1)) > 6


# Stretch and shear in the plane, of the director too, and a turn.
FIELD = np.array([[1.10, 0.20, 0.05], [-0.15, 0.95, -0.07], [0.30, -0.10, 1.1]])


def homogeneous(system, F):
    """Nodal coordinates of r = F X."""
    return (system.undeformed.reshape(-1, 4, 3) @ F.T).ravel()


@assumed_or_plain
def test_constant_strain_is_represented_on_distorted_meshes(assumed):
    mesh = quads.distorted(skfem.MeshQuad().refined(2), 0.3)
    system = system_on(mesh, any_law(), assumed)
    E, C = (FIELD.T @ FIELD - np.eye(3)) / 2, any_law().stiffness()
    q, voigt = homogeneous(system, FIELD), np.array([E[i, j] * (1 if i == j else 2) for i, j in VOIGT])
    strains = sk.Solution(system, q).strains(np.random.default_rng(2).uniform(0, 1, (2, 4)), THICKNESS / 2)
    assert np.abs(strains - voigt).max() < ROUNDING
    assert np.isclose(system.strain_energy(q), voigt @ C @ voigt / 2 * THICKNESS * quads.area(mesh), rtol=SUMS)


@assumed_or_plain
def test_patch_of_constant_strain_is_in_equilibrium(assumed, rng):
    """Homogeneous membrane stretch on the boundary: Newton's method finds it inside, on a distorted mesh."""
    mesh = quads.distorted(skfem.MeshQuad().refined(2), 0.3)
    system = system_on(mesh, assumed=assumed)
    F = np.linalg.qr(rng.normal(size=(3, 3)))[0] @ np.diag([1.1, 0.93, 1.0])
    exact = homogeneous(system, F)
    inside = np.setdiff1d(np.arange(system.n_dofs), (12 * mesh.boundary_nodes()[:, None] + np.arange(12)).ravel())
    q = exact.copy()
    q[inside] += 0.01 * rng.normal(size=inside.size)
    assert np.abs(system.internal_force(q)[inside]).max() > 1e-3, "a start that is no equilibrium"
    for _ in range(8):
        K = system.tangent(q).to_scipy()[inside][:, inside].toarray()
        q[inside] -= np.linalg.solve(K, system.internal_force(q)[inside])
    # Rounding times the condition of a plate of this thickness, about 1e4.
    assert np.abs(q - exact).max() < 1e-11


# --- classes and threads ---------------------------------------------------------------------------------------------


def test_equal_elements_share_their_sections():
    def classes(surface, mesh):
        return len(np.unique(system_on(mesh, surface=surface).assembly.sections.shape))

    square = sk.Rectangle(1, 1)
    assert classes(square, sk.meshes.uniform(square, 5, 4)) == 1
    assert classes(SECTOR, sk.meshes.uniform(SECTOR, 3, 7)) == 3, "one class for each radius"
    assert classes(sk.Plane(), quads.GENERAL["distorted"]) == 4


def test_threads_do_not_change_a_bit(monkeypatch, rng):
    surface = sk.Rectangle(1, 1)
    system = system_on(sk.meshes.uniform(surface, 18, 16), any_law(), surface=surface)
    assert sum(len(phase) for phase in system.assembly.schedule.phases) > 1, "one chunk: nothing would run at the same time"
    assert max(len(phase) for phase in system.assembly.schedule.phases) > 1
    q = disturbed(system, rng, 0.01)
    results = []
    for threads in ("1", "2"):
        monkeypatch.setenv("SKANCF_THREADS", threads)
        results.append((system.internal_force(q), system.tangent(q).values, system.stresses(q)))
    for one, two in zip(*results, strict=True):
        assert np.array_equal(one, two)

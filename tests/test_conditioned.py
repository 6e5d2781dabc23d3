"""Linear systems with conditions: against the null space of the conditions, pass by pass, with rows that depend."""

import numpy as np
import pytest
import scipy.sparse as sp

import skancf as sk
from skancf.errors import SingularMatrix
from skancf.linear import BlockMatrix, BlockPattern, ConditionedSolver, Constraints, DirectSolver, conditioned, contradiction

pytestmark = pytest.mark.filterwarnings("ignore:the sides 'start' and 'end'")


def by_null_space(matrix, gradient, rhs, values, free):
    """x of K x + G^T l = a, G x = b on the columns of ``free``, (n, m); conditions may depend on each other."""
    k, g = free.T @ matrix @ free, gradient @ free
    g[np.linalg.norm(g, axis=1) < 1e-10 * np.linalg.norm(gradient, axis=1)] = 0.0  # held by supports
    scale = 1 / np.sqrt(np.abs(np.diag(k)))  # units of unknowns
    k, g = k * np.outer(scale, scale), g * scale
    sizes = np.linalg.norm(g, axis=1, keepdims=True)
    rows = np.divide(g, sizes, out=np.zeros_like(g), where=sizes > 0)
    u, s, v = np.linalg.svd(rows)
    rank = int((s > 1e-9 * s[0]).sum())
    b = np.divide(values, sizes[:, 0], out=np.zeros(len(values)), where=sizes[:, 0] > 0)
    x = v[:rank].T @ ((u[:, :rank].T @ b) / s[:rank])
    null = v[rank:].T
    x = x + null @ np.linalg.solve(null.T @ k @ null, null.T @ (scale * (free.T @ rhs) - k @ x))
    return free @ (scale * x)


def chain(n=6, block=3, stiffness=(1.0, 3.0, 1e4)):
    """Nodes in a row with springs between them and to the ground, stiff along one direction and soft along another."""
    cells = np.stack([np.arange(n - 1), np.arange(1, n)])
    pattern = BlockPattern.from_cells((cells, np.arange(n)[:, None]), n, block, np.arange(n)[None])
    rng = np.random.default_rng(3)
    dense = np.zeros((block * n, block * n))
    for a, b in cells.T:
        turn = np.linalg.qr(rng.standard_normal((block, block)))[0]
        k = turn @ np.diag(stiffness) @ turn.T
        for i, j, sign in ((a, a, 1), (b, b, 1), (a, b, -1), (b, a, -1)):
            dense[block * i : block * (i + 1), block * j : block * (j + 1)] += sign * k
    dense += 0.01 * np.eye(block * n)
    values = np.array([dense[block * i : block * (i + 1), block * j : block * (j + 1)]
                       for i, j in zip(pattern.rows, pattern.indices, strict=True)])  # fmt: skip
    return BlockMatrix(pattern, values), dense


@pytest.mark.parametrize("framed", [False, True])
def test_against_the_null_space(framed):
    matrix, dense = chain()
    rng = np.random.default_rng(0)
    fixed = np.zeros((6, 3), bool)
    fixed[0], fixed[3, 1] = True, True
    turn = np.linalg.qr(rng.standard_normal((3, 3)))[0]
    constraints = Constraints(fixed, [3], turn[None]) if framed else Constraints(fixed)
    free = np.linalg.svd(constraints.free_projection.toarray())[0][:, : 18 - 4]
    gradient, rhs = sp.csr_matrix(rng.standard_normal((4, 18))), rng.standard_normal(18)
    values = gradient @ (free @ rng.standard_normal(14))
    solver = ConditionedSolver(DirectSolver(matrix.pattern, constraints), gradient).factor(matrix)
    x, multipliers = solver.solve_both(rhs, values)
    expected = by_null_space(dense, gradient.toarray(), rhs, values, free)
    assert np.abs(x - expected).max() < 1e-10 * np.abs(expected).max()
    assert np.abs(gradient @ x - values).max() < 1e-12 and not solver.held.any() and solver.lost == 0.0
    left = constraints.free_part(rhs - dense @ x - gradient.T @ multipliers)
    assert np.abs(left).max() < 1e-11 * np.abs(rhs).max()
    assert np.abs(gradient @ solver.solve(rhs)).max() < 1e-11
    assert np.allclose(constraints.free_projection @ rhs, constraints.free_part(rhs), atol=1e-14)


def test_negative_eigenvalues_are_those_among_motions_that_meet_the_conditions():
    matrix, dense = chain()
    pattern = matrix.pattern
    gradient = sp.csr_matrix(np.random.default_rng(1).standard_normal((2, 18)))
    null = np.linalg.svd(gradient.toarray())[2][2:].T
    counts = set()
    for shift in (0.0, 0.5, 2.0, 10.0):
        moved = BlockMatrix(pattern, matrix.values.copy())
        moved.values[pattern.diagonal_slots] -= shift * np.eye(3)
        solver = ConditionedSolver(DirectSolver(pattern, Constraints(np.zeros((6, 3), bool))), gradient).factor(moved)
        true = int((np.linalg.eigvalsh(null.T @ (dense - shift * np.eye(18)) @ null) < 0).sum())
        assert solver.negative_pivots == true
        counts.add(true)
    assert len(counts) > 2


def test_rows_that_supports_hold_and_rows_twice():
    matrix, dense = chain()
    fixed = np.zeros((6, 3), bool)
    fixed[:2] = True
    constraints = Constraints(fixed)
    rows = np.zeros((4, 18))
    rows[0, 3], rows[1, 9], rows[2, 9], rows[3, 9] = 1.0, 1.0, 1.0, -2.0  # held; three times the same
    rhs = np.random.default_rng(0).standard_normal(18)
    solver = ConditionedSolver(DirectSolver(matrix.pattern, constraints), sp.csr_matrix(rows)).factor(matrix)
    x, multipliers = solver.solve_both(rhs, np.zeros(4))
    expected = by_null_space(dense, rows[1:2], rhs, np.zeros(1), np.eye(18)[:, 6:])
    assert np.abs(x - expected).max() < 1e-11 * np.abs(expected).max()
    assert solver.held.tolist() == [True, False, False, False] and multipliers[0] == 0.0
    assert multipliers[1] == pytest.approx(multipliers[2]) and np.isfinite(multipliers).all()


def test_a_skew_part_beside_it():
    matrix, dense = chain()
    rng = np.random.default_rng(2)
    gradient, rhs = sp.csr_matrix(rng.standard_normal((3, 18))), rng.standard_normal(18)
    skew = 0.1 * rng.standard_normal((18, 18))
    skew = skew - skew.T
    free = DirectSolver(matrix.pattern, Constraints(np.zeros((6, 3), bool)))
    solver = ConditionedSolver(free, gradient).factor(matrix, sp.csr_matrix(skew))
    x, multipliers = solver.solve_both(rhs, np.zeros(3))
    expected = by_null_space(dense + skew, gradient.toarray(), rhs, np.zeros(3), np.eye(18))
    assert np.abs(x - expected).max() < 1e-8 * np.abs(expected).max()
    assert np.abs(solver.multiply(x) + gradient.T @ multipliers - rhs).max() < 1e-8


def test_a_motion_that_nothing_resists_is_singular_and_one_that_a_condition_holds_is_not():
    matrix, _ = chain()
    pattern = matrix.pattern
    loose = BlockMatrix(pattern, matrix.values.copy())
    loose.values[pattern.diagonal_slots] -= 0.01 * np.eye(3)  # no springs to the ground
    free = DirectSolver(pattern, Constraints(np.zeros((6, 3), bool)))
    all_three = sp.csr_matrix((np.ones(3), ([0, 1, 2], [0, 1, 2])), shape=(3, 18))
    x = ConditionedSolver(free, all_three).factor(loose).solve(np.ones(18))
    assert np.abs(x[:3]).max() < 1e-12 * np.abs(x).max()
    with pytest.raises(SingularMatrix):
        ConditionedSolver(free, all_three[:2]).factor(loose)


def test_contradictions():
    constraints = Constraints(np.zeros((2, 3), bool))
    rows = sp.csr_matrix(np.array([[1.0, 0, 0, -1, 0, 0], [0, 1, 0, 0, 0, 0], [-3.0, 0, 0, 3, 0, 0], [0, 1, 1, 0, 0, 0]]))
    ones = np.ones(4)
    assert not contradiction(rows, np.array([0.1, 0.5, -0.3, 0.2]), ones, constraints).size
    assert sorted(contradiction(rows, np.array([0.1, 0.5, 0.3, 0.2]), ones, constraints)) == [0, 2]
    assert not contradiction(rows, np.zeros(4), ones, constraints).size
    held = np.zeros((2, 3), bool)
    held[0, 1] = True
    assert contradiction(rows, np.array([0.1, 0.5, -0.3, 0.2]), ones, Constraints(held)).tolist() == [1]


TUBE = sk.CylinderSector(radius=1.0, length=0.5, angle=2 * np.pi)


def ring(thickness, theory="kirchhoff"):
    """A hinged tube with a link across it, twice, and one that is held: its stiffness, gradient and load."""
    links = [sk.RigidLink((0.0, 0.5), (0.5, 2.5))] * 2 + [sk.RigidLink((0.0, np.pi), (0.5, np.pi))]
    problem = sk.Problem(
        TUBE, thickness, sk.Isotropic(2e11, 0.3, 7800.0), [sk.Clamp(lambda x, y: abs(y - np.pi) < 1e-6)],
        [sk.PointForce((0.5, 0.0), (0, 0, 1.0))], conditions=[sk.Hinge("start", "end"), *links],
    )  # fmt: skip
    system = problem.on(sk.meshes.uniform(TUBE, 2, 8), theory)
    start = system.undeformed
    return system, system.stiffness(), system.conditions.gradient(start), system.external_force(start)


# What one and two passes leave of the answer, at most; the reference itself is known to 1e-11, 1e-9 and 1e-7.
LEFT = {1e-1: (1e-5, 1e-7), 1e-2: (1e-5, 1e-7), 1e-3: (1e-5, 1e-7)}


@pytest.mark.parametrize("thickness", LEFT)
@pytest.mark.parametrize("theory", ["kirchhoff", "full"])
def test_two_passes_on_a_shell(theory, thickness):
    system, stiffness, gradient, load = ring(thickness, theory)
    kept, basis = np.linalg.eigh(system.constraints.free_projection.toarray())
    free = basis[:, kept > 0.5]
    zero, mass = np.zeros(gradient.shape[0]), system.mass
    expected = by_null_space(stiffness.to_scipy().toarray(), gradient.toarray(), load, zero, free)
    solver = ConditionedSolver(DirectSolver(system.pattern, system.constraints), gradient).factor(stiffness)

    def off(x, expected=expected):
        e = x - expected
        return np.sqrt(e @ (mass @ e) / (expected @ (mass @ expected)))

    answers = [solver.solve_both(load, zero, passes)[0] for passes in (1, 2)]
    left = [off(x) for x in answers]
    assert left[0] < LEFT[thickness][0] and left[1] < LEFT[thickness][1] and solver.held.sum() == 1
    x, _ = solver.solve_both(load, zero)
    assert solver.passes <= 10 and solver.lost == 0.0 and off(x) < LEFT[thickness][1]
    assert off(answers[0], x) > 10 * off(answers[1], x)  # so one pass is not all


@pytest.mark.parametrize("stiffness", [1e2, 1e4, 1e5])
def test_the_answer_does_not_depend_on_the_scale(stiffness, monkeypatch):
    system, matrix, gradient, load = ring(1e-2)
    answers, stiff = [], []
    for each in (conditioned.STIFFNESS, stiffness):
        monkeypatch.setattr(conditioned, "STIFFNESS", each)
        solver = ConditionedSolver(DirectSolver(system.pattern, system.constraints), gradient).factor(matrix)
        answers.append(solver.solve(load))
        stiff.append(solver.stiffness.max())
    assert stiff[1] / stiff[0] == pytest.approx(stiffness / 1e3)
    assert np.abs(answers[1] - answers[0]).max() < 1e-10 * np.abs(answers[0]).max()


def test_conditions_that_are_nearly_the_same_are_told():
    links = [sk.RigidLink((0.0, 0.5), (0.5, 2.5)), sk.RigidLink((0.0, 0.5 + 1e-6), (0.5, 2.5))]
    problem = sk.Problem(
        TUBE, 0.01, sk.Isotropic(2e11, 0.3, 7800.0), [sk.Clamp("left")], [sk.EdgeLoad("right", (0.0, 1.0, 0.0))],
        conditions=[sk.Hinge("start", "end"), *links],
    )  # fmt: skip
    system = problem.on(sk.meshes.uniform(TUBE, 3, 12), "kirchhoff")
    start, direct = system.undeformed, DirectSolver(system.pattern, system.constraints)
    solver = ConditionedSolver(direct, system.conditions.gradient(start)).factor(system.stiffness())
    solver.solve(system.external_force(start))
    assert solver.lost > 0.0
    solver.lost = 1e-3
    with pytest.warns(sk.OutOfDepth, match="nearly the same"):
        solver.warn_if_lost()

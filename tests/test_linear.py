"""Block matrices, constraints, and one contract for all direct solvers."""

import gc
from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from skancf import memory
from skancf.errors import InputError, NotEnoughMemory, SingularMatrix, SkancfError
from skancf.linear import (
    BACKENDS,
    BlockMatrix,
    BlockPattern,
    Constraints,
    DirectSolver,
    available_backends,
    dissection,
    kernels,
    mkl,
    rslab,
    solver,
)
from skancf.linear.dissection import nested_dissection

ROUNDING = 1e-13  # sums of a few dozen products of numbers of size one
SOLVED = 1e-10  # rounding times the condition of the matrices below, which is under 1e4

SEED = 11
rng = np.random.default_rng(SEED)


@pytest.fixture(autouse=True)
def same_numbers() -> None:
    """Each test sees the same numbers, alone or after others."""
    global rng
    rng = np.random.default_rng(SEED)


def grid(nx: int, ny: int) -> tuple[np.ndarray, np.ndarray]:
    """Cells (4, nx * ny) and points (2, n) of a rectangle, nodes numbered at random."""
    number = rng.permutation((nx + 1) * (ny + 1)).reshape(ny + 1, nx + 1)
    cells = np.stack([number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]]).reshape(4, -1)
    points = np.empty((2, number.size))
    points[:, number.ravel()] = np.mgrid[0 : ny + 1, 0 : nx + 1].reshape(2, -1)
    return cells, points


def pattern_of(nx: int, ny: int, block: int) -> BlockPattern:
    cells, points = grid(nx, ny)
    return BlockPattern.from_cells(cells, points.shape[1], block, points)


def random_matrix(pattern: BlockPattern) -> BlockMatrix:
    """Symmetric and indefinite, with large and small entries on the diagonal."""
    values = rng.standard_normal((pattern.n_blocks, pattern.block, pattern.block))
    values[pattern.diagonal_slots] += values[pattern.diagonal_slots].transpose(0, 2, 1)
    return BlockMatrix(pattern, values)


def dense_twin(matrix: BlockMatrix) -> np.ndarray:
    """Block by block, the plain way."""
    pattern, block = matrix.pattern, matrix.pattern.block
    full = np.zeros(matrix.shape)
    for i in range(pattern.n_nodes):
        for slot in range(pattern.indptr[i], pattern.indptr[i + 1]):
            j = pattern.indices[slot]
            full[i * block : (i + 1) * block, j * block : (j + 1) * block] = matrix.values[slot]
            full[j * block : (j + 1) * block, i * block : (i + 1) * block] = matrix.values[slot].T
    return full


def laplacian(nx: int, ny: int, block: int) -> tuple[BlockMatrix, np.ndarray]:
    """Sum of cells that resist all but the translations, as the stiffness of a body without supports does."""
    cells, points = grid(nx, ny)
    pattern = BlockPattern.from_cells(cells, points.shape[1], block, points)
    slots = pattern.slots(cells)
    values = np.zeros((pattern.n_blocks, block, block))
    root = rng.standard_normal((4 * block, 4 * block))
    keep = np.eye(4 * block) - np.kron(np.ones((4, 4)) / 4, np.eye(block))
    cell = (keep @ root @ root.T @ keep).reshape(4, block, 4, block).transpose(0, 2, 1, 3)
    for c in range(cells.shape[1]):
        for a, b in np.argwhere(slots[c] >= 0):
            values[slots[c, a, b]] += cell[a, b]
    return BlockMatrix(pattern, values), points


def frames(count: int, block: int) -> np.ndarray:
    return np.linalg.qr(rng.standard_normal((count, block, block)))[0]


def some_constraints(pattern: BlockPattern, framed: int) -> Constraints:
    fixed = rng.random((pattern.n_nodes, pattern.block)) < 0.3
    nodes = rng.permutation(pattern.n_nodes)[:framed]
    return Constraints(fixed, nodes, frames(framed, pattern.block))


def free_basis(constraints: Constraints) -> np.ndarray:
    """Dense columns that span the free directions: q = basis @ z."""
    n = constraints.fixed.size
    turn = np.stack([constraints.to_frame(unit) for unit in np.eye(n)], axis=1)
    return turn.T[:, ~constraints.fixed.ravel()]


def dense_solution(matrix: BlockMatrix, constraints: Constraints, rhs: np.ndarray) -> np.ndarray:
    basis = free_basis(constraints)
    return basis @ np.linalg.solve(basis.T @ dense_twin(matrix) @ basis, basis.T @ rhs)


@pytest.fixture(params=[backend.name for backend in BACKENDS])
def backend(request: pytest.FixtureRequest) -> str:
    if request.param not in available_backends():
        pytest.skip(f"{request.param} is not installed")
    return request.param


# ---------------------------------------------------------------------------------------------------------- pattern


def test_slots_against_a_search_by_hand():
    cells, points = grid(4, 3)
    cells = np.vstack([cells, cells[:1]])  # a cell may name more nodes, and one of them twice
    pattern = BlockPattern.from_cells(cells, points.shape[1], 2, points)
    slots = pattern.slots(cells)
    assert slots.dtype == np.int32 and slots.shape == (12, 5, 5)
    for c, nodes in enumerate(cells.T):
        for a, row in enumerate(nodes):
            for b, column in enumerate(nodes):
                if row > column:
                    assert slots[c, a, b] == -1
                else:
                    assert (pattern.rows[slots[c, a, b]], pattern.indices[slots[c, a, b]]) == (row, column)


def test_pattern_is_the_graph_and_nothing_more():
    cells = np.array([[0], [1], [2], [4]])
    pattern = BlockPattern.from_cells(cells, 6, 2, np.zeros((2, 6)))
    rows = [pattern.indices[a:b].tolist() for a, b in zip(pattern.indptr[:-1], pattern.indptr[1:], strict=True)]
    assert rows == [[0, 1, 2, 4], [1, 2, 4], [2, 4], [3], [4], [5]]  # node 3 and 5 stand alone
    assert pattern.indptr.dtype == pattern.indices.dtype == np.int32


def test_pattern_refuses_what_does_not_fit():
    cells, points = grid(2, 2)
    pattern = BlockPattern.from_cells(cells[:, :1], 9, 3, points)
    with pytest.raises(InputError, match="are not coupled"):
        pattern.slots(cells)
    with pytest.raises(InputError, match="the mesh has 0 to 4"):
        BlockPattern.from_cells(cells, 5, 3, points[:, :5])
    with pytest.raises(InputError, match=r"give \(d, 9\)"):
        BlockPattern.from_cells(cells, 9, 3, points[:, :5])


# ----------------------------------------------------------------------------------------------------------- matrix


@pytest.mark.parametrize("block", [1, 3, 12])
def test_products_and_copies_agree_with_the_plain_twin(block):
    matrix = random_matrix(pattern_of(4, 3, block))
    full, v = dense_twin(matrix), rng.standard_normal(matrix.shape[0])
    assert (full == full.T).all()
    assert (matrix.to_scipy().toarray() == full).all()
    assert (matrix.diagonal() == np.diag(full)).all()
    assert np.abs(matrix @ v - full @ v).max() < ROUNDING * np.abs(full).sum(axis=1).max()
    assert np.abs(np.triu(full) @ v - full @ v).max() > 0.1  # half the matrix would be seen


def test_sums_and_multiples():
    pattern = pattern_of(2, 2, 3)
    a, b = random_matrix(pattern), random_matrix(pattern)
    assert ((a + 2 * b).values == a.values + 2 * b.values).all()
    assert ((b * np.float64(0.5)).values == 0.5 * b.values).all()
    with pytest.raises(InputError, match="one pattern"):
        a + random_matrix(pattern_of(2, 2, 3))
    with pytest.raises(InputError, match="give float64"):
        BlockMatrix(pattern, a.values[:-1])
    with pytest.raises(InputError, match="times a matrix"):
        a @ np.zeros(5)


# ------------------------------------------------------------------------------------------------------ constraints


def test_frames_are_turns_and_parts_add_up():
    pattern = pattern_of(3, 2, 4)
    constraints = some_constraints(pattern, framed=5)
    v = rng.standard_normal(pattern.shape[0])
    node, frame = constraints.frame_nodes[2], constraints.frames[2]
    turned = constraints.to_frame(v).reshape(-1, 4)
    assert np.abs(turned[node] - frame @ v.reshape(-1, 4)[node]).max() < ROUNDING
    assert np.abs(frame @ v.reshape(-1, 4)[node] - frame.T @ v.reshape(-1, 4)[node]).max() > 0.1  # R is not R^T
    assert np.abs(constraints.from_frame(turned.ravel()) - v).max() < ROUNDING
    free, fixed = constraints.free_part(v), constraints.fixed_part(v)
    assert np.abs(free + fixed - v).max() < ROUNDING
    assert np.abs(constraints.to_frame(free)[constraints.fixed.ravel()]).max() < ROUNDING
    assert np.abs(constraints.free_part(free) - free).max() < ROUNDING
    assert constraints.n_free == free_basis(constraints).shape[1]


def test_without_frames_parts_are_exact():
    fixed = rng.random((6, 3)) < 0.5
    v = rng.standard_normal(18)
    constraints = Constraints(fixed)
    assert (constraints.free_part(v) == np.where(fixed.ravel(), 0, v)).all()
    assert constraints.to_frame(v) is not v  # the caller may write into the answer


def test_constraints_refuse_what_does_not_fit():
    fixed = np.zeros((4, 3), bool)
    with pytest.raises(InputError, match="mutually orthogonal"):
        Constraints(fixed, np.array([1]), 1.001 * np.eye(3)[None])
    with pytest.raises(InputError, match="name each node once"):
        Constraints(fixed, np.array([1, 1]), frames(2, 3))
    with pytest.raises(InputError, match="one matrix per frame node"):
        Constraints(fixed, np.array([1]), frames(2, 3))
    with pytest.raises(InputError, match="give bool"):
        Constraints(np.zeros((4, 3)))


# ------------------------------------------------------------------------------------------------------- dissection


def fill(pattern: BlockPattern, order: np.ndarray) -> int:
    """Entries in the lower factor of a positive definite matrix when nodes are eliminated in this order."""
    full = pattern.sources().astype(bool).astype(float)[order][:, order].tocsc()
    full.data[:] = -1.0
    full.setdiag(10.0)
    return splu(full, permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True}).L.nnz


@pytest.mark.parametrize("block", [1, 3])
def test_upper_triangle_of_entries_against_scipy(block):
    matrix = random_matrix(pattern_of(3, 4, block))
    pattern = matrix.pattern
    indptr, indices = kernels.upper_pattern(pattern.indptr, pattern.indices, block)
    entries = np.empty(indices.size)
    kernels.upper_entries(pattern.indptr, matrix.values, entries)
    expected = sp.triu(matrix.to_scipy(), format="csr")
    assert (indptr == expected.indptr).all() and (indices == expected.indices).all()
    assert (entries == expected.data).all()


def test_dissection_is_a_permutation_with_less_fill():
    n = 60
    pattern = pattern_of(n, n, 1)
    order = nested_dissection(pattern)
    assert (np.sort(order) == np.arange(pattern.n_nodes)).all()
    row_by_row = np.lexsort(pattern.coordinates)
    # The band of the order row by row has n + 2 entries per node; theory gives 31/4 n^2 log2 n + O(n^2) for dissection.
    assert fill(pattern, order) < 0.65 * fill(pattern, row_by_row)
    assert fill(pattern, row_by_row) < 0.65 * fill(pattern, np.arange(pattern.n_nodes))  # the measure has teeth


def test_dissection_of_odd_meshes():
    for points in (np.zeros((2, 200)), rng.random((3, 200)), np.stack([np.arange(200.0), np.zeros(200)])):
        cells = np.stack([np.arange(199), np.arange(1, 200)])
        order = nested_dissection(BlockPattern.from_cells(cells, 200, 1, points), leaf=10)
        assert (np.sort(order) == np.arange(200)).all()


def test_touches_against_a_search_by_hand():
    pattern = pattern_of(5, 5, 1)
    indptr, indices = pattern.neighbours()
    part = rng.integers(0, 20, pattern.n_nodes)
    part[7] = 2
    nodes = np.flatnonzero(part != 2)
    plain = [any(part[j] == 2 for j in indices[indptr[i] : indptr[i + 1]]) for i in nodes]
    assert 0 < sum(plain) < len(plain)
    assert (kernels.touches(nodes, indptr, indices, part, 2) == plain).all()


# ----------------------------------------------------------------------------------------- contract of the solvers


@pytest.mark.parametrize("framed", [0, 7, 30])
def test_solution_and_inertia_against_dense_elimination(backend, framed):
    pattern = pattern_of(5, 4, 4)
    matrix, constraints = random_matrix(pattern), some_constraints(pattern, framed)
    rhs = rng.standard_normal(pattern.shape[0])
    direct = DirectSolver(pattern, constraints, backend)
    direct.factor(matrix)
    x, expected = direct.solve(rhs), dense_solution(matrix, constraints, rhs)
    assert direct.backend_name == backend and direct.perturbed_pivots == 0
    assert np.abs(x - expected).max() < SOLVED * np.abs(expected).max()
    assert np.abs(constraints.fixed_part(x)).max() < ROUNDING * np.abs(x).max()

    basis = free_basis(constraints)
    eigenvalues = np.linalg.eigvalsh(basis.T @ dense_twin(matrix) @ basis)
    assert direct.negative_pivots == np.count_nonzero(eigenvalues < 0)
    unconstrained = np.count_nonzero(np.linalg.eigvalsh(dense_twin(matrix)) < 0)
    assert direct.negative_pivots != unconstrained  # counting fixed coordinates too would be seen


def test_prescribed_part_of_the_right_hand_side_is_ignored(backend):
    pattern = pattern_of(3, 3, 3)
    constraints = some_constraints(pattern, 4)
    direct = DirectSolver(pattern, constraints, backend)
    direct.factor(random_matrix(pattern))
    rhs = rng.standard_normal(pattern.shape[0])
    with_more = rhs + 1e3 * constraints.fixed_part(rng.standard_normal(rhs.size))
    # A turn there and back leaves the rounding of the large part.
    assert np.abs(direct.solve(with_more) - direct.solve(rhs)).max() < SOLVED


def test_second_factorisation_reuses_the_symbolic_one(backend, monkeypatch):
    kind = next(kind for kind in BACKENDS if kind.name == backend)
    calls, symbolic = [], kind.symbolic

    def recording(self, pattern):
        calls.append(pattern)
        symbolic(self, pattern)

    monkeypatch.setattr(kind, "symbolic", recording)
    pattern = pattern_of(4, 4, 3)
    constraints = some_constraints(pattern, 3)
    direct = DirectSolver(pattern, constraints, backend)
    rhs, answers = rng.standard_normal(pattern.shape[0]), []
    for matrix in (random_matrix(pattern), random_matrix(pattern)):
        before = matrix.values.copy()
        direct.factor(matrix)
        answers.append(direct.solve(rhs))
        expected = dense_solution(matrix, constraints, rhs)
        assert np.abs(answers[-1] - expected).max() < SOLVED * np.abs(expected).max()
        assert (matrix.values == before).all()  # the caller's matrix stays as it is
    assert len(calls) == 1
    assert np.abs(answers[0] - answers[1]).max() > 0.01


def test_bad_scales_do_no_harm(backend):
    pattern = pattern_of(6, 6, 6)
    good = random_matrix(pattern)
    size = 10.0 ** rng.uniform(-6, 3, (pattern.n_nodes, pattern.block))  # diagonal from 1e-12 to 1e6
    bad = BlockMatrix(pattern, good.values * size[pattern.rows][:, :, None] * size[pattern.indices][:, None, :])
    assert np.ptp(np.log10(np.abs(bad.diagonal()))) > 16
    direct = DirectSolver(pattern, Constraints(np.zeros(size.shape, bool)), backend)
    direct.factor(bad)
    rhs = size.ravel() * rng.standard_normal(size.size)

    def residual(x: np.ndarray) -> float:
        return np.abs((bad @ x - rhs) / size.ravel()).max()

    # 1e-12 of a right-hand side of size one; some 50 terms of rounding 1e-16 and size at most 100 each.
    assert residual(direct.solve(rhs)) < 1e-12
    assert residual(direct.solve(rhs)) < 0.5 * residual(direct.solve(rhs, refinements=0))  # the refinement took part


def test_a_pivot_that_is_exactly_zero(backend):
    pattern = BlockPattern.from_cells(np.array([[0], [1]]), 2, 2, np.array([[0.0, 1.0]]))
    ones = np.ones((2, 2))
    matrix = BlockMatrix(pattern, np.stack([ones, np.array([[0.3, -0.5], [0.7, 0.2]]), ones]))
    direct = DirectSolver(pattern, Constraints(np.zeros((2, 2), bool)), backend)
    direct.factor(matrix)
    full = dense_twin(matrix)
    rhs = np.array([1.0, -2.0, 0.5, 3.0])
    assert np.abs(full @ direct.solve(rhs) - rhs).max() < ROUNDING
    assert direct.negative_pivots == np.count_nonzero(np.linalg.eigvalsh(full) < 0) > 0


def test_poor_factors_are_replaced_by_careful_ones(backend, monkeypatch):
    kind = next(kind for kind in BACKENDS if kind.name == backend)
    asked, factor = [], kind.factor

    def recording(self, values, careful=False):
        asked.append(careful)
        factor(self, values, careful)

    monkeypatch.setattr(kind, "factor", recording)
    monkeypatch.setattr(solver, "POOR", 0.0)  # every factor counts as poor
    pattern = pattern_of(5, 5, 3)
    matrix, constraints = random_matrix(pattern), some_constraints(pattern, 3)
    rhs = rng.standard_normal(pattern.shape[0])
    direct = DirectSolver(pattern, constraints, backend)
    direct.factor(matrix)
    negative, x = direct.negative_pivots, direct.solve(rhs)
    assert asked == [False, True]
    expected = dense_solution(matrix, constraints, rhs)
    assert np.abs(x - expected).max() < SOLVED * np.abs(expected).max()
    assert direct.negative_pivots == negative


@pytest.mark.skipif("rslab" not in available_backends(), reason="rslab is not installed")
def test_rslab_analyses_a_pattern_once_and_not_longer_than_it_lives(monkeypatch):
    analysed, analysis = [], rslab._analysis
    monkeypatch.setattr(rslab, "_analysis", lambda pattern: analysed.append(1) or analysis(pattern))
    pattern = pattern_of(4, 4, 3)
    constraints, rhs, answers = some_constraints(pattern, 3), rng.standard_normal(pattern.shape[0]), []
    matrix = random_matrix(pattern)
    for _ in range(2):
        with DirectSolver(pattern, constraints, "rslab") as direct:
            direct.factor(matrix)
            answers.append(direct.solve(rhs))
    assert len(analysed) == 1 and (answers[0] == answers[1]).all()
    known = len(rslab.ANALYSES)
    del pattern, matrix, direct
    gc.collect()
    assert len(rslab.ANALYSES) == known - 1


@pytest.mark.skipif("rslab" not in available_backends(), reason="rslab is not installed")
def test_rslab_hands_over_what_it_cannot_pivot():
    """Without a diagonal no supernode has pivots of its own."""
    pattern = pattern_of(9, 9, 1)
    matrix = random_matrix(pattern)
    matrix.values[pattern.diagonal_slots] = 0.0
    direct, full = rslab.Rslab(), dense_twin(matrix)
    direct.symbolic(pattern)
    direct.factor(matrix.values)
    assert direct.perturbed_pivots > 0
    assert direct.negative_pivots == np.count_nonzero(np.linalg.eigvalsh(full) < 0)
    direct.factor(matrix.values, careful=True)
    assert direct.perturbed_pivots == 0
    rhs = rng.standard_normal(pattern.shape[0])
    assert np.abs(full @ direct.solve(rhs) - rhs).max() < SOLVED * np.abs(direct.solve(rhs)).max()


# --------------------------------------------------------------------------------------------- what cannot be solved


@pytest.mark.parametrize("size", [3, 30])
def test_a_body_without_supports_is_named(backend, size):
    matrix, _ = laplacian(size, size, 3)
    pattern = matrix.pattern
    with pytest.raises(SingularMatrix, match=r"node \d+ at .* moves freely.*part without support"):
        DirectSolver(pattern, Constraints(np.zeros((pattern.n_nodes, 3), bool)), backend).factor(matrix)
    held = np.zeros((pattern.n_nodes, 3), bool)
    held[0] = True
    direct = DirectSolver(pattern, Constraints(held), backend)
    direct.factor(matrix)  # one held node is enough
    assert direct.negative_pivots == 0


def test_the_part_that_moves_is_the_one_named(backend):
    """Two bodies in one mesh, the second one without support in direction 1 of 3."""
    matrix, points = laplacian(4, 4, 3)
    n = points.shape[1]
    one = matrix.pattern
    indices = np.concatenate([one.indices, one.indices + n]).astype(np.int32)
    indptr = np.concatenate([one.indptr, one.indptr[1:] + one.n_blocks]).astype(np.int32)
    pattern = BlockPattern(2 * n, 3, indptr, indices, np.hstack([points, points + 9]))
    fixed = np.zeros((2 * n, 3), bool)
    fixed[0] = True
    fixed[n] = (True, False, True)
    both = BlockMatrix(pattern, np.tile(matrix.values, (2, 1, 1)))
    with pytest.raises(SingularMatrix) as caught:
        DirectSolver(pattern, Constraints(fixed), backend).factor(both)
    named = int(str(caught.value).split("node ")[1].split()[0])
    assert n <= named < 2 * n
    assert "coordinate 1" in str(caught.value)


def test_a_nearly_singular_matrix_is_still_solved(backend):
    """Ten orders softer than its diagonal: thin plates are like that, and must not be refused."""
    matrix, _ = laplacian(10, 10, 3)
    pattern = matrix.pattern
    soft = matrix.values.copy()
    soft[pattern.diagonal_slots] += 1e-10 * np.eye(3)
    direct = DirectSolver(pattern, Constraints(np.zeros((pattern.n_nodes, 3), bool)), backend)
    direct.factor(BlockMatrix(pattern, soft))
    rigid = np.tile([1.0, 2.0, 3.0], pattern.n_nodes)
    # x = rigid / 1e-10; rounding 1e-16 of the diagonal, some 30, against 1e-10 leaves four digits.
    assert np.abs(1e-10 * direct.solve(rigid) - rigid).max() < 1e-3
    assert direct.negative_pivots == 0


@pytest.mark.parametrize("framed", [False, True])
def test_a_coordinate_without_stiffness_is_named(backend, framed):
    matrix, _ = laplacian(3, 3, 3)
    pattern = matrix.pattern
    held, turn = np.zeros((pattern.n_nodes, 3), bool), frames(1, 3)
    held[0] = True
    constraints = Constraints(held, np.array([5]), turn) if framed else Constraints(held)
    dead = np.eye(3) - np.outer(turn[0, 1], turn[0, 1]) if framed else np.diag([1.0, 0.0, 1.0])
    values = matrix.values.copy()
    values[pattern.rows == 5] = dead @ values[pattern.rows == 5]
    values[pattern.indices == 5] = values[pattern.indices == 5] @ dead
    with pytest.raises(SingularMatrix, match=r"node 5, coordinate 1.*should be prescribed"):
        DirectSolver(pattern, constraints, backend).factor(BlockMatrix(pattern, values))


def test_values_that_are_not_finite_are_named(backend):
    pattern = pattern_of(3, 3, 2)
    matrix = random_matrix(pattern)
    direct = DirectSolver(pattern, Constraints(np.zeros((16, 2), bool)), backend)
    slot = int(np.flatnonzero(pattern.rows != pattern.indices)[0])
    for bad in (np.nan, np.inf):
        values = matrix.values.copy()
        values[slot, 1, 0] = bad
        with pytest.raises(SingularMatrix, match=f"nodes {pattern.rows[slot]} and {pattern.indices[slot]}"):
            direct.factor(BlockMatrix(pattern, values))
    values[pattern.diagonal_slots[3], 1, 1] = np.nan
    with pytest.raises(SingularMatrix, match="node 3, coordinate 1: diagonal entry nan"):
        direct.factor(BlockMatrix(pattern, values))
    with pytest.raises(SkancfError, match="call factor"):
        direct.solve(np.zeros(32))
    direct.factor(matrix)  # a failure leaves nothing behind
    rhs = rng.standard_normal(32)
    assert np.abs(matrix @ direct.solve(rhs) - rhs).max() < SOLVED


def test_misuse_is_refused(backend):
    pattern = pattern_of(2, 2, 2)
    constraints = Constraints(np.zeros((9, 2), bool))
    with DirectSolver(pattern, constraints, backend) as direct:
        direct.factor(random_matrix(pattern))
        with pytest.raises(InputError, match=r"give \(18,\)"):
            direct.solve(np.zeros(5))
        with pytest.raises(InputError, match="another pattern"):
            direct.factor(random_matrix(pattern_of(2, 2, 2)))
    for call in (lambda: direct.solve(np.zeros(18)), lambda: direct.factor(random_matrix(pattern))):
        with pytest.raises(SkancfError):
            call()
    direct.close()
    with pytest.raises(InputError, match="coordinates"):
        DirectSolver(pattern, Constraints(np.zeros((9, 3), bool)), backend)


# --------------------------------------------------------------------------------------------------------- memory


def test_counted_fill_against_that_of_superlu():
    pattern = pattern_of(6, 7, 3)
    single = replace(pattern, block=1)
    for order in (np.arange(pattern.n_nodes), nested_dissection(pattern, leaf=5), rng.permutation(pattern.n_nodes)):
        below = fill(single, order) - pattern.n_nodes
        assert dissection.fill(pattern, order) == 9 * below + 6 * pattern.n_nodes


def test_what_will_not_fit_is_refused_first(backend, monkeypatch):
    kind = next(kind for kind in BACKENDS if kind.name == backend)
    pattern = pattern_of(20, 20, 12)
    constraints = Constraints(np.zeros((pattern.n_nodes, 12), bool))
    needed = DirectSolver(pattern, constraints, backend).memory
    least = 2 * pattern.n_blocks * 144 * 8 + 8 * dissection.fill(pattern, nested_dissection(pattern))
    assert 0.8 * least < needed < 4 * least
    monkeypatch.setattr(kind, "factor", lambda *_: pytest.fail("factored"))
    monkeypatch.setattr(memory, "available", lambda: needed - 1)
    with pytest.raises(NotEnoughMemory, match=rf"5292 unknowns: .* by {backend} needs 0\.\d+ GB, and .*coarser mesh"):
        DirectSolver(pattern, constraints, backend)
    for enough in (needed, None):
        monkeypatch.setattr(memory, "available", lambda enough=enough: enough)
        DirectSolver(pattern, constraints, backend)


def test_memory_of_containers_and_of_the_machine(tmp_path, monkeypatch):
    proc, groups = tmp_path / "proc", tmp_path / "cgroup"
    monkeypatch.setattr(memory, "PROC", proc)
    monkeypatch.setattr(memory, "CGROUP", groups)
    (proc / "self").mkdir(parents=True)
    (groups / "job/step").mkdir(parents=True)
    (proc / "meminfo").write_text("MemTotal: 900 kB\nMemAvailable: 700 kB\n")
    assert memory.available() == 700 * 1024
    (proc / "self/cgroup").write_text("0::/job/step\n")
    (groups / "job/step/memory.max").write_text("max\n")
    assert memory.available() == 700 * 1024
    for name, text in (("max", "500000"), ("current", "300000"), ("stat", "anon 5\ninactive_file 1000\n")):
        (groups / f"job/memory.{name}").write_text(text)
    assert memory.available() == 201_000  # the limit of the whole job counts for each of its steps
    (proc / "meminfo").unlink()
    monkeypatch.setattr(memory.os, "sysconf_names", {})
    (groups / "job/memory.max").write_text("max\n")
    assert memory.available() is None


# -------------------------------------------------------------------------------------------- choosing a solver


def test_without_the_fast_solvers_the_next_one_is_taken(monkeypatch):
    pattern = pattern_of(2, 2, 2)
    constraints = Constraints(np.zeros((9, 2), bool))
    monkeypatch.setattr(mkl, "load", lambda: None)
    assert available_backends()[-1] == "superlu" and "mkl" not in available_backends()
    with pytest.raises(InputError, match=r"pip install 'skancf\[fast\]'"):
        DirectSolver(pattern, constraints, "mkl")
    monkeypatch.setattr(rslab, "_module", lambda: None)
    assert available_backends() == ("superlu",)
    assert DirectSolver(pattern, constraints).backend_name == "superlu"
    with pytest.raises(InputError, match="pip install rslab"):
        DirectSolver(pattern, constraints, "rslab")
    with pytest.raises(InputError, match="choose 'auto' or one of"):
        DirectSolver(pattern, constraints, "umfpack")


def test_auto_takes_the_first_available():
    direct = DirectSolver(pattern_of(2, 2, 2), Constraints(np.zeros((9, 2), bool)))
    assert direct.backend_name == available_backends()[0]


@pytest.mark.skipif("mkl" not in available_backends(), reason="mkl is not installed")
def test_mkl_gives_its_memory_back(monkeypatch):
    from skancf.linear.pardiso import RELEASE, _Handle

    gc.collect()  # the solvers that earlier tests dropped shall not be counted here
    phases, run = [], _Handle.run

    def recording(self, phase, *vectors):
        phases.append(phase)
        run(self, phase, *vectors)

    monkeypatch.setattr(_Handle, "run", recording)
    pattern = pattern_of(2, 2, 2)
    for close in (True, False):
        direct = DirectSolver(pattern, Constraints(np.zeros((9, 2), bool)), "mkl")
        direct.factor(random_matrix(pattern))
        if close:
            direct.close()
        del direct
        gc.collect()
    assert phases.count(RELEASE) == 2

"""Tolerances are in one file. Small numbers elsewhere are steps, shifts and ranges, listed here with their reason."""

import ast
import operator
from collections.abc import Iterator
from pathlib import Path

import pytest

import skancf
from skancf import tolerances

PACKAGE = Path(skancf.__file__).parent
SMALL = 1e-5
# Small numbers that are no tolerances of place, angle, rounding or convergence.
ELSEWHERE = {
    ("errors.py", "SMALLEST"): "range of numbers that are computed with",
    ("materials/section.py", "LEAST"): "range of stiffnesses",
    ("problem.py", "SMALLEST_EXTENT"): "range of lengths",
    ("dynamics/prescribed.py", "RATE_STEP"): "step of a difference",
    ("dynamics/step_newton.py", "DIFFERENCE"): "step of a difference",
    ("terms/forms/integrand.py", "DIFFERENCE"): "step of a difference",
    ("terms/forms/integrand.py", "COMPLEX_STEP"): "step of a difference",
    ("materials/hyperelastic/own_check.py", "DIFFERENCE"): "step of a difference",
    ("materials/hyperelastic/own_kernels.py", "SHORT"): "step of a difference",
    ("materials/hyperelastic/own_kernels.py", "TINY_STEP"): "step of a difference",
    ("materials/hyperelastic/own_kernels.py", "AHEAD"): "step of a difference",
    ("materials/hyperelastic/own_kernels.py", "SUSPECT"): "from where on a value is looked at once more",
    ("surfaces/mapped.py", "SMALLEST_STEP"): "step of a difference, bound of an argument",
    ("conditions/check.py", "STEPS"): "steps of differences",
    ("dynamics/impulses.py", "INSIDE"): "where in a step a load is looked at",
    ("materials/heights.py", "ABOVE"): "where above an interface stresses are shown",
    ("adaptive/grow.py", "SMALLEST"): "size of the smallest elements",
    ("linear/least_squares.py", "LEAST"): "damping of a step",
    ("linear/rslab.py", "SMALLEST_PIVOT"): "stands for a pivot",
    ("linear/softest.py", "SHIFT"): "shift of a matrix",
    ("linear/solver.py", "NEARBY"): "shift of a matrix",
    ("linear/superlu.py", "SIGN_SHIFT"): "shift of a matrix",
}
OPERATIONS = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
}


def number(node: ast.AST) -> float | None:
    """The value of a number, or of arithmetic with numbers only."""
    if isinstance(node, ast.Constant) and type(node.value) in (int, float):
        return float(node.value)
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        value = number(node.operand)
        return None if value is None else -value
    if isinstance(node, ast.BinOp) and type(node.op) in OPERATIONS:
        left, right = number(node.left), number(node.right)
        return None if left is None or right is None else OPERATIONS[type(node.op)](left, right)
    return None


def small_numbers(node: ast.AST) -> Iterator[ast.AST]:
    """Numbers below 1e-5 in a piece of code, and questions for the last digit; but not defaults, which users may change.

    Of arithmetic with numbers alone the value counts, not its parts, and of one less a small number that.
    """
    if isinstance(node, (ast.arguments, ast.AnnAssign)):  # of a function, and a field of a class
        return
    value = number(node)
    if value is not None:
        if 0 < abs(value) < SMALL or 0 < abs(value - 1) < SMALL:
            yield node
        return
    if isinstance(node, ast.Attribute) and node.attr == "finfo":
        yield node
    for child in ast.iter_child_nodes(node):
        yield from small_numbers(child)


def assigned(statement: ast.AST) -> list[tuple[str, ast.AST]]:
    """Names and values of the constants of a module's statement."""
    if not isinstance(statement, ast.Assign):
        return []
    target, value = statement.targets[0], statement.value
    if isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple):
        return [(ast.unparse(name), each) for name, each in zip(target.elts, value.elts, strict=True)]
    return [(ast.unparse(target), value)]


def misplaced(source: str, file: str) -> list[str]:
    """Small numbers of a file that are no exception, each as its line and the code."""
    found = []
    for statement in ast.parse(source).body:
        parts = assigned(statement) or [("", statement)]
        nodes = [node for name, value in parts if (file, name) not in ELSEWHERE for node in small_numbers(value)]
        found += [f"{file}:{node.lineno}: {ast.unparse(node)}" for node in nodes]
    return found


def library() -> dict[str, str]:
    """Every other file of the package."""
    files = {path.relative_to(PACKAGE).as_posix(): path.read_text(encoding="utf-8") for path in PACKAGE.rglob("*.py")}
    return {file: source for file, source in sorted(files.items()) if file != "tolerances.py"}


def test_tolerances_are_in_one_file():
    found = [line for file, source in library().items() for line in misplaced(source, file)]
    assert not found, "give each a name in tolerances.py, or a reason here"


def test_every_exception_is_needed():
    seen = {
        (file, name)
        for file, source in library().items()
        for statement in ast.parse(source).body
        for name, value in assigned(statement)
        if any(small_numbers(value))
    }
    assert set(ELSEWHERE) == seen & set(ELSEWHERE)


def test_no_name_is_of_a_tolerance_and_of_something_else():
    known = {name for name in vars(tolerances) if name.isupper()}
    twice = [
        f"{file}: {name}"
        for file, source in library().items()
        for statement in ast.parse(source).body
        for name, _ in assigned(statement)
        if name in known or name in ("ROUNDING", "SAME")
    ]
    assert not twice


@pytest.mark.parametrize(
    "source",
    [
        "ROUNDING = 1e-12",
        "LEAST, MOST = 1e-9, 3",
        "HELD = 1 - 1e-6",
        "SAME = 2.0**-40",
        "EPS = 16 * np.finfo(float).eps",
        "def f(x):\n    return x < 1e-9",
        "def f(x):\n    return np.linalg.pinv(x, rcond=1e-12)",
        "class Rule:\n    newton_rtol = 1e-9",
        "if -1e-7 < x: pass",
    ],
)
def test_the_search_finds(source):
    assert len(misplaced(source, "somewhere.py")) == 1


@pytest.mark.parametrize(
    "source",
    [
        "def solve(rtol=1e-7, *, atol=1e-30): ...",
        "class Options:\n    rtol: float = 1e-7",
        "SHARE = 0.05",
        "COUNT = 100_000",
        "ONE = 1.0",
        "text = 'abs(x) < 1e-9'",
        "from skancf.tolerances import ONE_PLACE\nreach = 2 * ONE_PLACE",
    ],
)
def test_the_search_passes(source):
    assert misplaced(source, "somewhere.py") == []


def test_families_are_in_order():
    """What one family takes for one is no closer than what it calls rounding."""
    t = tolerances
    assert t.ROUNDED_PLACE < t.ONE_PLACE < t.SAME_POINT < t.SEVEN_DIGITS < t.APART_OF_EDGE < t.MOVED_OF_EDGE
    assert t.ROUNDED_TIME < t.ONE_TIME < t.EQUIDISTANT
    assert t.PARALLEL_LINES < t.ORTHONORMAL < t.PARALLEL < t.ONE_LINE < t.ONE_DIRECTION
    assert t.EPS < t.ROUNDED_COORDINATE < t.ROUNDED_SUM < t.ROUNDED_VALUE < t.ROUNDED_PRODUCT < t.SAME_VALUE
    assert t.RIGID == t.ROUNDED_PRODUCT**2
    assert t.ROOT < t.NEWTON_EXACT < t.SHARPEST < t.NEWTON_DAMPED

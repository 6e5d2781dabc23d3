"""Objects are equal by value, and are copied and pickled before and after use."""

import copy
import pickle
import warnings
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial
from multiprocessing import get_context

import numpy as np
import pytest
from kept import every, example, linked, problem, results, system

import skancf as sk
from skancf.equality import same

COPIES = {"pickle": lambda thing: pickle.loads(pickle.dumps(thing)), "deepcopy": copy.deepcopy}
NAMES = ["Solution", "StaticResult", "with conditions", "PathResult", "Modes", "BucklingResult", "Motion",
         "Motion with conditions", "AdaptiveResult"]  # fmt: skip
MIDDLE = np.array([[0.5], [0.5]])


@pytest.fixture(scope="module")
def found():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return results()


@pytest.mark.parametrize("copied", COPIES.values(), ids=COPIES)
@pytest.mark.parametrize("name", every())
def test_descriptions_are_equal_by_value(name, copied):
    one = example(name)
    assert one == example(name) and hash(one) == hash(example(name))
    assert copied(one) == one and one != object()


def test_arrays_and_lists_describe_the_same():
    one, two = (sk.PointForce((0.5, 0.5), kind([0.0, 0.0, -1.0])) for kind in (np.array, list))
    assert one == two and hash(one) == hash(two)
    assert one != sk.PointForce((0.5, 0.5), (0.0, 0.0, -2.0)) and one != sk.PointMoment((0.5, 0.5), (0.0, 0.0, -1.0))


def test_problems_differ_by_any_part():
    one = problem()
    assert one == problem() and one != replace(one, thickness=0.011) and one != replace(one, supports=[])
    assert one != replace(one, material=sk.Anisotropic(np.eye(6) * 1e9, density=1.0))


@pytest.mark.parametrize(
    ("one", "two", "equal"),
    [
        (np.nan, float("nan"), True), ([1, 2.0], (1.0, 2), True), ([1, 2], [1, 2, 3], False), (np.zeros(2), "ab", False),
        (np.array([np.nan, 1]), np.array([np.nan, 1]), True), (np.zeros((2, 1)), np.zeros(2), False), ({"a": 1}, {}, False),
        ({"a": np.ones(2)}, {"a": [1, 1]}, True), (partial(max, 1), partial(max, 1), True), (partial(max, 1), max, False),
        (None, np.zeros(1), False), (np.array(["a"]), np.array(["a"]), True), (lambda: 1, lambda: 1, False),
    ],
)  # fmt: skip
def test_values(one, two, equal):
    assert same(one, two) is equal and same(two, one) is equal


@pytest.mark.parametrize("copied", COPIES.values(), ids=COPIES)
@pytest.mark.parametrize("make", [system, linked, lambda: system("full", tree=True)], ids=["plain", "linked", "tree"])
def test_systems_are_built_again(make, copied):
    one = make()
    before = copied(one)
    solution = sk.solve(one).solution  # there are factors, sums and compiled code now
    after = copied(one)
    assert one == before == after and hash(one) == hash(after) and one is not after
    assert np.array_equal(after.undeformed, one.undeformed)
    assert np.array_equal(sk.solve(after).solution.q, solution.q), "to the last bit"
    assert one != system("full")


def test_systems_differ_by_mesh_and_theory():
    one = system()
    assert one != system("full") and one != system(tree=True) and one != one.problem.on(
        sk.meshes.uniform(one.problem.surface, 2, 2), "kirchhoff")  # fmt: skip
    assert len({one, system(), system("full")}) == 2


@pytest.mark.parametrize("copied", COPIES.values(), ids=COPIES)
@pytest.mark.parametrize("name", NAMES)
def test_results_are_copied_after_use(found, name, copied):
    one = found[name]
    two = copied(one)
    assert one == two and one == one
    assert same(vars(one).get("records"), vars(two).get("records"))
    _ = getattr(one, "theory_errors", None)  # a cached property is no part of it
    assert copied(one) == two


def test_a_result_answers_after_pickling(found):
    one, two = (COPIES["pickle"](found["StaticResult"]), found["StaticResult"])
    assert one.solution.system is one.path[0].system, "one system stays one"
    for ask in (lambda s: s.section_forces(), lambda s: s.stresses(MIDDLE, "top"), lambda s: s.displacement((0.3, 0.2))):
        assert np.array_equal(ask(one.solution), ask(two.solution))


def test_results_differ(found):
    solution = found["Solution"]
    assert solution != replace(solution, q=solution.q + 1e-9, small=None) and solution != found["StaticResult"]
    motion = found["Motion"]
    assert motion != replace(motion, seconds=motion.seconds + 1) and motion != found["Motion with conditions"]


@pytest.mark.parametrize("tree", [False, True])
def test_meshes_of_the_library_are_equal_by_value(tree):
    one, two = (system(tree=tree).mesh for _ in range(2))
    assert same(one, two) and same(two, one)
    if tree:
        assert one == two and one != one.refined([1]) and COPIES["pickle"](one) == one
        assert np.array_equal(COPIES["pickle"](one).refined([0]).p, one.refined([0]).p)


def tip(state_and_factor):
    """For another process."""
    solution, factor = state_and_factor
    return sk.solve(solution.system, load_factor=factor, start=solution).solution


def test_other_processes_solve_on():
    start = sk.solve(system(), load_factor=0.5).solution
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        there = pool.submit(tip, (start, 1.0)).result()
    assert there == tip((start, 1.0)) and there.system == start.system

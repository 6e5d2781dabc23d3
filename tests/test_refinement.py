"""The paper's method from end to end: nodal stress, regions, graded mesh, and what it gains."""

import importlib.util
import math
import warnings
from pathlib import Path

import numpy as np
import pytest

import skancf as sk

DEMOS = Path(__file__).parents[1] / "demos"


def paper_plate():
    return sk.Problem(
        surface=sk.Rectangle(1.0, 1.0), thickness=0.05,
        material=sk.Isotropic(young=0.2e6, poisson=0.0, density=2000.0, kind="3d", shear_correction=1.0),
        supports=[sk.Pin("corners")], loads=[sk.PointForce(at=(0.5, 0.5), force=(0.0, 0.0, -20.0))],
    )  # fmt: skip


@pytest.fixture(scope="module")
def state():
    plate = paper_plate()
    system = plate.on(sk.meshes.uniform(plate.surface, 12, 12), sk.Full(assumed=False))
    return sk.simulate(system, 0.1, progress=False).at(0.1)


def stretched(strain=1e-3):
    """A plate pulled to a uniform strain along x: S11 = E strain, to the strain's own order."""
    plate = sk.Problem(sk.Rectangle(1.0, 1.0), 0.05, sk.Isotropic(1e6, 0.0, 1.0))
    system = plate.on(sk.meshes.uniform(plate.surface, 3, 3))
    q = system.undeformed.reshape(-1, 4, 3).copy()
    q[:, :2, 0] *= 1 + strain
    return sk.Solution(system, q.ravel())


def test_nodal_stress_of_a_uniform_strain():
    stress = stretched(1e-3).nodal_stresses()
    expected = np.array([1e6 * (1e-3 + 0.5e-6), 0, 0, 0, 0, 0])
    # Rounding of strains of 1e-3 in positions of order one.
    assert np.abs(stress - expected).max() < 1e-9 * expected[0]


def test_nodal_stress_at_a_depth_shows_bending():
    plate = sk.Problem(sk.Rectangle(1.0, 1.0), 0.1, sk.Isotropic(1e6, 0.0, 1.0), [sk.Clamp("left")],
                       [sk.EdgeMoment("right", (0, -1e-3, 0))])  # fmt: skip
    solution = sk.solve_linear(plate.on(sk.meshes.uniform(plate.surface, 4, 4)))
    bending = 1e-3 * 0.05 / (0.1**3 / 12)
    # The linear answer's strain has the square of its rotations, 1e-5, relative to strains of 6e-7 at the face.
    assert np.abs(solution.nodal_stresses(0.05)[:, 0]) == pytest.approx(bending, rel=1e-3)
    assert np.abs(solution.nodal_stresses(0.0)[:, 0]).max() < 1e-2 * bending


def test_measure_is_the_largest_chosen_component():
    solution = stretched()
    assert sk.nodal_measure(solution) == pytest.approx(solution.nodal_stresses()[:, 0])
    assert sk.nodal_measure(solution, ["S22", "S12"]).max() < 1e-6
    normal = sk.nodal_measure(solution, ("S11", "S22", "S33"))
    assert np.array_equal(sk.nodal_measure(solution, "normal"), normal)
    with pytest.raises(sk.InputError, match="in_plane"):
        sk.nodal_measure(solution, "S44")
    with pytest.raises(sk.InputError, match="outside the plate"):
        sk.nodal_measure(solution, z=1.0)


@pytest.mark.parametrize("theory", ["full", "kirchhoff"])
@pytest.mark.parametrize("ask", [sk.nodal_measure, sk.stress_indicator, sk.stress_regions])
def test_a_bent_state_without_a_depth_is_told(theory, ask):
    surface = sk.Rectangle(3.0, 1.0)
    problem = sk.Problem(surface, 0.03, sk.Isotropic(2e9, 0.0, 1.0), [sk.Clamp("left")], [sk.EdgeLoad("right", (0, 0, 1.0))])
    bent = sk.solve_linear(problem.on(sk.meshes.uniform(surface, 6, 2), theory))
    # The moment at the clamp is 3 N, sigma = 6 M / t^2.
    with pytest.warns(sk.OutOfDepth, match=r"z = 0, where .* Pa at a face.*z='top'") as told:
        ask(bent)
    assert told[0].filename == __file__
    face = sk.nodal_measure(bent, z="top")
    assert face.max() == pytest.approx(6 * 3 / 0.03**2, rel=0.1)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ask(bent, z=0.0)
        ask(bent, z="top")
        ask(stretched())


def test_uniform_stress_has_no_regions():
    assert len(sk.stress_regions(stretched())) == 0


def test_regions_of_the_paper_are_load_and_corners(state):
    regions = sk.stress_regions(state)
    centres = {tuple(np.round(region.centre, 9)) for region in regions}
    assert centres == {(0.5, 0.5), (0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, 1.0)}
    by_centre = {tuple(np.round(r.centre, 9)): r for r in regions}
    middle, corner = by_centre[0.5, 0.5], by_centre[0.0, 0.0]
    assert middle.ratio > corner.ratio > 1
    assert middle.half_size[0] > corner.half_size[0], "the region's size grows with the ratio"
    assert regions.cell == pytest.approx((1 / 12, 1 / 12))


def test_a_smaller_sphere_finds_no_fewer_regions(state):
    wide, narrow = (sk.stress_regions(state, radius=r) for r in (4.0, 0.9))
    assert len(narrow) >= len(wide) >= 1


def test_graded_mesh_has_the_asked_nodes_and_is_fine_where_the_stress_is(state):
    regions = sk.stress_regions(state)
    mesh = sk.meshes.graded(state.system.problem.surface, regions, nodes=169)
    assert mesh.p.shape[1] == 169
    x = np.unique(np.round(mesh.p[0], 12))
    lengths = np.diff(x)
    assert np.abs(x - 0.5).min() < 1e-12, "no node under the load"
    assert lengths[len(lengths) // 2] < 0.6 * lengths.max()
    free = sk.meshes.graded(state.system.problem.surface, regions)
    assert free.p.shape[1] > 169, "without a count the coarse length stays that of the uniform mesh"


def test_quarter_annulus_refined_at_an_angle():
    """A curved strip, clamped at one end and pushed by a force on its outer edge at 45 degrees."""
    surface = sk.AnnulusSector(1.0, 2.0, math.pi / 2)
    plate = sk.Problem(surface, 0.1, sk.Isotropic(1e6, 0.3, 1.0), [sk.Clamp("start"), sk.Clamp("end")],
                       [sk.PointForce((2.0, math.pi / 4), (-70.0, -70.0, 0.0))])  # fmt: skip
    solution = sk.solve(plate.on(sk.meshes.uniform(surface, 6, 12))).unwrap()
    regions = sk.stress_regions(solution)
    assert any(np.allclose(r.centre, (2.0, math.pi / 4)) for r in regions)
    load_only = [r for r in regions if abs(r.centre[1] - math.pi / 4) < 1e-9]
    mesh = sk.meshes.graded(surface, load_only, nodes=7 * 13)
    assert mesh.p.shape[1] == 91
    angles = np.diff(np.unique(np.round(mesh.p[1], 12)))
    assert angles[len(angles) // 2] < 0.7 * angles[0], "central angles are finest at the load"
    assert angles.sum() == pytest.approx(math.pi / 2, abs=1e-11)
    again = sk.solve(plate.on(mesh)).unwrap()
    assert np.linalg.norm(again.displacement((2.0, math.pi / 4))) > np.linalg.norm(solution.displacement((2.0, math.pi / 4)))


def test_the_demo_hits_its_number(tmp_path, capsys):
    spec = importlib.util.spec_from_file_location("paper_example", DEMOS / "plot_01_paper_example.py")
    demo = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(demo)
    studies = demo.main(size="small", out=str(tmp_path))
    for study in studies.values():
        graded, uniform = (run.errors(study.fine)[0] for run in (study.graded, study.coarse))
        assert study.graded.nodes == study.coarse.nodes
        assert graded < 0.9 * uniform
    assert "nodes" in capsys.readouterr().out
    names = {path.name for path in tmp_path.iterdir()}
    assert {"table.txt", "plain_2_stress.png", "assumed_graded.pvd", "plain_displacements.csv"} <= names
    table = np.genfromtxt(tmp_path / "plain_displacements.csv", delimiter=",", names=True)
    assert len(table) == 201 and np.isfinite(table["t"]).all()

"""Meshes from files of other programs and back: names are kept, and what is no mesh of the parameter plane is refused."""

import importlib.util
from pathlib import Path

import meshio
import numpy as np
import pytest
import skfem

import skancf as sk
from skancf.errors import InputError

DOCS = Path(__file__).resolve().parent.parent / "docs"
HOLE = DOCS / "tutorials" / "files" / "hole.msh"
PLATE = sk.Rectangle(2.0, 1.0)
STEEL = sk.Isotropic(70e9, 0.33, 2700.0)


@pytest.fixture
def mesh():
    """With names of edges and of parts that overlap."""
    mesh = sk.meshes.uniform(PLATE, 4, 3)
    return mesh.with_subdomains({"patch": lambda x: x[0] < 1.0, "low": lambda x: x[1] < 0.3})


def named(groups):
    return {name: sorted(np.asarray(members).tolist()) for name, members in (groups or {}).items()}


def middles(mesh, members):
    return np.sort(mesh.p[:, mesh.t[:, members]].mean(axis=1).round(9).T.tolist(), axis=0)


@pytest.mark.parametrize("suffix", [".msh", ".inp", ".vtu", ".vtk"])
def test_a_mesh_comes_back_with_its_names(tmp_path, mesh, suffix, capfd):
    path = sk.meshes.to_file(mesh, tmp_path / f"plate{suffix}")
    again = sk.meshes.from_file(path)
    assert again.nelements == mesh.nelements and again.p.shape == mesh.p.shape
    assert named(again.boundaries).keys() == {"left", "right", "bottom", "top"}
    for name, facets in mesh.boundaries.items():
        ends = [m.p[:, m.facets[:, f]].mean(axis=1) for m, f in ((mesh, facets), (again, again.boundaries[name]))]
        assert np.allclose(*(np.sort(e, axis=1) for e in ends))
    for name, members in mesh.subdomains.items():
        assert np.allclose(middles(mesh, members), middles(again, again.subdomains[name]))
    assert [file.name for file in tmp_path.iterdir()] == [path.name]
    assert not any(capfd.readouterr())


def test_gmsh_itself_reads_what_is_written(tmp_path, mesh):
    gmsh = pytest.importorskip(
        "gmsh", reason="gmsh, or a library that it needs, is not installed", exc_type=(ImportError, OSError)
    )
    gmsh.initialize()
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.open(str(sk.meshes.to_file(mesh, tmp_path / "plate.msh")))
        groups = gmsh.model.getPhysicalGroups()
        assert {gmsh.model.getPhysicalName(*group) for group in groups} == {*mesh.boundaries, *mesh.subdomains}
        assert len(gmsh.model.mesh.getNodes()[0]) == mesh.p.shape[1]
    finally:
        gmsh.finalize()


def test_a_plate_with_a_hole_from_gmsh():
    mesh = sk.meshes.from_file(HOLE)
    assert set(mesh.boundaries) == {"left", "right", "bottom", "top", "hole"} and named(mesh.subdomains).keys() == {"plate"}
    x, y = mesh.p[:, np.unique(mesh.facets[:, mesh.boundaries["hole"]])]
    assert np.allclose(np.hypot(x - 1.0, y - 0.5), 0.1)
    assert np.allclose(mesh.p[0, mesh.facets[:, mesh.boundaries["right"]]], 2.0)
    corners = mesh.p[:, mesh.t]
    ahead = np.roll(corners, -1, axis=1) - corners
    area = 0.5 * np.abs(ahead[0, 0] * ahead[1, 3] - ahead[1, 0] * ahead[0, 3] + ahead[0, 2] * ahead[1, 1]
                        - ahead[1, 2] * ahead[0, 1])  # fmt: skip
    assert area.sum() == pytest.approx(2.0 - np.pi * 0.01, rel=2e-3)


def test_names_of_a_file_are_places_and_zones():
    """In tension; a load on the edge of the hole and a zone of the whole plate take part."""
    mesh = sk.meshes.from_file(HOLE)
    supports = [sk.Roller("left", (1, 0, 0)), sk.Roller("boundary", (0, 0, 1)), sk.Roller([(0.0, 0.0)], (0, 1, 0))]

    def solved(loads, **more):
        return sk.solve_linear(sk.Problem(PLATE, 0.01, STEEL, supports, loads, **more).on(mesh, theory="full"))

    pulled = solved([sk.EdgeLoad("right", (1e4, 0.0, 0.0))])
    assert pulled.nodal_section_forces()[:, 0].max() / 1e4 == pytest.approx(3.133, rel=0.04)  # Howland (1930)
    assert pulled.reactions("left")[0] == pytest.approx(-1e4)
    around = 2 * 0.1 * np.sin(np.pi / 32) * 32
    held = solved([sk.EdgeLoad("hole", (1e4, 0.0, 0.0))]).reactions("left")[0]
    assert held == pytest.approx(-1e4 * around, rel=0.02)
    zone = sk.Zone("all", sk.meshes.within(mesh, "plate"), thickness=0.02)
    twice = solved([sk.EdgeLoad("right", (1e4, 0.0, 0.0))], zones=[zone])
    assert twice.displacement((2.0, 0.5))[0] == pytest.approx(pulled.displacement((2.0, 0.5))[0] / 2)


def test_within_tells_the_elements_of_a_subdomain(mesh):
    inside = sk.meshes.within(mesh, "low")
    x, y = np.meshgrid(np.linspace(0.1, 1.9, 5), [0.1, 0.5, 0.9])
    assert (inside(x, y) == (y < 1 / 3)).all() and inside(0.1, 0.1)
    with pytest.raises(InputError, match=r"name = 'high'.*\['low', 'patch'\]"):
        sk.meshes.within(mesh, "high")


@pytest.mark.parametrize("kinds", [("quad8", "line3"), ("quad9", "line3")])
def test_of_second_order_the_corners_are_kept(tmp_path, kinds):
    corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
    points = np.array([*corners, (0.5, -0.1), (1.1, 0.5), (0.5, 1.1), (0.0, 0.5), (0.5, 0.5)])
    n = int(kinds[0][4:])
    cells = [(kinds[0], [list(range(n))]), (kinds[1], [[0, 1, 4]])]
    file = tmp_path / "one.msh"
    data = [np.array([7]), np.array([3])]
    made = meshio.Mesh(np.column_stack([points[:n], np.full(n, 2.0)]), cells, field_data={"low": np.array([3, 1])},
                       cell_data={"gmsh:physical": data, "gmsh:geometrical": data})  # fmt: skip
    made.write(file, file_format="gmsh22")
    mesh = sk.meshes.from_file(file)
    assert mesh.p.T.tolist() == [list(corner) for corner in corners]
    # A group without a name has its number.
    assert named(mesh.boundaries).keys() == {"low"} and named(mesh.subdomains) == {"7": [0]}


QUAD, SQUARE = [("quad", [[0, 1, 2, 3]])], np.array([(0.0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)])
BENT = [*SQUARE, (0, 0, 0), (0, 0, 0), (0, 0, 0.1), (0, 0, 0.1)]
REFUSED = {
    "triangles": (SQUARE, [("triangle", [[0, 1, 2], [0, 2, 3]])], "2 of its elements are triangles; .*Recombine"),
    "both": (np.vstack([SQUARE, [(2.0, 0.5, 0.0)]]), [*QUAD, ("triangle", [[1, 4, 2]])], "1 of its elements are triangles"),
    "volumes": ([*SQUARE, (0, 0, 0), (0, 0, 0), (0, 0, 0), (0, 0, 1)], [("tetra", [[0, 1, 2, 3]])], "has 1 tetra"),
    "edges only": (SQUARE, [("line", [[0, 1]])], "has no quadrilaterals"),
    "not flat": (BENT, QUAD, r"z runs from 0 to 0\.1; .*parameter plane"),
    "folded": (SQUARE, [("quad", [[0, 2, 1, 3]])], "not convex quads"),
}


@pytest.mark.parametrize("kind", REFUSED)
def test_what_is_no_mesh_of_the_plane_is_refused(tmp_path, kind):
    points, cells, word = REFUSED[kind]
    meshio.Mesh(points, cells).write(tmp_path / "mesh.vtu")
    with pytest.raises(InputError, match=word):
        sk.meshes.from_file(tmp_path / "mesh.vtu")


def test_named_edges_must_be_edges_of_elements(tmp_path):
    data = [np.array([1]), np.array([2])]
    made = meshio.Mesh(SQUARE, [*QUAD, ("line", [[0, 2]])], field_data={"across": np.array([2, 1])},
                       cell_data={"gmsh:physical": data, "gmsh:geometrical": data})  # fmt: skip
    made.write(tmp_path / "mesh.msh", file_format="gmsh22")
    with pytest.raises(InputError, match="1 of the 1 edges named 'across' are no edges"):
        sk.meshes.from_file(tmp_path / "mesh.msh")


def test_nodes_without_an_element_are_left_out(tmp_path):
    meshio.Mesh(np.vstack([[(9.0, 9.0, 0.0)], SQUARE]), [("vertex", [[0]]), ("quad", [[1, 2, 3, 4]])]).write(
        tmp_path / "m.vtu"
    )
    assert sk.meshes.from_file(tmp_path / "m.vtu").p.max() == 1.0


def test_files_that_are_none_are_named(tmp_path, capfd):
    for name, content in (("a.msh", "nonsense"), ("a.vtu", "<VTKFile>"), ("a.xyz", ""), ("a.inp", "*NODE\n1,x")):
        (tmp_path / name).write_text(content)
        with pytest.raises(InputError, match=rf"{name}'.*"):
            sk.meshes.from_file(tmp_path / name)
    with pytest.raises(InputError, match="there is no such file"):
        sk.meshes.from_file(tmp_path / "b.msh")
    assert not any(capfd.readouterr())


def test_meshes_that_cannot_be_written_are_refused(tmp_path, mesh):
    tree = sk.meshes.quadtree(sk.meshes.uniform(PLATE, 2, 2)).refined([0])
    with pytest.raises(InputError, match=r"hanging nodes.*sk.meshes.save"):
        sk.meshes.to_file(tree, tmp_path / "tree.msh")
    with pytest.raises(InputError, match=r"ends in '.stl'"):
        sk.meshes.to_file(mesh, tmp_path / "mesh.stl")


def test_the_script_of_the_hole_makes_the_file_that_is_kept(tmp_path):
    pytest.importorskip("gmsh", reason="gmsh, or a library that it needs, is not installed", exc_type=(ImportError, OSError))
    spec = importlib.util.spec_from_file_location("hole", DOCS / "measure" / "hole.py")
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    script.make(tmp_path / "hole.msh")
    made, kept = sk.meshes.from_file(tmp_path / "hole.msh"), sk.meshes.from_file(HOLE)
    # Other versions of gmsh may place nodes elsewhere.
    assert made.nelements == pytest.approx(kept.nelements, rel=0.2) and set(made.boundaries) == set(kept.boundaries)


def test_scikit_fem_s_own_files_keep_their_names(tmp_path, mesh):
    skfem.MeshQuad(mesh.p, mesh.t, mesh.boundaries, mesh.subdomains).save(tmp_path / "own.vtk")
    assert named(sk.meshes.from_file(tmp_path / "own.vtk").boundaries) == named(mesh.boundaries)

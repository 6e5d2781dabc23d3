"""Charts of adaptivity, and quadtree meshes in charts."""

import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image

import skancf as sk
from skancf import output
from skancf.errors import InputError
from skancf.meshes import Region, quadtree, refined_in, uniform
from skancf.output.adaptive_charts import _draw_triangles, _levels, _logarithmic
from skancf.output.plane import cell_outlines, edge_curves, subdivided

SQUARE = sk.Rectangle(1.0, 1.0)
ANNULUS = sk.AnnulusSector(1.0, 2.0)
DOFS = 100 * 4.0 ** np.arange(4)


def tree(surface=SQUARE, centre=(0.3, 0.4), n=4):
    return refined_in(uniform(surface, n, n), [Region(centre, (0.1, 0.1), 16.0)])


# Quadtree meshes in the plane


@pytest.mark.parametrize("mesh", [uniform(SQUARE, 3, 2), quadtree(uniform(SQUARE, 3, 2)), tree()])
def test_every_edge_is_drawn_once(mesh):
    drawn = np.abs(np.diff(edge_curves(mesh, None), axis=1)).sum()
    sides = np.ptp(mesh.p[:, mesh.t], axis=1).sum() * 2
    # Inner edges belong to two elements, those of the boundary, of length 4, to one.
    assert drawn == pytest.approx((sides + 4) / 2, rel=1e-12)


def test_an_edge_between_two_levels_is_drawn_as_its_halves():
    mesh = quadtree(uniform(SQUARE, 2, 1)).refined(np.array([0]))
    at_middle = [line for line in edge_curves(mesh, None) if (line[:, 0] == 0.5).all()]
    assert sorted(np.abs(np.diff(line[:, 1]))[0] for line in at_middle) == [0.5, 0.5]


@pytest.mark.parametrize("surface", [None, ANNULUS])
def test_outlines_enclose_the_elements(surface):
    outlines = cell_outlines(tree(ANNULUS, (1.3, 0.4)), surface)
    x, y = np.moveaxis(outlines, -1, 0)
    areas = 0.5 * np.abs((x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1)).sum(axis=1))
    # Arcs are polygons of short chords.
    assert areas.sum() == pytest.approx(np.pi / 2 if surface is None else 0.75 * np.pi, rel=1e-3)


def test_a_field_has_no_gap_at_hanging_nodes():
    mesh = tree()
    field = np.random.default_rng(3).normal(size=mesh.p.shape[1])
    triangles, fine = subdivided(mesh, field, None)
    places = np.round(np.stack([triangles.x, triangles.y]), 9)
    _, inverse = np.unique(places, axis=1, return_inverse=True)
    inverse = inverse.ravel()
    mean = np.bincount(inverse, fine) / np.bincount(inverse)
    assert np.bincount(inverse).max() > 1, "points of two levels meet"
    assert np.abs(fine - mean[inverse]).max() < 1e-12
    plain = subdivided(mesh.plain(), field, None)[1]
    assert np.abs(plain - (np.bincount(inverse, plain) / np.bincount(inverse))[inverse]).max() > 0.1


# Charts


def test_charts_are_drawn(tmp_path):
    mesh, ring = tree(), tree(ANNULUS, (1.3, 0.4))
    meshes = [uniform(SQUARE, 4, 4), mesh, mesh.refined(np.arange(5))]
    errors = {"uniform": (DOFS, DOFS**-0.5), "adaptive": (DOFS[:3], 2 / DOFS[:3]), "exact": ([10.0], [0.0])}
    ratios = {"recovery": (DOFS, [1.3, 1.1, 0.95, 1.0]), "residual": (DOFS, [30.0, 9.0, 3.0, 0.5])}
    made = [
        output.mesh_chart(ring, tmp_path / "mesh.png", ANNULUS),
        output.field_chart(mesh, mesh.p[0], tmp_path / "field.png", "x (m)"),
        output.mesh_levels(meshes, tmp_path / "levels.png", titles=["a", "b", "c"]),
        output.mesh_levels([ring] * 6, tmp_path / "six.png", surface=ANNULUS),
        output.mesh_levels([mesh], tmp_path / "values.pdf", values=[np.arange(mesh.nelements)], label="error (J)"),
        output.mesh_levels([mesh], tmp_path / "constant.png", values=[np.ones(mesh.nelements)]),
        output.convergence(errors, tmp_path / "errors.svg", slopes=(-1, -0.5, -2, -3), title="L-shaped plate"),
        output.convergence(errors, tmp_path / "plain.png", xlabel="seconds"),
        output.effectivity(ratios, tmp_path / "wide.png", band=(0.8, 1.2)),
        output.effectivity({"signed": (DOFS, [-0.5, 0.5, 0.9, 1.0])}, tmp_path / "signed.png"),
    ]
    for path in made:
        assert path.stat().st_size > 2000
        if path.suffix == ".png":
            assert np.asarray(Image.open(path).convert("L")).std() > 5


def test_levels_have_one_colour_in_all_panels():
    shown, colours = _levels([uniform(SQUARE, 2, 2), tree()])
    assert set(shown[0]) == {0} and set(shown[1]) == {0, 1, 2}
    assert colours["norm"](shown[1]).max() == 2 and colours["cmap"].N == 3


def test_values_that_vanish_have_the_lowest_colour():
    mesh = uniform(SQUARE, 2, 2)
    (shown,), colours = _logarithmic([mesh], [[0.0, 1e-30, 1.0, 100.0]])
    assert colours["norm"](shown).tolist() == pytest.approx([0.0, 0.0, 2 / 3, 1.0])


@pytest.mark.parametrize("slopes", [(-1,), (-2, -0.5), (-3, -2, -1, -0.5), (1, 2)])
def test_triangles_have_their_slopes_and_no_curve_in_them(slopes):
    axes = Figure().add_subplot()
    curves = [(DOFS, DOFS**-0.5), (DOFS[:3], np.array([0.1, 0.3, 0.001]))]
    _draw_triangles(axes, curves, slopes)
    corners = [np.log(patch.get_xy()[:3]) for patch in axes.patches]
    found = [np.diff(c[:2, 1])[0] / np.diff(c[:2, 0])[0] for c in corners]
    assert sorted(found) == pytest.approx(sorted(slopes))
    for corner in corners:
        for x, error in curves:
            inside = np.linspace(corner[:, 0].min(), corner[:, 0].max(), 40)
            height = np.interp(inside, np.log(x), np.log(error))
            line = np.interp(inside, *corner[:2].T)
            away = np.sign(corner[2, 1] - corner[:2, 1].mean())
            assert (away * (height - line) < 0).all()


def test_what_cannot_be_drawn_is_refused(tmp_path):
    mesh, path = uniform(SQUARE, 2, 2), tmp_path / "a.png"
    calls = {
        "meshes: the sequence is empty": lambda: output.mesh_levels([], path),
        "titles: 1 for 2 meshes": lambda: output.mesh_levels([mesh] * 2, path, titles=["a"]),
        "values: 2 for 1 meshes": lambda: output.mesh_levels([mesh], path, values=[np.ones(4)] * 2),
        r"values\[0\] has shape .*4 elements": lambda: output.mesh_levels([mesh], path, values=[np.ones(9)]),
        r"values\[0\] has -1.0: negative": lambda: output.mesh_levels([mesh], path, values=[-np.ones(4)]),
        "all are zero": lambda: output.mesh_levels([mesh], path, values=[np.zeros(4)]),
        "no positive values": lambda: output.convergence({"a": (DOFS, 0 * DOFS)}, path),
        "'a': values of shape": lambda: output.convergence({"a": (DOFS, [1.0])}, path),
        "slope of 0": lambda: output.convergence({"a": (DOFS, DOFS)}, path, slopes=(0, 1)),
        "curves: the sequence is empty": lambda: output.effectivity({}, path),
        "x = 0.0 cannot be drawn": lambda: output.effectivity({"a": (0 * DOFS, DOFS)}, path),
        "band = .*about 1": lambda: output.effectivity({"a": (DOFS, DOFS)}, path, band=(1.1, 1.2)),
        "end it in .png or .pdf or .svg": lambda: output.effectivity({"a": (DOFS, DOFS)}, path.with_suffix(".jpg")),
    }
    for message, call in calls.items():
        with pytest.raises(InputError, match=f"(?s){message}"):
            call()
    assert not list(tmp_path.iterdir())

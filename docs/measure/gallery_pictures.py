"""The first picture of each page of the gallery, which is also its thumbnail: states that the example computes, drawn alike.

From the folder of the repository, in some minutes:

    .venv/bin/python docs/measure/gallery_pictures.py

Names of examples draw these only, for example ``05_hemisphere``. The pictures go to docs/pictures/gallery.
"""

import importlib.util
import sys
from collections.abc import Callable
from itertools import product
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np
import pyvista as pv

import skancf as sk
from skancf import output
from skancf.output.fields import von_mises

ROOT = Path(__file__).resolve().parents[2]
OUT = ROOT / "docs" / "pictures" / "gallery"
FOUR = ((1, 1, 1), (-1, 1, 1), (1, -1, 1), (-1, -1, 1))


class Shot(NamedTuple):
    """States in one picture, and how to look at them."""

    states: list[sk.Solution]
    view: tuple[float, float, float] = (1.0, -1.6, 0.9)
    colour: Callable[[sk.Solution, output.Samples], np.ndarray] | None = None
    """Values at the sampled points; the length of the displacement where nothing is said."""
    scale: float = 1.0
    mirrors: tuple[tuple[int, int, int], ...] = ((1, 1, 1),)
    about: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """The point that mirrors keep."""
    apart: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """From each state to the next, in the picture."""
    colours: str = "viridis"
    symmetric: bool = False
    z: Any = 0.0


def stress(z: Any = "top") -> dict[str, Any]:
    return {"colour": lambda state, surface: von_mises(surface.stress), "z": z}


def height(state: sk.Solution, surface: output.Samples) -> np.ndarray:
    return surface.displacement[:, 2]


def thickness(state: sk.Solution, surface: output.Samples) -> np.ndarray:
    """Of the section at the sampled points."""
    top, bottom = (output.sample(state, 6, z=side).points for side in ("top", "bottom"))
    return np.linalg.norm(top - bottom, axis=1)


def paper(demo: ModuleType) -> Shot:
    coarse = sk.simulate(
        demo.PLATE.on(sk.meshes.uniform(demo.PLATE.surface, 12, 12)), 0.1, rtol=8e-3, progress=False
    ).unwrap()
    mesh = sk.meshes.graded(demo.PLATE.surface, sk.stress_regions(coarse.at(0.1)), nodes=169)
    motion = sk.simulate(demo.PLATE.on(mesh), 0.4, rtol=8e-3, progress=False).unwrap()
    return Shot([motion.at(0.35)], scale=2.0)


def elastica(demo: ModuleType) -> Shot:
    states = [demo.bend(load, 16).solution for load in (1e-6, 1.0, 2.0, 4.0, 10.0)]
    return Shot(states, (0.5, -1.0, 0.5), **stress())


def annulus(demo: ModuleType) -> Shot:
    state = sk.solve(demo.PLATE.on(sk.meshes.uniform(demo.RING, 6, 12))).unwrap()
    regions = [region for region in sk.stress_regions(state) if np.allclose(region.centre, demo.LOAD)]
    graded = sk.meshes.graded(demo.RING, regions, shape=(6, 12))
    return Shot([sk.solve(demo.PLATE.on(graded)).unwrap()], (0.6, -1.0, 1.1), **stress())


def roll_up(demo: ModuleType) -> Shot:
    path = demo.roll_up("kirchhoff", 16).path
    return Shot([*path[:: max(1, len(path) // 8)], path[-1]], (0.55, -1.5, 0.7), **stress())


def hemisphere(demo: ModuleType) -> Shot:
    state = sk.solve(demo.system_on(16)).unwrap()
    return Shot([state], (1.0, -1.3, 0.75), mirrors=FOUR)


def roof(demo: ModuleType) -> Shot:
    path = demo.follow(demo.roof(demo.THICK, 8), 1.08)
    return Shot([path.solution], (1.2, -1.0, 0.45), height, mirrors=FOUR, about=(254.0, 0.0, 0.0))


def laminate(demo: ModuleType) -> Shot:
    return Shot([demo.settled(0.15, 8).unwrap()], (1.5, -0.7, 0.6), height, mirrors=FOUR)


def modes(demo: ModuleType) -> Shot:
    found, first = demo.first_modes(12)["free"]
    return Shot([found.shape(first + 4, size=0.2)], (0.8, -1.3, 0.8), height, colours="RdBu_r", symmetric=True)


def l_shape(demo: ModuleType) -> Shot:
    quantity = demo.QUANTITIES["energy"]
    found = sk.adapt(demo.PLATE, quantity, 2e-3, mesh=demo.runs(quantity, 2000)["adaptive"].levels[0].mesh, linear=True)
    state = found.solution
    top = np.abs(output.sample(state, 4).displacement).max()
    return Shot([state], (-0.9, -1.3, 1.3), scale=0.35 / top)


def opening(demo: ModuleType) -> Shot:
    state = demo.on_patch(demo.CASES["bending"], 1 / 64).solution
    return Shot([state], (0.4, -1.0, 0.8), scale=0.3 / np.abs(output.sample(state, 4).displacement).max(), **stress())


def corners(demo: ModuleType) -> Shot:
    state = demo.loops("centre", 1e-4, 4000)["goal"].solution
    top = np.abs(output.sample(state, 4).displacement).max()
    return Shot([state], scale=0.3 / top)


def paper_meshes(demo: ModuleType) -> Shot:
    state = sk.adapt(demo.PLATE, demo.WANTED["centre"], 2e-3, theory=demo.THEORIES["assumed"], max_dofs=6000).solution
    top = np.abs(output.sample(state, 4).displacement).max()
    return Shot([state], scale=0.3 / top)


def ruler(demo: ModuleType) -> Shot:
    states = list(demo.run(demo.ruler(), "dissipative").states)
    return Shot(states[4:48:4], (0.25, -1.0, 0.35))


def tumbling(demo: ModuleType) -> Shot:
    states = list(demo.throw(demo.plate(3), demo.BENDING["hard"]).states)
    return Shot(states[2:44:8], (0.3, -1.3, 0.5), height, apart=(0.2, 0.0, -0.2))


def pendulum(demo: ModuleType) -> Shot:
    states = list(demo.swing(demo.STIFFER, 4, 2e-3, demo.RETARDATION).states)
    return Shot(states[0:120:12], (0.35, -1.0, 0.3))


def following(demo: ModuleType) -> Shot:
    motion = demo.runnings(demo.SIZES["small"])[0][-1][1]
    states = list(motion.states)
    state = states[2 * len(states) // 3]
    top = np.abs(output.sample(state, 4).displacement).max()
    extent = np.ptp(output.sample(state, 2).points, axis=0).max()
    return Shot([state], (0.3, -1.0, 0.9), height, scale=0.06 * extent / top)


def airbag(demo: ModuleType) -> Shot:
    return Shot([demo.airbag(10).unwrap()], (1.0, -1.4, 1.0), height, mirrors=FOUR)


def sandwich(demo: ModuleType) -> Shot:
    state = demo.plate("full", 8)
    extent = np.ptp(output.sample(state, 2).points, axis=0).max()
    return Shot([state], scale=0.1 * extent / np.abs(output.sample(state, 4).displacement).max())


def two_theories(demo: ModuleType) -> Shot:
    return Shot([demo.compare("full", sk.meshes.uniform(demo.PLATE.surface, 6, 3), lambda *_: None)], **stress())


def hinges(demo: ModuleType) -> Shot:
    control = sk.DisplacementControl(at=(0.0, 0.0), direction=(0.0, 1.0, 0.0), to=1.35 * demo.RADIUS)
    path = sk.trace(demo.ring(-demo.UNIT, 24), control).unwrap()
    states = list(path.solutions)
    return Shot(states[:: max(1, len(states) // 5)], (1.6, -0.5, 0.35), **stress(), apart=(-0.35, 0.0, 0.0))


def balloon(demo: ModuleType) -> Shot:
    path = demo.inflate(demo.LAWS["neo-Hooke"][0], 6, 2.0)
    return Shot([path.solution], colour=height, mirrors=tuple(product((1, -1), repeat=3)))


def rubber_sheet(demo: ModuleType) -> Shot:
    path = demo.pinched(8)
    return Shot([path.events[0].solution, path.solution], (0.4, -1.5, 0.6), **stress())


def blade(demo: ModuleType) -> Shot:
    found = sk.modes(demo.blade(3), 4)
    return Shot([found.shape(1, size=0.05)], (1.0, -1.3, 0.7), thickness)


def doubler(demo: ModuleType) -> Shot:
    bonded = sk.Zone("doubler", demo.PATCH, thickness=2e-3, offset=0.5e-3)
    return Shot([demo.sheet((bonded,))], scale=50.0, **stress())


SHOTS = {
    "01_paper_example": paper,
    "02_elastica": elastica,
    "03_annulus": annulus,
    "04_roll_up": roll_up,
    "05_hemisphere": hemisphere,
    "06_snap_through": roof,
    "07_laminate": laminate,
    "08_plate_modes": modes,
    "09_l_shape": l_shape,
    "10_opening": opening,
    "11_corner_supported": corners,
    "12_paper_meshes": paper_meshes,
    "13_free_ruler": ruler,
    "14_tumbling_plate": tumbling,
    "15_plate_pendulum": pendulum,
    "16_following": following,
    "17_arrival": airbag,
    "18_sandwich": sandwich,
    "19_two_theories": two_theories,
    "20_links_and_hinges": hinges,
    "21_balloon": balloon,
    "22_rubber_sheet": rubber_sheet,
    "23_tapered_blade": blade,
    "24_doubler": doubler,
}


def surface_of(state: sk.Solution, shot: Shot, k: int) -> tuple[pv.PolyData, pv.PolyData]:
    """The k-th state as facets with values, and the edges of its elements."""
    found = output.sample(state, 6, z=shot.z)
    values = np.linalg.norm(found.displacement, axis=1) if shot.colour is None else shot.colour(state, found)
    places = found.points + (shot.scale - 1) * found.displacement + k * np.array(shot.apart)
    facets = pv.PolyData.from_regular_faces(places, found.cells)
    facets["values"] = values
    edges = pv.PolyData(places, lines=np.concatenate([[len(rim), *rim] for rim in found.rims]))
    return facets, edges


def mirrored(piece: pv.PolyData, shot: Shot, mirror: tuple[int, int, int]) -> pv.PolyData:
    copy, about = piece.copy(), np.array(shot.about)
    copy.points = about + (copy.points - about) * mirror
    return copy


def draw(shot: Shot, file: Path) -> None:
    """One picture, white behind."""
    plotter = pv.Plotter(off_screen=True, window_size=(1800, 1260), lighting="light kit")
    vtk_offset()
    parts = [surface_of(state, shot, k) for k, state in enumerate(shot.states)]
    low, high = np.percentile(np.concatenate([facets["values"] for facets, _ in parts]), [0.5, 99.5])
    if shot.symmetric:
        high = max(-low, high)
        low = -high
    painted: dict[str, Any] = {
        "scalars": "values", "cmap": shot.colours, "clim": (low, high), "smooth_shading": True, "show_scalar_bar": False,
        "specular": 0.2, "ambient": 0.3,
    }  # fmt: skip
    for facets, edges in parts:
        for mirror in shot.mirrors:
            plotter.add_mesh(mirrored(facets, shot, mirror).clean(tolerance=1e-6), **painted)
            plotter.add_mesh(mirrored(edges, shot, mirror), color="#0b2239", line_width=2.5)
    plotter.view_vector(shot.view, viewup=(0, 0, 1))
    plotter.enable_anti_aliasing("ssaa")
    file.parent.mkdir(parents=True, exist_ok=True)
    plotter.screenshot(str(file))
    plotter.close()
    shrink(file)


def vtk_offset() -> None:
    """Lines in front of the facets that they lie in."""
    from vtkmodules.vtkRenderingCore import vtkMapper

    vtkMapper.SetResolveCoincidentTopologyToPolygonOffset()
    vtkMapper.SetResolveCoincidentTopologyPolygonOffsetParameters(2.0, 2.0)
    vtkMapper.SetResolveCoincidentTopologyLineOffsetParameters(-2.0, -2.0)


def shrink(file: Path) -> None:
    """Without its margins, on 900 x 630 pixels, as a JPEG of some tens of kilobytes."""
    from PIL import Image, ImageChops

    with Image.open(file) as picture:
        full = picture.convert("RGB")
    inner = full.crop(ImageChops.difference(full, Image.new("RGB", full.size, "white")).getbbox())
    inner.thumbnail((860, 590), Image.Resampling.LANCZOS)
    sheet = Image.new("RGB", (900, 630), "white")
    sheet.paste(inner, ((900 - inner.width) // 2, (630 - inner.height) // 2))
    sheet.save(file.with_suffix(".jpg"), quality=88, optimize=True)
    file.unlink()


def load(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, ROOT / "demos" / f"plot_{name}.py")
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


def main() -> None:
    for name in sys.argv[1:] or SHOTS:
        print(name, flush=True)
        draw(SHOTS[name](load(name)), OUT / f"{name}.png")


if __name__ == "__main__":
    main()

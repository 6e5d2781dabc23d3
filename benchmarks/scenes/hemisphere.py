"""A hemisphere with a hole, pinched by four forces."""

from math import pi

from benchmarks.scenes import stored
from benchmarks.scenes.scene import Quantity, Scene

SOURCE = "Thin: uniform meshes of up to 96 x 96 bicubic elements, extrapolated (python -m benchmarks.references)."

SCENE = Scene(
    name="hemisphere",
    title="Pinched hemisphere",
    text="A hemisphere of radius 10 and thickness 0.04 with a hole of 18 degrees at its top; the equator is a free edge. "
    "Four forces of 400 at the equator pull it outwards at two opposite points (along x) and push it inwards at the "
    "two between (along y). By symmetry a quarter, with half a force at either end of its equator: A on the axis x, "
    "B on the axis y. Static.",
    data={"radius": 10.0, "thickness": 0.04, "hole": 18 * pi / 180, "young": 6.825e7, "poisson": 0.3, "force": 400.0},
    quantities={
        "outwards": Quantity("A moves outwards", "m", source=SOURCE, **stored.references("hemisphere", "outwards")),
        "inwards": Quantity("B moves inwards", "m", source=SOURCE, **stored.references("hemisphere", "inwards")),
    },
)

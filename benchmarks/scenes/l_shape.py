"""A clamped L-shaped plate, linear."""

from benchmarks.scenes import stored
from benchmarks.scenes.scene import Quantity, Scene

POISSON, THICKNESS = 0.3, 0.002
SOURCE = ("Thin: uniform meshes of up to 256 x 256 bicubic elements, extrapolated by the order of the corner (python "
          "-m benchmarks.references); adaptive meshes with their error estimate added agree within 1e-5.")  # fmt: skip

SCENE = Scene(
    name="l_shape",
    title="Clamped L-shape",
    text="The square [-1, 1] x [-1, 1] without its quarter [0, 1] x [-1, 0], 0.002 thick, bending stiffness 1, clamped "
    "along the whole boundary, under a uniform load of 1. Asked for: the integral of the deflection, so the work of "
    "the load. Linear.",
    data={
        "thickness": THICKNESS, "young": 12 * (1 - POISSON**2) / THICKNESS**3, "poisson": POISSON, "pressure": 1.0,
    },
    quantities={
        "volume": Quantity("integral of w", "m3", source=SOURCE, **stored.references("l_shape", "volume")),
    },
)  # fmt: skip

"""A cantilever strip under a shear force at its end."""

from benchmarks.scenes import stored
from benchmarks.scenes.scene import Quantity, Scene

LENGTH = 10.0
SOURCE = ("Boundary value problem of a rod with the stiffnesses of the strip, solved by collocation to 1e-10 (python -m "
          "benchmarks.references); thin: it stretches and bends, thick: with shear, k = 5/6. Without stretch the elliptic "
          "integrals give u = 3.28941, w = 6.69964; data from Sze, Liu and Lo (2004), example 3.1.")  # fmt: skip

SCENE = Scene(
    name="end_shear",
    title="Strip, end shear",
    text="A strip of length 10, width 1 and thickness 0.1, clamped at x = 0. A force of 4 in all, along z and dead, is "
    "spread evenly over its other edge. Static.",
    data={"length": LENGTH, "width": 1.0, "thickness": 0.1, "young": 1.2e6, "poisson": 0.0, "force": 4.0},
    quantities={
        "u": Quantity("end moves back, -u", "m", source=SOURCE, scale=LENGTH, **stored.references("end_shear", "u")),
        "w": Quantity("end moves up, w", "m", source=SOURCE, scale=LENGTH, **stored.references("end_shear", "w")),
    },
)

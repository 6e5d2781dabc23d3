"""A clamped L-shaped plate, linear."""

from benchmarks.scenes.scene import Quantity, Scene

POISSON, THICKNESS = 0.3, 0.002

SCENE = Scene(
    name="l_shape",
    title="Clamped L-shape",
    text="The square [-1, 1] x [-1, 1] without its quarter [0, 1] x [-1, 0], 0.002 thick, bending stiffness 1, clamped along the "
    "whole boundary, under a uniform load of 1. Asked for: the integral of the deflection, so the work of the load. Linear.",
    data={
        "thickness": THICKNESS, "young": 12 * (1 - POISSON**2) / THICKNESS**3, "poisson": POISSON, "pressure": 1.0,
    },
    quantities={
        "volume": Quantity("integral of w", "m3", {"thin": 0.0035784}, {"thin": 4e-5},
                           "Thin: adaptive meshes of bicubic elements to 1e-5, with the error estimate added."),
    },
)  # fmt: skip

"""A plate on its four corners with a force at its centre, linear."""

from benchmarks.scenes import stored
from benchmarks.scenes.scene import Quantity, Scene

POISSON, THICKNESS = 0.3, 0.001
SOURCE = "Thin: adaptive meshes of bicubic elements, with the error estimate added (python -m benchmarks.references)."

SCENE = Scene(
    name="corner_plate",
    title="Plate on four corners",
    text="A square plate of side 1 and thickness 0.001, bending stiffness 1, held in z at its corners only, with a force "
    "of 1 at its centre. Asked for: the deflections of the centre and of the middle of an edge. Linear.",
    data={
        "side": 1.0, "thickness": THICKNESS, "young": 12 * (1 - POISSON**2) / THICKNESS**3, "poisson": POISSON, "force": 1.0,
    },
    quantities={
        "centre": Quantity("deflection of the centre", "m", source=SOURCE, **stored.references("corner_plate", "centre")),
        "edge": Quantity("deflection of mid-edge", "m", source=SOURCE, **stored.references("corner_plate", "edge")),
    },
)  # fmt: skip

"""A ruler thrown by a pulse at one end."""

from benchmarks.scenes import stored
from benchmarks.scenes.scene import Quantity, Scene

LENGTH = 0.3
TEXTS = {"near_x": "end at x = 0, along x", "near_z": "end at x = 0, along z", "far_x": "loaded end, along x",
         "far_z": "loaded end, along z"}  # fmt: skip
SOURCE = ("Thin: bicubic elements, mesh and steps refined until the series no longer change (python -m "
          "benchmarks.references).")  # fmt: skip

SCENE = Scene(
    name="free_ruler",
    title="Free ruler",
    text="A steel ruler, 0.3 m x 0.06 m x 2 mm (206 GPa, no Poisson effect, 7800 kg/m3), free. Forces along x and z, 1200"
    " N and 2000 N in all, spread over its edge at x = 0.3 m, rise linearly from zero at 0 to these values at 2 ms "
    "and fall to zero at 4 ms. Asked for: the displacements of the middles of both ends over 20 ms. The error is the"
    " root mean square of the difference over the length. Dynamic.",
    data={"length": LENGTH, "width": 0.06, "thickness": 0.002, "young": 206e9, "poisson": 0.0, "density": 7800.0,
          "force_x": 1200.0, "force_z": 2000.0, "peak": 2e-3, "over": 4e-3, "end": 20e-3},
    quantities={
        key: Quantity(text, "m", source=SOURCE, scale=LENGTH, **stored.references("free_ruler", key))
        for key, text in TEXTS.items()
    },
    times=tuple(stored.read("free_ruler")["times"]),
)  # fmt: skip

"""The example of the paper: a plate on its corners under a sudden force, small and large."""

from benchmarks.scenes import stored
from benchmarks.scenes.scene import Quantity, Scene, root_mean_square

POINTS = {"centre": (0.5, 0.5), "quarter": (0.25, 0.25), "edge": (0.5, 0.0)}
SOURCE = ("Thin: bicubic elements, mesh and steps refined until the series no longer change (python -m "
          "benchmarks.references). A thick plate has no limit under a force at a point.")  # fmt: skip


def scene(force: float) -> Scene:
    name = f"paper_{force:g}n"
    largest = root_mean_square(stored.read(name)["thin"]["centre"])
    return Scene(
        name=name,
        title=f"The paper's plate, {force:g} N",
        text="A square plate of side 1 m and thickness 0.05 m whose four corners cannot move (E = 0.2 MPa, no Poisson "
        f"effect, 2000 kg/m3) gets a force of {force:g} N at its centre, along z, at once and for good. Asked for: "
        "the deflection of three points over 0.5 s. The error is the root mean square of the difference over that "
        "of the deflection of the centre. Dynamic.",
        data={"side": 1.0, "thickness": 0.05, "young": 0.2e6, "poisson": 0.0, "density": 2000.0, "force": force, "end": 0.5},
        quantities={
            key: Quantity(f"deflection of {point}", "m", source=SOURCE, scale=largest, **stored.references(name, key))
            for key, point in POINTS.items()
        },
        times=tuple(stored.read(name)["times"]),
        limitless=("thick",),
    )  # fmt: skip


SCENES = (scene(2.0), scene(20.0))

"""A shallow roof that snaps through."""

from benchmarks.scenes import stored
from benchmarks.scenes.scene import Quantity, Scene

SOURCE = ("Thin: uniform meshes of up to 64 x 64 bicubic elements, extrapolated (python -m benchmarks.references); "
          "isogeometric elements of the same theory (Kratos) and NGSolve's agree within 1.1e-4. Small: programs whose "
          "strains are small agree among themselves, not with it, at the largest deflection.")  # fmt: skip
LIMIT = 2226.0
# Between the limits of two programs' meshes, which differ by twice the uncertainty: Exudyn's 2212.6, 520.3, 3133 and those
# of Kratos' triangles, 2214.7, 518.9, 3133.
SMALL, DOUBT = (2213.7, 519.6, 3133.0), 5e-4
DEFLECTIONS = (10.0, 20.0, 29.0)

SCENE = Scene(
    name="hinged_roof",
    title="Hinged roof, snap-through",
    text="A cylindrical roof of radius 2540, thickness 12.7, length 508 and half an opening angle of 0.1. Its straight "
    "edges are hinged (they turn, do not move), the curved ones free. A force at the centre presses it through. "
    "Asked for: that force at three deflections of the centre, before, near and after the lowest load. By symmetry a"
    " quarter. Static.",
    data={
        "radius": 2540.0, "thickness": 12.7, "half_length": 254.0, "half_angle": 0.1, "young": 3102.75, "poisson": 0.3,
        **{f"deflection_{k}": w for k, w in enumerate(DEFLECTIONS)},
    },
    quantities={
        f"force_{k}": Quantity(f"force at {w:g} mm (relative to the limit load)", "N", source=SOURCE, scale=LIMIT,
                               **stored.references("hinged_roof", f"force_{k}", small=SMALL[k], doubt=DOUBT))
        for k, w in enumerate(DEFLECTIONS)
    },
    limitless=("thick",),
)  # fmt: skip

"""Kratos Multiphysics: its corotational shells, thin and thick, and its Kirchhoff-Love shell on B-splines."""

from collections.abc import Sequence

from benchmarks.programs.program import Outcome, Program, Variant
from benchmarks.scenes import Scene

THIN: dict[str, Sequence[float]] = {
    "end_shear": (4, 6, 8, 12, 16, 24, 32, 48, 64),
    "roll_up": (3, 4, 6, 8, 12),
    "hemisphere": (8, 12, 16, 24, 32, 40, 48),
    "hinged_roof": (4, 6, 8, 12, 16, 24, 32, 48),
    "l_shape": (4, 6, 8, 12, 16, 24, 32, 48, 64),
    "corner_plate": (4, 6, 8, 12, 16, 24, 32, 48, 64),
    "paper_2n": (8, 12, 16, 24, 32),
    "paper_20n": (8, 12, 16, 24, 32),
    "free_ruler": (8, 12, 16, 24, 32, 48),
}
VARIANTS = {
    "thin": Variant("Kratos, thin", "small", THIN),
    "nurbs": Variant(
        "Kratos, thin, NURBS", "thin",
        {
            "end_shear": (4, 6, 8, 12, 16, 24, 32),
            "hemisphere": (6, 8, 12),
            "hinged_roof": (3, 4, 6, 8, 12, 16, 24),
            "corner_plate": (2, 3, 4, 6, 8, 12, 16, 24, 32),
            "paper_2n": (4, 6, 8, 12, 16),
            "paper_20n": (4, 6, 8, 12, 16),
            "free_ruler": (8, 12, 16, 24),
        },
        {"roll_up": "its elements have no rotations, and no condition puts a moment on their edge",
         "l_shape": "not one patch but three, joined by penalties: not tried"},
    ),
    "thick": Variant("Kratos, thick", "thick", THIN),
}  # fmt: skip


def prepare() -> None:
    from benchmarks.programs import kratos_nurbs  # noqa: F401
    from benchmarks.programs.kratos_shell import quiet

    quiet()


def version() -> str:
    from importlib.metadata import version

    return f"Kratos {version('KratosMultiphysics')}, Eigen's sparse LU and conjugate gradients"


def run(scene: Scene, variant: str, size: float) -> Outcome:
    if variant == "nurbs":
        from benchmarks.programs import kratos_nurbs

        return kratos_nurbs.solve(scene, int(size))
    from benchmarks.programs.kratos_models import solve

    return solve(scene, variant, int(size))


PROGRAM = Program("Kratos", VARIANTS, prepare, version, run, "kratos")

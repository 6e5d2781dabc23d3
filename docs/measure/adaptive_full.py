"""Theory `full` on a smooth problem, uniform and adaptive meshes: docs/theory/adaptive_full.csv.

From the folder of the repository, in half a minute:

    .venv/bin/python docs/measure/adaptive_full.py
"""

import csv
import warnings
from pathlib import Path

import skancf as sk

SIDE, THICKNESS, REFERENCE = 1.0, 0.1, 0.00427284
"""The deflection of the middle times D / q a^4, by a series; hard simple support, shear correction factor 5/6."""
YOUNG, POISSON, PRESSURE = 1.0e9, 0.3, 1.0
MIDDLE = (SIDE / 2, SIDE / 2)
OUT = Path(__file__).resolve().parent.parent / "theory" / "adaptive_full.csv"


def plate() -> sk.Problem:
    return sk.Problem(
        surface=sk.Rectangle(SIDE, SIDE),
        thickness=THICKNESS,
        material=sk.Isotropic(YOUNG, POISSON, density=1.0),
        supports=[sk.SimpleSupport("boundary", "hard")],
        loads=[sk.SurfaceLoad((0.0, 0.0, -PRESSURE))],
    )


def error(deflection: float) -> float:
    """Relative to the series, in per cent."""
    stiffness = YOUNG * THICKNESS**3 / 12 / (1 - POISSON**2)
    return 100 * (-deflection * stiffness / (PRESSURE * SIDE**4) / REFERENCE - 1)


def uniform(n: int) -> tuple[int, float]:
    problem = plate()
    state = sk.solve_linear(problem.on(sk.meshes.uniform(problem.surface, n, n), "full"))
    return state.system.n_dofs, error(state.displacement(MIDDLE)[2])


def main() -> None:
    warnings.simplefilter("ignore")
    rows = [("uniform", n * n, *uniform(n)) for n in (4, 8, 16, 32, 64)]
    result = sk.adapt(plate(), sk.Displacement(at=MIDDLE), rtol=3e-4, theory="full", linear=True, max_dofs=60_000,
                      marking=sk.Doerfler(0.9))  # fmt: skip
    rows += [("adaptive", level.n_elements, level.n_dofs, error(level.value)) for level in result.levels]
    with OUT.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["meshes", "elements", "nodal coordinates", "error (%)"])
        writer.writerows((name, elements, dofs, f"{percent:.3f}") for name, elements, dofs, percent in rows)
    print(OUT.read_text(encoding="utf-8"))


if __name__ == "__main__":
    main()

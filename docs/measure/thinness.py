"""Where the thin theory fails, and what it says of that itself: tables of docs/theory/kirchhoff.rst.

From the folder of the repository, in half a minute:

    .venv/bin/python docs/measure/thinness.py

It writes locking_thinness.csv and locking_corner.csv in docs/theory. The references are those of docs/measure/locking.py,
Reissner-Mindlin plates.
"""

import warnings

import numpy as np
import skfem
from locking import clamped, save, supported

import skancf as sk
from skancf.theories import Theory

NU = 0.3


def answer(edges: str, h: float, n: int, theory: Theory) -> sk.Solution:
    """Small deflections of the unit square under a unit load, with D = 1."""
    support = sk.Clamp("boundary") if edges == "clamped" else sk.SimpleSupport("boundary", kind="hard")
    law = sk.Isotropic(12 * (1 - NU**2) / h**3, NU, 1.0)
    plate = sk.Problem(sk.Rectangle(1.0, 1.0), h, law, [support], [sk.SurfaceLoad((0, 0, 1.0))])
    return sk.solve_linear(plate.on(sk.meshes.uniform(plate.surface, n, n), theory))


def shear() -> None:
    """Deflections against Reissner-Mindlin plates, and the predicted beside the true change of the energy."""
    rows: list[list[object]] = []
    for edges, reference in (("simply supported", supported), ("clamped", clamped)):
        for slenderness in (5, 10, 20, 50, 100):
            h = 1 / slenderness
            centre, mean = reference(h, NU)
            thin, thick = answer(edges, h, 16, sk.Kirchhoff()), answer(edges, h, 32, sk.Full())
            deflections = [solution.displacement((0.5, 0.5))[2] / centre for solution in (thin, thick)]
            # The load is one: its work is the mean deflection.
            left_out = mean / (2 * thin.strain_energy) - 1
            rows.append([edges, slenderness, *(f"{d:.4f}" for d in deflections),
                         f"{100 * thin.shear_share:.2f}", f"{100 * left_out:.2f}"])  # fmt: skip
    head = ["edges", "a/h", "kirchhoff 16 x 16", "full 32 x 32", "shear_share (%)", "true (%)"]
    save("thinness", head, rows)


def mean_deflection(n: int, notched: bool) -> float:
    """Integral of w over a clamped square (-1, 1)^2, or over the L that is left without its fourth quadrant; D = 1."""
    line = np.linspace(-1, 1, n + 1)
    mesh = skfem.MeshQuad.init_tensor(line, line)
    if notched:
        x, y = mesh.p[:, mesh.t].mean(axis=1)
        mesh = mesh.remove_elements(np.flatnonzero((x > 0) & (y < 0)))
    h = 0.01
    law = sk.Isotropic(12 * (1 - NU**2) / h**3, NU, 1.0)
    plate = sk.Problem(sk.Plane(), h, law, [sk.Clamp("boundary")], [sk.SurfaceLoad((0, 0, 1.0))])
    return 2 * sk.solve_linear(plate.on(mesh, "kirchhoff")).strain_energy


def corner() -> None:
    """A reentrant corner against a smooth plate: the integral of the deflection and its change with each halving."""
    rows: list[list[object]] = []
    last = [float("nan")] * 2
    for n in (4, 8, 16, 32, 64):
        now = [mean_deflection(n, notched) for notched in (False, True)]
        change = ["" if a != a else f"{100 * (b / a - 1):+.4f}" for a, b in zip(last, now, strict=True)]
        rows.append([f"{n} x {n}", f"{now[0]:.7f}", change[0], f"{now[1]:.7f}", change[1]])
        last = now
    save("corner", ["mesh", "square: integral of w", "change (%)", "L: integral of w", "change (%)"], rows)


if __name__ == "__main__":
    warnings.simplefilter("ignore", sk.OutOfDepth)
    shear()
    corner()

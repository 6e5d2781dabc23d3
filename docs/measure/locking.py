"""Where the fully parameterised plate locks, and how much: the tables of docs/theory/full.rst.

From the folder of the repository, in about a minute on two cores:

    .venv/bin/python docs/measure/locking.py

It writes docs/theory/locking_*.csv. Reference answers are computed here too, by a double Fourier series (simply
supported) and by Ritz's method with polynomials (clamped), both of Reissner-Mindlin plates.
"""

import csv
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.polynomial import Legendre, Polynomial

import skancf as sk

FOLDER = Path(__file__).resolve().parent.parent / "theory"
KAPPA = 5 / 6


def save(name: str, head: list[str], rows: list[list[object]]) -> None:
    with (FOLDER / f"locking_{name}.csv").open("w", newline="", encoding="utf-8") as stream:
        csv.writer(stream, lineterminator="\n").writerows([head, *rows])
    print(name, head, *rows, sep="\n   ")


# --- references -------------------------------------------------------------------------------------------------------


def supported(h: float, nu: float, terms: int = 400) -> tuple[float, float]:
    """w D / (q a^4) at the centre and in the mean, of a square plate on hard simple supports, side 1, thickness h."""
    m = np.arange(1, 2 * terms, 2)
    sign = (-1.0) ** ((m - 1) // 2)
    square = math.pi**2 * (m[:, None] ** 2 + m[None, :] ** 2)
    load = 16 / (math.pi**2 * m[:, None] * m[None, :]) * np.outer(sign, sign)
    shear = h**2 / (6 * (1 - nu) * KAPPA)
    w = np.abs(load) / square**2 * (1 + shear * square)
    return float((np.outer(sign, sign) * w).sum()), float((w * np.abs(load)).sum() / 4)


def clamped(h: float, nu: float, order: int = 18) -> tuple[float, float]:
    """The same for clamped edges: Ritz's method, (1 - x^2) times Legendre polynomials in both directions."""
    x, weight = np.polynomial.legendre.leggauss(order + 6)
    functions = [Polynomial([1, 0, -1]) * Legendre.basis(k).convert(kind=Polynomial) for k in range(order)]
    value = np.array([f(x) for f in functions])
    slope = 2 * np.array([f.deriv()(x) for f in functions])  # x runs over a plate of side 1, from -1 to 1

    def pair(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return (a * weight / 2) @ b.T

    mass, mixed, stiff = pair(value, value), pair(slope, value), pair(slope, slope)
    D, shear = 1.0, KAPPA * 6 * (1 - nu) / h**2  # both times 1 / D
    wxx, wyy, unit = np.kron(stiff, mass), np.kron(mass, stiff), np.kron(mass, mass)
    to_x, to_y = np.kron(mixed, mass), np.kron(mass, mixed)  # slope of w with the rotation
    cross = nu * np.kron(mixed, mixed.T) + (1 - nu) / 2 * np.kron(mixed.T, mixed)
    bend = (1 - nu) / 2
    K = np.block(
        [
            [shear * (wxx + wyy), -shear * to_x, -shear * to_y],
            [-shear * to_x.T, D * (wxx + bend * wyy) + shear * unit, D * cross],
            [-shear * to_y.T, D * cross.T, D * (wyy + bend * wxx) + shear * unit],
        ]
    )
    load = np.zeros(len(K))
    load[: order**2] = np.kron(value @ weight / 2, value @ weight / 2)
    w = np.linalg.solve(K, load)[: order**2]
    middle = np.array([f(0.0) for f in functions])
    return float(middle @ w.reshape(order, order) @ middle), float(w @ load[: order**2])


# --- measurements -----------------------------------------------------------------------------------------------------


def centre(edges: str, h: float, n: int, assumed: bool, kind: str = "plane_stress", nu: float = 0.3) -> float:
    """w D / (q a^4) of the element, small deflections."""
    support = sk.Clamp("boundary") if edges == "clamped" else sk.SimpleSupport("boundary", kind="hard")
    plate = sk.Problem(
        sk.Rectangle(1.0, 1.0), h, sk.Isotropic(1.0, nu, 1.0, kind=kind), [support], [sk.SurfaceLoad((0, 0, 1.0))]
    )
    system = plate.on(sk.meshes.uniform(plate.surface, n, n), sk.Full(assumed=assumed))
    return sk.solve_linear(system).displacement((0.5, 0.5))[2] * h**3 / (12 * (1 - nu**2))


def shear() -> None:
    rows: list[list[object]] = []
    for edges, exact in (("simply supported", supported), ("clamped", clamped)):
        for slenderness in (10, 100, 1000):
            h = 1 / slenderness
            for assumed in (False, True):
                ratios = [centre(edges, h, n, assumed) / exact(h, 0.3)[0] for n in (4, 8, 16, 32)]
                rows.append([edges, slenderness, "assumed" if assumed else "plain", *(f"{r:.3f}" for r in ratios)])
    save("shear", ["edges", "a/h", "strains", "4 x 4", "8 x 8", "16 x 16", "32 x 32"], rows)


def poisson() -> None:
    rows: list[list[object]] = []
    for nu in (0.0, 0.1, 0.2, 0.3, 0.4, 0.45):
        coarse, fine = (
            centre("supported", 0.01, n, True, "3d", nu) / centre("supported", 0.01, n, True, nu=nu) for n in (8, 32)
        )
        rows.append([nu, f"{coarse:.4f}", f"{fine:.4f}", f"{(1 - 2 * nu) / (1 - nu) ** 2:.4f}"])
    save("poisson", ["nu", "8 x 8", "32 x 32", "(1 - 2 nu) / (1 - nu)^2"], rows)


def roll_up() -> None:
    length, width, h, young = 12.0, 1.0, 0.1, 1.2e6
    rows: list[list[object]] = []
    for assumed in (False, True):
        for n in (8, 16, 32):
            cells: list[object] = []
            for turns in (0.25, 0.5, 1.0):
                moment = turns * 2 * math.pi * young * h**3 / 12 / length
                strip = sk.Problem(
                    sk.Rectangle(length, width), h, sk.Isotropic(young, 0.0, 1.0),
                    [sk.Clamp("left")], [sk.EdgeMoment("right", (0, -moment, 0))],
                )  # fmt: skip
                system = strip.on(sk.meshes.uniform(strip.surface, n, 1), sk.Full(assumed=assumed))
                result = sk.solve(system, control=sk.statics.HalveAndGrow(smallest=0.02))
                u = result.solution.displacement((length, width / 2))
                ok = result.status is sk.Status.CONVERGED
                cells.append(f"{-u[0]:.2f}, {u[2]:.2f} ({result.iterations})" if ok else "none")
            rows.append(["assumed" if assumed else "plain", n, *cells])
    exact = [(length * (1 - np.sinc(2 * m)), length * (1 - math.cos(2 * math.pi * m)) / (2 * math.pi * m))
             for m in (0.25, 0.5, 1.0)]  # fmt: skip
    rows.append(["exact", "", *(f"{u:.2f}, {w:.2f}" for u, w in exact)])
    save("roll_up", ["strains", "elements", "quarter circle", "half circle", "full circle"], rows)


def point_load() -> None:
    """Under a point force the deflection gains the same amount with every halving of the elements."""
    h, nu, radius = 0.05, 0.3, 0.1
    material = sk.Isotropic(1.0, nu, 1.0)
    gain = math.log(2) / (2 * math.pi * KAPPA * h / (2 * (1 + nu)))
    rows: list[list[object]] = []
    last = [math.nan, math.nan]
    for n in (4, 8, 16, 32, 64):
        w = []
        for load in (sk.PointForce((0.5, 0.5), (0, 0, 1.0)), sk.DiskForce((0.5, 0.5), radius, (0, 0, 1.0))):
            plate = sk.Problem(sk.Rectangle(1.0, 1.0), h, material, [sk.Clamp("boundary")], [load])
            solution = sk.solve_linear(plate.on(sk.meshes.uniform(plate.surface, n, n)))
            w.append(solution.displacement((0.5, 0.5))[2])
        steps = ["" if math.isnan(before) else f"{now - before:+.2f}" for now, before in zip(w, last, strict=True)]
        rows.append([f"{n} x {n}", f"{w[0]:.2f}", steps[0], f"{gain:.2f}", f"{w[1]:.2f}", steps[1]])
        last = w
    head = ["mesh", "point force: w", "change", "F ln 2 / (2 pi kappa G h)", "disk force: w", "change"]
    save("point_load", head, rows)


@dataclass(frozen=True)
class Roof:
    """A cylindrical roof over (axis, angle)."""

    radius: float = 25.0
    length: float = 50.0
    half_angle: float = math.radians(40)

    sides = ("near", "far", "left", "right")
    closed = (False, False)

    @property
    def bounds(self) -> tuple[tuple[float, float], tuple[float, float]]:
        return (0.0, self.length), (-self.half_angle, self.half_angle)

    def position(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        x, y = np.broadcast_arrays(np.asarray(x, float), np.asarray(y, float))
        return np.stack([x, self.radius * np.sin(y), self.radius * np.cos(y)])

    def derivatives(self, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        x, y = np.broadcast_arrays(np.asarray(x, float), np.asarray(y, float))
        zero = np.zeros_like(x)
        return (np.stack([zero + 1, zero, zero]),
                np.stack([zero, self.radius * np.cos(y), -self.radius * np.sin(y)]))  # fmt: skip

    def second_derivatives(self, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        x, y = np.broadcast_arrays(np.asarray(x, float), np.asarray(y, float))
        zero = np.zeros((3, *x.shape))
        return zero, zero, np.stack([zero[0], -self.radius * np.sin(y), -self.radius * np.cos(y)])


def roof() -> None:
    """Scordelis and Lo's roof, 0.3024: a curved surface, thin but not very."""
    rows: list[list[object]] = []
    for assumed in (False, True):
        ratios = []
        for n in (4, 8, 16, 32):
            shell = sk.Problem(
                Roof(), 0.25, sk.Isotropic(4.32e8, 0.0, 1.0),
                [sk.Prescribed(["near", "far"], (None, 0.0, 0.0)), sk.Prescribed((25.0, 0.0), (0.0, None, None))],
                [sk.SurfaceLoad((0, 0, -90.0))],
            )  # fmt: skip
            system = shell.on(sk.meshes.uniform(shell.surface, n, n), sk.Full(assumed=assumed))
            ratios.append(-sk.solve_linear(system).displacement((25.0, Roof().half_angle))[2] / 0.3024)
        rows.append(["assumed" if assumed else "plain", *(f"{r:.3f}" for r in ratios)])
    save("roof", ["strains", "4 x 4", "8 x 8", "16 x 16", "32 x 32"], rows)


def zero_modes() -> None:
    """Zero eigenvalues of one free element, which should be the six rigid motions, and of a free patch of 3 x 3."""
    rows: list[list[object]] = []
    for assumed in (False, True):
        counts = []
        for n in (1, 3):
            plate = sk.Problem(sk.Rectangle(1.0, 0.7), 0.1, sk.Isotropic(1.0, 0.3, 1.0))
            system = plate.on(sk.meshes.uniform(plate.surface, n, n), sk.Full(assumed=assumed))
            matrix = system.tangent(system.undeformed)
            dense = np.array([matrix @ unit for unit in np.eye(system.n_dofs)])
            values = np.linalg.eigvalsh((dense + dense.T) / 2)
            counts.append(int((np.abs(values) < 1e-11 * values[-1]).sum()))
        rows.append(["assumed" if assumed else "plain", *counts])
    save("zero_modes", ["strains", "one element", "3 x 3 elements"], rows)


def count(result: sk.statics.StaticResult) -> str:
    steps = len(result.path) - 1
    return f"{result.iterations}" + (f" in {steps} load steps" if steps > 1 else "")


def newton() -> None:
    """Iterations for the cantilever strip under the force of Sze et al. (2004), P L^2 / EI = 4, and more."""
    length, width, h, young = 10.0, 1.0, 0.1, 1.2e6
    rows: list[list[object]] = []
    for load in (1.0, 4.0, 10.0):
        force = load * young * h**3 / 12 / length**2
        strip = sk.Problem(
            sk.Rectangle(length, width), h, sk.Isotropic(young, 0.0, 1.0),
            [sk.Clamp("left")], [sk.EdgeLoad("right", (0, 0, force))],
        )  # fmt: skip
        system = strip.on(sk.meshes.uniform(strip.surface, 16, 1))
        results = [sk.solve(system, mixed=mixed, max_iterations=60) for mixed in (False, True)]
        rows.append([f"{load:g}", *(count(r) for r in results)])
    save("newton", ["P L^2 / EI", "plain Newton", "mixed integration point"], rows)


if __name__ == "__main__":
    for measure in (shear, poisson, roll_up, point_load, roof, zero_modes, newton):
        measure()

"""Microseconds per point of laws at points, and what an energy of one's own costs beside the law written by hand.

    python -m benchmarks.laws [--points 20000]

The best of several runs on one core; both laws of a row run in turns in one process, so that the ratio means something on a
busy machine. C33 starts from that of a state 0.1 % away, as in Newton's method.
"""

import argparse
import time
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

import skancf as sk

MU, NU, RHO = 1.5e6, 0.45, 1000.0
PAIRS = [(6.3e5, 1.3), (0.012e5, 5.0), (-0.1e5, -2.0)]


def neo_hooke(I1: Any, I2: Any, J: Any, par: Any) -> Any:
    return par[0] / 2 * (J ** (-2 / 3) * I1 - 3) + par[1] / 4 * (J * J - 1 - 2 * np.log(J))


def mooney(I1: Any, I2: Any, J: Any, par: Any) -> Any:
    return (par[0] * (J ** (-2 / 3) * I1 - 3) + par[1] * (J ** (-4 / 3) * I2 - 3)
            + par[2] / 4 * (J * J - 1 - 2 * np.log(J)))  # fmt: skip


def mooney_incompressible(I1: Any, I2: Any, J: Any, par: Any) -> Any:
    return par[0] * (I1 - 3) + par[1] * (I2 - 3)


def mooney_of_components(a: Any, b: Any, c: Any, d: Any, par: Any) -> Any:
    p = a * b - d * d
    I3 = p * c
    I1, I2 = a + b + c, p + c * (a + b)
    return par[0] * (I3 ** (-1 / 3) * I1 - 3) + par[1] * (I3 ** (-2 / 3) * I2 - 3) + par[2] / 4 * (I3 - 1 - np.log(I3))


def ogden_of_components(a: Any, b: Any, c: Any, d: Any, par: Any) -> Any:
    h, r = (a + b) / 2, np.sqrt(((a - b) / 2) ** 2 + d * d + 1e-20)
    I3, s = (a * b - d * d) * c, 0.0 * a
    for k in range(3):
        m, al = par[1 + 2 * k], par[2 + 2 * k]
        s = s + m / al * (I3 ** (-al / 6) * ((h + r) ** (al / 2) + (h - r) ** (al / 2) + c ** (al / 2)) - 3)
    return s + par[0] / 4 * (I3 - 1 - np.log(I3))


class Row(NamedTuple):
    """A law by hand and the same as an energy of one's own; microseconds of each."""

    name: str
    by_hand: float
    own: float


def pairs() -> dict[str, tuple[Any, Any]]:
    """Laws by hand and those of the same energy."""
    neo, rubber = sk.NeoHooke(MU, RHO, poisson=NU), sk.MooneyRivlin(7 / 16 * MU, MU / 16, RHO, poisson=NU)
    stiff, ogden = sk.MooneyRivlin(7 / 16 * MU, MU / 16, RHO), sk.Ogden(PAIRS, RHO, poisson=NU)
    c10, c01, bulk = rubber.c10, rubber.c01, rubber.bulk_modulus
    return {
        "neo-Hooke, by invariants": (neo, sk.Hyperelastic(neo_hooke, (MU, bulk), RHO)),
        "Mooney-Rivlin, by invariants": (rubber, sk.Hyperelastic(mooney, (c10, c01, bulk), RHO)),
        "the same, incompressible": (stiff, sk.Hyperelastic(mooney_incompressible, (c10, c01), RHO, incompressible=True)),
        "Mooney-Rivlin, by components": (rubber, sk.Hyperelastic(mooney_of_components, (c10, c01, bulk), RHO)),
        "Ogden of three terms, by components": (ogden, sk.Hyperelastic(ogden_of_components, ogden.parameters, RHO)),
    }


def microseconds(calls: list[Callable[[], Any]], n: int, seconds: float = 2.0) -> list[float]:
    """Shortest run of each, in turns, in processor time per point."""
    best, end = [np.inf] * len(calls), time.perf_counter() + seconds
    while time.perf_counter() < end:
        for k, call in enumerate(calls):
            start = time.thread_time()
            call()
            best[k] = min(best[k], time.thread_time() - start)
    return [1e6 * each / n for each in best]


def measure(points: int = 20000) -> list[Row]:
    """All rows."""
    rng = np.random.default_rng(0)
    C = np.array([[1.0], [1.0], [0.0]]) + 0.2 * rng.uniform(-1, 1, (3, points))
    near = C + 1e-3 * rng.uniform(-1, 1, C.shape)
    rows = []
    for name, laws in pairs().items():
        starts = [law.plane_stress(C).stretch33 for law in laws]
        calls = [lambda law=law, c33=c33: law.respond(near, c33) for law, c33 in zip(laws, starts, strict=True)]
        rows.append(Row(name, *microseconds(calls, points)))
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--points", type=int, default=20000)
    for row in measure(parser.parse_args().points):
        print(f"{row.name:<36} by hand {row.by_hand:6.3f}, own {row.own:6.3f} us, {row.own / row.by_hand:5.1f} times that")


if __name__ == "__main__":
    main()

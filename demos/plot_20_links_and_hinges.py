r"""
Links and hinges
================

.. image:: /pictures/gallery/20_links_and_hinges.jpg
   :alt: A ring with a hinge, pushed at the hinge, in steps until it snaps.
   :class: example-picture

A sheet bent to a tube meets itself along two of its sides, and a hinge joins them: positions are equal, turns are free. And
a rod of fixed length ties the feet of an arch. Both are *conditions*, g(q) = 0. What keeps them are their multipliers, which
are part of every answer: a force per length along the hinge, a force in the rod.

A ring of radius R with one hinge, pulled by P along the diameter through it, gives way by

.. math:: \delta = \Bigl(\frac{\pi}{4} - \frac{4}{3\pi}\Bigr) \frac{P R^3}{EI}, \qquad H = \frac{2 P}{3 \pi}

with the force H that the hinge carries along the circle. Pushed, it snaps. In an arch of half a circle, the tie takes
:math:`P / \pi` of a force at the crown.

This example shows ``conditions``, :class:`~skancf.Hinge`, :class:`~skancf.RigidLink`, and their forces. It builds on
snap-through.
"""

# %%
import argparse
import os
from collections.abc import Callable
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import skancf as sk
from skancf import output

# sphinx_gallery_thumbnail_path = "pictures/gallery/20_links_and_hinges.jpg"

YOUNG, RADIUS, THICKNESS, WIDTH = 2e11, 1.0, 0.01, 0.05
STEEL = sk.Isotropic(young=YOUNG, poisson=0.0, density=7800.0)
EI = YOUNG * THICKNESS**3 / 12 * WIDTH
UNIT = EI / RADIUS**2
"""Forces are told in EI / R^2."""

# %%
# The ring
# --------
# The surface goes around once and is not closed: its sides ``"start"`` and ``"end"`` lie on each other, at y = 0 and
# :math:`2\pi`, and the hinge names them. The load acts on one of the two; the hinge hands half of it to the other.
RING = sk.CylinderSector(RADIUS, WIDTH, angle=2 * np.pi)


def opposite(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """The line at the other end of the diameter."""
    return np.abs(y - np.pi) < 1e-6


def ring(force: float, elements: int) -> sk.system.System:
    """Pulled by a force along -y."""
    problem = sk.Problem(
        RING, THICKNESS, STEEL,
        supports=[sk.Clamp(opposite)],
        loads=[sk.EdgeLoad("start", (0.0, -force / WIDTH, 0.0))],
        conditions=[sk.Hinge("start", "end")],
    )  # fmt: skip
    return problem.on(sk.meshes.uniform(RING, 1, elements), theory="kirchhoff")


# %%
# The arch
# --------
# Pinned at one foot, free to slide at the other, and tied by a rod along each edge.
ARCH = sk.CylinderSector(RADIUS, WIDTH, angle=np.pi)


def arch(force: float, elements: int, *, tied: bool = True) -> sk.system.System:
    """Pressed down at its crown."""
    rods = [sk.RigidLink((x, 0.0), (x, np.pi), name=f"rod at {x:g}") for x in (0.0, WIDTH)]
    problem = sk.Problem(
        ARCH, THICKNESS, STEEL,
        supports=[sk.Pin("start"), sk.Roller("end")],
        loads=[sk.LineLoad((0.0, np.pi / 2), (WIDTH, np.pi / 2), (0.0, 0.0, -force / WIDTH))],
        conditions=rods if tied else [],
    )  # fmt: skip
    return problem.on(sk.meshes.uniform(ARCH, 1, elements), theory="kirchhoff")


# %%
# Small deflections
# -----------------
# The numbers to hit: the three of beam theory. Stretch of the ring changes them by parts of :math:`(t / R)^2`.


def small_deflections(elements: int, say: Callable) -> None:
    """AssertionError where the numbers are not those of beam theory."""
    pulled = sk.solve_linear(ring(1.0, elements))
    numbers = {
        "deflection of the ring": (-pulled.displacement((0.0, 0.0))[1] / RADIUS**3 * EI, np.pi / 4 - 4 / (3 * np.pi)),
        "force across the hinge": (pulled.conditions["hinge"].total[1], 0.5),
        "force along the circle": (-pulled.conditions["hinge"].total[2], 2 / (3 * np.pi)),
        "force in the ties": (sum(sk.solve_linear(arch(1.0, elements)).conditions.values()), 1 / np.pi),
    }
    for what, (found, expected) in numbers.items():
        say(f"{what}: {found:.6f}, by beam theory {expected:.6f}")
        assert abs(found - expected) < 2e-3 * expected, (what, found, expected)


# %%
# Large ones
# ----------
# Pushed at its hinge the ring gives way, and snaps. The path goes through its limit point by displacement control, and
# multipliers are carried along. The arch with its ties holds several times what it does without.


def main(size: str = "full", out: str = "out", say: Callable = print) -> dict[str, float]:
    """All of it; returns the load at which the ring snaps, and those that the arch holds, in EI / R^2."""
    folder = Path(out)
    output.check_folder(folder)
    elements = {"full": 48, "small": 24}[size]
    small_deflections(elements, say)

    control = sk.DisplacementControl(at=(0.0, 0.0), direction=(0.0, 1.0, 0.0), to=1.35 * RADIUS)
    path = sk.trace(ring(-UNIT, elements), control).unwrap()
    limits = [event.load_factor for event in path.events if event.kind == "limit point"]
    say(f"the ring snaps at {limits[0]:.4f} EI / R^2, in {len(path.solutions)} steps and {path.iterations} iterations")
    meet = path.solution.position([(0.0, 0.0), (0.0, 2 * np.pi)])
    assert np.abs(meet[0] - meet[1]).max() < 1e-12 * RADIUS

    pressed = {}
    for tied in (True, False):
        downward = sk.DisplacementControl(at=(0.0, np.pi / 2), direction=(0.0, 0.0, -1.0), to=0.3 * RADIUS)
        pressed[tied] = sk.trace(arch(UNIT, elements, tied=tied), downward).unwrap()
        say(f"the arch {'with' if tied else 'without'} ties: {pressed[tied].load_factors[-1]:.3f} EI / R^2 at 0.3 R")
    state = pressed[True].solution
    feet = state.position([(0.0, 0.0), (0.0, np.pi)])
    assert abs(np.linalg.norm(feet[1] - feet[0]) - 2 * RADIUS) < 1e-12 * RADIUS
    draw(path, pressed, folder / "links_and_hinges.png")
    held = {("tied" if tied else "free"): float(found.load_factors[-1]) for tied, found in pressed.items()}
    return {"snaps": limits[0], **held}


# %%
# Pictures
# --------


def draw(path: sk.PathResult, pressed: dict[bool, sk.PathResult], file: Path) -> None:
    """Shapes of the ring, its path, and the force in the ties."""
    _, (left, middle, right) = plt.subplots(1, 3, figsize=(12, 3.8), layout="constrained")
    around = np.linspace(0, 2 * np.pi, 145)
    for k in np.linspace(0, len(path.solutions) - 1, 5).astype(int):
        line = path.solutions[k].position(np.column_stack([0 * around, around]))
        left.plot(line[:, 1], line[:, 2], color=plt.cm.viridis(k / len(path.solutions)))
        left.plot(*line[0, 1:], "o", ms=5, color="k", zorder=3)
    left.set(aspect="equal", xlabel="y (m)", ylabel="z (m)", title="A ring pushed at its hinge")
    limits = [event.solution for event in path.events if event.kind == "limit point"]
    states = sorted([*path.solutions, *limits], key=lambda state: state.displacement((0.0, 0.0))[1])
    middle.plot(*zip(*[(state.displacement((0.0, 0.0))[1], state.load_factor) for state in states], strict=True), "o-", ms=4)
    for state in limits:
        middle.plot(state.displacement((0.0, 0.0))[1], state.load_factor, "o", ms=8, color="C3", zorder=3)
    middle.set(xlabel="displacement of the hinge (m)", ylabel=r"load (EI / R$^2$)", title="Its path, and where it snaps")
    tied = pressed[True]
    right.plot(-tied.displacement((0.0, np.pi / 2))[:, 2], tied.load_factors, "o-", ms=4, label="load, tied")
    ties = [sum(state.conditions.values()) / UNIT for state in tied.solutions]
    right.plot(-tied.displacement((0.0, np.pi / 2))[:, 2], ties, "o--", ms=4, label="force in the ties")
    free = pressed[False]
    right.plot(-free.displacement((0.0, np.pi / 2))[:, 2], free.load_factors, "o-", ms=4, color="0.6",
               label="load, without ties")  # fmt: skip
    right.set(xlabel="the crown goes down by (m)", ylabel=r"force (EI / R$^2$)", title="An arch with ties")
    right.legend(frameon=False)
    middle.figure.savefig(file, dpi=120)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="A ring with a hinge, and an arch with ties")
    parser.add_argument("--size", choices=["full", "small"], default=os.environ.get("SKANCF_DEMO_SIZE", "full"))
    parser.add_argument("--out", default=os.environ.get("SKANCF_DEMO_OUT", "out"))
    arguments, _ = parser.parse_known_args()
    main(arguments.size, arguments.out)

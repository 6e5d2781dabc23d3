r"""
A blade that grows thinner to its tip
=====================================

.. image:: /pictures/gallery/23_tapered_blade.jpg
   :alt: A blade in one of its modes, coloured by its thickness.
   :class: example-picture

A turbine blade, a reed of an organ, a ruler filed down: the thickness falls from the root to the tip, so that the root
carries the bending and the tip weighs little. In this library the thickness is given as a function of the parameters (x, y).
It is asked where the elements integrate, so that stiffness, :math:`E h^3 / 12`, and mass, :math:`\rho h`, are those of the
function.

A straight taper :math:`h = h_0 (1 - \alpha x / L)` has the frequencies
:math:`\omega = \lambda\, L^{-2} \sqrt{E h_0^2 / 12 \rho}` of a beam,

.. math:: \frac{d^2}{dx^2} \Bigl( (1 - \alpha x)^3\, w'' \Bigr) = \lambda^2 (1 - \alpha x)\, w,

which Ritz' method with polynomials solves to rounding. A uniform strip has :math:`\lambda = 3.516`; of a wedge,
:math:`\alpha = 1`, G. Kirchhoff found 5.315 with Bessel functions (*Monatsberichte der Akademie*, Berlin 1879): less
material, and a higher tone.

This example shows the thickness as a function of place, and modes of a taper. It builds on how square plates vibrate.
"""

# %%
# Beams by Ritz' method
# ---------------------
import argparse
import os
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from scipy.linalg import eigh

import skancf as sk
from skancf import output

# sphinx_gallery_thumbnail_path = "pictures/gallery/23_tapered_blade.jpg"

LENGTH, WIDTH, ROOT, YOUNG, DENSITY = 0.5, 0.04, 2e-3, 200e9, 7800.0
STRIP = sk.Rectangle(LENGTH, WIDTH)
UNIT = np.sqrt(YOUNG * ROOT**2 / 12 / DENSITY) / LENGTH**2
SHARES = (0.0, 0.25, 0.5, 0.75, 0.9)


def beam(share: float, n: int = 16) -> np.ndarray:
    """Frequencies of a tapered cantilever in units of :data:`UNIT`, from the first on."""
    x, w = np.polynomial.legendre.leggauss(60)
    x, w = (x + 1) / 2, w / 2
    clamped = np.polynomial.Polynomial([0, 0, 1]).convert(domain=[0, 1], kind=np.polynomial.Legendre)
    shapes = [np.polynomial.Legendre.basis(k, [0, 1]) * clamped for k in range(n)]
    values, bent = (np.stack([f(x) for f in each]) for each in (shapes, [f.deriv(2) for f in shapes]))
    h = 1 - share * x
    return np.sqrt(eigh(bent * w * h**3 @ bent.T, values * w * h @ values.T, eigvals_only=True))


# %%
# The strip
# ---------
# Without lateral contraction a strip is a beam. Each column of elements is a class of its own, as the thickness is another
# one there; elements of one column share it.


def thickness(share: float) -> Any:
    """A function of (x, y)."""
    return lambda x, y: ROOT * (1 - share * x / LENGTH)


def strip(share: float, n: int) -> sk.system.System:
    """A tapered cantilever of the thin theory."""
    material = sk.Isotropic(YOUNG, 0.0, DENSITY)
    problem = sk.Problem(STRIP, thickness(share), material, [sk.Clamp("left")])
    return problem.on(sk.meshes.uniform(STRIP, n, 1), "kirchhoff")


def flapping(system: sk.system.System, expected: np.ndarray) -> np.ndarray:
    """Of the modes those that flap, the nearest to the beam's; others twist the strip or bend it in its plane."""
    omega = sk.modes(system, 8).omega / UNIT
    return np.array([omega[np.argmin(np.abs(omega - one))] for one in expected])


# %%
# A blade
# -------
# Steel, thinner to its tip and to its edges, on both sides of its middle surface. With ``offset``, a function as well, it
# would be flat below; the thin theory has its mass in the surface, and says so where that is off.


def blade(n: int) -> sk.system.System:
    """A cantilever with crowned faces."""

    def crowned(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return ROOT * (1 - 0.75 * x / LENGTH) * (1 - 0.6 * (2 * y / WIDTH - 1) ** 2)

    problem = sk.Problem(STRIP, crowned, sk.Isotropic(YOUNG, 0.3, DENSITY), [sk.Clamp("left")])
    return problem.on(sk.meshes.uniform(STRIP, 4 * n, n), "kirchhoff")


# %%
# Pictures
# --------


def draw(axes: plt.Axes, found: np.ndarray) -> None:
    """Three frequencies against the taper."""
    fine = np.linspace(0.0, 0.97, 40)
    lines = np.array([beam(share)[:3] for share in fine])
    for k, colour in enumerate(("#0072B2", "#D55E00", "#009E73")):
        axes.plot(fine, lines[:, k] / lines[0, k], color=colour, lw=2, label=f"beam, {k + 1}")
        axes.plot(SHARES, found[:, k] / lines[0, k], "o", color=colour, ms=6)
    axes.set(xlabel=r"taper $\alpha$ (0: uniform, 1: a wedge)", ylabel="frequency over that of the uniform strip",
             title="A thinner tip: the first tone rises, the others fall")  # fmt: skip
    axes.legend(frameon=False)
    axes.grid(color="#e0e0e0")


# %%
# The run
# -------
# The numbers to hit: three frequencies of five tapers to 2e-4 on 16 elements, and the mass of the blade, which is a
# polynomial, to rounding.


def main(size: str = "full", out: str = "out") -> np.ndarray:
    """Print frequencies, save pictures; returns the frequencies of the strips."""
    n, close = (16, 2e-4) if size == "full" else (8, 2e-3)
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    found = []
    print("taper      strip: three frequencies       error")
    for share in SHARES:
        expected = beam(share)[:3]
        found.append(flapping(strip(share, n), expected))
        error = np.abs(found[-1] / expected - 1).max()
        print(f"{share:5.2f}  {'  '.join(f'{value:9.5f}' for value in found[-1])}   {error:.0e}")
        assert error < close, (share, found[-1], expected)
    assert abs(beam(0.999)[0] - 5.315) < 0.02 and abs(beam(0.0)[0] - 3.51602) < 1e-5

    system = blade(4 if size == "full" else 2)
    mass = DENSITY * ROOT * LENGTH * WIDTH * (1 - 0.75 / 2) * (1 - 0.6 / 3)
    modes = sk.modes(system, 4)
    print(f"\nblade: mass {system.inertia.total:.6f} kg, exact {mass:.6f}; frequencies "
          f"{', '.join(f'{f:.1f}' for f in modes.frequencies)} Hz")  # fmt: skip
    assert abs(system.inertia.total / mass - 1) < 1e-12

    chart, axes = plt.subplots(figsize=(8, 5.5), layout="constrained")
    draw(axes, np.array(found))
    chart.savefig(folder / "tapered_strips.png", dpi=120)
    output.picture(modes.shape(1, size=0.05), folder / "tapered_blade.png", field="thickness",
                   title=f"Thickness of the blade, on its mode of {modes.frequencies[1]:.0f} Hz")  # fmt: skip
    return np.array(found)


def arguments() -> dict[str, str]:
    """Size and folder from the command line, else from the environment."""
    parser = argparse.ArgumentParser(description="A blade that grows thinner to its tip")
    parser.add_argument("--size", choices=["full", "small"], default=os.environ.get("SKANCF_DEMO_SIZE", "full"))
    parser.add_argument("--out", default=os.environ.get("SKANCF_DEMO_OUT", "out"), help="folder for pictures")
    return vars(parser.parse_known_args()[0])


if __name__ == "__main__":
    main(**arguments())

"""A cantilever strip rolled up by a moment at its end."""

from math import cos, pi, sin

from benchmarks.scenes.scene import Quantity, Scene

LENGTH, THICKNESS, YOUNG = 12.0, 0.1, 1.2e6
MOMENT = 2 * pi * YOUNG * THICKNESS**3 / 12 / LENGTH


def thin_end() -> tuple[float, float]:
    """-u and w of the end for the energy EA (λ² - 1)² / 8 + EI (λ φ')² / 2 per length, λ the stretch.

    It measures curvature per undeformed length, so that a moment shortens the mid-surface: (λ² - 1) / 2 = -(h φ')² / 12,
    M = EI λ² φ'.
    """
    square = 1.0
    for _ in range(50):
        curvature = 2 * pi / LENGTH / square
        square = 1 - (THICKNESS * curvature) ** 2 / 6
    angle, radius = curvature * LENGTH, square**0.5 / curvature
    return LENGTH - radius * sin(angle), radius * (1 - cos(angle))


SOURCE = ("Closed form. Small and thick: the circle that small strains give. Thin: for the energy of the theory, whose "
          "curvature per undeformed length shortens the mid-surface. Data from Sze, Liu and Lo (2004), 3.2.")  # fmt: skip
U, W = thin_end()
EXACT = {"thin": 1e-12, "small": 1e-12, "thick": 1e-12}

SCENE = Scene(
    name="roll_up",
    title="Strip, rolled up",
    text="A strip of length 12, width 1 and thickness 0.1, clamped at x = 0. A moment of 2 pi EI / L about the axis y is "
    "spread evenly over its other edge and closes the strip to a circle that rises to z > 0. Static.",
    data={"length": LENGTH, "width": 1.0, "thickness": THICKNESS, "young": YOUNG, "poisson": 0.0, "moment": MOMENT},
    quantities={
        "u": Quantity("end moves back, -u", "m", {"thin": U, "small": LENGTH, "thick": LENGTH}, EXACT, SOURCE, LENGTH),
        "w": Quantity("end moves up, w", "m", {"thin": W, "small": 0.0, "thick": 0.0}, EXACT, SOURCE, LENGTH),
    },
)

"""Motion: time integrators, step control, the loop."""

from skancf.dynamics.generalized_alpha import GeneralizedAlpha
from skancf.dynamics.motion import Motion, MotionStatus
from skancf.dynamics.simulate import simulate
from skancf.dynamics.steps import FixedStep, LocalError

__all__ = ["FixedStep", "GeneralizedAlpha", "LocalError", "Motion", "MotionStatus", "simulate"]

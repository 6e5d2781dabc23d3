"""What every solve that goes step by step has in common: Newton's method, how it ended, and that the computed is kept."""

from skancf.solving.loop import End, run_steps
from skancf.solving.newton import FOUND, Iteration, iterate
from skancf.solving.status import Status

__all__ = ["FOUND", "End", "Iteration", "Status", "iterate", "run_steps"]

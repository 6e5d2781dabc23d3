"""What every solve that goes step by step has in common: how it ended, and that what was computed is kept."""

from skancf.solving.status import Status

__all__ = ["Status"]

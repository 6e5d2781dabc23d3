"""The command ``skancf``."""

from skancf.cli.main import main

__all__ = ["main"]

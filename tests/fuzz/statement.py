"""All names that a case's ``repr`` is made of."""

from numpy import array, inf, nan

from fuzz.case import Case, Mesh
from fuzz.cases import Frame
from fuzz.moving import Moving
from fuzz.properties import PROPERTIES
from fuzz.shapes import Barrel, Moved, Torus
from skancf import *  # noqa: F403
from skancf import __all__ as _public

__all__ = ["PROPERTIES", "Barrel", "Case", "Frame", "Mesh", "Moved", "Moving", "Torus", "array", "inf", "nan", *_public]

"""Laws: strain to stress, as pure functions at a point."""

from skancf.materials.isotropic import Isotropic
from skancf.materials.law import Anisotropic, Law
from skancf.materials.orthotropic import Orthotropic

ALL = [Isotropic, Orthotropic, Anisotropic]

__all__ = ["ALL", "Anisotropic", "Isotropic", "Law", "Orthotropic"]

"""Shape functions on the reference square, as scikit-fem elements."""

from skancf.elements.quad_ancf import ElementQuadANCF, MappingPlate, through_thickness
from skancf.elements.quad_hermite import ElementQuadHermite

ALL = [ElementQuadANCF, ElementQuadHermite]

__all__ = ["ALL", "ElementQuadANCF", "ElementQuadHermite", "MappingPlate", "through_thickness"]

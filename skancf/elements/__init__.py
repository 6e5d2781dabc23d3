"""Shape functions on the reference square, as scikit-fem elements."""

from skancf.elements.quad_ancf import ElementQuadANCF, MappingPlate, through_thickness

ALL = [ElementQuadANCF]

__all__ = ["ALL", "ElementQuadANCF", "MappingPlate", "through_thickness"]

"""Meshes of the parameter plane: uniform and graded; each one is a scikit-fem ``MeshQuad``."""

from skancf.meshes.check import check_mesh
from skancf.meshes.graded import graded
from skancf.meshes.progression import progression
from skancf.meshes.region import Region, Regions
from skancf.meshes.tensor import tensor
from skancf.meshes.uniform import uniform

__all__ = ["Region", "Regions", "check_mesh", "graded", "progression", "tensor", "uniform"]

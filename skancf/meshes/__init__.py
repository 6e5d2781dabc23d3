"""Meshes of the parameter plane: uniform, graded, and quadtrees; each one is a scikit-fem ``MeshQuad``."""

from skancf.meshes.check import check_mesh
from skancf.meshes.files import from_file, to_file, within
from skancf.meshes.graded import graded
from skancf.meshes.lines import with_lines
from skancf.meshes.progression import progression
from skancf.meshes.quadtree import MeshQuadTree, quadtree
from skancf.meshes.quadtree_file import load, save
from skancf.meshes.region import Region, Regions
from skancf.meshes.tensor import tensor
from skancf.meshes.tree_regions import refined_in
from skancf.meshes.uniform import uniform

__all__ = [
    "MeshQuadTree", "Region", "Regions", "check_mesh", "from_file", "graded", "load", "progression", "quadtree",
    "refined_in", "save", "tensor", "to_file", "uniform", "with_lines", "within",
]  # fmt: skip

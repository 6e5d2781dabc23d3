"""Plates and shells that move and bend a lot: ANCF with local refinement on scikit-fem."""

from skancf import adapt, meshes
from skancf.dynamics import simulate
from skancf.elements import ElementQuadANCF, through_thickness
from skancf.errors import DidNotConverge, InputError, SingularMatrix, SkancfError
from skancf.loads import DiskForce, EdgeLoad, EdgeMoment, Gravity, PointForce, SurfaceLoad
from skancf.materials import Anisotropic, Isotropic, Orthotropic
from skancf.problem import Problem
from skancf.solution import Solution
from skancf.statics import solve, solve_linear
from skancf.supports import Clamp, Pin, Prescribed, Roller, SimpleSupport, Symmetry
from skancf.surfaces import AnnulusSector, Plane, Rectangle
from skancf.theories import Full
from skancf.version import __version__

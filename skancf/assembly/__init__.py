"""From problem and mesh to a system: local vectors, tables, kernels, sparsity."""

from skancf.assembly.system import System

__all__ = ["System"]

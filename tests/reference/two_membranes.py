r"""Simply supported convex polygonal plates as two membranes (Marcus 1924; Timoshenko and Woinowsky-Krieger, article 24).

With D = q = 1, :math:`-\Delta m = 1,\; -\Delta w = m` and m = w = 0 at the straight edges. At an obtuse corner w is as
singular as the plate's, but the membranes' energy feels it less: biquadratic elements converge fast.
"""

from functools import cache
from math import cos, sin

import numpy as np
import skfem
from skfem.models.poisson import laplace, mass, unit_load


@cache
def rhombic_centre(angle: float, n: int = 64) -> float:
    """w in the middle of a rhombus of side 1 on n by n elements."""
    row = np.linspace(0.0, 1.0, n + 1)
    mesh = skfem.MeshQuad.init_tensor(row, row)
    x, y = mesh.p
    basis = skfem.Basis(skfem.MeshQuad(np.array([x + y * cos(angle), y * sin(angle)]), mesh.t), skfem.ElementQuad2())
    K, held = laplace.assemble(basis), basis.get_dofs()
    m = skfem.solve(*skfem.condense(K, unit_load.assemble(basis), D=held))
    w = skfem.solve(*skfem.condense(K, mass.assemble(basis) @ m, D=held))
    middle = np.array([[(1 + cos(angle)) / 2], [sin(angle) / 2]])
    return float((basis.probes(middle) @ w)[0])

"""Compiled symmetric tangent of a follower pressure."""

import numpy as np

from skancf.compiled import OPTIONS, compiled
from skancf.kernels.constants import AXES, FUNCTIONS, LOCAL
from skancf.kernels.gather import gather, scatter_tangent


@compiled(**OPTIONS)
def pressure_stiffness(start, stop, order, q, pressure, values, slopes, maps, slots, out):
    """Adds minus the symmetric derivative of p N (r_1 x r_2); ``values`` (16, n) have the weights, ``slopes`` (2, 16, n).

    With the vectors :math:`c_b = r_1 N_{b,2} - r_2 N_{b,1}` the derivative of the force on function a with respect to b is
    the cross product with :math:`p N_a c_b`; its symmetric part is that with :math:`p (N_a c_b - N_b c_a) / 2`.
    """
    n_points = values.shape[1]
    local, K = np.empty((FUNCTIONS, AXES)), np.zeros((LOCAL, LOCAL))
    M, c = np.empty((AXES, FUNCTIONS, FUNCTIONS)), np.empty((n_points, FUNCTIONS))
    one, two = np.empty(n_points), np.empty(n_points)
    for index in range(start, stop):
        e = order[index]
        gather(e, q, maps, local)
        for i in range(3):
            one[:] = 0.0
            two[:] = 0.0
            for a in range(FUNCTIONS):
                for p in range(n_points):
                    one[p] += slopes[0, a, p] * local[a, i]
                    two[p] += slopes[1, a, p] * local[a, i]
            for p in range(n_points):
                for b in range(FUNCTIONS):
                    c[p, b] = one[p] * slopes[1, b, p] - two[p] * slopes[0, b, p]
            np.dot(values, c, M[i])
        half = -0.5 * pressure[e]
        for a in range(FUNCTIONS):
            for b in range(FUNCTIONS):
                x, y, z = (half * (M[0, a, b] - M[0, b, a]), half * (M[1, a, b] - M[1, b, a]),
                           half * (M[2, a, b] - M[2, b, a]))  # fmt: skip
                a2, a3, b2, b3 = a + FUNCTIONS, a + 2 * FUNCTIONS, b + FUNCTIONS, b + 2 * FUNCTIONS
                K[a, b2], K[a, b3], K[a2, b3] = -z, y, -x
                K[a2, b], K[a3, b], K[a3, b2] = z, -y, x
        scatter_tangent(e, maps, slots, K, out)

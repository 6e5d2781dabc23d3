"""Load-displacement tables of shells in large displacement, by S4R elements of Abaqus.

Sze, Liu and Lo, Popular benchmark problems for geometric nonlinear analysis of shells, Finite Elements in Analysis and
Design 40 (2004), 1551-1569. Their meshes leave about 0.5 % of the end value.
"""

import numpy as np

# Section 3.1, cantilever under end shear, load in twentieths of 4: -u and w of the tip.
END_SHEAR = np.array([
    (0.026, 0.663), (0.103, 1.309), (0.224, 1.922), (0.381, 2.493), (0.563, 3.015), (0.763, 3.488), (0.971, 3.912),
    (1.184, 4.292), (1.396, 4.631), (1.604, 4.933), (1.807, 5.202), (2.002, 5.444), (2.190, 5.660), (2.370, 5.855),
    (2.541, 6.031), (2.705, 6.190), (2.861, 6.335), (3.010, 6.467), (3.151, 6.588), (3.286, 6.698),
])  # fmt: skip

# Section 3.3, slit annular plate lifted at one side of the slit by 0.8 per length: its inner and its outer corner.
SLIT_ANNULUS = np.array([13.891, 17.528])

# Section 3.4, hemisphere with a hole of 18 degrees, load in twentieths of 400: outward and inward under the two forces.
HEMISPHERE = np.array([
    (0.855, 0.955), (1.499, 1.840), (1.969, 2.604), (2.321, 3.261), (2.596, 3.833), (2.819, 4.339), (3.002, 4.790),
    (3.158, 5.196), (3.291, 5.565), (3.406, 5.902), (3.508, 6.212), (3.598, 6.497), (3.678, 6.761), (3.750, 7.006),
    (3.816, 7.234), (3.875, 7.448), (3.929, 7.647), (3.979, 7.835), (4.025, 8.011), (4.067, 8.178),
])  # fmt: skip

# Section 3.8, hinged cylindrical roof, t = 12.7, isotropic, along the path: deflection of the crown, load over 3000.
HINGED_ROOF = np.array([
    (0.693, 0.0877), (1.638, 0.1980), (3.087, 0.3473), (4.477, 0.4686), (5.802, 0.5647), (7.057, 0.6381), (8.237, 0.6908),
    (9.339, 0.7246), (10.358, 0.7412), (11.293, 0.7421), (12.141, 0.7286), (12.903, 0.7023), (13.583, 0.6649),
    (14.188, 0.6182), (14.728, 0.5643), (15.217, 0.5055), (15.676, 0.4442), (16.125, 0.3830), (16.590, 0.3245),
    (17.094, 0.2717), (17.657, 0.2272), (18.299, 0.1940), (19.028, 0.1750), (19.852, 0.1729), (20.771, 0.1905),
    (21.780, 0.2303), (22.875, 0.2950), (24.049, 0.3871), (24.663, 0.4443), (25.293, 0.5093), (25.940, 0.5826),
    (26.601, 0.6644), (27.276, 0.7551), (27.964, 0.8549), (28.663, 0.9643), (29.374, 1.0835),
])  # fmt: skip

"""Sizes of arrays that compiled kernels, theories and the layout share. A compiler knows them as it knows any constant."""

R, R_X, R_Y, FOURTH = range(4)
"""The vectors of a block of a plate: position, its two slopes, and the fourth vector of the theory."""
VECTORS, AXES = 4, 3
"""Vectors of a block, and components of each."""
BLOCK = VECTORS * AXES
"""Unknowns of a block."""
MATRIX = BLOCK * BLOCK
"""Entries of the matrix of two blocks."""
CORNERS = 4
FUNCTIONS = CORNERS * VECTORS
"""Local functions of an element, each with a local vector."""
LOCAL = FUNCTIONS * AXES
"""Rows of an element's matrix, component by component."""
SECOND, THIRD = FUNCTIONS, 2 * FUNCTIONS
"""Where the second and the third component begin there."""
POINTS = 16
"""Integration points of an element."""

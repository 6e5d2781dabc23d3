"""Tolerances, in four families: places, angles, rounding and convergence.

Each says what it is relative to, and why it is no smaller and no larger. Parameters of a method (shares, factors, steps of
differences, shifts of a matrix) are not tolerances; they stand with the method.
"""

import numpy as np

# Places, and times, which are places on their axis

ONE_PLACE = 1e-9
"""Of the extent in which places lie: two that are closer are one, and lengths that differ less are equal. Sums of some
thousand lengths round by less, and no element is that small."""
SAME_UNIT = 1e-12
"""Of the size of a unit: two that differ by less are one."""
SAME_POINT = 1e-8
"""Of the extent of the mesh: a point that was given, or found by the inverse of a map, is at a node that is closer."""
ABOUT_A_PLACE = 1e-6
"""Of an element: elements that meet at a place are looked for this far from it; a place closer to an edge is on the edge."""
SEVEN_DIGITS = 1e-6
"""Of the extent, a side or a cell: coordinates that were written with seven digits are one if they are closer, unless
elements are that small."""
SINGLE_PRECISION = 2.0**-22
"""Of a coordinate: twice what single precision may be off, for what was also computed in it."""
MOVED_OF_EDGE = 1e-2
"""Of the shortest edge: no node is taken for one on a bound that is farther, however small elements are."""
APART_OF_EDGE = 1e-3
"""Of the shortest edge: nodes that are farther apart are two, however small elements are."""
ROUNDED_PLACE = 1e-12
"""Of what a place lies in (an element, the range of a parameter, the thickness): what rounding alone moves it."""
NO_AREA = 1e-12
"""Of the square of the longest side: less is no area. Rounding leaves 1e-16, derivatives by differences 1e-12; an aspect
ratio of 1e6 has 1e-6."""
LOST_AREA = 1e-6
"""Of the undeformed area: a smaller deformed one counts as zero."""
ONE_TIME = 1e-9
"""Of a span of time: a time this near to its end is in it, and one this near to another is the same. Sums of time steps
round by less."""
ROUNDED_TIME = 1e-12
"""Of a run: no step is that short, and what is left of it before its end is rounding."""
EQUIDISTANT = 1e-6
"""Of the mean interval: times are equidistant where no interval differs by more, as those of a file of seven digits."""

# Angles: sines, cosines of right angles, products of unit vectors

PARALLEL = 1e-9
"""Directions that were computed to rounding: with a smaller sine they are one, with a smaller cosine at right angles.
Derivatives by differences have errors of 1e-12."""
ONE_DIRECTION = 1e-6
"""The same of directions that were given in decimals, or are derivatives by differences: errors of 1e-9 on short waves."""
ONE_LINE = 1e-8
"""The same of edges of a mesh in the parameter plane, in extents: differences of coordinates, which have fewer digits."""
PARALLEL_LINES = 1e-12
"""The same of two lines before they are cut: where they cut is checked by itself."""
VANISHED = 1e-9
"""Of the largest vector or area of its kind: a smaller one has no direction, as a slope at a pole, and a normal where two
slopes are parallel."""
ORTHONORMAL = 1e-10
"""Of a product of two unit vectors of a frame that is a product of a few; a shear or a stretch is many orders larger."""
ROUNDED_PROJECTION = 1e-12
"""Of a projection on directions, which has ones and zeros: parts that are smaller are rounding."""
FULL_TURN = 1e-12
"""Of 2 pi: a full turn that was given in decimals, or added up from parts."""
HALF_TURN = 1e-7
"""Sine of a rotation's angle: below it the rotation is small, or half a turn, whose axis is told by its symmetric part."""

# Rounding

EPS = np.finfo(float).eps
"""From one to the next number, 2.2e-16."""
TINY = np.finfo(float).tiny
"""The smallest number with all its digits, 2.2e-308."""
ABOVE_ZERO = 1e-300
"""Stands for a divisor that is zero, in any unit."""
ROUNDED_ROW = EPS / 4
"""Of the sum of the sizes of its terms: the product of a row of a matrix. It is what rounding is in the mean."""
ROUNDED_POSITION = 2e-16
"""Of the size of the body: what a position is known to."""
ROUNDED_COORDINATE = 1e-15
"""Of a nodal coordinate that an iteration found; its square times the stiffness is energy below which nothing is known."""
HELD_FORCE = 1e-15
"""Of the square of a force: what supports leave of one that they hold as a whole."""
ROUNDED_SUM = 1e-14
"""Of the sum of the sizes of its terms, or of the largest entry: a sum of up to a hundred."""
ROUNDED_VALUE = 1e-13
"""Of the largest value: values of a function, a law or a metric that differ less are one, and smaller ones are zero."""
ROUNDED_PRODUCT = 1e-12
"""Of the sum of the sizes of its terms, or of the largest eigenvalue: products with the matrix of a system, and what solves
and derivatives of second order leave."""
SAME_VALUE = 1e-9
"""Of their size: two values that are equal in exact arithmetic, but were computed in different ways, as at elements that are
mirror images. A smaller difference does not count."""
SAME_DERIVATIVE = 1e-5
"""Of its size: a derivative and a central difference, of whose steps the best counts, that differ by more are two things."""
SYMMETRIC = 1e-10
"""Of the largest entry of a law that was given in decimals: what is skew in it."""
ROUNDED_FORCE = 1e-10
"""Of the largest component: forces of a term of one's own, whose own inner sums are not known."""
DIFFERENCED = 1.5e-6
"""Of positions over the extent, and of slopes: the noise of values that are differences themselves, or rounded."""
CLOSE_JETS = 1e-6
"""Of the size of a jet: over a smaller change the energy changes by the work of the force in the middle, to rounding."""
ONE_COUNT = 1e-7
"""Cells: counts that are closer are one. It is the rounding of an integral, not a difference of the problem."""
CANCELLED = 1e-6
"""Of the largest that a product can be, by the energies of both: a smaller one is zero, and no error is relative to it."""
DEPENDENT = 1e-10
"""Of the largest eigenvalue or singular value: directions of smaller ones depend on the others."""
OPEN_FIT = 1e-11
"""Of the largest eigenvalue of a fit: below it no value and no slope tells that part of the polynomial."""
SINGULAR_FIT = 1e-8
"""Of the largest eigenvalue of a fit without slopes: a smaller one is of a polynomial that vanishes at all its places."""
CONDITION_HELD = 1e-10
"""Of the gradient of a row of a condition: where supports leave less of it free, they hold the row."""
SOFTEST_OF_BLOCK = 1e-10
"""Of the largest absolute eigenvalue of a 3 x 3 block of a matrix: a smaller one is rounding, and no stiffness."""
SINGULAR_MATRIX = 16 * EPS
"""A x is a sum of block * neighbours products. When it is no larger than this share of |A| |x|, the matrix cannot be told
from a singular one: the sum is the rounding of its terms, and of the sums from which the entries came."""
REGULAR_MATRIX = 1e-10
"""A matrix that amplifies a random load no more than one over this needs no second look."""
RIGID = 1e-24
"""Of the energy of the way of each coordinate by itself: a motion whose strain energy is smaller is rigid. Strains have the
rounding :data:`ROUNDED_PRODUCT`, which is squared in it."""
RIGID_PRODUCT = 1e-13
"""The same of an energy that is a product of the stiffness and a change, not made of strains."""
ZERO_EIGENVALUE = 1e4 * EPS
"""Of the sum of the sizes of the terms whose sum it is: a smaller eigenvalue is zero. Rigid motions of free plates, L/h from
10 to 10^4, have up to 1500 EPS, their softest elastic one a million and more."""
NO_SERIES = 64 * EPS
"""Of the largest value of a series of samples: what a fitted trend leaves of a series that is the trend."""

# Convergence

AT_REST = 1e-6
"""Of what the loads move: what other forces may move a structure that counts as one at rest without loads."""
ROOT = 1e-14
"""Of the size of what is sought: the last correction of an inner iteration for one place or length."""
LAST_STEP = 1e-6
"""Of what is sought: after a step of Newton's method that is smaller, what is left is 1e-12, and its square is
nothing."""
ROOT_OF_COUNTS = 1e-13
"""Of the logarithm of an element length."""
ROOT_OF_GROWTH, ROOT_OF_GROWTH_RTOL = 1e-16, 1e-15
"""Of the logarithm of the growth from element to element, which hundreds of elements amplify; and relative to it."""
REFINED = 1e-14
"""Of an answer: where products have more digits than entries, refinement of a solve goes on until the correction after the
last, by the ratio of the last two, is this small."""
LEFT_BY_REFINEMENT = 1e-6
"""Of an answer: what is left when corrections no longer shrink, and is said if it is more."""
GMRES_RTOL = 1e-9
"""Of the solution without the skew part of a matrix: what is left when the one with it is found."""
NO_CHANGE = 1e-6
"""Of a strain between two states, relative to the strains: what is of third order in it is rounding of the energy."""
PASSED = 1e-12
"""Of the answer of a linear solve with conditions, and of its multipliers: the last pass. Each gains a thousandfold."""
SAMPLED_EXACTLY = 1e-11
"""Of the largest value of a function: differences of a table of it that are rounding, as those of a surface must be, which
count against displacements."""
SAMPLED, SAMPLED_AT_MOST = 1e-6, 1e-3
"""The same of other functions: differences that a table should have, and those that it may have."""
ROUNDED_LEAST_SQUARES = 1e-14
"""Of matrix and right-hand side: where an iteration for least squares ends."""
CONTRADICTION = 1e-6
"""Of what conditions ask for: what least squares leave where they contradict each other."""
NEWTON_EXACT = 1e-9
"""Newton's method in rules for time steps that are to keep energy to its last digits; in the energy norm, relative."""
NEWTON_DAMPED = 1e-6
"""Newton's method in a rule that keeps momenta, but takes energy out; in the energy norm, relative."""
STALLED_ENERGY = 1e-20
"""Of the energy of the motion: that of corrections which no longer shrink, below which they are rounding."""
SHARPEST = 1e-7
"""Smallest tolerance of an equilibrium, in the energy norm, that an analysis asks for by itself, and that is checked."""
CONDITION_MET = 1e-9
"""Of the scale of a row of a condition, as the extent of the body: where Newton's method may end, and how far it may be from
zero in the undeformed state. Rounding of positions leaves 1e-15, one more correction the square of this."""
BALANCED = 1e-6
"""Of what drives the body: the largest sum of forces or moments that is left over."""
KNOWN_START = 1e-6
"""Of the displacement at a start, which is an equilibrium: smaller vibrations about it are not followed."""
SEPARATION = 1e-6
"""Two eigenvalues that differ less, relatively, are not told apart when they are counted."""
ORTHOGONAL_SHAPES = 1e-6
"""Of products of two converged shapes of unit size."""
ALIKE = 1e-6
"""Of the largest component of a converged motion: those that are equal by symmetry differ by less."""
ZERO_IN_BRACKET = 1e-9
"""Of the eigenvalue at the other end of a bracket: one that is smaller is zero."""

"""Compiled products of laws and strains, whichever the strains are."""

from skancf.compiled import OPTIONS, compiled
from skancf.kernels.constants import POINTS


@compiled(**OPTIONS)
def add_law(start, stop, order, law, of_element, pairs, change, out):
    """Adds what the law of each element, one of (n_laws, n_pairs, 16), makes of a change of strains, (n_elements, n, 16).

    ``pairs`` (n_pairs, 2) are the entries k <= l that the law has.
    """
    for index in range(start, stop):
        e = order[index]
        own = law[of_element[e]]
        for m in range(pairs.shape[0]):
            k, l = pairs[m]
            for p in range(POINTS):
                out[e, k, p] += own[m, p] * change[e, l, p]
            if k != l:
                for p in range(POINTS):
                    out[e, l, p] += own[m, p] * change[e, k, p]

"""Compiled internal force of theory `full`, several elements at a time.

The arithmetic is that of :mod:`skancf.theories.full.kernels`, one integration point after the other; arrays have the
elements of a batch last, and inner loops run over them, which keeps the vector units busy.
"""

import numpy as np

from skancf.compiled import INNER, OPTIONS, compiled
from skancf.kernels.constants import AXES, CORNERS, FUNCTIONS, POINTS
from skancf.theories.full.kernels import N_SAMPLED
from skancf.theories.full.nodes import N_POSITION
from skancf.theories.full.theory import N_IN_PLANE, N_STRAINS

LANES = 32
INLINED = {**INNER, "inline": "always"}
"""Compiled as one function, which takes a quarter less time than one by one."""


@compiled(**INLINED)
def gather_batch(base, stop, order, q, maps, elements, local, classes):
    """Local vectors (16, 3, lanes) of the elements order[base:stop]; returns whether all are of one class."""
    lanes = local.shape[2]
    local[:] = 0.0
    for lane in range(min(lanes, stop - base)):
        e = order[base + lane]
        classes[lane] = elements.shape[e]
        for k in range(maps.pointer[e], maps.pointer[e + 1]):
            a, v = maps.rows[k], maps.values[k]
            n, kind = maps.nodes[e, maps.corners[k]], maps.kinds[k]
            for i in range(3):
                local[a, i, lane] += v * q[n, kind, i]
    same = True
    for lane in range(lanes):
        if base + lane >= stop:
            classes[lane] = classes[0]
        same = same and classes[lane] == classes[0]
    return same


@compiled(**INLINED)
def scatter_batch(base, stop, order, force, maps, out):
    """Adds the forces on the local vectors (16, 3, lanes) to out (n_nodes, 4, 3)."""
    for lane in range(min(force.shape[2], stop - base)):
        e = order[base + lane]
        for k in range(maps.pointer[e], maps.pointer[e + 1]):
            a, v = maps.rows[k], maps.values[k]
            n, kind = maps.nodes[e, maps.corners[k]], maps.kinds[k]
            for i in range(3):
                out[n, kind, i] += v * force[a, i, lane]


@compiled(**INLINED)
def point_jets(tables, p, local, x):
    """r_1, r_2, d_1, d_2 at integration point p: x (4, 3, lanes)."""
    lanes = x.shape[2]
    x[:] = 0.0
    for a in range(N_POSITION):
        t1, t2 = tables.position[a, 0, p], tables.position[a, 1, p]
        for i in range(3):
            for l in range(lanes):
                x[0, i, l] += t1 * local[a, i, l]
                x[1, i, l] += t2 * local[a, i, l]
    for a in range(CORNERS):
        t1, t2 = tables.director[a, 0, p], tables.director[a, 1, p]
        for i in range(3):
            for l in range(lanes):
                x[2, i, l] += t1 * local[N_POSITION + a, i, l]
                x[3, i, l] += t2 * local[N_POSITION + a, i, l]


@compiled(**INLINED)
def sample_jets_batch(tables, local, x):
    """r_1, r_2, d_1, d_2, d at the sampling points: x (n_samples, 5, 3, lanes)."""
    lanes = x.shape[3]
    x[:] = 0.0
    for s in range(x.shape[0]):
        for a in range(N_POSITION):
            t1, t2 = tables.sample_position[0, s, a], tables.sample_position[1, s, a]
            if t1 != 0.0 or t2 != 0.0:
                for i in range(3):
                    for l in range(lanes):
                        x[s, 0, i, l] += t1 * local[a, i, l]
                        x[s, 1, i, l] += t2 * local[a, i, l]
        for a in range(CORNERS):
            t1, t2, t = tables.sample_director[0, s, a], tables.sample_director[1, s, a], tables.sample_director[2, s, a]
            for i in range(3):
                for l in range(lanes):
                    x[s, 2, i, l] += t1 * local[N_POSITION + a, i, l]
                    x[s, 3, i, l] += t2 * local[N_POSITION + a, i, l]
                    x[s, 4, i, l] += t * local[N_POSITION + a, i, l]


@compiled(**INLINED)
def sampled_strains(tables, x, out):
    """Shear and thickness strains at their sampling points: out (n_rows, lanes)."""
    lanes = out.shape[1]
    for r in range(out.shape[0]):
        k, s = tables.sample_rows[r]
        factor = 0.5 if k == 4 else 1.0
        for l in range(lanes):
            out[r, l] = factor * (
                x[s, k, 0, l] * x[s, 4, 0, l] + x[s, k, 1, l] * x[s, 4, 1, l] + x[s, k, 2, l] * x[s, 4, 2, l]
            )


@compiled(**INLINED)
def point_strains(tables, p, x, sampled, eps):
    """The 14 strains at integration point p before the undeformed ones are subtracted: eps (14, lanes)."""
    lanes = eps.shape[1]
    for l in range(lanes):
        a0, a1, a2, b0, b1, b2 = x[0, 0, l], x[0, 1, l], x[0, 2, l], x[1, 0, l], x[1, 1, l], x[1, 2, l]
        c0, c1, c2, d0, d1, d2 = x[2, 0, l], x[2, 1, l], x[2, 2, l], x[3, 0, l], x[3, 1, l], x[3, 2, l]
        eps[0, l] = 0.5 * (a0 * a0 + a1 * a1 + a2 * a2)
        eps[1, l] = 0.5 * (b0 * b0 + b1 * b1 + b2 * b2)
        eps[2, l] = a0 * b0 + a1 * b1 + a2 * b2
        eps[3, l] = a0 * c0 + a1 * c1 + a2 * c2
        eps[4, l] = b0 * d0 + b1 * d1 + b2 * d2
        eps[5, l] = a0 * d0 + a1 * d1 + a2 * d2 + b0 * c0 + b1 * c1 + b2 * c2
        eps[6, l] = 0.5 * (c0 * c0 + c1 * c1 + c2 * c2)
        eps[7, l] = 0.5 * (d0 * d0 + d1 * d1 + d2 * d2)
        eps[8, l] = c0 * d0 + c1 * d1 + c2 * d2
    for k in range(N_IN_PLANE, N_STRAINS):
        for l in range(lanes):
            eps[k, l] = 0.0
    for r in range(sampled.shape[0]):
        k, s = tables.sample_rows[r]
        weight = tables.interpolation[k, s, p]
        if weight != 0.0:
            for l in range(lanes):
                eps[N_IN_PLANE + k, l] += weight * sampled[r, l]


@compiled(**INLINED)
def point_stresses(tables, p, eps, elements, classes, same, stress):
    """Stress (14, lanes) with the weights at integration point p; subtracts the undeformed strains from eps."""
    lanes = eps.shape[1]
    stress[:] = 0.0
    if same:
        c = classes[0]
        for k in range(N_STRAINS):
            undeformed = elements.reference[c, k, p]
            for l in range(lanes):
                eps[k, l] -= undeformed
        for m in range(tables.pairs.shape[0]):
            k, j, d = tables.pairs[m, 0], tables.pairs[m, 1], elements.law[c, m, p]
            for l in range(lanes):
                stress[k, l] += d * eps[j, l]
            if k != j:
                for l in range(lanes):
                    stress[j, l] += d * eps[k, l]
        return
    for k in range(N_STRAINS):
        for l in range(lanes):
            eps[k, l] -= elements.reference[classes[l], k, p]
    for m in range(tables.pairs.shape[0]):
        k, j = tables.pairs[m]
        for l in range(lanes):
            stress[k, l] += elements.law[classes[l], m, p] * eps[j, l]
        if k != j:
            for l in range(lanes):
                stress[j, l] += elements.law[classes[l], m, p] * eps[k, l]


@compiled(**INLINED)
def point_forces(tables, p, x, stress, sampled, f, force):
    """Adds the force of point p to force (16, 3, lanes), and its shear and thickness stresses to sampled (n_rows, lanes)."""
    lanes = stress.shape[1]
    for i in range(3):
        for l in range(lanes):
            a, b, c, d = x[0, i, l], x[1, i, l], x[2, i, l], x[3, i, l]
            f[0, i, l] = stress[0, l] * a + stress[2, l] * b + stress[3, l] * c + stress[5, l] * d
            f[1, i, l] = stress[2, l] * a + stress[1, l] * b + stress[5, l] * c + stress[4, l] * d
            f[2, i, l] = stress[3, l] * a + stress[5, l] * b + stress[6, l] * c + stress[8, l] * d
            f[3, i, l] = stress[5, l] * a + stress[4, l] * b + stress[8, l] * c + stress[7, l] * d
    for a in range(N_POSITION):
        t1, t2 = tables.position[a, 0, p], tables.position[a, 1, p]
        for i in range(3):
            for l in range(lanes):
                force[a, i, l] += t1 * f[0, i, l] + t2 * f[1, i, l]
    for a in range(CORNERS):
        t1, t2 = tables.director[a, 0, p], tables.director[a, 1, p]
        for i in range(3):
            for l in range(lanes):
                force[N_POSITION + a, i, l] += t1 * f[2, i, l] + t2 * f[3, i, l]
    for r in range(sampled.shape[0]):
        k, s = tables.sample_rows[r]
        weight = tables.interpolation[k, s, p]
        if weight != 0.0:
            for l in range(lanes):
                sampled[r, l] += weight * stress[N_IN_PLANE + k, l]


@compiled(**INLINED)
def sample_forces(tables, x, sampled, f, force):
    """Adds the forces of the sampled stresses (n_rows, lanes) to force (16, 3, lanes)."""
    lanes = sampled.shape[1]
    f[:] = 0.0
    for r in range(sampled.shape[0]):
        k, s = tables.sample_rows[r]
        for i in range(3):
            for l in range(lanes):
                f[s, 4, i, l] += sampled[r, l] * x[s, k, i, l]
            if k < N_SAMPLED - 1:
                for l in range(lanes):
                    f[s, k, i, l] += sampled[r, l] * x[s, 4, i, l]
    for s in range(x.shape[0]):
        for a in range(N_POSITION):
            t1, t2 = tables.sample_position[0, s, a], tables.sample_position[1, s, a]
            if t1 != 0.0 or t2 != 0.0:
                for i in range(3):
                    for l in range(lanes):
                        force[a, i, l] += t1 * f[s, 0, i, l] + t2 * f[s, 1, i, l]
        for a in range(CORNERS):
            t1, t2, t = tables.sample_director[0, s, a], tables.sample_director[1, s, a], tables.sample_director[2, s, a]
            if t1 != 0.0 or t2 != 0.0 or t != 0.0:
                for i in range(3):
                    for l in range(lanes):
                        force[N_POSITION + a, i, l] += t1 * f[s, 2, i, l] + t2 * f[s, 3, i, l] + t * f[s, 4, i, l]


@compiled(**OPTIONS)
def residual(start, stop, order, q, tables, maps, elements, out):
    """Internal force of the elements order[start:stop], added to out (n_nodes, 4, 3)."""
    n_samples, n_rows = tables.sample_position.shape[1], tables.sample_rows.shape[0]
    classes = np.zeros(LANES, dtype=np.int64)
    local, force = np.empty((FUNCTIONS, AXES, LANES)), np.empty((FUNCTIONS, AXES, LANES))
    x, f = np.empty((4, 3, LANES)), np.empty((4, 3, LANES))
    sx, sf = np.empty((n_samples, 5, 3, LANES)), np.empty((n_samples, 5, 3, LANES))
    sampled, collected = np.empty((n_rows, LANES)), np.empty((n_rows, LANES))
    eps, stress = np.empty((N_STRAINS, LANES)), np.empty((N_STRAINS, LANES))
    for base in range(start, stop, LANES):
        same = gather_batch(base, stop, order, q, maps, elements, local, classes)
        sample_jets_batch(tables, local, sx)
        sampled_strains(tables, sx, sampled)
        force[:] = 0.0
        collected[:] = 0.0
        for p in range(POINTS):
            point_jets(tables, p, local, x)
            point_strains(tables, p, x, sampled, eps)
            point_stresses(tables, p, eps, elements, classes, same, stress)
            point_forces(tables, p, x, stress, collected, f, force)
        sample_forces(tables, sx, collected, sf, force)
        scatter_batch(base, stop, order, force, maps, out)


@compiled(**OPTIONS)
def force_of(start, stop, order, q, stresses, tables, maps, elements, out):
    """Force of given stresses (n_elements, 14, 16), which have the weights, added to out (n_nodes, 4, 3)."""
    n_samples, n_rows = tables.sample_position.shape[1], tables.sample_rows.shape[0]
    classes = np.zeros(LANES, dtype=np.int64)
    local, force = np.empty((FUNCTIONS, AXES, LANES)), np.empty((FUNCTIONS, AXES, LANES))
    x, f = np.empty((4, 3, LANES)), np.empty((4, 3, LANES))
    sx, sf = np.empty((n_samples, 5, 3, LANES)), np.empty((n_samples, 5, 3, LANES))
    collected, stress = np.empty((n_rows, LANES)), np.zeros((N_STRAINS, LANES))
    for base in range(start, stop, LANES):
        gather_batch(base, stop, order, q, maps, elements, local, classes)
        sample_jets_batch(tables, local, sx)
        force[:] = 0.0
        collected[:] = 0.0
        for p in range(POINTS):
            point_jets(tables, p, local, x)
            for lane in range(min(LANES, stop - base)):
                for k in range(N_STRAINS):
                    stress[k, lane] = stresses[order[base + lane], k, p]
            point_forces(tables, p, x, stress, collected, f, force)
        sample_forces(tables, sx, collected, sf, force)
        scatter_batch(base, stop, order, force, maps, out)

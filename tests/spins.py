"""Bodies in relative equilibrium, for several test files."""

import numpy as np

import skancf as sk


def centre(system):
    """The centre of mass."""
    one = np.zeros((system.n_dofs // 12, 4, 3))
    one[:, 0] = 1
    weights = (system.mass @ one.ravel()).reshape(-1, 3)
    return (weights * system.undeformed.reshape(-1, 3)).sum(axis=0) / (weights * one.reshape(-1, 3)).sum(axis=0)


def spinning(system, spin):
    """The state with f_int(q) = omega^2 M_perp (q - c), by Newton's method without turns about and moves along the axis."""
    spin = np.asarray(spin, float)
    square = spin @ spin
    across = np.eye(3) - np.outer(spin, spin) / square
    pull = square * system.mass.to_scipy() @ np.kron(np.eye(system.n_dofs // 3), across)
    middle = np.zeros((system.n_dofs // 12, 4, 3))
    middle[:, 0] = centre(system)
    q, middle = system.undeformed, middle.ravel()
    for _ in range(20):
        residual = system.internal_force(q) - pull @ (q - middle)
        idle = [sk.RigidVelocity(spin=tuple(spin)).at(q - middle), sk.RigidVelocity(tuple(spin)).at(q)]
        held = sum(np.outer(v, v) for v in idle)
        tangent = system.tangent(q).to_scipy() - pull + held
        # At a pole r_xy has neither stiffness nor mass, and is held.
        change = np.linalg.solve(tangent + np.diag(system.constraints.fixed.ravel().astype(float)), -residual)
        q = q + change
        if np.abs(change).max() < 1e-11:
            return sk.Solution(system, q, np.cross(spin, (q - middle).reshape(-1, 3)).ravel(), 0.0)
    raise AssertionError("no relative equilibrium found")

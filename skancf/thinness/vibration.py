r"""What shear and the rotary inertia of the normal do to eigenvalues of the thin theory.

With the energy E of a shape :math:`\phi` without the stresses of the state, the compliance of shear is in series with that
of bending: E falls to :math:`E / (1 + F(\phi, \phi) / E)`. The mass grows by the rotary inertia of the normals.
"""

from typing import Any

import numpy as np

from skancf.conditions.solver import solver_at
from skancf.errors import InputError, SingularMatrix
from skancf.linear import DirectSolver, factor_shifted, soft_motions
from skancf.system.rigid import free_rigid_motions
from skancf.system.system import System
from skancf.thinness.form import ShearForm
from skancf.thinness.moments import moment_rates


def product_of(form: ShearForm, q: np.ndarray, shape: np.ndarray) -> float:
    """F of a small motion (n_dofs,) about a state q with itself."""
    fields = form.fields(moment_rates(form.system, q, shape))
    return form.product(fields, fields)


def rotary_inertia(system: System, q: np.ndarray, shape: np.ndarray) -> float:
    r""":math:`\int \rho z^2 dz \int |\delta n|^2 dA`, which a small motion adds to :math:`\phi \cdot M \phi`."""
    geometry, inertia = system.geometry, system.assembly.section.at(system.geometry.integration.local).second_moment
    local, rates = (geometry.local(system.shell.nodal(v)) for v in (q, shape))
    turned = geometry.integration.gathered(
        lambda points, e: geometry.theory.normal_rates(local[e], rates[e], points, geometry.side[e])
    )
    each = (turned**2).sum(axis=1) * system.assembly.areas
    return inertia * float(each.sum()) if isinstance(inertia, float) else float((inertia * each).sum())


def with_shear(value: float, energy: float, product: float, rotary: float = 0.0) -> float:
    r"""An eigenvalue :math:`\lambda = \omega^2` of a shape of unit modal mass with shear, from E and F, and with the rotary
    inertia."""
    return (value - product / (1 + product / energy)) / (1 + rotary)


def first_share(system: System) -> float:
    """By which part shear and rotary inertia change the energy of the first vibration that is no rigid motion.

    Raises
    ------
    InputError
        Where some motion has neither stiffness nor mass.
    """
    stiffness: Any = system.stiffness()
    rigid = len(free_rigid_motions(system))
    with DirectSolver(system.pattern, system.constraints) as solver:
        try:
            held = solver_at(system, solver, system.undeformed)
            factor_shifted(held, stiffness, system.mass)
        except SingularMatrix as none:
            raise InputError(f"theory = 'auto' judges by the first vibration, which does not exist ({none}); name the "
                             "theory, 'kirchhoff' or 'full'") from none  # fmt: skip
        values, shapes = soft_motions(system, held, stiffness, rigid + SPARE, ITERATIONS)
    first = np.argsort(values)[min(rigid, len(values) - 1)]
    value, shape, start = float(values[first]), shapes[first], system.undeformed
    product = product_of(ShearForm(system), start, shape)
    return (1 + product / value) * (1 + rotary_inertia(system, start, shape)) - 1


SPARE, ITERATIONS = 3, 10
"""Motions besides the rigid ones, and inverse iterations, for the first of them."""

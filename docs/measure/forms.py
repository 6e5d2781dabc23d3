"""What terms from forms cost: the table of decision 0023.

From the folder of the repository, in half a minute on one core:

    SKANCF_THREADS=1 .venv/bin/python docs/measure/forms.py

It writes docs/decisions/forms.csv. Times are the best of a few, in microseconds of processor time per element.
"""

import os
import time
from collections.abc import Callable
from typing import Any

os.environ.setdefault("SKANCF_THREADS", "1")

import numpy as np
import skfem
import tables
from skfem.helpers import dot, grad

import skancf as sk

CELLS = 20
SURFACE = sk.CylinderSector(1.0, 1.5, 1.0)
CASE = sk.Case()


def change_of_normal(u: Any, w: Any) -> np.ndarray:
    """J n changes by it along u, times J: cross products of slopes."""
    u_x, u_y = grad(u)[:, 0], grad(u)[:, 1]
    return (np.cross(u_x, w.r_y, axis=0) + np.cross(w.r_x, u_y, axis=0)) / w.dA


FORMS = {
    "foundation": (
        lambda w: 1.5 * w.u[2] ** 2,
        lambda v, w: 3.0 * w.u[2] * v[2],
        lambda u, v, w: 3.0 * u[2] * v[2],
    ),
    "pressure": (
        lambda w: dot(w.r, w.n) * w.J / 3,
        lambda v, w: dot(w.n, v) * w.J,
        lambda u, v, w: dot(change_of_normal(u, w), v),
    ),
    "bending": (lambda w: 2.0 * w.H**2 * w.J, None, None),
}


def microseconds(call: Callable[[], Any]) -> float:
    call()
    spent = []
    for _ in range(4):
        start = time.process_time()
        call()
        spent.append(time.process_time() - start)
    return 1e6 * min(spent) / CELLS**2


def of_term(system: Any, term: sk.FormTerm) -> list[str]:
    bound, q = term.on(system.shell, system.layout), 1.01 * system.undeformed
    times = (microseconds(lambda: bound.force(q, None, CASE)),
             microseconds(lambda: bound.add_tangent(q, None, CASE, system.blocks())))  # fmt: skip
    return [f"{each:.0f}" for each in times]


def by_scikit_fem(system: Any) -> list[str]:
    """A foundation on the basis, for each pair of its 48 functions, and the way back."""
    basis, T = system.basis(), system.to_mesh
    area = basis.interpolate(T @ system.undeformed)
    force = skfem.LinearForm(lambda v, w: 3.0 * w["u"][2] * v[2])
    tangent = skfem.BilinearForm(lambda u, v, w: 3.0 * u[2] * v[2])
    calls = (lambda: T.T @ force.assemble(basis, u=area), lambda: T.T @ tangent.assemble(basis) @ T)
    return [f"{microseconds(call):.0f}" for call in calls]


def main() -> None:
    plate = sk.Problem(SURFACE, 0.05, sk.Isotropic(1e6, 0.3, 1000.0))
    system = plate.on(sk.meshes.uniform(SURFACE, CELLS, CELLS), "kirchhoff")
    rows = []
    for name, (energy, residual, tangent) in FORMS.items():
        rows.append([name, "energy", *of_term(system, sk.FormTerm(energy=energy))])
        if residual:
            rows.append([name, "residual", *of_term(system, sk.FormTerm(residual=residual))])
            rows.append([name, "residual and tangent", *of_term(system, sk.FormTerm(residual=residual, tangent=tangent))])
    rows.append(["foundation", "scikit-fem's loops", *by_scikit_fem(system)])
    q = 1.01 * system.undeformed
    stresses = system.stresses(q)
    rows.append(["the plate itself", "compiled", f"{microseconds(lambda: system.shell.internal_force(q)):.1f}",
                 f"{microseconds(lambda: system.tangent(q, stresses=stresses)):.1f}"])  # fmt: skip
    tables.write("forms.csv", "term; given as; force (us); tangent (us)", rows)


if __name__ == "__main__":
    main()

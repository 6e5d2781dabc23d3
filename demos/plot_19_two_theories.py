r"""
The two theories, as they are written
=====================================

.. image:: /pictures/gallery/19_two_theories.jpg
   :alt: A strip of plate that is lifted at its free end.
   :class: example-picture

The elements of skancf are compiled, and compiled code does not read as mechanics does. Here are the two theories a second
time, with nothing of those kernels: strain, law and virtual work as one would write them on paper, as `scikit-fem
<https://scikit-fem.readthedocs.io>`_ forms on the same elements. They find the same equilibrium, to ten digits.

What is needed for that is a basis on the system's mesh, and the matrix T from the system's unknowns q to the degrees of
freedom of that basis, where hanging nodes and seams are resolved:

.. math:: f(q) = T^T f_{forms}(T q), \qquad K(q) = T^T K_{forms}(T q) \, T .

The plate is clamped at its left edge and bent by a force along its right one until it turns by a large angle. Its mesh has
hanging nodes.

This example shows ``system.basis`` and ``system.to_mesh``, both theories as forms of scikit-fem. It builds on the
elastica.
"""

# %%
import argparse
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib.pyplot as plt
import numpy as np
from scipy.sparse.linalg import spsolve
from skfem import BilinearForm, LinearForm
from skfem.helpers import cross, ddot, dot, grad, mul, transpose

import skancf as sk
from skancf import output

# sphinx_gallery_thumbnail_path = "pictures/gallery/19_two_theories.jpg"

THICKNESS = 0.05
LAW = sk.Isotropic(young=2e6, poisson=0.3, density=1000.0)
LOAD = (0.0, 0.0, 20.0)
PLATE = sk.Problem(
    surface=sk.Rectangle(1.0, 0.5),
    thickness=THICKNESS,
    material=LAW,
    supports=[sk.Clamp("left")],
    loads=[sk.EdgeLoad("right", LOAD)],
)

# %%
# The law
# -------
# Young's modulus E and Poisson's ratio of plane stress, as a fourth-order tensor. In the plane it is the same in both
# theories; that of the solid also has the stiffness across and the transverse shear, with its correction.
PAIRS = {(0, 0): 0, (1, 1): 1, (2, 2): 2, (1, 2): 3, (0, 2): 4, (0, 1): 5}
VOIGT = [[PAIRS[min(i, j), max(i, j)] for j in range(3)] for i in range(3)]
SOLID = LAW.stiffness()[VOIGT][:, :, VOIGT]
PLANE = SOLID[:2, :2, :2, :2]
MEMBRANE, BENDING = THICKNESS * PLANE, THICKNESS**3 / 12 * PLANE


def stress(C: np.ndarray, strain: np.ndarray) -> np.ndarray:
    """C : E."""
    return np.einsum("ijkl,kl...->ij...", C, strain)


def sym(a: np.ndarray) -> np.ndarray:
    """The symmetric part."""
    return (a + transpose(a)) / 2


# %%
# Theory `full`
# -------------
# A solid of the positions :math:`\mathbf r + z \mathbf d`, on ``ElementQuadANCF``. With the deformation gradient F,
#
# .. math:: E = \tfrac12 (F^T F - 1), \quad S = C : E, \quad \delta W = \int S : \delta E \, dV, \quad
#     \delta E = \operatorname{sym}(F^T \nabla \delta r)


def green(F: np.ndarray) -> np.ndarray:
    """Green-Lagrange strain; that of a surface if F has two columns."""
    return (mul(transpose(F), F) - np.eye(F.shape[1])[:, :, None, None]) / 2


def solid(r: np.ndarray) -> dict[str, np.ndarray]:
    """What a state of the solid is."""
    return {"F": grad(r), "S": stress(SOLID, green(grad(r)))}


@LinearForm
def full_force(v, w):
    return ddot(w["S"], sym(mul(transpose(w["F"]), grad(v))))


@BilinearForm
def full_tangent(u, v, w):
    dE, DE = (sym(mul(transpose(w["F"]), grad(each))) for each in (v, u))
    dDE = sym(mul(transpose(grad(u)), grad(v)))
    return ddot(stress(SOLID, DE), dE) + ddot(w["S"], dDE)


# %%
# Theory `kirchhoff`
# ------------------
# A surface r on ``ElementQuadHermite``, which is C1. Its strains are those of the surface and its curvature, with the unit
# normal :math:`n = m / |m|, m = r_{,x} \times r_{,y}`,
#
# .. math:: \varepsilon = \tfrac12 (\nabla r^T \nabla r - 1), \quad \kappa = -n \cdot \nabla\nabla r, \quad
#     N = A : \varepsilon, \quad M = D : \kappa, \quad \delta W = \int N : \delta\varepsilon + M : \delta\kappa \, dA
#
# The normal turns by :math:`\delta n`, and by :math:`\delta\Delta n` to the second order:
#
# .. math::
#     \delta n &= (1 - n n^T) \, \delta m / |m|, \\
#     \delta\Delta n &= \bigl((1 - n n^T) \, \delta\Delta m - \Delta n \, (n \cdot \delta m) - \delta n \, (n \cdot \Delta m)
#         - n \, (\Delta n \cdot \delta m)\bigr) / |m| .


def surface(r: Any) -> dict[str, np.ndarray]:
    """What a state of the surface is."""
    m = cross(grad(r)[:, 0], grad(r)[:, 1])
    n = m / np.sqrt(dot(m, m))
    N, M = stress(MEMBRANE, green(grad(r))), stress(BENDING, -along(n, r.hess))
    return {"F": grad(r), "H": r.hess, "n": n, "size": np.sqrt(dot(m, m)), "N": N, "M": M}


def along(n: np.ndarray, hess: np.ndarray) -> np.ndarray:
    """n . second derivatives, (2, 2, ...)."""
    return np.einsum("i...,iab...->ab...", n, hess)


def across(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The first column of one times the second of the other, both ways: the change of m."""
    return cross(a[:, 0], b[:, 1]) + cross(b[:, 0], a[:, 1])


@LinearForm
def thin_force(v, w):
    n, dm = w["n"], across(w["F"], grad(v))
    dn = (dm - n * dot(n, dm)) / w["size"]
    return ddot(w["N"], sym(mul(transpose(w["F"]), grad(v)))) - ddot(w["M"], along(n, v.hess) + along(dn, w["H"]))


@BilinearForm
def thin_tangent(u, v, w):
    n, size, H = w["n"], w["size"], w["H"]
    dm, Dm, dDm = across(w["F"], grad(v)), across(w["F"], grad(u)), across(grad(u), grad(v))
    dn, Dn = ((m - n * dot(n, m)) / size for m in (dm, Dm))
    dDn = (dDm - n * dot(n, dDm) - Dn * dot(n, dm) - dn * dot(n, Dm) - n * dot(Dn, dm)) / size
    dE, DE = (sym(mul(transpose(w["F"]), grad(each))) for each in (v, u))
    dk, Dk = -along(n, v.hess) - along(dn, H), -along(n, u.hess) - along(Dn, H)
    dDE, dDk = sym(mul(transpose(grad(u)), grad(v))), -along(dn, u.hess) - along(Dn, v.hess) - along(dDn, H)
    return ddot(stress(MEMBRANE, DE), dE) + ddot(w["N"], dDE) + ddot(stress(BENDING, Dk), dk) + ddot(w["M"], dDk)


# %%
# Newton's method
# ---------------
# The load is a form too, on the right edge. The forms have no assumed strains, and the theories are asked for without.


class Theory(NamedTuple):
    """A theory of the library, and what it is made of here."""

    theory: Any
    state: Callable
    force: LinearForm
    tangent: BilinearForm
    thickness: float | None

    def at(self, system: sk.system.System, q: np.ndarray) -> tuple[np.ndarray, Callable]:
        """Force of the unknowns, and a function that makes their tangent."""
        T, basis = system.to_mesh, system.basis(thickness=self.thickness)
        fields = self.state(basis.interpolate(T @ q))
        return T.T @ self.force.assemble(basis, **fields), lambda: T.T @ self.tangent.assemble(basis, **fields) @ T


THEORIES = {
    "full": Theory(sk.Full(assumed=False), solid, full_force, full_tangent, THICKNESS),
    "kirchhoff": Theory(sk.Kirchhoff(assumed=False), surface, thin_force, thin_tangent, None),
}
LARGEST_STEP = 0.5
load = LinearForm(lambda v, w: LOAD[2] * v[2])


def equilibrium(system: sk.system.System, theory: Theory, say: Callable) -> np.ndarray:
    """Newton's method with forms alone; no vector of a node changes by more than a part of its size in one step."""
    T, free = system.to_mesh, ~system.constraints.fixed.ravel()
    applied, q = T.T @ load.assemble(system.basis(facets="right")), system.undeformed.copy()
    for step in range(40):
        force, tangent = theory.at(system, q)
        residual = (force - applied)[free]
        say(f"   step {step}: largest residual {np.abs(residual).max():.1e} N")
        if np.abs(residual).max() < 1e-9 * np.abs(applied).max():
            return q
        change = -spsolve(tangent()[free][:, free].tocsc(), residual)
        q[free] += change * min(1.0, LARGEST_STEP / np.abs(change).max())
    raise AssertionError("Newton's method did not converge")


# %%
# The run
# -------
# The numbers to hit: coordinates of the equilibrium, and entries of force and tangent there, are those of the library to
# ten digits of the largest.
EQUAL = 1e-10


def compare(name: str, mesh: Any, say: Callable) -> sk.Solution:
    """Solve by forms, and with the library's own solver; AssertionError where they differ."""
    theory = THEORIES[name]
    system = PLATE.on(mesh, theory.theory)
    say(f"theory '{name}', {system.n_dofs} unknowns, {system.to_mesh.shape[0]} degrees of freedom of the basis")
    q = equilibrium(system, theory, say)
    force, tangent = theory.at(system, q)
    pairs = {
        "coordinates": (q, sk.solve(system).unwrap().q),
        "force": (force, system.internal_force(q)),
        "tangent": (tangent().toarray(), system.tangent(q).to_scipy().toarray()),
    }
    for what, (mine, theirs) in pairs.items():
        difference = np.abs(mine - theirs).max() / np.abs(theirs).max()
        say(f"   {what}: {difference:.0e} from the library's")
        assert difference < EQUAL, (name, what, difference)
    return sk.Solution(system, q)


def main(size: str = "full", out: str = "out", say: Callable = print) -> dict[str, float]:
    """Both theories; returns how far the loaded edge rises."""
    folder = Path(out)
    output.check_folder(folder)
    shape = {"full": (6, 3), "small": (2, 1)}[size]
    mesh = sk.meshes.quadtree(sk.meshes.uniform(PLATE.surface, *shape)).refined([0])
    solutions = {name: compare(name, mesh, say) for name in THEORIES}
    _, axes = plt.subplots(figsize=(8, 3.4), layout="constrained")
    x = np.linspace(0, 1, 61)
    for (name, solution), style in zip(solutions.items(), ("-", "--"), strict=True):
        line = solution.position(np.column_stack([x, np.full_like(x, 0.25)]))
        axes.plot(line[:, 0], line[:, 2], style, lw=2, label=f"theory '{name}', by forms")
    axes.plot(x, 0 * x, color="0.6", lw=1, label="undeformed")
    axes.set(xlabel="x (m)", ylabel="z (m)", title="The middle line of the plate", aspect="equal")
    axes.legend(frameon=False)
    axes.figure.savefig(folder / "two_theories.png", dpi=120)
    rises = {name: float(solution.displacement((1.0, 0.25))[2]) for name, solution in solutions.items()}
    assert min(rises.values()) > 0.2, rises
    return rises


# %%
# The thick element bends a little less: without assumed strains it locks, on so coarse a mesh. The library's own default has
# them.

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="The two theories as forms of scikit-fem")
    parser.add_argument("--size", choices=["full", "small"], default=os.environ.get("SKANCF_DEMO_SIZE", "full"))
    parser.add_argument("--out", default=os.environ.get("SKANCF_DEMO_OUT", "out"))
    arguments, _ = parser.parse_known_args()
    main(arguments.size, arguments.out)

"""States in motion on finer and coarser meshes: what becomes of their energy by how positions are carried, and the time.

Writes docs/decisions/settled.csv, settled_runs.csv and settled_cost.csv. From the folder of the repository, in ten minutes:

    .venv/bin/python docs/measure/motion.py
"""

import time
import warnings
from collections.abc import Callable, Iterator
from math import pi
from typing import Any

import numpy as np
from tables import write

import skancf as sk
from skancf.adaptive.interpolation import Interpolation
from skancf.adaptive.remap import remap
from skancf.dynamics.state import State
from skancf.dynamics.step_solver import StepSolver
from skancf.linear import DirectSolver
from skancf.meshes import MeshQuadTree, quadtree, uniform
from skancf.system.system import System

ALUMINIUM = sk.Isotropic(70e9, 0.3, 2700.0)
PLATE = sk.Rectangle(1.0, 0.8)
TUBE = sk.CylinderSector(1.0, 1.0, 2 * pi, closed=True)
STRIP = sk.Rectangle(1.0, 0.5)
SPEED = 30.0


def struck(system: System, place: tuple[float, float], radius: float) -> np.ndarray:
    """The velocity that a blow leaves: normal, a Gauss function of the distance."""
    geometry = system.geometry
    X = geometry.undeformed
    centre = geometry.surface.position(*np.array(place)[:, None])[:, 0]
    way, normal = X[:, 0] - centre, np.cross(X[:, 1], X[:, 2])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    bell = SPEED * np.exp(-(way**2).sum(axis=1) / radius**2)
    slopes = [-2 * (way * X[:, k]).sum(axis=1) / radius**2 for k in (1, 2)]
    factors = [np.ones_like(bell), *slopes, slopes[0] * slopes[1] * (not geometry.theory.directors)]
    v = np.stack([(factor * bell)[:, None] * normal for factor in factors], axis=1)
    return system.constraints.free_part(v.ravel())


def moving(problem: sk.Problem, mesh: MeshQuadTree, theory: str, place: tuple[float, float], radius: float) -> sk.Solution:
    """4 ms after a blow."""
    system = problem.on(mesh, theory)
    blow = struck(system, place, radius)
    motion = sk.simulate(system, 4e-3, velocity=blow, outputs=2, progress=False, rtol=1e-3).unwrap()
    return sk.Solution(system, motion.q[-1], motion.v[-1], 4e-3)


def rolled(mesh: MeshQuadTree, theory: str) -> sk.Solution:
    """A free strip bent to a half circle, at rest."""
    system = sk.Problem(STRIP, 0.002, ALUMINIUM, [], []).on(mesh, theory)
    q = system.undeformed.reshape(-1, 4, 3).copy()
    angle = pi * q[:, 0, 0]
    q[:, 0, 0], q[:, 0, 2] = np.sin(angle) / pi, (1 - np.cos(angle)) / pi
    q[:, 1] = np.stack([np.cos(angle), 0 * angle, np.sin(angle)], axis=1)
    if system.geometry.theory.directors:
        q[:, 3] = np.stack([-np.sin(angle), 0 * angle, np.cos(angle)], axis=1)
    return sk.Solution(system, q.ravel(), np.zeros(system.n_dofs), 0.0)


def states(theory: str) -> Iterator[tuple[str, sk.Solution]]:
    mesh = quadtree(uniform(PLATE, 8, 8)).refined()
    for name, supports in (("free plate", []), ("clamped plate", [sk.Clamp("boundary")])):
        yield name, moving(sk.Problem(PLATE, 0.002, ALUMINIUM, supports, []), mesh, theory, (0.5, 0.4), 0.12)
    yield "rolled strip", rolled(quadtree(uniform(STRIP, 8, 4)).refined(), theory)
    mesh = quadtree(uniform(TUBE, 8, 16), TUBE).refined()
    yield "tube", moving(sk.Problem(TUBE, 0.01, ALUMINIUM, [], []), mesh, theory, (0.5, 2.0), 0.3)


def on(system: System, mesh: MeshQuadTree) -> System:
    return system.problem.on(mesh, system.geometry.theory)


def projected(state: sk.Solution, new: System) -> np.ndarray:
    """Positions of the smallest distance in the mass norm."""
    there, back = (Interpolation(*(s.geometry for s in pair)) for pair in ((state.system, new), (new, state.system)))
    q = there.positions(state.q)
    with DirectSolver(new.pattern, new.constraints) as solver:
        solver.factor(new.mass)
        lost = state.system.mass @ (state.q - back.positions(q))
        return q + solver.solve(back.transposed(lost), refinements=2)


def energies() -> list[list[Any]]:
    """Change of the strain energy over the total energy: by interpolation, by projection, and settled."""
    rows = []
    for theory in ("kirchhoff", "full"):
        for name, state in states(theory):
            mesh, total = state.system.mesh, state.strain_energy + state.kinetic_energy
            for other in (mesh.coarsened(np.arange(mesh.nelements)), half(mesh), mesh.refined()):
                new = on(state.system, other)
                plain, settled = (remap(state, new, settle=settle) for settle in (False, True))
                finer = other.nelements > 2 * mesh.nelements
                found = [plain.q, None if finer else projected(state, new), settled.q]
                rises = [None if q is None else (new.strain_energy(q) - state.strain_energy) / total for q in found]
                texts = ["" if rise is None else f"{rise:+.1e}" for rise in rises]
                rows.append([theory, name, mesh.nelements, other.nelements, *texts, f"{settled.change.factor:.3f}"])
    return rows


def half(mesh: MeshQuadTree) -> MeshQuadTree:
    """One half coarsened."""
    return mesh.coarsened(np.flatnonzero(mesh.p[0, mesh.t].mean(axis=0) > 0.5 * mesh.p[0].max()))


def runs() -> list[list[Any]]:
    """Energy over that of the blow, less one, after 16 stretches of 0.2 ms; the mesh changes after each but the last."""
    rows = []
    for theory, name, surface, thickness, place, counts in (
        ("kirchhoff", "plate", PLATE, 0.002, (0.5, 0.4), (8, 8)),
        ("kirchhoff", "tube", TUBE, 0.01, (0.5, 2.0), (8, 16)),
        ("full", "plate", PLATE, 0.002, (0.5, 0.4), (8, 8)),
    ):
        problem = sk.Problem(surface, thickness, ALUMINIUM, [], [])
        mesh = quadtree(uniform(surface, *counts), surface).refined()
        ends = [run(problem.on(mesh, theory), place, settle) for settle in (None, False, True)]
        rows.append([theory, name, *(f"{end:+.1e}" for end in ends)])
    return rows


def run(system: System, place: tuple[float, float], settle: bool | None, stretches: int = 16) -> float:
    """One end of the body is coarsened and all is refined again, then the other end; None: always the same mesh."""
    state = sk.Solution(system, system.undeformed, struck(system, place, 0.25) / 3, 0.0)
    first = state.kinetic_energy
    for k in range(stretches):
        system = state.system
        motion = sk.simulate(system, 2e-4, start=state, outputs=2, progress=False, rtol=1e-3).unwrap()
        state = sk.Solution(system, motion.q[-1], motion.v[-1], float(motion.times[-1]))
        if settle is not None and k < stretches - 1:
            mesh, along = system.mesh, system.mesh.p[0, system.mesh.t].mean(axis=0) / system.mesh.p[0].max()
            ends = np.flatnonzero(along > 0.75 if k % 4 == 0 else along < 0.25)
            other = mesh.refined(np.flatnonzero(mesh.levels == 0)) if k % 2 else mesh.coarsened(ends)
            new = on(system, other)
            found = remap(state, new, settle=settle)
            state = sk.Solution(new, found.q, found.v, state.time)
    return (state.strain_energy + state.kinetic_energy) / first - 1


def costs() -> list[list[Any]]:
    """Milliseconds of a change of mesh and of time steps."""
    rows = []
    mesh = quadtree(uniform(PLATE, 16, 16)).refined()
    at = mesh.p[0, mesh.t].mean(axis=0)
    other = mesh.adapted(np.flatnonzero(at < 0.15), np.flatnonzero(at > 0.6))
    for theory in ("kirchhoff", "full"):
        problem = sk.Problem(PLATE, 0.002, ALUMINIUM, [], [])
        state = moving(problem, mesh, theory, (0.5, 0.4), 0.12)
        new, old = problem.on(other, theory), state.system
        steps = StepSolver(old, sk.EnergyMomentum())
        a = steps.initial_acceleration(state.q, state.velocity, 4e-3, np.zeros(old.n_dofs))

        def step(fresh: bool, steps: StepSolver = steps, state: sk.Solution = state, a: np.ndarray = a) -> None:
            steps.factors.dt = 0.0 if fresh else steps.factors.dt
            steps.step(State(4e-3, state.q, state.velocity, a), 2e-5)

        calls: list[Callable[[], Any]] = [
            lambda problem=problem, theory=theory: problem.on(other, theory).mass,
            lambda state=state, new=new, a=a: remap(state, new, a, settle=False),
            lambda state=state, new=new, a=a: remap(state, new, a),
            lambda step=step: step(True),
            lambda step=step: step(False),
        ]  # fmt: skip
        rows.append([theory, mesh.nelements, other.nelements, *(f"{1e3 * fastest(call):.0f}" for call in calls)])
    return rows


def fastest(call: Callable[[], Any], times: int = 5) -> float:
    """Seconds."""
    found = []
    for _ in range(times):
        begin = time.perf_counter()
        call()
        found.append(time.perf_counter() - begin)
    return min(found)


def main() -> None:
    warnings.simplefilter("ignore")
    write("settled.csv", "theory; state; elements; then; at nodes; projected; settled; factor", energies())
    write("settled_runs.csv", "theory; body; one mesh; at nodes; settled", runs())
    write("settled_cost.csv", "theory; elements; then; new system; carried; and settled; step with new factors; without",
          costs())  # fmt: skip


if __name__ == "__main__":
    main()

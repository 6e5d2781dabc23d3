"""Runs for the tests of checkpoints, each in a process of its own that may be killed.

    python restarts.py                          reads orders from its input and forks for each
    python restarts.py NAME FOLDER RESULT       one run
    python restarts.py forces                   prints internal forces

An order is a line ``NAME FOLDER RESULT``; the answers are lines with the number of the process, and its exit status.
"""

import os
import sys
from dataclasses import astuple, dataclass

import numpy as np

import skancf as sk
from skancf.dynamics.run import NewMesh
from skancf.dynamics.state import State


@dataclass(frozen=True)
class Looks:
    """Refines at given looks, going back once, then coarsens; remembers nothing."""

    every: int = 3

    def check(self, system):
        assert system.mesh.levels.max() == 0

    def change(self, system, before, now, end, energy, again):
        mesh, level = system.mesh, system.mesh.levels.max()
        right = np.flatnonzero(mesh.p[0, mesh.t].mean(axis=0) > 0.6)
        if level == 0 and now.time > 0.03 and again:
            return self.moved(system, before, mesh.refined(right), True)
        if level == 1 and now.time > 0.06:
            return self.moved(system, now, mesh.refined(right[:2]), False)
        if level == 2 and now.time > 0.08:
            return self.moved(system, now, mesh.coarsened(np.arange(mesh.nelements)), False)
        return None

    def moved(self, system, state, mesh, again):
        new = system.problem.on(mesh, system.geometry.theory)
        there = sk.transfer(sk.Solution(system, state.q, state.v, state.time), new)
        a = sk.transfer(sk.Solution(system, state.q, state.a, state.time), new).velocity
        event = sk.dynamics.MeshEvent(state.time, system.geometry.n_elements, new.geometry.n_elements, 0, 0, 0, 0, again)
        return NewMesh(new, State(state.time, there.q, there.velocity, a, state.dt), event)


def system_on(theory, n, supports, loads, damping=None, tree=False):
    surface = sk.Rectangle(1.0, 1.0)
    problem = sk.Problem(surface, 0.05, sk.Isotropic(1e6, 0.3, 1000.0), supports, loads, damping)
    mesh = sk.meshes.uniform(surface, n, n)
    return problem.on(sk.meshes.quadtree(mesh, surface) if tree else mesh, theory)


def tip(state):
    return state.displacement((1.0, 0.5))


CLAMP = [sk.Clamp("left")]
JUMP = [sk.EdgeLoad("right", (0, 0, 20.0), history=lambda t: float(t > 0.02))]
ROUGH = [sk.EdgeLoad("right", (300.0, 0, 40.0), history=sk.Pulse(0.05, 0.01, "rectangle"))]
STRUCK = [sk.Impulse((1.0, 1.0), (0, 0, 0.4), 0.021), sk.EdgeImpulse("right", (0, 0.2, -0.4), 0.05)]
MOVING = [sk.MovingForce(sk.Path([0, 0.05, 0.1], [(0.1, 0.3), (0.9, 0.7), (0.9, 0.1)]), (0, 0, -20.0)),
          sk.Impulse((1.0, 1.0), (0, 0, -0.5), 0.07)]  # fmt: skip
DRIVEN = [sk.Prescribed("left", (0, 0, 0.02), history=lambda t: np.sin(50 * t)), sk.Dashpot((1.0, 1.0), (3.0, 3.0, 3.0))]

RUNS = {
    "rough": lambda: (system_on("full", 4, CLAMP, ROUGH), {"rtol": 3e-3, "balance": None}),
    "momentum": lambda: (
        system_on("kirchhoff", 4, CLAMP, [*STRUCK, sk.Gravity((0, 0, -9.81))], sk.Damping(stiffness=1e-4)),
        {"rule": sk.EnergyMomentum(), "dt": 2e-3, "record": {"tip": tip, "energy": lambda s: s.strain_energy}},
    ),
    "moving": lambda: (
        system_on("kirchhoff", 4, DRIVEN, MOVING, sk.Damping(mass=0.5)),
        {"rtol": 1e-3, "record": {"tip": tip}, "backend": "superlu"},
    ),
    "meshes": lambda: (
        system_on("kirchhoff", 3, CLAMP, [*JUMP, *STRUCK], tree=True),
        {"dt": 2e-3, "follow": Looks(), "balance": None, "record": {"tip": tip}},
    ),
    "large": lambda: (system_on("kirchhoff", 33, CLAMP, JUMP), {"dt": 1e-2}),
    "large_superlu": lambda: (system_on("full", 33, CLAMP, JUMP), {"dt": 2e-2, "backend": "superlu"}),
}  # fmt: skip
EVERY = {"large": 2, "large_superlu": 2}


def run(name, folder, **more):
    system, options = RUNS[name]()
    checkpoint = None if folder is None else sk.Checkpoint(folder, every=EVERY.get(name, 7))
    options = {"outputs": 13, "progress": False, "checkpoint": checkpoint, **options, **more}
    return sk.simulate(system, 0.1, **options)


def arrays(motion):
    """All that a motion has, as arrays."""
    parts = {f"{name}_{i}": getattr(part, name) for i, part in enumerate(motion.segments)
             for name in ("times", "q", "v", "outputs")}  # fmt: skip
    records = {f"record_{name}_{i}": a for name, pair in motion.records.items() for i, a in enumerate(pair)}
    events = np.array([astuple(event) for event in motion.ledger.events])
    steps = np.array([astuple(step) for step in motion.steps], dtype=float)
    return {**parts, **records, **motion.ledger.table(), "events": events, "steps": steps}


def same(one, two):
    """Names of what differs by any byte."""
    missing = set(one) ^ set(two)
    return [name for name in {**one, **two} if name in missing or one[name].tobytes() != two[name].tobytes()]


def save(name, folder, result):
    motion = run(name, folder, resume=True)
    np.savez(result, seconds=motion.seconds, status=motion.status.name, **arrays(motion))


def forces():
    """Internal forces as text: the same bytes whether this process compiles or loads machine code."""
    system = system_on("kirchhoff", 3, CLAMP, [])
    q = system.undeformed + 1e-2 * np.cos(np.arange(system.n_dofs))
    print(system.internal_force(q).tobytes().hex(), system.shell.force_of(q, system.stresses(q)).tobytes().hex())


def serve():
    for order in sys.stdin:
        pid = os.fork()
        if not pid:
            code = 1
            try:
                save(*order.split())
                code = 0
            finally:
                os._exit(code)
        print(pid, flush=True)
        print(os.waitpid(pid, 0)[1], flush=True)


if __name__ == "__main__":
    {1: serve, 2: forces}[len(sys.argv)]() if len(sys.argv) < 3 else save(*sys.argv[1:])

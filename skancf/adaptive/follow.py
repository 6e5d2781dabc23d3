"""Meshes that follow a motion: a policy that the loop in time asks."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from skancf.adaptive.grow import may_be_merged, may_be_quartered
from skancf.adaptive.marking import check_indicators
from skancf.adaptive.recovery import recovery_indicator
from skancf.adaptive.remap import remap
from skancf.arguments import function, plain, whole
from skancf.dynamics import MeshEvent
from skancf.dynamics.named_state import flat
from skancf.dynamics.run import NewMesh
from skancf.dynamics.state import State
from skancf.equality import by_value
from skancf.errors import InputError, positive, warn
from skancf.functions import called
from skancf.history import Case
from skancf.kernels.constants import BLOCK
from skancf.meshes import MeshQuadTree
from skancf.meshes.forest import Leaves
from skancf.showing import short
from skancf.solution import Solution
from skancf.system.system import System
from skancf.theories import left_per_halving

EARLY, AIM = 0.5, 0.25
"""Of the allowed squared error: how much there may be before elements are quartered, and how much should be left then."""
SMALLEST = 2.0**-13
"""Of the extent of the surface: large motions round strains as the squares of positions are rounded."""
LATE = 2.0
"""So many times the allowed squared error came without being seen: the run goes back."""
SURE = 0.01
"""Of the allowed squared error: what merging may add to it; what it loses goes on as vibrations of the coarser mesh."""
PLACES = 5
"""Times until the next check at which places of loads are asked for."""


@by_value
@dataclass(frozen=True)
class Follow:
    r"""Elements are quartered and merged while the body moves, so that the error stays below an allowed one.

    At regular intervals of steps the indicators :math:`\eta_K^2` of the present state, energies, are compared with an
    allowed error,

    .. math:: \sum_K \eta_K^2 \le \tau^2 E

    with the largest strain energy E in the run so far, or a given one. When half of it is reached, the fewest elements that
    bring it down to a quarter are quartered, and those around them, into which the motion goes on. Where twice as much has
    come between two checks of the mesh, the run goes back to the last one and starts there with the finer mesh. Elements
    where loads will be until the next check are as fine as those where they are. Elements are merged where that adds no
    more than a hundredth.

    What an element lost of the motion before it was quartered, or loses when it is merged, goes on as a small vibration of
    the other elements, which error-controlled steps may follow at great cost. A little damping of the material,
    :class:`~skancf.Damping`, takes it out.

    Positions, velocities and accelerations go from mesh to mesh by :func:`~skancf.remap`: momenta are kept, and elements
    are not merged where that would raise the energy. Every change is an event in the ledger.

    Parameters
    ----------
    rtol : float
        :math:`\tau`, the error in the energy norm: the square root of the sum of the indicators over the energy.
    every : int
        Steps from one check of the mesh to the next.
    indicator : function of a Solution
        Squared errors of the elements (J), (n_elements,), as :func:`~skancf.recovery_indicator`.
    max_dofs : int
        No element is quartered beyond this number of unknowns; a warning tells of it.
    smallest : float
        Size of the smallest elements, of the extent of the surface.
    coarsest : int
        Level, counted from the coarse mesh, to which elements are merged at most.
    energy : float, optional
        E (J), where the run so far says too little of it: at its beginning, when a load has done hardly any work yet, a
        small part of a small energy would be asked for. Without it the mesh stays while the energy doubles from check to
        check.

    Raises
    ------
    InputError
        For numbers that are not positive, and for an invalid indicator.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.0, density=7850.0)
    >>> pull = sk.EdgeLoad("right", (0.0, 0.0, 100.0))
    >>> strip = sk.Problem(sk.Rectangle(1.0, 0.1), 0.01, steel, supports=[sk.Clamp("left")], loads=[pull])
    >>> mesh = sk.meshes.quadtree(sk.meshes.uniform(strip.surface, 4, 1), strip.surface)
    >>> system = strip.on(mesh, "kirchhoff")
    >>> motion = sk.simulate(system, 0.005, rtol=0.05, follow=sk.Follow(every=5), progress=False)
    >>> print(motion.status.value)
    finished
    """

    rtol: float = 0.2
    every: int = 10
    indicator: Callable[[Solution], np.ndarray] = recovery_indicator
    max_dofs: int = 200_000
    smallest: float = SMALLEST
    coarsest: int = 0
    energy: float | None = None

    __repr__ = short

    def __post_init__(self) -> None:
        plain(self)
        for name in ("rtol", "max_dofs", "smallest"):
            positive(name, getattr(self, name))
        whole("every", self.every, floats=True)
        whole("coarsest", self.coarsest, least=0)
        if self.smallest > 1:
            raise InputError(f"smallest = {self.smallest}: give a part of the extent, at most 1")
        if self.energy is not None:
            positive("energy", self.energy, "J")
        function("indicator", self.indicator, "a function of a Solution, for example sk.recovery_indicator")

    def check(self, system: System) -> None:
        """InputError for a mesh that cannot be refined, and for terms that remember something."""
        if not isinstance(system.mesh, MeshQuadTree):
            raise InputError("follow: the mesh of the system must be a quadtree; make it by sk.meshes.quadtree(mesh)")
        if names := flat(system.terms.state()):
            raise InputError(f"follow: a term remembers '{min(names)}', which does not go from mesh to mesh; let the motion "
                             "be on one mesh, without follow")  # fmt: skip

    def change(self, system: System, before: State, now: State, end: float, energy: float, again: bool) -> NewMesh | None:
        """The mesh to go on with and the state there, from the states at the last check and now; None to keep the mesh.

        ``end`` is that of the run (s), ``energy`` the largest strain energy so far, ``again`` whether the run may go back
        to the last check.
        """
        state = Solution(system, now.q, now.v, now.time)
        if self.energy is None and self._begins(Solution(system, before.q, before.v, before.time), state, energy):
            return None
        allowed = self.rtol**2 * (energy if self.energy is None else self.energy)
        values = check_indicators(called("indicator", self.indicator, state))
        ahead = min(2 * now.time - before.time, end)
        fine = self._marked(system, values, allowed, (now.time, ahead))
        target = self._finer(system, fine)
        if again and values.sum() > LATE * allowed and target is not system.mesh:
            return self._moved(system, before, target, again=True)
        merged = self._merged(system, target, values, allowed)
        if merged is not None:
            new = self._moved(system, now, merged, again=False)
            if new is None or new.raised <= 0:
                return new
        return self._moved(system, now, target, again=False)

    def _begins(self, before: Solution, now: Solution, most: float) -> bool:
        """Whether the strain energy is the largest so far and still doubles from check to check: it says nothing yet."""
        return now.strain_energy > 0.999 * most and now.strain_energy > 2 * before.strain_energy

    def _room(self, system: System, marked: np.ndarray) -> np.ndarray:
        """Marked elements that may be quartered, a mask."""
        return marked & may_be_quartered(system.mesh.leaves, system.geometry.surface, self.smallest)

    def _marked(self, system: System, values: np.ndarray, allowed: float, span: tuple[float, float]) -> np.ndarray:
        """Elements to quarter, a mask: those that have most of the error, those around them, those in the way of loads."""
        mesh, own = system.mesh, np.zeros(len(values), dtype=bool)
        if values.sum() > EARLY * allowed:
            order = np.argsort(-values, kind="stable")
            gained = np.cumsum(values[order]) * (1 - left_per_halving(system.geometry.theory))
            own[order[: np.searchsorted(gained, values.sum() - AIM * allowed) + 1]] = True
        finest = np.full(mesh.p.shape[1], -1)
        np.maximum.at(finest, mesh.t[:, own].ravel(), np.tile(mesh.levels[own], 4))
        around = finest[mesh.t].max(axis=0) >= mesh.levels
        return self._room(system, around | self._in_the_way(system, *span))

    def _in_the_way(self, system: System, now: float, ahead: float) -> np.ndarray:
        """Elements where loads will be until the next check, if they are coarser than where these are now."""
        out, here = np.zeros(system.geometry.n_elements, dtype=bool), system.loads.places(Case(time=now))
        if not here.shape[1]:
            return out
        level = system.mesh.levels
        finest = level[system.geometry.locate_all(here)[0]].max()
        for time in np.linspace(now, ahead, PLACES)[1:]:
            places = system.loads.places(Case(time=float(time)))
            if places.shape[1]:
                elements = system.geometry.locate_all(places)[0]
                out[elements[level[elements] < finest]] = True
        return out

    def _finer(self, system: System, marked: np.ndarray) -> MeshQuadTree:
        mesh: MeshQuadTree = system.mesh
        if not marked.any():
            return mesh
        finer = mesh.regrown(mesh.leaves.refined(np.flatnonzero(marked)))
        if BLOCK * finer.p.shape[1] > self.max_dofs:
            warn(
                f"max_dofs = {self.max_dofs}: the mesh that this motion asks for has {BLOCK * finer.p.shape[1]} unknowns "
                "and is not made; errors are larger than asked. Raise it, or ask for less by rtol"
            )  # fmt: skip
            return mesh
        return finer

    def _merged(self, system: System, target: MeshQuadTree, values: np.ndarray, allowed: float) -> MeshQuadTree | None:
        """The target with elements merged that will have little of the error; None without such elements."""
        leaves: Leaves = system.mesh.leaves
        # The merged element has what its quarters have over what a quartering leaves.
        added = values * (1 / left_per_halving(system.geometry.theory) - 1)
        order = np.argsort(added, kind="stable")
        small = order[: np.searchsorted(np.cumsum(added[order]), SURE * allowed)]
        small = small[may_be_merged(system)[small] & (leaves.cells.level[small] > self.coarsest)]
        cells = leaves.cells.take(small)
        found = target.leaves.find(cells)
        merged = target.coarsened(found[found >= 0])
        return merged if len(merged.leaves) < len(target.leaves) else None

    def _moved(self, system: System, state: State, mesh: MeshQuadTree, again: bool) -> NewMesh | None:
        if mesh is system.mesh:
            return None
        new = system.problem.on(mesh, system.geometry.theory)
        there = remap(Solution(system, state.q, state.v, state.time), new, state.a)
        assert there.v is not None and there.a is not None
        change = there.change
        event = MeshEvent(
            state.time, system.geometry.n_elements, new.geometry.n_elements, float(np.diff(change.strain_energy)[0]),
            float(np.diff(change.kinetic_energy)[0]), float(change.momentum[0]), float(change.momentum[1]), again,
        )  # fmt: skip
        return NewMesh(new, State(state.time, there.q, there.v, there.a, state.dt), event, change.raised)

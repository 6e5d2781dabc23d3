"""States on another mesh, for those who ask for a state."""

from skancf.adaptive.interpolation import Interpolation, is_finer, multipliers_on, require_one_tree
from skancf.adaptive.remap import remap
from skancf.arguments import SYSTEM, instance
from skancf.solution import Solution
from skancf.states import StateLike, solution_of
from skancf.system.system import System


def transfer(state: StateLike, system: System) -> Solution:
    r"""A state on another mesh of the same quadtree, with the same theory.

    Where the new mesh is finer, the position field is the same function there: in theory `kirchhoff` spaces are nested, and
    positions, slopes and the velocity do not change. (In theory `full` slopes across edges jump; there the new nodes take
    those of one side.) On curved surfaces new nodes go where the finer surface is, so that a body that moved rigidly is
    without strain. Of a small-deflection answer it is the displacement field. Where the new mesh is coarser somewhere, nodes
    that stay are where they were, and settle so that the internal forces do not jump; a velocity is the projection in the
    mass norm,

    .. math:: \int \rho t\, (v_{new} - v) \cdot \delta v_{new} \, dA = 0,

    on what supports leave free. A free body keeps its momenta on every surface, and its energy does not rise: see
    :func:`remap`, which also tells what changed. Supports hold exactly what they prescribe, at new nodes too.

    Raises
    ------
    InputError
        For meshes that do not grow from one coarse mesh, and for another theory.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> coarse = sk.meshes.quadtree(sk.meshes.uniform(plate.surface, 4, 4), plate.surface)
    >>> state = sk.solve_linear(plate.on(coarse, "kirchhoff"))
    >>> moved = sk.transfer(state, plate.on(coarse.refined(), "kirchhoff"))
    >>> print(np.allclose(moved.displacement((0.3, 0.3)), state.displacement((0.3, 0.3))))
    True
    """
    state = solution_of("state", state)
    instance("system", system, System, SYSTEM)
    old, new = state.system.geometry, system.geometry
    require_one_tree(old, new)
    if state.linear:
        q = system.undeformed + Interpolation.of(state.system, system).field(state.q - state.system.undeformed)
        wanted = system.undeformed + system.prescribed(state.case)
        q, v = q + system.constraints.fixed_part(wanted - q), None
    else:
        there = remap(state, system, settle=not is_finer(new.mesh.leaves, old.mesh.leaves))
        q, v = there.q, there.v
    multipliers = None if state.multipliers is None else multipliers_on(state, system)
    return Solution(
        system, q, v, time=state.time, load_factor=state.load_factor, linear=state.linear, multipliers=multipliers
    )

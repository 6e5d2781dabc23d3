r"""The paper's indicator: the largest second Piola-Kirchhoff stress component at each node."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from skancf.adaptive.regions import find_regions
from skancf.errors import InputError, shown, warn
from skancf.materials.heights import Depth
from skancf.meshes import Regions
from skancf.solution import STRESSES, Solution
from skancf.states import StateLike, solution_of
from skancf.tolerances import SAME_VALUE

SEARCH = ("radius", "size", "cap")
LITTLE = 0.01
"""Of the stress at a face: less says nothing of where that is large."""
COMPONENTS = {"in_plane": ("S11", "S22", "S12"), "normal": ("S11", "S22", "S33")}


def nodal_measure(solution: StateLike, components: str | Sequence[str] = "in_plane", z: Depth | None = None) -> np.ndarray:
    r""":math:`\sigma_i = \max_k |S_k|` over some components, (n_mesh_nodes,) (Pa).

    Parameters
    ----------
    components : {"in_plane", "normal"} or names
        ``"in_plane"``: S11, S22, S12; ``"normal"``: S11, S22, S33; or any of S11, S22, S33, S23, S13, S12.
    z : float or {"top", "middle", "bottom"}
        Depth (m). Default: the reference surface, z = 0, as in the paper, where bending leaves membrane and shear stress.

    Warns
    -----
    OutOfDepth
        Without z, where the stress at z = 0 is less than a hundredth of that at a face: it says nothing of the bending.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> system = plate.on(sk.meshes.uniform(plate.surface, 6, 6), "kirchhoff")
    >>> print(f"{sk.nodal_measure(sk.solve_linear(system), z='top').max() / 1e6:.2f} MPa")
    2.84 MPa
    """
    solution = solution_of("solution", solution)
    names = COMPONENTS.get(components, (components,)) if isinstance(components, str) else components
    try:
        names = tuple(names)
        known = bool(names) and all(isinstance(name, str) and name in STRESSES for name in names)
    except TypeError:
        known = False
    if not known:
        raise InputError(f"components = {shown(components)}: choose {sorted(COMPONENTS)} or some of {list(STRESSES)}")
    columns = [STRESSES.index(name) for name in names]

    def at(depth: Depth) -> np.ndarray:
        return np.asarray(np.abs(solution.nodal_stresses(depth)[:, columns]).max(axis=1))

    if z is not None:
        return at(z)
    measure = at(0.0)
    face = max(float(at(name).max()) for name in ("top", "bottom"))
    if measure.max() < LITTLE * face:
        warn(f"the stress measure is that of the reference surface, z = 0, where it is {measure.max():.3g} Pa at most, and "
             f"{face:.3g} Pa at a face: it does not see that the body is bent. Give z='top' or z='bottom'")  # fmt: skip
    return measure


def stress_indicator(
    solution: StateLike, components: str | Sequence[str] = "in_plane", z: Depth | None = None
) -> np.ndarray:
    r"""The largest measure at the corners of each element, 0 where it does not exceed the mean: (n_elements,) (Pa).

    .. math:: \eta_K = \max_{i \in K} \sigma_i \quad \text{if} \quad \max_{i \in K} \sigma_i > \bar\sigma
              = \tfrac1n \sum_i \sigma_i

    Parameters
    ----------
    solution : Solution
    components, z
        Which stress, without z that of the reference surface, which does not see bending: see :func:`nodal_measure`.

    References
    ----------
    Research on local mesh refine method based on absolute nodal coordinate formulation: stress is concentrated where it
    exceeds its mean over the nodes.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> system = plate.on(sk.meshes.uniform(plate.surface, 6, 6), "kirchhoff")
    >>> print(sk.stress_indicator(sk.solve_linear(system), z="top").shape)
    (36,)
    """
    solution = solution_of("solution", solution)
    sigma = nodal_measure(solution, components, z)
    largest = sigma[solution.system.mesh.t].max(axis=0)
    return np.where(largest > sigma.mean() * (1 + SAME_VALUE), largest, 0.0)


def face_stress(solution: Solution) -> np.ndarray:
    """The larger :func:`stress_indicator` of the two faces, so that bending counts, (n_elements,) (Pa)."""
    return np.max([stress_indicator(solution, z=z) for z in ("bottom", "top")], axis=0)


def stress_regions(
    solution: StateLike, components: str | Sequence[str] = "in_plane", z: Depth | None = None, **search: Any
) -> Regions:
    r"""Regions to refine: about every node whose stress exceeds the mean and is the largest around it.

    Parameters
    ----------
    solution
        A state on a uniform mesh, for example ``motion.at(0.1)``.
    components, z
        Which stress, without z that of the reference surface, which does not see bending: see :func:`nodal_measure`.
    **search
        ``radius``, ``size``, ``cap`` of :func:`~skancf.adaptive.find_regions`.

    Returns
    -------
    Regions
        A tuple of :class:`~skancf.meshes.Region` that remembers the element lengths of the mesh it was found on.

    References
    ----------
    Research on local mesh refine method based on absolute nodal coordinate formulation, eqs. (5) and (6).

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> system = plate.on(sk.meshes.uniform(plate.surface, 6, 6), "kirchhoff")
    >>> regions = sk.stress_regions(sk.solve_linear(system), z="top")
    >>> print([tuple(np.round(region.centre, 2).tolist()) for region in regions])
    [(0.0, 0.5), (0.5, 0.0), (0.5, 0.5), (0.5, 1.0), (1.0, 0.5)]
    """
    solution = solution_of("solution", solution)
    if unknown := sorted(set(search) - set(SEARCH)):
        raise TypeError(f"stress_regions() got an unexpected keyword argument {unknown[0]!r}; there are {', '.join(SEARCH)}")
    geometry = solution.system.geometry
    mesh = geometry.mesh
    cell = np.median(np.ptp(mesh.p[:, mesh.t], axis=1), axis=1)
    positions = geometry.at_mesh_nodes(geometry.undeformed)[:, 0].T
    sides = positions[:, np.roll(mesh.t, -1, axis=0)] - positions[:, mesh.t]
    regions = find_regions(
        mesh.p, nodal_measure(solution, components, z), positions=positions,
        spacing=float(np.median(np.linalg.norm(sides, axis=0))), cell=(float(cell[0]), float(cell[1])), **search,
    )  # fmt: skip
    return Regions(regions, cell=(float(cell[0]), float(cell[1])))

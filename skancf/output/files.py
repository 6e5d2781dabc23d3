"""States as files that ParaView opens, and back."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from skancf.arguments import choice, mapping, text, whole
from skancf.atomic import AnyPath, as_path, check_file, replacing
from skancf.errors import InputError, number
from skancf.materials import Section
from skancf.output.collection import read_collection, write_collection
from skancf.output.fields import values
from skancf.output.reels import series_of
from skancf.output.sampling import grid, sample_strain, sample_surface
from skancf.progress import Bar, ShowProgress, check_progress, number_of
from skancf.solution import Solution
from skancf.tensors import von_mises

FILE_ORDER = (0, 1, 2, 5, 3, 4)
"""Where the components 11, 22, 33, 12, 23, 13 of a file stand in the order 11, 22, 33, 23, 13, 12 of the library."""

CURVED = "VTK_LAGRANGE_QUADRILATERAL"
LAGRANGE_ORDER = np.array([0, 3, 15, 12, 1, 2, 7, 11, 13, 14, 4, 8, 5, 6, 9, 10])
"""VTK's order of the 4 x 4 points of a cell, which are numbered in rows along xi: corners, edges in the direction of growing
coordinates, inner points."""


def write(
    states: Any,
    path: AnyPath,
    *,
    subdivisions: int | None = None,
    depths: Mapping[str, float] | None = None,
    progress: ShowProgress = True,
    cells: str = "flat",
) -> Path:
    """Write one state as a ``.vtu`` file, or many as a ``.pvd`` collection that ParaView plays as a film.

    A collection ``run.pvd`` lists the files of the folder ``run`` next to it. Every file appears under its name when it
    is whole, and those of a collection only when all are: after a failure, older results are as they were.

    Parameters
    ----------
    states : Solution, StaticResult, AdaptiveResult, or iterable of Solution, Motion or PathResult
        A generator is read one state at a time.
    path : str or Path
        ``*.vtu`` for one state, ``*.pvd`` for many.
    subdivisions : int, optional
        Flat cells along an element's edge. Default: 4.
    depths : mapping from name to z (m), optional
        Where stress and strain are written. Default: the faces ``top`` and ``bottom`` and ``mid``, halfway between
        them. ``{}``: displacements and velocities only, a tenth of the size.
    progress : bool or callable
        A bar, nothing, or a function that is told of each state; see :class:`~skancf.Progress`.
    cells : {"flat", "curved"}
        Each element cut into small flat quadrilaterals, which every program reads; or one curved cell for each element, the
        Lagrange quadrilateral of order 3 of VTK, which is the element's own polynomial.

    Returns
    -------
    Path
        The file to open.

    Raises
    ------
    InputError
        For a folder that cannot be written, a name that ends otherwise, and times that do not increase.

    Notes
    -----
    Curved cells have the exact mid-surface in two thirds of the size: positions and displacements are right everywhere in
    an element, and fields interpolate their values at its 4 x 4 points. VTK, and so ParaView and pyvista, draws one through
    3 x 3 facets, and through twice as many in each direction for each further "Nonlinear Subdivision Level" of ParaView.
    Few other programs know such cells, and some filters do not: that is why flat ones are the default.

    Points lie on the deformed mid-surface. Point data are ``displacement`` (m), ``velocity`` (m/s, if there is one),
    and for each depth, say ``top``,

    - ``stress_top``: second Piola-Kirchhoff stress in the local frame (Pa),
    - ``strain_top``: Green-Lagrange strain in the local frame, shear strains doubled,
    - ``mises_top``: von Mises' equivalent of the stress (Pa),

    and ``membrane_force`` (N/m) and ``moment`` (N) per length, in the order 11, 22, 12. Where it is not everywhere the same,
    there is the ``thickness`` (m).

    Their components stand in the order 11, 22, 33, 12, 23, 13, which ParaView labels XX, YY, ZZ, XY, YZ, XZ; the rest
    of the library has the shear in the order 23, 13, 12. Cell data ``element`` is the number of the element.

    The time of a state without one is its load factor if these increase, else its number.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> system = plate.on(sk.meshes.uniform(plate.surface, 6, 6), "kirchhoff")
    >>> file = sk.output.write(sk.solve_linear(system), "plate.vtu")
    >>> print(file.name)
    plate.vtu
    """
    choice("cells", cells, ("flat", "curved"))
    check_progress(progress)
    if subdivisions is not None:
        whole("subdivisions", subdivisions)
        if cells == "curved":
            raise InputError(
                f"subdivisions = {subdivisions}: curved cells are not subdivided; leave it out, or take cells='flat'"
            )
    if depths is not None:
        for name, z in mapping("depths", depths, "names and depths, as in depths={'top': 0.005}").items():
            number(f"depths[{text('depths', name)!r}]", z)
    states = series_of(states)
    if isinstance(states, Solution):
        file = check_file(path, ".vtu")
        write_state(states, file, subdivisions or 4, depths, cells)
        return file
    if not isinstance(states, Iterable) or isinstance(states, str | bytes) or getattr(states, "ndim", 1) == 0:
        what = type(states).__name__
        raise InputError(f"states: give a Solution or a sequence of them, as motion.states or result.path, not {what}")
    file = check_file(path, ".pvd")
    with Bar("write", number_of(states), progress) as bar:

        def write_one(state: Solution, part: Path) -> None:
            write_state(state, part, subdivisions or 4, depths, cells)
            bar.next(part.name)

        return write_collection(file, states, write_one)


def write_state(
    solution: Solution, path: Path, subdivisions: int = 4, depths: Mapping[str, float] | None = None, cells: str = "flat"
) -> None:
    """One state as a ``.vtu`` file, binary and compressed."""
    import meshio

    curved = cells == "curved"
    subdivisions = 3 if curved else subdivisions
    surface = sample_surface(solution, subdivisions)
    data = {"displacement": surface.displacement}
    if surface.velocity is not None:
        data["velocity"] = surface.velocity
    if not isinstance(solution.system.problem.section, Section):
        data["thickness"] = values(solution, "thickness", subdivisions, None)
    faces = {"mid": "middle", "top": "top", "bottom": "bottom"}
    given = faces if depths is None else {name: number(f"depths[{name!r}]", z) for name, z in depths.items()}
    for name, z in given.items():
        strain, stress = sample_strain(solution, subdivisions, z)
        data[f"stress_{name}"], data[f"strain_{name}"] = stress[:, FILE_ORDER], strain[:, FILE_ORDER]
        data[f"mises_{name}"] = von_mises(stress)
    if depths is None or depths:
        forces = solution.recovered_section_forces(grid(subdivisions).points).swapaxes(1, 2).reshape(-1, 6)
        data["membrane_force"], data["moment"] = forces[:, :3], forces[:, 3:]
    n = solution.system.geometry.n_elements
    kind, corners, elements = "quad", surface.cells, surface.elements
    if curved:
        kind, corners, elements = CURVED, 16 * np.arange(n)[:, None] + LAGRANGE_ORDER, np.arange(n)
    mesh = meshio.Mesh(surface.points, [(kind, corners)], point_data=data, cell_data={"element": [elements]})
    with replacing(path) as part:
        meshio.vtu.write(part, mesh, binary=True, compression="zlib")


def read(path: AnyPath) -> Any:
    """Read what :func:`write` wrote.

    Parameters
    ----------
    path : str or Path

    Returns
    -------
    meshio.Mesh or list of (float, Path)
        Of a ``.vtu`` file points, cells and point data, as described at :func:`write`. Of a ``.pvd`` collection the
        times and the files, which are read one by one.

    Raises
    ------
    InputError
        For a file that is not there, or is no such file.

    Examples
    --------
    >>> steel = sk.Isotropic(young=210e9, poisson=0.3, density=7850.0)
    >>> plate = sk.Problem(
    ...     sk.Rectangle(1.0, 1.0), 0.01, steel,
    ...     supports=[sk.Clamp("boundary")],
    ...     loads=[sk.SurfaceLoad((0.0, 0.0, -1000.0))],
    ... )
    >>> system = plate.on(sk.meshes.uniform(plate.surface, 6, 6), "kirchhoff")
    >>> mesh = sk.output.read(sk.output.write(sk.solve_linear(system), "plate.vtu"))
    >>> print(mesh.point_data["displacement"].shape[1])
    3
    """
    file = as_path("file", path)
    if not file.is_file():
        raise InputError(f"file '{file}': there is no such file")
    if file.suffix.lower() == ".pvd":
        return read_collection(file)
    if file.suffix.lower() == ".vtu":
        return _read_state(file)
    raise InputError(f"file '{file}': its name ends in '{file.suffix}'; only .vtu and .pvd can be read")


def _read_state(file: Path) -> Any:
    import meshio

    # Damage shows as an exception of the XML parser, of zlib, of base64, of numpy or of meshio itself.
    try:
        mesh = meshio.vtu.read(file)
    except Exception as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise InputError(f"file '{file}': is no .vtu file, or is damaged ({reason}); write it again") from error
    if not all(np.isfinite(values).all() for values in (mesh.points, *mesh.point_data.values())):
        raise InputError(f"file '{file}': holds numbers that are not finite; it is damaged, write it again")
    return mesh

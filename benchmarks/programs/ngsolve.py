"""NGSolve: Koiter shells and Kirchhoff plates by Hellan-Herrmann-Johnson elements of several orders."""

import atexit
from collections.abc import Callable, Sequence
from math import cos, pi, sin
from typing import Any

from benchmarks.programs.program import Outcome, Program, Variant
from benchmarks.scenes import Scene

Sizes = dict[str, Sequence[float]]
SECOND: Sizes = {
    "end_shear": (2, 3, 4, 6, 8, 12, 16),
    "roll_up": (6, 8, 12, 16, 24, 32, 48),
    "hemisphere": (4, 6, 8, 12, 16, 24, 32),
    "hinged_roof": (2, 3, 4, 6, 8, 12, 16),
    "l_shape": (1, 2, 3, 4, 6, 8, 12, 16, 24),
    "corner_plate": (2, 3, 4, 6, 8, 12, 16, 24, 32),
    "paper_2n": (2, 4, 6, 8),
    "paper_20n": (2, 4, 6, 8),
    "free_ruler": (3, 4, 6, 8, 12, 16),
}
FOURTH: Sizes = {
    "end_shear": (1, 2, 3, 4),
    "roll_up": (2, 3, 4, 6, 8, 12),
    "hemisphere": (2, 3, 4, 6, 8, 12, 16),
    "hinged_roof": (1, 2, 3, 4, 6, 8),
    "l_shape": (1, 2, 3, 4, 6, 8, 12),
    "corner_plate": (2, 3, 4, 6, 8, 12),
    "paper_2n": (2, 4),
    "paper_20n": (2, 4),
    "free_ruler": (1, 2, 3, 4, 6),
}
# Time steps for each element along a side and order.
STEPS = {"paper_2n": 10, "paper_20n": 10, "free_ruler": 10}
VARIANTS = {
    "second": Variant("NGSolve, HHJ, order 2", "thin", SECOND),
    "fourth": Variant("NGSolve, HHJ, order 4", "thin", FOURTH),
}
ORDER = {"second": 2, "fourth": 4}


def prepare() -> None:
    import ngsolve

    ngsolve.ngsglobals.msg_level = 0
    ngsolve.SetNumThreads(1)
    atexit.register(forget)


def forget() -> None:
    """Netgen keeps the last geometry beyond the interpreter's end, and a closure among its mappings would abort it there."""
    import netgen.meshing as netgen

    netgen.SurfaceGeometry(unit_square).GenerateMesh(quads=True, nx=1, ny=1)


def unit_square(x: float, y: float, z: float) -> tuple[float, float, float]:
    return x, y, z


def version() -> str:
    import ngsolve

    return f"NGSolve {ngsolve.__version__}"


def run(scene: Scene, variant: str, size: float) -> Outcome:
    return SOLVE[scene.name](scene, ORDER[variant], int(size))


def strip(scene: Scene, order: int, n: int, mirrors: str = "") -> Any:
    from benchmarks.programs.ngsolve_shell import Shell, surface_mesh

    length, width = scene.data["length"], scene.data["width"]
    mesh = surface_mesh(lambda x, y, z: (length * x, width * y, 0), (n, 1), order, True)
    sides = f"left|{mirrors}" if mirrors else "left"
    return Shell(mesh, order, scene.data, True, ("left", sides, "left"), "left", mirrors)


def end(scene: Scene, shell: Any, first: float) -> Outcome:
    load_path(shell, first)
    u, _, w = shell.displacement(scene.data["length"], scene.data["width"] / 2, 0)
    return Outcome({"u": -float(u), "w": float(w)}, shell.dofs, shell.note)


def load_path(shell: Any, first: float) -> None:
    for _ in shell.follow([1.0], lambda factor, rtol: shell.equilibrium(factor, {}, rtol), first):
        pass


def end_shear(scene: Scene, order: int, n: int) -> Outcome:
    import ngsolve as ng

    shell = strip(scene, order, n)
    v = shell.space.TestFunction()[0]
    shell.spread(scene.data["force"] / scene.data["width"] * v[2] * ng.dx(definedon=shell.mesh.BBoundaries("right")))
    return end(scene, shell, 1.0)


def roll_up(scene: Scene, order: int, n: int) -> Outcome:
    """Its long sides are planes of symmetry, as in the authors' own example: free, the closed strip buckles sideways."""
    import ngsolve as ng

    shell = strip(scene, order, n, "bottom|top")
    rotation = shell.space.TestFunction()[2].Trace() * shell.conormal
    moment = scene.data["moment"] / scene.data["width"]
    shell.spread(ng.IfPos(ng.x - 0.999999 * scene.data["length"], moment, 0) * rotation * ng.ds(element_boundary=True))
    return end(scene, shell, 0.1)


def hemisphere(scene: Scene, order: int, n: int) -> Outcome:
    from benchmarks.programs.ngsolve_shell import Shell, surface_mesh

    d = scene.data
    radius, rise = d["radius"], pi / 2 - d["hole"]

    def sphere(x: float, y: float, z: float) -> tuple[float, float, float]:
        up, around = rise * y, pi / 2 * x
        return radius * cos(up) * cos(around), radius * cos(up) * sin(around), radius * sin(up)

    shell = Shell(surface_mesh(sphere, (n, n), order, False), order, d, False, ("right", "left", ""), mirrors="left|right")
    a, b = (radius, 0, 0), (0, radius, 0)
    outwards, inwards = shell.at(a, 0), shell.at(b, 1)
    shell.hold(shell.at(a, 2))
    shell.load[outwards], shell.load[inwards] = d["force"] / 2, -d["force"] / 2
    load_path(shell, 0.2)
    return Outcome({"outwards": shell.z.vec[outwards], "inwards": -shell.z.vec[inwards]}, shell.dofs, shell.note)


def hinged_roof(scene: Scene, order: int, n: int) -> Outcome:
    """A quarter; the height of its crown is prescribed."""
    from benchmarks.programs.ngsolve_shell import Shell, surface_mesh

    d = scene.data
    radius, length, angle = d["radius"], d["half_length"], d["half_angle"]

    def roof(x: float, y: float, z: float) -> tuple[float, float, float]:
        return length * x, -radius * sin(angle * (1 - y)), radius * cos(angle * (1 - y))

    mesh = surface_mesh(roof, (n, n), order, False)
    shell = Shell(mesh, order, d, False, ("bottom|right", "bottom|top", "bottom"), mirrors="right|top")
    crown = shell.at((length, 0, radius), 2)
    shell.hold(crown)
    deflections = [d[f"deflection_{k}"] for k in range(len(scene.quantities))]
    path = shell.follow(deflections, lambda w, rtol: shell.equilibrium(0.0, {crown: -w}, rtol), deflections[0])
    values = {f"force_{k}": -4 * shell.reaction(crown) for k, _ in enumerate(path)}
    return Outcome(values, shell.dofs, shell.note)


def l_shape(scene: Scene, order: int, n: int) -> Outcome:
    """Triangles, geometrically smaller towards the inner corner."""
    import ngsolve as ng

    from benchmarks.programs.ngsolve_plate import Plate, corner_mesh

    outline = ((-1, -1), (0, -1), (0, 0), (1, 0), (1, 1), (-1, 1))
    mesh = corner_mesh([(*point, "clamped") for point in outline], 1 / n, {(0, 0): min(order + n // 2, 10)})
    plate = Plate(mesh, order, scene.data, fixed="clamped", clamped="clamped")
    plate.load += scene.data["pressure"] * plate.v * ng.dx
    w = plate.solve()
    return Outcome({"volume": float(ng.Integrate(w, mesh, order=order + 1))}, plate.dofs, f"{mesh.ne} elements")


def corner_plate(scene: Scene, order: int, n: int) -> Outcome:
    """A quarter, its elements geometrically smaller towards the force and the support."""
    from benchmarks.programs.ngsolve_plate import Plate, corner_mesh

    side, force = scene.data["side"] / 2, scene.data["force"] / 4
    outline = [(0, 0, "mirror"), (side, 0, "free"), (side, side, "free"), (0, side, "mirror")]
    levels = min(order + n // 2, 8)
    mesh = corner_mesh(outline, side / n, {(0, 0): levels, (side, side): levels})
    plate = Plate(mesh, order, scene.data, clamped="mirror")
    centre, edge, corner = (plate.at(point) for point in ((0, 0), (0, side), (side, side)))
    plate.force[centre] = force
    plate.held[corner] = True
    w = plate.solve().vec
    return Outcome({"centre": w[centre], "edge": w[edge]}, plate.dofs, f"{mesh.ne} elements")


def paper_example(scene: Scene, order: int, n: int) -> Outcome:
    """A quarter, its corner held."""
    from benchmarks.programs.ngsolve_shell import Shell, surface_mesh

    d, half = scene.data, scene.data["side"] / 2
    mesh = surface_mesh(lambda x, y, z: (half * x, half * y, 0), (n, n), order, True)
    shell = Shell(mesh, order, d, True, ("right", "top", ""), mirrors="right|top", density=d["density"])
    for axis in range(3):
        shell.hold(shell.at((0, 0, 0), axis))
    points = {"centre": (half, half, 0), "quarter": (half / 2, half / 2, 0), "edge": (half, 0, 0)}
    shell.load[shell.at(points["centre"], 2)] = d["force"] / 4
    seen = {key: (point, 2) for key, point in points.items()}
    return moving(scene, shell, seen, lambda t: 1.0, STEPS[scene.name] * order * n)


def free_ruler(scene: Scene, order: int, n: int) -> Outcome:
    """Half of its width."""
    import ngsolve as ng

    from benchmarks.programs.ngsolve_shell import Shell, surface_mesh

    d = scene.data
    length, width = d["length"], d["width"]
    mesh = surface_mesh(lambda x, y, z: (length * x, width / 2 * y, 0), (n, 1), order, True)
    shell = Shell(mesh, order, d, True, ("", "top", ""), mirrors="top", density=d["density"])
    v = shell.space.TestFunction()[0]
    shell.spread((d["force_x"] * v[0] + d["force_z"] * v[2]) / width * ng.dx(definedon=mesh.BBoundaries("right")))
    ends = {"near": (0, width / 2, 0), "far": (length, width / 2, 0)}
    seen = {f"{end}_{axis}": (point, k) for end, point in ends.items() for axis, k in (("x", 0), ("z", 2))}
    pulse = lambda t: max(0.0, min(t / d["peak"], (d["over"] - t) / (d["over"] - d["peak"])))  # noqa: E731
    return moving(scene, shell, seen, pulse, STEPS[scene.name] * order * n)


def moving(scene: Scene, shell: Any, seen: Any, factor: Callable[[float], float], steps: int) -> Outcome:
    values = shell.move(scene.data["end"], steps, factor, seen, scene.times)
    return Outcome(values, shell.dofs, shell.note)


SOLVE: dict[str, Callable[[Scene, int, int], Outcome]] = {
    "end_shear": end_shear, "roll_up": roll_up, "hemisphere": hemisphere, "hinged_roof": hinged_roof,
    "l_shape": l_shape, "corner_plate": corner_plate,
    "paper_2n": paper_example, "paper_20n": paper_example, "free_ruler": free_ruler,
}  # fmt: skip
PROGRAM = Program("NGSolve", VARIANTS, prepare, version, run, environment="ngsolve")

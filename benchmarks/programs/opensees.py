"""OpenSees (openseespy): the thin element ShellNLDKGQ and the thick element ASDShellQ4.

What ShellNLDKGQ returns depends on the steps of the load: its error is of first order in them. The tangent of ASDShellQ4
does not fit its forces: where membrane forces are large, Newton converges linearly or not at all.
"""

from math import ceil
from typing import Any

from benchmarks.programs.opensees_shell import Shell, flat
from benchmarks.programs.program import Outcome, Program, Variant
from benchmarks.scenes import Scene

# A size is the number of elements along the longer side; here what belongs to it: load steps, the step of the controlled
# deflection (mm), time steps over the scene's time.
LEVELS: dict[str, dict[str, dict[float, float]]] = {
    "thin": {
        "end_shear": {8: 100, 12: 200, 16: 400, 24: 800, 32: 1600},
        "roll_up": {8: 200, 12: 400, 16: 800, 24: 1600, 32: 3200},
        "hinged_roof": {4: 1.0, 6: 0.5, 8: 0.25, 12: 0.1},
        "paper_2n": {4: 25, 6: 35, 8: 50, 12: 70, 16: 100, 20: 140},
        "paper_20n": {4: 25, 6: 35, 8: 50, 12: 70, 16: 100, 20: 140},
        "free_ruler": {6: 200, 8: 400, 12: 800, 16: 1600},
    },
    "thick": {
        "hinged_roof": {4: 5.0, 6: 5.0, 8: 5.0, 12: 5.0, 16: 5.0, 24: 5.0},
        "paper_2n": {4: 35, 6: 50, 8: 70, 12: 100, 16: 140, 20: 200},
        "paper_20n": {4: 35, 6: 50, 8: 70, 12: 100, 16: 140, 20: 200},
        "free_ruler": {8: 70, 12: 110, 16: 150, 24: 250, 32: 350, 48: 560},
    },
}
LINEAR = {"l_shape": (8, 16, 24, 32, 48, 64, 96, 128), "corner_plate": (4, 6, 8, 12, 16, 24, 32, 48)}

VARIANTS = {
    "thin": Variant(
        "OpenSees, DKGQ", "small", {**{name: tuple(levels) for name, levels in LEVELS["thin"].items()}, **LINEAR},
        {"hemisphere": "ShellNLDKGQ stops at 47 % of the load on 8 x 8 elements, with 800 load steps and more"},
    ),
    "thick": Variant(
        "OpenSees, ASDShellQ4", "thick",
        {**{name: tuple(levels) for name, levels in LEVELS["thick"].items()}, **LINEAR,
         "end_shear": (8, 12, 16, 24, 32, 48, 64), "roll_up": (4, 6, 8, 12, 16)},
        {"hemisphere": "its tangent does not fit its forces: Newton stops at 9 % of the load, with 20 load steps or 100; "
         "with artificial damping the state still swings by 0.5 % after 200 steps on 16 x 16 elements"},
    ),
}  # fmt: skip


def prepare() -> None:
    import numpy  # noqa: F401
    import openseespy.opensees as ops

    ops.logFile("/dev/null", "-noEcho")


def version() -> str:
    import openseespy.opensees as ops

    return f"OpenSees {ops.version()}"


def run(scene: Scene, variant: str, size: float) -> Outcome:
    import openseespy.opensees as ops

    ops.wipe()
    return SOLVERS[scene.name](scene, variant, int(size))


def strip(scene: Scene, variant: str, n: int) -> Outcome:
    """Thin: load steps. Thick: a moment in one step; a force with dashpots that come to rest, as Newton stops at 60 %."""
    d, damped = scene.data, variant == "thick" and scene.name == "end_shear"
    tiny = 1e-6
    shell = Shell(flat(n, 1, d["length"], d["width"]), d, variant, density=tiny / d["thickness"] if damped else 0.0)
    shell.fix(shell.tags[0], 1, 1, 1, 1, 1, 1)
    load = (0.0, 0.0, d.get("force", 0.0) / 2, 0.0, -d.get("moment", 0.0) / 2, 0.0)
    shell.load(dict.fromkeys(shell.tags[-1].tolist(), load), "Constant" if damped else "Linear", 1)
    end = shell.tags[-1, 0]
    if damped:
        last = (0.0, 0.0)
        # Dashpots of 0.1 of the force per length and unit of time: the fastest of 0.05 ... 1.
        shell.ops.rayleigh(0.1 * d["force"] / tiny, 0.0, 0.0, 0.0)
        shell.solver(("Newmark", 1.0, 1.0), "Transient", "FixedNumIter", 1)
        now, count = (0.0, 0.0), 0
        while count == 0 or max(abs(a - b) for a, b in zip(now, last, strict=True)) > 1e-5 * d["length"]:
            if count == 100:
                raise RuntimeError("the dashpots still move after 100 steps")
            count, last = count + 1, now
            shell.step(1.0)
            now = (shell.at(end, 1), shell.at(end, 3))
        return shell.outcome({"u": -now[0], "w": now[1]}, f"{count} steps of one iteration")
    steps = int(LEVELS[variant][scene.name][n]) if variant == "thin" else 1
    shell.solver(("LoadControl", 1.0 / steps), "Static", "NormDispIncr", 1e-4, 30, 0)
    iterations = sum(shell.step() for _ in range(steps))
    return shell.outcome({"u": -shell.at(end, 1), "w": shell.at(end, 3)}, f"{steps} steps, {iterations} iterations")


def hinged_roof(scene: Scene, variant: str, n: int) -> Outcome:
    import numpy as np

    d = scene.data
    x, angle = np.linspace(0.0, d["half_length"], n + 1)[:, None], np.linspace(-d["half_angle"], 0.0, n + 1)[None]
    points = np.stack(np.broadcast_arrays(x, d["radius"] * np.sin(angle), d["radius"] * np.cos(angle)), -1)
    shell = Shell(points, d, variant)
    crown = int(shell.tags[-1, -1])
    shell.fix(shell.tags[:-1, 0], 1, 1, 1, 0, 0, 0)
    shell.fix(shell.tags[-1:, 0], 1, 1, 1, 0, 1, 1)
    shell.fix(shell.tags[:-1, -1], 0, 1, 0, 1, 0, 1)
    shell.fix(shell.tags[-1, 1:-1], 1, 0, 0, 0, 1, 1)
    shell.fix(shell.tags[-1:, -1], 1, 1, 0, 1, 1, 1)
    shell.load({crown: (0.0, 0.0, -1.0, 0.0, 0.0, 0.0)})
    largest = LEVELS[variant]["hinged_roof"][n]
    shell.solver(("DisplacementControl", crown, 3, -largest), "Static", "NormDispIncr", 1e-3, 30, 0)
    values, reached, count, iterations = {}, 0.0, 0, 0
    for k in range(len(scene.quantities)):
        way = d[f"deflection_{k}"] - reached
        steps = ceil(way / largest - 1e-9)
        shell.ops.integrator("DisplacementControl", crown, 3, -way / steps)
        iterations += sum(shell.step() for _ in range(steps))
        reached, count = reached + way, count + steps
        values[f"force_{k}"] = 4 * float(shell.ops.getTime())
    return shell.outcome(values, f"{count} steps, {iterations} iterations")


def l_shape(scene: Scene, variant: str, n: int) -> Outcome:
    """Every node carries its share of the load, so that their work is the integral asked for."""
    import numpy as np

    d = scene.data
    points = flat(n, n, 2.0, 2.0) - np.array([1.0, 1.0, 0.0])
    middle = (points[:-1, :-1] + points[1:, 1:]) / 2
    shell = Shell(points, d, variant, linear=True, keep=(middle[..., 0] < 0) | (middle[..., 1] > 0))
    share = np.bincount(shell.elements.ravel(), minlength=points[..., 0].size + 1)[1:]
    shell.fix(shell.tags.ravel()[(share > 0) & (share < 4)], 1, 1, 1, 1, 1, 1)
    free = shell.tags.ravel()[share == 4].tolist()
    cell = (2.0 / n) ** 2
    shell.load(dict.fromkeys(free, (0.0, 0.0, d["pressure"] * cell, 0.0, 0.0, 0.0)))
    linear(shell)
    return shell.outcome({"volume": cell * sum(shell.at(tag, 3) for tag in free)})


def corner_plate(scene: Scene, variant: str, n: int) -> Outcome:
    d, half = scene.data, scene.data["side"] / 2
    shell = Shell(flat(n, n, half, half), d, variant, linear=True)
    tags = shell.tags
    shell.fix(tags[:1, :1], 1, 1, 0, 1, 1, 1)
    shell.fix(tags[0, 1:], 1, 0, 0, 0, 1, 1)
    shell.fix(tags[1:, 0], 0, 1, 0, 1, 0, 1)
    shell.fix(tags[-1:, -1], 0, 0, 1, 0, 0, 0)
    shell.load({int(tags[0, 0]): (0.0, 0.0, d["force"] / 4, 0.0, 0.0, 0.0)})
    linear(shell)
    return shell.outcome({"centre": shell.at(tags[0, 0], 3), "edge": shell.at(tags[0, -1], 3)})


def linear(shell: Shell) -> None:
    shell.solver(("LoadControl", 1.0), "Static", "NormUnbalance", 1.0, 1, 0)
    shell.ops.algorithm("Linear")
    if shell.ops.analyze(1):
        raise RuntimeError("the linear solver failed")


def paper_example(scene: Scene, variant: str, n: int) -> Outcome:
    d, half = scene.data, scene.data["side"] / 2
    shell = Shell(flat(n, n, half, half), d, variant, density=d["density"])
    tags = shell.tags
    centre = int(tags[-1, -1])
    shell.fix(tags[:1, 0], 1, 1, 1, 0, 0, 0)
    shell.fix(tags[-1, :-1], 1, 0, 0, 0, 1, 1)
    shell.fix(tags[:-1, -1], 0, 1, 0, 1, 0, 1)
    shell.fix(tags[-1:, -1], 1, 1, 0, 1, 1, 1)
    shell.load({centre: (0.0, 0.0, d["force"] / 4, 0.0, 0.0, 0.0)}, "Constant", 1)
    # The masses are lumped: at the first moment the force moves the node at the centre alone.
    shell.ops.setNodeAccel(centre, 3, d["force"] / (d["density"] * d["thickness"] * (half / n) ** 2), "-commit")
    points = {"centre": (centre, 3), "quarter": (tags[n // 2, n // 2], 3), "edge": (tags[-1, 0], 3)}
    return moving(scene, shell, int(LEVELS[variant][scene.name][n]), points)


def free_ruler(scene: Scene, variant: str, n: int) -> Outcome:
    d = scene.data
    shell = Shell(flat(n, 1, d["length"], d["width"]), d, variant, density=d["density"])
    load = (d["force_x"] / 2, 0.0, d["force_z"] / 2, 0.0, 0.0, 0.0)
    pulse = ("Path", 1, "-time", 0.0, d["peak"], d["over"], d["end"], "-values", 0.0, 1.0, 0.0, 0.0)
    shell.load(dict.fromkeys(shell.tags[-1].tolist(), load), *pulse)
    near, far = shell.tags[0, 0], shell.tags[-1, 0]
    points = {"near_x": (near, 1), "near_z": (near, 3), "far_x": (far, 1), "far_z": (far, 3)}
    return moving(scene, shell, int(LEVELS[variant][scene.name][n]), points)


def moving(scene: Scene, shell: Shell, steps: int, points: dict[str, tuple[Any, int]]) -> Outcome:
    """Average acceleration over equal steps, and the series between them."""
    import numpy as np

    dt, scale = scene.data["end"] / steps, max(scene.data.get(key, 0.0) for key in ("side", "length"))
    shell.solver(("Newmark", 0.5, 0.25), "Transient", "NormDispIncr", 1e-5 * scale, 25, 0)
    series, iterations = np.zeros((len(points), steps + 1)), 0
    for k in range(1, steps + 1):
        iterations += shell.step(dt)
        series[:, k] = [shell.at(*point) for point in points.values()]
    times = np.linspace(0.0, scene.data["end"], steps + 1)
    values = {key: np.interp(scene.times, times, row).tolist() for key, row in zip(points, series, strict=True)}
    return shell.outcome(values, f"{steps} steps, {iterations} iterations")


SOLVERS = {
    "end_shear": strip, "roll_up": strip, "hinged_roof": hinged_roof, "l_shape": l_shape, "corner_plate": corner_plate,
    "paper_2n": paper_example, "paper_20n": paper_example, "free_ruler": free_ruler,
}  # fmt: skip
PROGRAM = Program("OpenSees", VARIANTS, prepare, version, run, environment="opensees")

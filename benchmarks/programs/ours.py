"""skancf itself: theories, uniform, graded and adaptive meshes, plain Newton."""

from collections.abc import Sequence
from math import log2
from typing import Any

from benchmarks.programs.program import Outcome, Program, Variant
from benchmarks.scenes import Scene

STATIC = ("end_shear", "roll_up", "hemisphere", "hinged_roof", "l_shape", "corner_plate")
DYNAMIC = ("paper_2n", "paper_20n", "free_ruler")

UNIFORM: dict[str, Sequence[float]] = {
    "end_shear": (2, 3, 4, 6, 8, 12, 16),
    "roll_up": (4, 6, 8, 12, 16, 24, 32),
    "hemisphere": (8, 10, 12, 14, 16, 20, 24, 32, 48),
    "hinged_roof": (2, 3, 4, 6, 8, 12, 16),
    "l_shape": (4, 8, 12, 16, 24, 32, 36, 48, 64, 128),
    "corner_plate": (1, 2, 3, 4, 6, 8, 12, 16, 24, 32),
    "paper_2n": (2, 3, 4, 6, 8, 10, 12, 16, 20),
    "paper_20n": (2, 3, 4, 6, 8, 10, 12, 16, 20),
    "free_ruler": (3, 4, 5, 6, 8, 12),
}
# Steps for each size, whose errors are about those of the mesh: an asked accuracy, or a length (s).
STEPS: dict[str, dict[float, dict[str, float]]] = {
    "paper_2n": {
        2: {"rtol": 3e-2}, 3: {"rtol": 2e-2}, 4: {"rtol": 1.2e-2}, 6: {"rtol": 6e-3}, 8: {"rtol": 4e-3},
        10: {"rtol": 2.5e-3}, 12: {"rtol": 1.5e-3}, 16: {"rtol": 7e-4}, 20: {"rtol": 3e-4},
    },
    "paper_20n": {
        2: {"rtol": 3e-2}, 3: {"rtol": 2e-2}, 4: {"rtol": 1.2e-2}, 6: {"rtol": 6e-3}, 8: {"rtol": 4e-3},
        10: {"rtol": 2.5e-3}, 12: {"rtol": 1.5e-3}, 16: {"rtol": 7e-4}, 20: {"rtol": 3e-4},
    },
    "free_ruler": {
        3: {"dt": 1.5e-4}, 4: {"dt": 1e-4}, 5: {"dt": 7e-5}, 6: {"dt": 5e-5}, 8: {"dt": 3e-5}, 12: {"dt": 1.5e-5},
    },
}  # fmt: skip
# No iteration more accurate than the steps; and energy must balance to a thousandth.
NEWTON = 1e-4
# The same for equilibrium, as an energy norm.
RESIDUAL = 1e-4
FIRST = {"roll_up": 0.125, "hemisphere": 0.5}
TOLERANCES = (1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5)
NO_ADAPTIVE_TIME = "meshes that follow a motion do not pay where the plate bends as a whole"
NO_GOAL = "one number is asked of an adaptive run; here several states are"

VARIANTS = {
    "uniform": Variant("skancf, thin", "thin", UNIFORM),
    "graded": Variant(
        "skancf, thin, graded", "thin", {name: UNIFORM[name] for name in STATIC[2:]},
        {**dict.fromkeys(("end_shear", "roll_up", "free_ruler"), "nothing is concentrated"),
         **dict.fromkeys(("paper_2n", "paper_20n"), "waves run everywhere: uniform meshes have the smaller errors")},
    ),
    "adaptive": Variant(
        "skancf, thin, adaptive", "thin", dict.fromkeys(("hemisphere", "l_shape", "corner_plate"), TOLERANCES),
        {**dict.fromkeys(DYNAMIC, NO_ADAPTIVE_TIME), **dict.fromkeys(STATIC[:2], "nothing is concentrated"),
         "hinged_roof": NO_GOAL},
    ),
    "plain": Variant(
        "skancf, thin, plain Newton", "thin", {name: UNIFORM[name] for name in STATIC[:4]},
        {**dict.fromkeys(("l_shape", "corner_plate"), "linear"), **dict.fromkeys(DYNAMIC, "the default there")},
    ),
    "full": Variant("skancf, full", "thick", UNIFORM),
}  # fmt: skip


def prepare() -> None:
    import skancf  # noqa: F401


def version() -> str:
    import skancf
    from skancf.linear import available_backends

    return f"skancf {skancf.__version__}, {available_backends()[0]}"


def run(scene: Scene, variant: str, size: float) -> Outcome:
    from benchmarks.programs.models import model

    theory = "full" if variant == "full" else "kirchhoff"
    built = model(scene)
    if variant == "adaptive":
        return adaptive(built, size)
    system = built.problem.on(graded(built, int(size)) if variant == "graded" else built.uniform(int(size)), theory)
    if scene.times:
        return moving(scene, built, system, STEPS[scene.name][size])
    if built.linear:
        import skancf as sk

        return Outcome(built.values(sk.solve_linear(system)), free(system))
    if scene.name == "hinged_roof":
        return pressed(scene, built, system, variant != "plain")
    return static(scene, built, system, variant != "plain")


def free(system: Any) -> int:
    """Coordinates that are not prescribed."""
    return int((~system.constraints.fixed).sum())


def static(scene: Scene, built: Any, system: Any, mixed: bool) -> Outcome:
    import skancf as sk

    # The first load steps of the others were found by trial, too.
    control = sk.HalveAndGrow(first=FIRST.get(scene.name, 1.0))
    result = sk.solve(system, mixed=mixed, control=control, rtol=RESIDUAL)
    note = f"{len(result.path) - 1} steps, {result.iterations} iterations"
    return Outcome(built.values(result.unwrap()), free(system), note)


def pressed(scene: Scene, built: Any, system: Any, mixed: bool) -> Outcome:
    """The force at one prescribed deflection after the other."""
    import skancf as sk

    state, values, steps, iterations = None, {}, 0, 0
    for k in range(len(scene.quantities)):
        result = sk.solve(system, load_factor=scene.data[f"deflection_{k}"], start=state, mixed=mixed, rtol=RESIDUAL)
        state = result.unwrap()
        steps, iterations = steps + len(result.path) - 1, iterations + result.iterations
        values[f"force_{k}"] = built.values(state)["force"]
    return Outcome(values, free(system), f"{steps} steps, {iterations} iterations")


def moving(scene: Scene, built: Any, system: Any, steps: dict[str, float]) -> Outcome:
    import skancf as sk

    motion = sk.simulate(
        system,
        scene.data["end"],
        **steps,
        newton_rtol=NEWTON,
        outputs=(0.0, *scene.times),
        progress=False,
    ).unwrap()
    values = {key: series[1:] for key, series in built.values(motion).items()}
    return Outcome(values, free(system), f"{len(motion.steps)} steps")


def adaptive(built: Any, rtol: float) -> Outcome:
    import skancf as sk

    result = sk.adapt(built.problem, built.goal, rtol, linear=built.linear, mesh=built.uniform(4))
    return Outcome(built.values(result.solution), free(result.solution.system), f"{len(result.levels)} meshes")


def graded(built: Any, n: int) -> Any:
    """Small at the peaks: as many elements as the uniform mesh, or, at the corner of an opening, a uniform mesh whose
    elements there are quartered again and again."""
    import skancf as sk

    if built.openings:
        mesh = sk.meshes.quadtree(built.uniform(n))
        # As often as makes the corner's error, of order 1.09 in the size there, that of the rest, of order four.
        for _ in range(max(0, round(2.67 * log2(n) - 3.7))):
            size = 0.1 * float(mesh.params().min())
            regions = [sk.meshes.Region(at, (size, size)) for at in built.peaks]
            mesh = sk.meshes.refined_in(mesh, regions, levels=1)
        return mesh
    (x0, x1), (y0, y1) = built.problem.surface.bounds
    regions = [sk.meshes.Region(at, (0.05 * (x1 - x0), 0.05 * (y1 - y0)), 16.0) for at in built.peaks]
    return sk.meshes.graded(built.problem.surface, regions, shape=(n, n), openings=built.openings)


PROGRAM = Program("skancf", VARIANTS, prepare, version, run)

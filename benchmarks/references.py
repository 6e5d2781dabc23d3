"""Computes the reference values of the scenes and stores them with their uncertainty in ``benchmarks/scenes/references``.

    python -m benchmarks.references [NAME ...]

Statics: meshes of halved size, extrapolated; the uncertainty is the distance between two extrapolations.
Dynamics: the finest mesh and steps; the uncertainty is what a coarser mesh and longer steps change, over what halving would
leave of it. About a quarter of an hour for all.
"""

import argparse
import json
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.integrate import solve_bvp

from benchmarks.programs.models import Model, model
from benchmarks.scenes import SCENES
from benchmarks.scenes.stored import FOLDER
from skancf.atomic import replacing

Found = dict[str, Any]


def rod(thin: bool) -> Found:
    """The strip under end shear as a rod; thin: with the energy EA (λ² - 1)² / 8 + EI (λ φ')² / 2 per length, λ the stretch;
    thick: EA (λ - 1)² / 2 + EI φ'² / 2 + k GA γ² / 2.

    The force P is dead: P sin φ acts along the rod, P cos φ across, and M' = -P dx/ds.
    """
    d = SCENES["end_shear"].data
    area, inertia = d["width"] * d["thickness"], d["width"] * d["thickness"] ** 3 / 12
    EA, EI, kGA, P = d["young"] * area, d["young"] * inertia, 5 / 6 * d["young"] / 2 * area, d["force"]

    def state(phi: np.ndarray, moment: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """φ', stretch and shear."""
        if not thin:
            return moment / EI, 1 + P * np.sin(phi) / EA, P * np.cos(phi) / kGA
        stretch = np.ones_like(phi)
        for _ in range(30):  # a contraction by the strain
            bend = moment / (EI * stretch**2)
            stretch = np.sqrt(1 + 2 * (P * np.sin(phi) / stretch - EI * bend**2) / EA)
        return bend, stretch, np.zeros_like(phi)

    def slopes(s: np.ndarray, y: np.ndarray) -> np.ndarray:
        bend, along, across = state(y[0], y[1])
        x = along * np.cos(y[0]) - across * np.sin(y[0])
        z = along * np.sin(y[0]) + across * np.cos(y[0])
        return np.stack([bend, -P * x, x, z])

    def ends(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return np.array([a[0], b[1], a[2], a[3]])

    s = np.linspace(0, d["length"], 101)
    start = np.stack([0.12 * s, P * (d["length"] - s), s, 0.05 * s**2])
    out = solve_bvp(slopes, ends, s, start, tol=1e-10, max_nodes=100_000)
    if not out.success:
        raise RuntimeError(out.message)
    return {"u": float(d["length"] - out.y[2, -1]), "w": float(out.y[3, -1])}


def end_shear() -> Found:
    return {"thin": rod(True), "thick": rod(False), "uncertainty": 1e-8}


def limits(values: list[np.ndarray], order: float | None) -> tuple[np.ndarray, np.ndarray]:
    """Extrapolation of the last of values on meshes of halved size, and what it is uncertain by.

    With a known order: the distance from the extrapolation of the two before. With the order that the last three show
    (Aitken): the distance from an extrapolation with order two.
    """
    a, b, c = values[-3:]
    if order is None:
        last = c + (c - b) ** 2 / ((b - a) - (c - b))
        return last, np.abs(last - (4 * c - b) / 3)
    first, last = (later + (later - sooner) / (2**order - 1) for sooner, later in ((a, b), (b, c)))
    return last, np.abs(last - first)


def on_meshes(name: str, state: Callable[[Model, int], Any], sizes: list[int], order: float | None) -> Found:
    """A static scene on meshes of halved size."""
    scene, rows = SCENES[name], []
    for n in sizes:
        built = model(scene)
        rows.append(state(built, n))
        print(f"  {n:4d}", {k: float(f"{v:.10g}") for k, v in rows[-1].items()}, flush=True)
    keys = list(scene.quantities)
    last, distance = limits([np.array([row[k] for k in keys]) for row in rows], order)
    scales = [scene.quantities[k].scale or abs(v) for k, v in zip(keys, last, strict=True)]
    return {"thin": dict(zip(keys, last.tolist(), strict=True)), "uncertainty": float((distance / scales).max())}


def hemisphere() -> Found:
    import skancf as sk

    def state(built: Model, n: int) -> dict[str, float]:
        return built.values(sk.solve(built.problem.on(built.uniform(n), "kirchhoff"), rtol=1e-9).unwrap())

    # Under a point force the order falls from four towards two as meshes become finer.
    return on_meshes("hemisphere", state, [24, 48, 96], None)


def hinged_roof() -> Found:
    from benchmarks.programs.ours import pressed

    scene = SCENES["hinged_roof"]

    def state(built: Model, n: int) -> dict[str, float]:
        return dict(pressed(scene, built, built.problem.on(built.uniform(n), "kirchhoff"), True).values)

    return on_meshes("hinged_roof", state, [16, 32, 64], None)


def l_shape() -> Found:
    import skancf as sk

    def state(built: Model, n: int) -> dict[str, float]:
        return built.values(sk.solve_linear(built.problem.on(built.uniform(n), "kirchhoff")))

    # The corner: deflections grow with r to the power 1.5445, and the energy is wrong by the square of h to 0.5445.
    return on_meshes("l_shape", state, [32, 64, 128, 256], 2 * 0.544484)


def corner_plate() -> Found:
    """On adaptive meshes, each quantity with its error estimate added; ten times as thick, with the same bending stiffness,
    which a linear thin plate does not notice, but rounding does."""
    import skancf as sk

    scene = SCENES["corner_plate"]
    thicker = {"thickness": 10 * scene.data["thickness"], "young": scene.data["young"] / 1000}
    built = model(replace(scene, data={**scene.data, **thicker}))
    values, doubts = {}, []
    for key, at in (("centre", (0.0, 0.0)), ("edge", (0.0, scene.data["side"] / 2))):
        result = sk.adapt(built.problem, sk.Displacement(at), 1e-6, mesh=built.uniform(4), linear=True)
        values[key] = float(result.corrected)
        doubts.append(abs(result.error_bar / result.corrected))
        print(f"  {key} {values[key]:.10g} +- {doubts[-1]:.1e}", flush=True)
    return {"thin": values, "uncertainty": float(max(doubts))}


def motion(name: str, mesh: int, rtol: float) -> dict[str, list[float]]:
    import skancf as sk

    scene = SCENES[name]
    built = model(scene)
    system = built.problem.on(built.uniform(mesh), "kirchhoff")
    began = time.perf_counter()
    run = sk.simulate(system, scene.data["end"], rtol=rtol, outputs=(0.0, *scene.times), progress=False).unwrap()
    print(f"  {mesh} elements, steps to {rtol:g}: {len(run.steps)} steps, {time.perf_counter() - began:.0f} s", flush=True)
    return {key: series[1:] for key, series in built.values(run).items()}


def moving(name: str, mesh: int, rtol: float) -> Found:
    """A run, and the sum of what its mesh and its steps leave, from runs on a mesh coarser by 1.5 and with steps' errors
    larger by 3: both are of order two, so that they change 1.25 and 2 times as much."""
    scene, best = SCENES[name], motion(name, mesh, rtol)
    others = motion(name, round(mesh / 1.5), 3 * rtol), motion(name, mesh, 3 * rtol)
    stepped, meshed = distance(scene, best, others[1]) / 2, distance(scene, others[1], others[0]) / 1.25
    print(f"  mesh {meshed:.1e}, steps {stepped:.1e}")
    return {"times": list(scene.times), "thin": best, "uncertainty": meshed + stepped}


def distance(scene: Any, a: dict[str, list[float]], b: dict[str, list[float]]) -> float:
    """The error of b if a were the reference."""
    return max(replace(q, reference={"thin": a[key]}).error(b[key], "thin") for key, q in scene.quantities.items())


REFERENCES: dict[str, Callable[[], Found]] = {
    "end_shear": end_shear,
    "hemisphere": hemisphere,
    "hinged_roof": hinged_roof,
    "l_shape": l_shape,
    "corner_plate": corner_plate,
    "paper_2n": lambda: moving("paper_2n", 24, 1e-4),
    "paper_20n": lambda: moving("paper_20n", 20, 6e-4),
    "free_ruler": lambda: moving("free_ruler", 24, 2.5e-4),
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", choices=[[], *REFERENCES])
    for name in parser.parse_args().names or REFERENCES:
        print(name, flush=True)
        found = REFERENCES[name]()
        with replacing(FOLDER / f"{name}.json") as part:
            part.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()

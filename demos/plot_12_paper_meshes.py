r"""
The paper's plate: strips, trees, and goals
===========================================

*Builds on:* the paper's example and the plate on its four corners. *Shows:* what three ways to refine are worth in large
deflections, with error bars, and what is said of a number that has no limit.

The plate of the paper's example, 1 m x 1 m x 0.05 m with E = 0.2 MPa and :math:`\nu = 0`, hangs by its four corner nodes and
carries 20 N at its centre, here at rest. Three points are watched: the loaded centre, the middle between centre and corner,
and the middle of an edge. The meshes are

- *uniform*,
- *strips*: geometric progressions in x and y with as many nodes, fine where the stress of the uniform mesh is (*Research on
  local mesh refine method based on absolute nodal coordinate formulation*),
- *tree*: the same regions of stress, in which elements of the uniform mesh are quartered,
- *goal*: the loop of ``sk.adapt``, which knows the wanted displacement.

In theory `kirchhoff` the deflection under the force has a limit. What hangs by single nodes stretches there without bound:
the force P through an arc of radius r asks for a nominal stress :math:`P / (h r)`, which in the law at hand grows with the
third power of the stretch, so that

.. math:: \lambda \sim r^{-1/3}, \qquad u \sim r^{2/3} .

Displacements have a limit, but on meshes whose elements at the corners have size h they are wrong by :math:`O(h^{2/3})`. That
power is the number to hit. In theory `full` the force and the supports sink in with the logarithm of the element size, and
the loop says so.
"""

# %%
# The plate
# ---------
import argparse
import os
import warnings
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import skancf as sk
from skancf import output

SURFACE = sk.Rectangle(1.0, 1.0)
PLATE = sk.Problem(
    SURFACE, thickness=0.05,
    material=sk.Isotropic(young=0.2e6, poisson=0.0, density=2000.0, kind="3d", shear_correction=1.0),
    supports=[sk.Pin("corners")], loads=[sk.PointForce(at=(0.5, 0.5), force=(0.0, 0.0, -20.0))],
)  # fmt: skip
POINTS = {"centre": (0.5, 0.5), "quarter": (0.25, 0.25), "edge": (0.5, 0.0)}
WANTED = {name: sk.Displacement(at=at) for name, at in POINTS.items()}


# %%
# The power of the corners
# ------------------------
# Meshes whose elements at the corners are quartered again and again. What each one changes falls by :math:`2^{-2/3}`.


def corner_power(times: int) -> float:
    """The power of the element size at the corners with which deflections change."""
    mesh, half, values = sk.meshes.quadtree(sk.meshes.uniform(SURFACE, 8, 8)), 0.125, []
    for _ in range(times):
        values.append(WANTED["quarter"].value(sk.solve(PLATE.on(mesh, "kirchhoff")).unwrap()))
        half /= 2
        corners = [sk.meshes.Region((x, y), (half, half), ratio=2.0) for x in (0.0, 1.0) for y in (0.0, 1.0)]
        mesh = sk.meshes.refined_in(mesh, corners, levels=1)
    changes = np.abs(np.diff(values))
    return float(np.log2(changes[-2] / changes[-1]))


# %%
# Three kinds of meshes from one stress
# -------------------------------------
# As in the paper the stress is that on the neutral surface.


def from_stress(n: int) -> dict[str, sk.Solution]:
    """Answers on a uniform mesh of n x n elements, on strips with as many nodes, and on a tree."""
    uniform = sk.meshes.uniform(SURFACE, n, n)
    out = {"uniform": sk.solve(PLATE.on(sk.meshes.quadtree(uniform), "kirchhoff")).unwrap()}
    regions = sk.stress_regions(out["uniform"])
    strips = sk.meshes.quadtree(sk.meshes.graded(SURFACE, regions, nodes=uniform.p.shape[1]))
    for name, mesh in {"strips": strips, "tree": sk.meshes.refined_in(uniform, regions)}.items():
        out[name] = sk.solve(PLATE.on(mesh, "kirchhoff")).unwrap()
    return out


# %%
# Each number comes with the estimate of its error, (3, n): nodes, values, estimates.


def estimates(states: list[sk.Solution], point: str) -> np.ndarray:
    """Of meshes of any kind."""
    found = [sk.goal_estimate(state, WANTED[point]) for state in states]
    return np.array([(state.system.n_dofs / 12, e.value, e.error) for state, e in zip(states, found, strict=True)]).T


def levels(result: sk.AdaptiveResult) -> np.ndarray:
    """Of the loop."""
    kept = [level for level in result.levels if not level.rejected]
    return np.array([(level.n_dofs / 12, level.value, level.error) for level in kept]).T


# %%
# Theory `full`
# -------------


def in_theory_full(max_dofs: int) -> None:
    """Prints what the loop says there of the loaded point, and of one away from it."""
    try:
        sk.adapt(PLATE, WANTED["centre"], theory="full")
    except sk.NoLimit as why:
        print(f"centre: {why}")
    else:
        raise AssertionError("a deflection without a limit was computed")
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        result = sk.adapt(PLATE, WANTED["quarter"], theory="full", max_dofs=max_dofs)
    drifts = [str(warning.message) for warning in said if "drifts" in str(warning.message)]
    print(f"quarter: {result}\n{result.table()}\n{result.message}\nWarning: {drifts[0]}")


# %%
# Pictures
# --------


def draw(tables: dict, truths: dict, meshes: dict, state: sk.Solution, folder: Path) -> None:
    """Meshes, errors and estimates, and the plate."""
    output.mesh_levels(
        list(meshes.values()), folder / "paper_meshes.png", surface=SURFACE,
        titles=[f"{name}: {mesh.p.shape[1]} nodes" for name, mesh in meshes.items()],
    )  # fmt: skip
    ratios = {}
    for point, kinds in tables.items():
        curves = {}
        for name, (nodes, values, error) in kinds.items():
            true = truths[point].corrected - values
            seen = np.abs(true) > 3 * truths[point].error_bar
            curves[name] = nodes[seen], np.abs(true[seen] / truths[point].corrected)
            if name in ("uniform", "strips", "tree"):
                ratios[f"{point}, {name}"] = nodes[seen], error[seen] / true[seen]
        output.convergence(curves, folder / f"paper_{point}.png", xlabel="nodes", title=f"Deflection, {point}")
    output.effectivity(ratios, folder / "paper_estimates.png", xlabel="nodes", title="Is the error bar right?")
    output.picture(state, folder / "paper_deformed.png", field="u3", title="20 N at the centre, true to scale")
    _, axes = plt.subplot_mosaic(
        [["meshes"] * 3, ["centre", "quarter", "edge"], ["estimates", "deformed", "deformed"]],
        figsize=(15, 14), layout="constrained",
    )  # fmt: skip
    for name, axis in axes.items():
        axis.imshow(plt.imread(folder / f"paper_{name}.png"))
        axis.set_axis_off()


# %%
# The run
# -------


def error_with(table: np.ndarray, truth: float, nodes: float) -> float:
    """Relative error of a kind of meshes with some number of nodes, between its meshes on a log-log scale."""
    errors = np.abs(1 - table[1] / truth)
    inside = table[0].min() <= nodes <= table[0].max()
    return float(np.exp(np.interp(np.log(nodes), np.log(table[0]), np.log(errors)))) if inside else np.nan


def compare(tables: dict, truths: dict, nodes: int) -> dict[str, dict[str, float]]:
    """Prints relative errors with equal numbers of nodes, and returns them by point and kind of mesh."""
    errors = {
        point: {name: error_with(table, truths[point].corrected, nodes) for name, table in kinds.items()}
        for point, kinds in tables.items()
    }
    print(f"\nRelative errors with {nodes} nodes, in %\n{'point':<10}" + "".join(f"{name:>10}" for name in errors["centre"]))
    for point, row in errors.items():
        print(f"{point:<10}" + "".join(f"{100 * error:>10.3f}" for error in row.values()))
    return errors


def main(size: str = "full", out: str = "out") -> dict[str, dict[str, float]]:
    """Print the comparison, save pictures; returns relative errors by point and kind of mesh."""
    counts, rtol, max_dofs, nodes, times = {
        "full": ((6, 8, 12, 16, 20), 1e-3, 12_000, 169, 9), "small": ((6, 8, 12), 2e-3, 4_000, 120, 7),
    }[size]  # fmt: skip
    folder = Path(out)
    output.check_folder(folder)
    power = corner_power(times)
    print(f"power of the element size at the corners: {power:.4f}, by the argument above 2/3\n")
    states = [from_stress(n) for n in counts]
    tables, truths = {}, {}
    for point in POINTS:
        truths[point] = sk.adapt(PLATE, WANTED[point], rtol, max_dofs=max_dofs)
        kinds = {name: estimates([found[name] for found in states], point) for name in states[0]}
        tables[point] = {**kinds, "goal": levels(truths[point])}
        print(f"{point}: {truths[point]}\n{truths[point].table()}\n")
    errors = compare(tables, truths, nodes)
    print("\nTheory full")
    in_theory_full(max_dofs // 2)
    meshes = {name: state.system.mesh for name, state in states[2].items()}
    meshes["goal"] = min(truths["centre"].levels, key=lambda level: abs(level.mesh.p.shape[1] - nodes)).mesh
    draw(tables, truths, meshes, truths["centre"].solution, folder)

    assert abs(power - 2 / 3) < 0.05, power
    return errors


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="The paper's plate, refined in three ways")
    parser.add_argument("--size", choices=["full", "small"], default=os.environ.get("SKANCF_DEMO_SIZE", "full"))
    parser.add_argument("--out", default=os.environ.get("SKANCF_DEMO_OUT", "out"))
    arguments, _ = parser.parse_known_args()
    main(arguments.size, arguments.out)

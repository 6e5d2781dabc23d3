r"""
A quarter annulus, refined at an angle
======================================

.. image:: /pictures/gallery/03_annulus.jpg
   :alt: A quarter of a flat ring, pushed inwards at 45 degrees, on a mesh that is fine there.
   :class: example-picture

A quarter of a flat ring, clamped at both of its straight ends, is pushed inwards, and a little upwards, by a force on its
outer edge at 45 degrees. The parameters of the surface are the radius and the central angle: the mesh is a rectangle in
them, and grading it makes the angles of its elements a geometric progression, :math:`\alpha_n = \alpha_0 q^n`.

This example shows a curved mesh, refined by geometric progression in its central angles. It builds on the paper's
example.
"""

# %%
import argparse
import os
from math import pi
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import skancf as sk
from skancf import output

# sphinx_gallery_thumbnail_path = "pictures/gallery/03_annulus.jpg"

RING = sk.AnnulusSector(inner=1.0, outer=2.0, angle=pi / 2)
LOAD = (2.0, pi / 4)
PLATE = sk.Problem(
    surface=RING,
    thickness=0.05,
    material=sk.Isotropic(young=1e6, poisson=0.3, density=1.0),
    supports=[sk.Clamp("start"), sk.Clamp("end")],
    loads=[sk.PointForce(LOAD, (-20.0, -20.0, 2.0))],
)


# %%
# Stress on a uniform mesh, the regions it leads to, and the graded mesh with as many nodes.
def main(size: str = "full", out: str = "out") -> dict:
    """Solve on a uniform, a graded and a fine mesh; returns the deflections under the load."""
    folder = Path(out)
    output.check_folder(folder)
    nr, na, finer = {"full": (6, 12, 4), "small": (4, 8, 3)}[size]
    uniform = sk.meshes.uniform(RING, nr, na)
    state = sk.solve(PLATE.on(uniform)).unwrap()
    regions = [r for r in sk.stress_regions(state) if np.allclose(r.centre, LOAD)]
    assert regions, "no stress concentration was found at the load"
    graded = sk.meshes.graded(RING, regions, shape=(nr, na))
    meshes = {"uniform": uniform, "graded": graded, "fine": sk.meshes.uniform(RING, finer * nr, finer * na)}
    solutions = {name: sk.solve(PLATE.on(mesh)).unwrap() for name, mesh in meshes.items()}
    deflections = {name: float(np.linalg.norm(s.displacement(LOAD))) for name, s in solutions.items()}
    for name, value in deflections.items():
        print(f"{name:<8} {meshes[name].p.shape[1]:>5} nodes   |u| under the load = {1e3 * value:.3f} mm")
    angles = np.degrees(np.diff(np.unique(np.round(graded.p[1], 12))))
    print("central angles of the graded mesh (degrees):", np.array2string(angles, precision=2))
    output.mesh_chart(graded, folder / "annulus_mesh.png", RING, regions=regions, points={"load": LOAD}, title="Graded mesh")
    output.picture(solutions["graded"], folder / "annulus_deformed.png", field="mises", z=0.025, title="Quarter annulus")
    _, axes = plt.subplots(1, 2, figsize=(12, 5), layout="constrained")
    for axis, picture in zip(axes, ("annulus_mesh", "annulus_deformed"), strict=True):
        axis.imshow(plt.imread(folder / f"{picture}.png"))
        axis.set_axis_off()
    # The numbers to hit: the angles fill the quarter, are finest at the load, and the deflection is that of the fine mesh to
    # what these meshes are worth.
    assert abs(angles.sum() - 90) < 1e-9
    assert angles[na // 2] < 0.85 * 90 / na < angles[0]
    assert abs(deflections["graded"] / deflections["fine"] - 1) < 0.1
    return deflections


# %%
# The deflection under the load is hardly nearer to that of the fine mesh, or not at all: what the finer angles gain there,
# the coarser ones at the clamped ends lose.


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="A quarter annulus, refined at an angle")
    parser.add_argument("--size", choices=["full", "small"], default=os.environ.get("SKANCF_DEMO_SIZE", "full"))
    parser.add_argument("--out", default=os.environ.get("SKANCF_DEMO_OUT", "out"))
    arguments, _ = parser.parse_known_args()
    main(arguments.size, arguments.out)

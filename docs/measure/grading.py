"""What a product of two rows of nodes costs: the table of docs/theory/refinement.rst.

From the folder of the repository, in ten seconds:

    .venv/bin/python docs/measure/grading.py

It writes docs/theory/grading.csv.
"""

import csv
from pathlib import Path

import numpy as np
import skfem

import skancf as sk

TABLE = Path(__file__).resolve().parent.parent / "theory" / "grading.csv"


def row(name: str, mesh: skfem.MeshQuad, regions: sk.meshes.Regions) -> list[object]:
    corner = mesh.p[:, mesh.t]
    lengths, centres = np.ptp(corner, axis=1), corner.mean(axis=1)
    inside = np.zeros(mesh.nelements, bool)
    for region in regions:
        offset = np.abs(centres - np.array(region.centre)[:, None])
        inside |= (offset < np.array(region.half_size)[:, None]).all(axis=0)
    ratio = max(np.exp(np.abs(np.diff(np.log(np.diff(np.unique(x))))).max()) for x in np.round(mesh.p, 9))
    return [name, mesh.nvertices, f"{lengths.min():.4f}", f"{lengths.max():.4f}", f"{ratio:.2f}",
            f"{(lengths.max(axis=0) / lengths.min(axis=0)).max():.1f}", f"{100 * inside.mean():.0f} %"]  # fmt: skip


def main() -> None:
    plate = sk.Problem(
        sk.Rectangle(1.0, 1.0), 0.05, sk.Isotropic(0.2e6, 0.0, 2000.0),
        [sk.Pin("corners")], [sk.PointForce((0.5, 0.5), (0.0, 0.0, -20.0))],
    )  # fmt: skip
    uniform = sk.meshes.uniform(plate.surface, 12, 12)
    motion = sk.simulate(plate.on(uniform), 0.1, progress=False).unwrap()
    regions = sk.stress_regions(motion.at(0.1))
    strongest = sk.meshes.Regions([max(regions, key=lambda r: r.ratio)], regions.cell)
    rows = [
        row("uniform 12 x 12", uniform, regions),
        row("graded, 9 regions, nodes=169", sk.meshes.graded(plate.surface, regions, nodes=169), regions),
        row("graded, 9 regions, l_0 kept", sk.meshes.graded(plate.surface, regions), regions),
        row("graded, strongest region, l_0 kept", sk.meshes.graded(plate.surface, strongest), strongest),
    ]
    head = ["mesh", "nodes", "smallest (m)", "largest (m)", "largest q", "slenderness", "elements inside regions"]
    with TABLE.open("w", newline="", encoding="utf-8") as stream:
        csv.writer(stream, lineterminator="\n").writerows([head, *rows])
    print(head, *rows, sep="\n")


if __name__ == "__main__":
    main()

"""A plate with a round hole, made by gmsh and recombined into quadrilaterals with named edges.

Writes docs/tutorials/files/hole.msh, which the page "Meshes, tables and other programs" and tests read. With ``errors`` it
makes finer ones too, and says how far the stress at the hole is from Howland's 3.13 of the stress far away:

    .venv/bin/python docs/measure/hole.py
    .venv/bin/python docs/measure/hole.py errors
"""

import sys
import tempfile
from pathlib import Path

FILE = Path(__file__).resolve().parent.parent / "tutorials" / "files" / "hole.msh"
LENGTH, WIDTH, RADIUS = 2.0, 1.0, 0.1
HOWLAND = 3.133
"""Largest stress over that far away, for a hole of a fifth of the width (Howland 1930)."""


def make(path: Path, at_hole: float = 0.03, away: float = 0.2) -> None:
    """Elements of these sizes; the hole becomes a polygon."""
    import gmsh

    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    geometry = gmsh.model.occ
    middle = LENGTH / 2, WIDTH / 2, 0
    plate = geometry.addRectangle(0, 0, 0, LENGTH, WIDTH)
    disk = geometry.addDisk(*middle, RADIUS, RADIUS)
    geometry.cut([(2, plate)], [(2, disk)])
    geometry.synchronize()

    # The names of edges, and of the plate.
    for _, curve in gmsh.model.getEntities(1):
        x, y, _ = geometry.getCenterOfMass(1, curve)
        sides = {"left": x, "right": LENGTH - x, "bottom": y, "top": WIDTH - y}
        on = [name for name, distance in sides.items() if abs(distance) < 1e-6]
        gmsh.model.addPhysicalGroup(1, [curve], name=on[0] if on else "hole")
    gmsh.model.addPhysicalGroup(2, [plate], name="plate")

    # Small elements at the hole.
    ball = gmsh.model.mesh.field.add("Ball")
    sizes = {"XCenter": middle[0], "YCenter": middle[1], "Radius": 1.2 * RADIUS,
             "Thickness": 0.4, "VIn": at_hole, "VOut": away}  # fmt: skip
    for name, value in sizes.items():
        gmsh.model.mesh.field.setNumber(ball, name, value)
    gmsh.model.mesh.field.setAsBackgroundMesh(ball)
    gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 0)
    gmsh.option.setNumber("Mesh.MeshSizeFromPoints", 0)

    # Quadrilaterals only.
    gmsh.option.setNumber("Mesh.Algorithm", 8)
    gmsh.option.setNumber("Mesh.RecombineAll", 1)
    gmsh.option.setNumber("Mesh.RecombinationAlgorithm", 2)
    gmsh.model.mesh.generate(2)
    path.parent.mkdir(parents=True, exist_ok=True)
    gmsh.write(str(path))
    gmsh.finalize()


def largest(path: Path) -> tuple[int, float]:
    """Elements, and the largest stress at nodes over that far away, in theory `full`."""
    import skancf as sk

    mesh = sk.meshes.from_file(path)
    plate = sk.Problem(
        sk.Rectangle(LENGTH, WIDTH), 0.01, sk.Isotropic(70e9, 0.33, 2700.0),
        supports=[sk.Roller("left", (1, 0, 0)), sk.Roller("boundary", (0, 0, 1)), sk.Roller([(0.0, 0.0)], (0, 1, 0))],
        loads=[sk.EdgeLoad("right", (1e4, 0, 0))],
    )  # fmt: skip
    solution = sk.solve_linear(plate.on(mesh, theory="full"))
    return mesh.nelements, float(solution.nodal_section_forces()[:, 0].max() / 1e4)


def main() -> None:
    make(FILE)
    print(f"{FILE.name}: {FILE.stat().st_size} bytes")
    if "errors" not in sys.argv:
        return
    with tempfile.TemporaryDirectory() as folder:
        for size in (0.06, 0.03, 0.015, 0.0075):
            path = Path(folder) / "hole.msh"
            make(path, size)
            elements, factor = largest(path)
            print(f"size {size}: {elements} elements, {factor:.3f} ({factor / HOWLAND - 1:+.1%})")


if __name__ == "__main__":
    main()

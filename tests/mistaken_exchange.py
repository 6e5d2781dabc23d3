"""Valid calls of what reads and writes files of other programs, and of loads from tables: see ``tests.mistakes``."""

from typing import Any

import numpy as np

import skancf as sk


def add_exchange(add: Any, s: Any) -> None:
    add_files(add, s)
    add_tables(add)


def add_files(add: Any, s: Any) -> None:
    m, named = sk.meshes, s.plain.with_subdomains({"patch": lambda x: x[0] < 0.5})
    mesh_file = m.to_file(named, s.folder / "mesh.msh")
    file = {"path": "file"}
    add("to_file", m.to_file, mesh=named, path=s.folder / "written.msh", aliases=file)
    add("from_file", m.from_file, path=mesh_file)
    add("within", m.within, mesh=named, name="patch")
    add("calculix", sk.export.calculix, system=s.system, path=s.folder / "deck.inp", nonlinear=True, refine=0,
        element="C3D20R", increment=0.1, aliases=file)  # fmt: skip
    deck = sk.export.calculix(s.system, s.folder / "kept.inp")
    x, y, _ = deck.bricks.points.T
    rows = "".join(f" {k} 0.0 0.0 {value:.6E}\n" for k, value in enumerate(x * y, 1))
    answers = s.folder / "kept.dat"
    answers.write_text(f" displacements (vx,vy,vz) for set NALL and time  0.1000000E+01\n\n{rows}")
    add("read_calculix", sk.export.read_calculix, path=answers)
    add("CalculixDeck.result", deck.result, path=answers, takes="path:none")
    add("CalculixResult.displacement", deck.result().displacement, at=(0.25, 0.5), aliases={"at": "point"})
    add("CalculixResult.difference", deck.result().difference, solution=s.solution)


def add_tables(add: Any) -> None:
    table = {"x": [0.25, 0.75, 0.25], "y": [0.5, 0.5, 0.75], "fz": [1.0, 2.0, 3.0], "mx": [0.0, 1.0, 0.0]}
    titles = {"titles": "mapping"}
    add("point_forces", sk.loads.point_forces, table=table, titles={"fz": "fz"}, history=sk.Ramp(1.0), kinds={
        **titles, "table": "any", "history": "function"})  # fmt: skip
    add("sampled", sk.loads.sampled, table=table, values="fz", titles={"x": "x"}, kinds={**titles, "table": "any"},
        aliases={"values": "table"})  # fmt: skip
    field = sk.loads.sampled(table, ("fz", "mx", "fz2"), titles={"fz2": "fz"})
    add("Sampled()", field, x=np.array([0.3]), y=np.array([0.55]), aliases={"x": "samples", "y": "samples"})
    add("Table.of", sk.Table.of, table={"time": [0.0, 1.0], "factor": [0.0, 1.0]}, time="time", value="factor",
        kind="linear", kinds={"table": "any"}, aliases={"time": "table", "value": "table"})  # fmt: skip

"""What supports hold depends neither on the unit of length nor on that of a parameter."""

from math import pi

import numpy as np
import pytest
from fuzz.case import Case, Mesh
from fuzz.transforms import in_frame, in_units

import skancf as sk
from skancf.system.rigid import free_rigid_motions

MATERIAL = sk.Isotropic(2e9, 0.25, 1200.0)
EVEN = Mesh((0.0, 0.5, 1.0), (0.0, 0.25, 0.6, 1.0))
AROUND = Mesh((0.0, 0.4, 1.0), tuple(k / 6 for k in range(7)))
LENGTHS = [1e-6, 1e3, 1e6]
theories = pytest.mark.parametrize("theory", ["kirchhoff", "full"])

CASES = {
    "point of a sector": (
        sk.AnnulusSector(0.4, 0.8, 2.0), EVEN, [sk.Clamp((0.6, 0.0)), sk.Spring((0.8, 2.0), (0.0, 30.0, 500.0))],
    ),
    "point of a cone": (sk.Cone(0.8, 0.3, 1.0, 1.2), EVEN, [sk.Clamp((0.5, 0.72))]),
    "point of a sphere": (sk.SphereSector(1.3, (0.5, 1.4), 0.9), EVEN, [sk.Clamp((0.95, 0.0)), sk.Roller((1.4, 0.9))]),
    "pole and point of a disc": (
        sk.AnnulusSector(0.0, 1.0, 2 * pi, closed=True), AROUND, [sk.NoRotation((0.4, pi)), sk.Pin((0.4, pi / 3)),
                                                                  sk.Clamp((0.0, 0.0))],
    ),
    "skew edges": (
        sk.Parallelogram(1.0, 0.6, 1.0), EVEN,
        [sk.Roller("bottom", (0.6, 0.0, 0.8)), sk.Clamp("left"), sk.NoRotation((0.5, 0.6))],
    ),
    "moved edge": (
        sk.CylinderSector(0.5, 1.0, 1.5), EVEN,
        [sk.Clamp("left"), sk.Prescribed("right", (1e-4, None, 2e-4), rotation=(0.0, 1e-3, 2e-3))],
    ),
}  # fmt: skip


def case(name, theory):
    surface, mesh, supports = CASES[name]
    return Case(sk.Problem(surface, 0.02, MATERIAL, supports, [sk.SurfaceLoad((200.0, 300.0, -500.0))]), mesh, theory)


@pytest.mark.filterwarnings("ignore::skancf.OutOfDepth")
@theories
@pytest.mark.parametrize("name", CASES)
def test_the_same_in_every_unit_of_length(name, theory):
    here = sk.solve_linear(case(name, theory).system())
    size = np.abs(here.displacements).max()
    for length in LENGTHS:
        there = sk.solve_linear(in_units(case(name, theory), length, 1.0).system())
        assert there.system.constraints.n_free == here.system.constraints.n_free
        # Rounding of thin bending, 1e-16 (L / h)^2, with digits in hand.
        assert np.abs(there.displacements / length - here.displacements).max() < 1e-9 * size


@pytest.mark.filterwarnings("ignore::skancf.OutOfDepth")
@theories
def test_a_tube_clamped_at_a_point_answers_the_same_in_every_frame(theory):
    """Where it lies along an axis of space a coordinate is held nearly alone, with 1e-3 of another one that counts."""
    tube = sk.CylinderSector(900.0, 1500.0, 2 * pi, closed=True)
    supports, loads = [sk.Clamp((1500.0, 0.0))], [sk.PointForce((0.0, pi), (300.0, -200.0, 500.0))]
    here = Case(sk.Problem(tube, 300.0, sk.Isotropic(300.0, 0.3, 1e-9), supports, loads), AROUND, theory)
    turn = np.linalg.qr([[0.9, 0.8, 0.3], [-0.3, 1.0, 0.6], [0.2, 0.3, 1.0]])[0]
    there = in_frame(here, turn, np.array([2e3, -5e2, 0.0]))
    one, two = (sk.solve_linear(case.system()).displacements for case in (here, there))
    assert np.abs(turn.T @ two - one).max() < 1e-9 * np.abs(one).max()


def barrel(unit):
    """One strip of a barrel, whose second parameter counts in a unit of its own."""

    def position(x, y):
        return 0.7 * x, 0.5 * y / unit, 0.2 * x * (1 - x) * (1.5 - (y / unit) ** 2)

    return sk.MappedSurface(position, ((0.0, 1.0), (0.0, unit)))


def askew(unit):
    """Most of the elements are no rectangles."""
    mesh = sk.meshes.uniform(barrel(1.0), 3, 2)
    x, y = mesh.p
    points = np.stack([x + 0.3 * y * x * (1 - x), unit * (y + 0.6 * y * (1 - y) * x)])
    return type(mesh)(points, mesh.t).with_boundaries(mesh.boundaries)


@pytest.mark.filterwarnings("ignore::skancf.OutOfDepth")
@pytest.mark.parametrize("theory, make_mesh", [
    ("kirchhoff", lambda unit: sk.meshes.uniform(barrel(unit), 2, 2)), ("full", askew),
], ids=["kirchhoff", "full, askew"])  # fmt: skip
def test_the_same_in_every_unit_of_a_parameter(theory, make_mesh):
    found = []
    for unit in (1.0, 1e-3, 1e4, 1e8):
        mesh = make_mesh(unit)
        place = tuple(mesh.p[:, -1].tolist())
        supports = [sk.Clamp(place), sk.Roller("bottom", (0.6, 0.0, 0.8)), sk.Pin(["left", "bottom"])]
        problem = sk.Problem(barrel(unit), 0.02, MATERIAL, supports, [sk.SurfaceLoad((0.0, 200.0, -500.0))])
        found.append(sk.solve_linear(problem.on(mesh, theory)))
    for one in found[1:]:
        assert one.system.constraints.n_free == found[0].system.constraints.n_free
        gap = np.abs(one.displacements - found[0].displacements).max()
        # Derivatives of this surface are differences, right to some 1e-11.
        assert gap < 1e-8 * np.abs(found[0].displacements).max()


@theories
@pytest.mark.parametrize("length", [1e-6, 1.0, 1e9])
def test_what_is_free_and_what_contradicts_is_said_in_every_unit(length, theory):
    surface, thickness = sk.CylinderSector(0.5 * length, length, 1.5), 0.02 * length
    mesh = sk.meshes.uniform(surface, 2, 2)

    def system(*supports):
        return sk.Problem(surface, thickness, MATERIAL, supports).on(mesh, theory)

    assert free_rigid_motions(system(sk.Clamp((0.5 * length, 0.75)))) == []
    assert len(free_rigid_motions(system(sk.Pin((0.5 * length, 0.75))))) == 3
    assert len(free_rigid_motions(system(sk.Pin([(0.0, 0.0), (length, 0.0)])))) == 1
    moved = sk.Prescribed("left", (length, 0.0, 0.0), rotation=(0.0, 1e-3, 0.0))
    system(moved, sk.Prescribed("left", rotation=(0.0, 1e-3, 0.0)))
    with pytest.raises(sk.InputError, match="different values"):
        system(moved, sk.Prescribed("left", rotation=(0.0, 1.001e-3, 0.0)))


@pytest.mark.parametrize("length", [1.0, 1e8])
def test_a_point_that_is_no_node_is_none_in_every_unit(length):
    surface = sk.CylinderSector(length, 2 * length, 1.0)
    mesh = sk.meshes.uniform(surface, 2, 4)
    with pytest.raises(sk.InputError, match="no node of the mesh is there"):
        sk.Problem(surface, 0.01 * length, MATERIAL, [sk.Pin((length, 0.6))]).on(mesh)
    assert sk.Problem(surface, 0.01 * length, MATERIAL, [sk.Pin((length, 0.75))]).on(mesh).constraints.fixed.sum() == 3


def test_a_slanting_roller_leaves_a_thin_plate_its_digits():
    """A flat plate that is moved by its edges bends in proportion to what they move, however thin it is."""
    found, surface = [], sk.AnnulusSector(0.4, 1.0, 1.1)
    for h in (1e-2, 1e-6):
        supports = [
            sk.Clamp("outer"), sk.Roller("inner", (1.0, 2.0, -0.4)), sk.Prescribed("inner", (None, None, h)),
            sk.Roller("start", (-0.2, 1.0, 0.0)),
        ]  # fmt: skip
        system = sk.Problem(surface, h, MATERIAL, supports).on(sk.meshes.uniform(surface, 2, 3), "kirchhoff")
        found.append(sk.solve_linear(system).displacements[2] / h)
    # A frame that mixes bending with the membrane by 1e-16 loses 1e-16 (L / h)^2.
    assert np.abs(found[0] - found[1]).max() < 1e-9

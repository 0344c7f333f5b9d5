"""The chain of the stress test, without CalculiX. Run by pytest."""

from __future__ import annotations

import math

import numpy as np
import pytest

import fea
import stress

PRINTED = """
                        S T E P       1


 total force (fx,fy,fz) for set PULLED and time  0.1000000E+01

       -1.250000E-13  2.000000E+00 -2.100000E+05

 stresses (elem, integ.pnt.,sxx,syy,szz,sxy,sxz,syz) for set SOLID and time  0.1000000E+01

""" + "".join(f"{element:10d}{point:4d}  {element:.6E} {-point:.6E}  0.000000E+00  0.000000E+00 -1.500000E-01  7.000000E+00\n" for element in (1, 2) for point in (1, 2, 3, 4))


@pytest.fixture(scope="module")
def box(tmp_path_factory):
    from build123d import Box, export_step

    step = tmp_path_factory.mktemp("box") / "box.step"
    export_step(Box(2, 2, 2), str(step))
    return fea.mesh(step, fea.Sizes(1.0, 0.7, (0, 0, 0), (1, 1, 1)))


def test_von_mises_of_known_stresses():
    tension, shear, pressure = [3, 0, 0, 0, 0, 0], [0, 0, 0, 0, 0, 2], [5, 5, 5, 0, 0, 0]
    assert np.allclose(fea.von_mises(np.array([tension, shear, pressure], float)), [3, 2 * math.sqrt(3), 0])


def test_what_ccx_prints_is_read_and_counted():
    found, reaction = fea.read(PRINTED, 2)
    assert found.shape == (2, 4, 6) and found[1, 2].tolist() == [2, -3, 0, 0, -0.15, 7] and reaction.tolist() == [-1.25e-13, 2, -2.1e5]
    with pytest.raises(fea.NoAnswer):
        fea.read(PRINTED, 3)


def test_nodes_on_edges_are_where_c3d10_has_them(box):
    p = box.points[box.tetrahedra]
    for middle, (a, b) in enumerate(((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)), 4):
        assert np.allclose(p[:, middle], (p[:, a] + p[:, b]) / 2)
    assert (np.einsum("ei,ei->e", np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), p[:, 3] - p[:, 0]) > 0).all()


def test_a_linear_stress_is_found_at_corners_nodes_and_on_the_skin(box):
    corners = box.points[box.tetrahedra[:, :4]]
    inside = np.einsum("pc,ecx->epx", np.full((4, 4), fea.AMONG) + (fea.INSIDE - fea.AMONG) * np.eye(4), corners)
    stresses = np.zeros((*inside.shape[:2], 6))
    stresses[..., 0] = 10 + inside @ [1, 2, 3]
    assert np.allclose(fea.at_corners(stresses)[..., 0], 10 + corners @ [1, 2, 3])
    used = np.unique(box.tetrahedra[:, :4])
    assert np.allclose(fea.at_nodes(box, stresses)[used], 10 + box.points[used] @ [1, 2, 3])
    answer = fea.Answer(stresses, np.zeros(3), 0.0)
    run = stress.Run(0.7, box, answer, np.ones(len(box.tetrahedra), bool), 2.0, 1.0, 1.0, 1.0, np.zeros(3))
    points, values = stress.skin_values(run)
    assert np.allclose(values, (10 + points @ [1, 2, 3]) / 2)
    a, b, c = points[0::3], points[1::3], points[2::3]
    assert math.isclose(np.einsum("ti,ti->", a, np.cross(b, c)) / 6, 8)  # of the box: all triangles turn the same way


def test_fields_are_no_longer_than_ccx_reads(box):
    lines = fea.deck(box, [(np.array([0]), 2, -1 / 3)], np.array([0, 1])).splitlines()
    assert max(len(field.strip()) for line in lines if not line.startswith("*") for field in line.split(",")) <= 20


def test_growth_at_a_right_corner():
    assert math.isclose(stress.growth(1.5 * math.pi), 2 ** (1 - 0.5444837), rel_tol=1e-6)

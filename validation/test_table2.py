"""What Table 2's script is made of, without gmsh, TetGen or the program. Run by pytest."""

from __future__ import annotations

import numpy as np
import pytest

import parts
import table2

CORNERS = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0], [0, 0, 4], [4, 4, 4]], float)
TWO = np.array([[0, 1, 2, 3], [4, 1, 2, 3]])  # two tetrahedra with a common face


def test_edges_are_there_once():
    assert parts.edges(TWO).tolist() == [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [1, 4], [2, 3], [2, 4], [3, 4]]


def test_tetgen_files_are_read_as_they_are_written(tmp_path):
    (tmp_path / "a.node").write_text("2  3  0  0\n   0    1 2.5  -3\n   1    0 0  1e-3\n# made by tetgen\n")
    (tmp_path / "a.ele").write_text("1  4  0\n    0       3     1     0     2\n# made by tetgen\n")
    points, tetrahedra = parts.read(tmp_path / "a")
    assert points.tolist() == [[1, 2.5, -3], [0, 0, 1e-3]] and tetrahedra.tolist() == [[3, 1, 0, 2]]
    assert parts.smesh(CORNERS[:3], np.array([[0, 1, 2]])).splitlines() == [
        "3 3 0 0", "0 0.0 0.0 0.0", "1 4.0 0.0 0.0", "2 0.0 4.0 0.0", "1 0", "3 0 1 2", "0", "0"]


def test_a_bow_rises_by_its_part_and_passes_no_node_twice():
    pairs = parts.edges(TWO)
    points, pieces = parts.bowed(CORNERS, pairs, 4, 0.02)
    assert (len(points), len(pieces)) == (5 + 3 * 9, 4 * 9)
    degrees = np.bincount(pieces.ravel())
    assert degrees[:5].tolist() == np.bincount(pairs.ravel()).tolist() and set(degrees[5:]) == {2}
    middle = points[len(CORNERS) + 9 : len(CORNERS) + 18]  # the second of three points of each edge
    straight = CORNERS[pairs].mean(axis=1)
    lengths = np.linalg.norm(CORNERS[pairs[:, 0]] - CORNERS[pairs[:, 1]], axis=1)
    assert np.allclose(np.linalg.norm(middle - straight, axis=1), 0.02 * lengths)
    ends = points[pieces]
    assert np.allclose(np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).reshape(4, 9).sum(axis=0) / lengths, 1, atol=0.002)


def test_sizes_are_tuned_to_a_count_that_falls_with_them():
    size, found = parts.tuned(lambda size: int(1e5 / size**3) + 500, 6000, 10)
    assert abs(found / 6000 - 1) < parts.MOST_OFF and found == int(1e5 / size**3) + 500
    with pytest.raises(RuntimeError, match="no size"):
        parts.tuned(lambda size: 100 if size > 3 else 900, 500, 10)


def test_rows_of_one_degree_are_taken_together():
    assert table2.together([[8, 1, 0.5, 0.5, 0.5, 4, 4, 4], [8, 3, 0.1, 0.7, 0.3, 3, 9, 6]]) == [8, 4, 0.1, 0.7, pytest.approx(0.35), 3, 9, 5.5]


def printed(name: str, factor: float) -> str:
    """As `bench table` prints it."""
    paper = "".join(f"| paper: {k} | 100 | 20 | 38 | 6.0 | 99.0 | 30.0 | 48.0 | 677.0 | 200.0 |\n" for k in range(9))
    ours = f"| {name} | 101 | 19 | 30 | 0.20 | 3.00 | {factor:.2f} | 1.00 | 130.00 | {10 * factor:.2f} |\n"
    degrees = f"| degree | nodes | smoothing min, ms | max | avg | construction min, ms | max | avg |\n|{'---|' * 8}\n| 8 | 10 | 0.20 | 0.40 | 0.30 | 3.00 | 5.00 | 4.00 |\n"
    return f"| model | edges |\n|---|{'---|' * 9}\n{paper}{ours}\n{degrees}"


def test_the_page_has_both_rows_of_each_model():
    page = table2.page([printed(name, 1 + 0.5 * k) for k, name in enumerate(table2.MODELS)]).splitlines()
    models = [line for line in page if line.startswith(("| paper: ", *(f"| {name} |" for name in table2.MODELS)))]
    assert [line.split(" | ")[0] for line in models] == [f"| {name}" for k, own in enumerate(table2.MODELS) for name in (f"paper: {k}", own)]
    assert any("6 to 20 times for smoothing and 4 to 13 times for construction" in line for line in page)
    assert "| 8 | 90 | 0.20 | 0.40 | 0.30 | 3.00 | 5.00 | 4.00 |" in page
    with pytest.raises(ValueError):
        table2.page([printed("another", 1)] * 9)

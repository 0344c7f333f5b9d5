"""Reads the surfaces that `lattice-brep evaluate nodes --surfaces` writes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np


@dataclass
class Surface:
    axes: np.ndarray  # unit vectors along the struts
    points: np.ndarray  # mm
    distances: np.ndarray  # from the original node, mm, positive outside
    means: np.ndarray  # mean curvature, 1/mm, positive where the solid bulges
    triangles: np.ndarray


def read(path: Path) -> Surface:
    header, body = path.read_text().split("end_header\n")
    counts = {line.split()[1]: int(line.split()[2]) for line in header.splitlines() if line.startswith("element")}
    axes = [line.split()[2:] for line in header.splitlines() if line.startswith("comment strut")]
    lines = body.splitlines()
    vertices = np.array([line.split() for line in lines[: counts["vertex"]]], float)
    triangles = np.array([line.split()[1:] for line in lines[counts["vertex"] :]], int)
    return Surface(np.array(axes, float), vertices[:, :3], vertices[:, 3], vertices[:, 4], triangles)

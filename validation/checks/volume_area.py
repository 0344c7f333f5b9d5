"""Are volume, area and centroid what we say they are? The kernel's own integrals (OCC 8, and FreeCAD's where `valid` ran it) against
our report and against the validation properties in the STEP file. Limit: 1e-6 relative; the centroid 1e-6 of the bounding box's diagonal.

OCC integrates each face adaptively by Gauss over its spans (1e-12 on a body known in closed form).
The file must carry the three properties; `expected["volume_mm3"]`, `["area_mm2"]`, `["centroid_mm"]` are our report's.
"""

from __future__ import annotations

import math

from OCP.Bnd import Bnd_Box
from OCP.BRepBndLib import BRepBndLib
from OCP.BRepGProp import BRepGProp
from OCP.GProp import GProp_GProps

from checks import main, verdict
from model import load

LIMIT = 1e-6
EPS = 1e-9  # adaptive integration's own target; measured 1e-14 on the closed form


def check(model_or_path, expected: dict) -> dict:
    model = load(model_or_path)
    solid, skin = GProp_GProps(), GProp_GProps()
    BRepGProp.VolumeProperties_s(model.shape, solid, EPS)
    BRepGProp.SurfaceProperties_s(model.shape, skin, EPS)
    volume, area, c = solid.Mass(), skin.Mass(), solid.CentreOfMass()
    centre = (c.X(), c.Y(), c.Z())
    box = Bnd_Box()
    BRepBndLib.Add_s(model.shape, box)
    diagonal = math.sqrt(box.SquareExtent())

    why, figures = [], {"volume_mm3": volume, "area_mm2": area, "centroid_mm": centre}

    def compare(what: str, found: float, wanted: float) -> None:
        off = abs(found - wanted) / abs(wanted) if wanted else math.inf
        figures[f"{what} off"] = off
        if not off <= LIMIT:
            why.append(f"{what}: kernel {found!r}, said {wanted!r}, off by {off:.2e} of it")

    def compare_centre(what: str, wanted) -> None:
        off = math.dist(centre, wanted) / diagonal
        figures[f"{what} off"] = off
        if not off <= LIMIT:
            why.append(f"{what}: kernel {centre}, said {tuple(wanted)}, off by {off:.2e} of the diagonal")

    text = model.text
    if not (text.volumes_mm3 and text.areas_mm2 and text.centroids_mm):
        why.append("the file lacks validation properties (volume, area and centre point)")
    else:
        compare("volume in file", volume, sum(text.volumes_mm3))
        compare("area in file", area, sum(text.areas_mm2))
        weights = text.volumes_mm3
        if len(text.centroids_mm) == len(weights):
            mean = [sum(w * p[k] for w, p in zip(weights, text.centroids_mm)) / sum(weights) for k in range(3)]
            compare_centre("centre in file", mean)
        else:
            why.append(f"{len(weights)} volumes but {len(text.centroids_mm)} centre points in the file")
    if "volume_mm3" in expected:
        compare("volume in report", volume, expected["volume_mm3"])
    if "area_mm2" in expected:
        compare("area in report", area, expected["area_mm2"])
    if expected.get("centroid_mm"):
        compare_centre("centre in report", expected["centroid_mm"])
    return verdict(why, **figures)


if __name__ == "__main__":
    main(check)

"""Is it exactly the expected number of closed solids and nothing else?

Every edge used twice, in opposite senses (a seam twice by its own face); no face outside a solid; one shell a solid, closed;
volume positive, so that the faces look outward.
`expected["components"]`: how many solids (1 if not given).
"""

from __future__ import annotations

from OCP.BRep import BRep_Tool
from OCP.BRepGProp import BRepGProp
from OCP.GProp import GProp_GProps
from OCP.TopoDS import TopoDS

from checks import main, verdict
from model import FACE, SHELL, SOLID, explore, load


def check(model_or_path, expected: dict) -> dict:
    model = load(model_or_path)
    wanted = expected.get("components", 1)
    why = []

    solids = model.solids
    if len(solids) != wanted:
        why.append(f"{len(solids)} solids, wanted {wanted}")
    loose = sum(1 for _ in explore(model.shape, FACE, SOLID))
    if loose:
        why.append(f"{loose} faces belong to no solid")

    for i, solid in enumerate(solids):
        shells = [TopoDS.Shell(s) for s in explore(solid, SHELL)]
        if len(shells) != 1:
            why.append(f"solid {i} has {len(shells)} shells, wanted 1")
        if not all(BRep_Tool.IsClosed_s(shell) for shell in shells):
            why.append(f"solid {i} has an open shell")
        inside = GProp_GProps()
        BRepGProp.VolumeProperties_s(solid, inside)
        if not inside.Mass() > 0:
            why.append(f"solid {i} has volume {inside.Mass():g}: inside out")

    uses = {"free": 0, "crowded": 0, "same sense": 0}
    for edge in model.edges:
        if edge.degenerate:
            continue
        if len(edge.uses) < 2:
            uses["free"] += 1
        elif len(edge.uses) > 2:
            uses["crowded"] += 1
        elif edge.uses[0][1].Orientation() == edge.uses[1][1].Orientation():
            uses["same sense"] += 1
    for fault, number in uses.items():
        if number:
            why.append(f"{number} edges are {fault} (each must be used twice, in opposite senses)")
    return verdict(why, solids=len(solids), **{k.replace(" ", "_"): v for k, v in uses.items()})


if __name__ == "__main__":
    main(check)

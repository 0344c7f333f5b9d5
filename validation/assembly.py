"""`export --assembly`: the number of parts, their volume, and whether OCC 8 (XDE) and FreeCAD open the file as it is meant."""

from __future__ import annotations

import json
import time
from pathlib import Path

from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepGProp import BRepGProp
from OCP.GProp import GProp_GProps
from OCP.IFSelect import IFSelect_ReturnStatus
from OCP.OCP.collections import Sequence_TDF_Label
from OCP.STEPCAFControl import STEPCAFControl_Reader
from OCP.TCollection import TCollection_ExtendedString
from OCP.TDF import TDF_Label
from OCP.TDocStd import TDocStd_Document
from OCP.XCAFDoc import XCAFDoc_DocumentTool, XCAFDoc_ShapeTool

import checks
import program
from checks.valid import in_freecad
from result import cost, fell, finish

CELL, REPEAT = "bcc", "4x4x4"
CLOSE = 1e-6  # volumes, relative


def opened(path: Path) -> dict:
    """What OCC's XDE reader finds: parts, instances, their volume, whether all shapes are valid."""
    document = TDocStd_Document(TCollection_ExtendedString("assembly"))
    reader = STEPCAFControl_Reader()
    start = time.process_time()
    if reader.ReadFile(str(path)) != IFSelect_ReturnStatus.IFSelect_RetDone or not reader.Transfer(document):
        return {"error": "OCC 8 does not read the file"}
    free, placed = Sequence_TDF_Label(), Sequence_TDF_Label()
    XCAFDoc_DocumentTool.ShapeTool_s(document.Main()).GetFreeShapes(free)
    if free.Length() != 1:
        return {"error": f"OCC 8 finds {free.Length()} roots, wanted 1"}
    XCAFDoc_ShapeTool.GetComponents_s(free.Value(1), placed)
    volumes: dict[int, float] = {}
    total = 0.0
    for k in range(1, placed.Length() + 1):
        part = TDF_Label()
        XCAFDoc_ShapeTool.GetReferredShape_s(placed.Value(k), part)
        if part.Tag() not in volumes:
            held = GProp_GProps()
            BRepGProp.VolumeProperties_s(XCAFDoc_ShapeTool.GetShape_s(part), held, 1e-7)
            volumes[part.Tag()] = held.Mass()
        total += volumes[part.Tag()]
    valid = BRepCheck_Analyzer(XCAFDoc_ShapeTool.GetShape_s(free.Value(1))).IsValid()
    return {"parts": len(volumes), "instances": placed.Length(), "volume_mm3": total, "valid": valid, "cpu_s": round(time.process_time() - start, 2)}


def judge(out: Path) -> dict:
    """A block of cells as an assembly, against the same block as one solid."""
    result = {"name": f"assembly of {CELL} {REPEAT}", "detail": {}, "checks": {}}
    start = time.monotonic()
    graph = out / "assembly.graph.json"
    done = program.run("cell", CELL, "--size", "10", "--repeat", REPEAT, "--radius", "0.5", "-o", graph)
    if not done.ok:
        return fell(result, "cell", done)
    reports = {}
    for name, options in (("assembly", ["--assembly"]), ("one-solid", [])):
        step, report = out / f"{name}.step", out / f"{name}.report.json"
        done = program.run("export", graph, "-o", step, "--report", report, *options)
        if not done.ok:
            return fell(result, "export", done)
        reports[name] = json.loads(report.read_text())
        result.setdefault("export", cost(done))
    nodes = len(json.loads(graph.read_text())["nodes"])
    parts, volume = len(reports["assembly"]["solids"]), reports["one-solid"]["volume_mm3"]

    def why(found: dict, instances: str, **wanted: float) -> list[str]:
        if "error" in found:
            return [found["error"]]
        off = [f"{name} {found[name]}, wanted {count}" for name, count in {instances: nodes, **wanted}.items() if found[name] != count]
        if abs(found["volume_mm3"] / volume - 1) > CLOSE:
            off.append(f"volume {found['volume_mm3']} mm3, wanted {volume}")
        return off if found["valid"] else [*off, "not valid"]

    step = out / "assembly.step"
    in_occ = opened(step)
    result["checks"]["xde"] = checks.verdict(why(in_occ, "instances", parts=parts), **in_occ)
    in_free = in_freecad(step, 600, False)
    result["checks"]["freecad"] = checks.verdict(why(in_free, "solids", loose_faces=0), **in_free)
    for name in ("assembly", "one-solid"):
        (out / f"{name}.step").unlink()
    return finish(result, start)

"""`export --assembly`: the number of parts, their volume, and whether OCC 8 (XDE) and FreeCAD open the file as it is meant.

    validation/.venv/bin/python validation/assembly.py FILE        what XDE finds in a file, and its CPU time
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Iterator
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

CELL, REPEAT = "bcc", "5x5x5"  # 341 nodes: two levels of blocks
CLOSE = 1e-6  # volumes, relative


def instances(label: TDF_Label) -> Iterator[TDF_Label]:
    """The parts placed below an assembly, as often as they are placed."""
    placed = Sequence_TDF_Label()
    XCAFDoc_ShapeTool.GetComponents_s(label, placed)
    for k in range(1, placed.Length() + 1):
        part = TDF_Label()
        XCAFDoc_ShapeTool.GetReferredShape_s(placed.Value(k), part)
        if XCAFDoc_ShapeTool.IsAssembly_s(part):
            yield from instances(part)
        else:
            yield part


def opened(path: Path, is_judged: bool = True) -> dict:
    """What OCC's XDE reader finds: parts, instances, their volume, whether all shapes are valid."""
    document = TDocStd_Document(TCollection_ExtendedString("assembly"))
    reader = STEPCAFControl_Reader()
    start = time.process_time()
    if reader.ReadFile(str(path)) != IFSelect_ReturnStatus.IFSelect_RetDone:
        return {"error": "OCC 8 does not read the file"}
    read = time.process_time() - start
    if not reader.Transfer(document):
        return {"error": "OCC 8 does not take the file over"}
    cpu = time.process_time() - start
    free = Sequence_TDF_Label()
    XCAFDoc_DocumentTool.ShapeTool_s(document.Main()).GetFreeShapes(free)
    if free.Length() != 1:
        return {"error": f"OCC 8 finds {free.Length()} roots, wanted 1"}
    volumes: dict[int, float] = {}
    count, total = 0, 0.0
    for part in instances(free.Value(1)):
        if part.Tag() not in volumes:
            held = GProp_GProps()
            BRepGProp.VolumeProperties_s(XCAFDoc_ShapeTool.GetShape_s(part), held, 1e-7)
            volumes[part.Tag()] = held.Mass()
        count += 1
        total += volumes[part.Tag()]
    found = {"parts": len(volumes), "instances": count, "volume_mm3": total, "read_cpu_s": round(read, 2), "transfer_cpu_s": round(cpu - read, 2)}
    if is_judged:
        found["valid"] = BRepCheck_Analyzer(XCAFDoc_ShapeTool.GetShape_s(free.Value(1))).IsValid()
    return found


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


if __name__ == "__main__":
    print(json.dumps(opened(Path(sys.argv[1]), is_judged=False)))

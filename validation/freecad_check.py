"""Run by Debian's Python with FreeCAD's modules (OCC 7.6): reads one STEP file, prints one line of JSON.

    PYTHONPATH=/usr/lib/freecad-python3/lib /usr/bin/python3 freecad_check.py [--deep|--shallow] FILE.step
"""

import json
import sys
import time

import FreeCAD  # noqa: F401 - must be imported before Part
import Part


def faults(shape, deep):
    """FreeCAD's `check` raises with its list of findings; no exception means none."""
    try:
        shape.check(deep)
        return []
    except Exception as found:
        lines = [line.strip() for line in str(found).splitlines() if line.strip() and not line.startswith("BOP check found")]
        counted = {}
        for line in lines:
            counted[line] = counted.get(line, 0) + 1
        return ["%s (%d times)" % item if item[1] > 1 else item[0] for item in sorted(counted.items())][:20]


def main():
    deep, path = sys.argv[1] == "--deep", sys.argv[2]
    start = time.process_time()
    shape = Part.read(path)
    read = time.process_time() - start
    kinds = {}
    for face in shape.Faces:
        name = type(face.Surface).__name__
        kinds[name] = kinds.get(name, 0) + 1
    in_solids = sum(len(solid.Faces) for solid in shape.Solids)
    answer = {
        "version": "FreeCAD %s.%s, OCC %s" % (FreeCAD.Version()[0], FreeCAD.Version()[1], Part.OCC_VERSION),
        "valid": bool(shape.isValid()),
        "faults": faults(shape, deep),
        "solids": len(shape.Solids),
        "loose_faces": len(shape.Faces) - in_solids,
        "closed": all(shell.isClosed() for shell in shape.Shells),
        "faces": len(shape.Faces),
        "edges": len(shape.Edges),
        "vertices": len(shape.Vertexes),
        "kinds": kinds,
        "volume_mm3": shape.Volume,
        "area_mm2": shape.Area,
        "max_tolerance_mm": shape.getTolerance(1),
        "read_cpu_s": round(read, 2),
        "check_cpu_s": round(time.process_time() - start - read, 2),
    }
    print(json.dumps(answer))


main()

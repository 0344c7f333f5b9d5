"""Can it be meshed into tetrahedra as it is? gmsh reads the STEP file with every repair switched off and meshes it; in its own process
with a time limit, since a mesher may also crash or never end.

Reports elements and the smallest quality (minSICN: 1 is a perfect tetrahedron, 0 flat, below 0 inverted); fails below `QUALITY_LIMIT`,
when the number of volumes differs, or when the mesh's volume is off the solid's by more than 10 % (8 elements around a strut cost 6 %).
Where `most_inverted` is given, the mesh is twice as fine and gets curved edges (second order), and at most that share of its elements may be turned
inside out by that: faces whose parameters run unevenly fail here, though their tetrahedra are fine.
`expected`: mesh_seconds (300, of CPU; 0 skips), components, radius_mm, most_inverted.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import timebox
from checks import main, verdict

QUALITY_LIMIT = 1e-3
AROUND = 8  # elements around a full circle
VOLUME_LIMIT = 0.1
TEN_NODES = 11  # gmsh's type of tetrahedra of second order


def as_it_is(gmsh) -> None:
    """No repair, no output, one thread."""
    for option in ("OCCAutoFix", "OCCFixDegenerated", "OCCFixSmallEdges", "OCCFixSmallFaces", "OCCSewFaces", "OCCMakeSolids"):
        gmsh.option.setNumber(f"Geometry.{option}", 0)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.option.setNumber("General.NumThreads", 1)


def mesh(path: str, radius: float, curved: bool) -> dict:
    import gmsh

    gmsh.initialize(interruptible=False)
    as_it_is(gmsh)
    gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", AROUND * (1 + curved))
    gmsh.option.setNumber("Mesh.MeshSizeMax", 1.5 * radius)
    gmsh.option.setNumber("Mesh.MeshSizeMin", 0.25 * radius)
    gmsh.model.add("solid")
    found = gmsh.model.occ.importShapes(path, highestDimOnly=False)
    gmsh.model.occ.synchronize()
    volumes = [tag for dim, tag in gmsh.model.getEntities(3)]
    exact = sum(gmsh.model.occ.getMass(3, tag) for tag in volumes)
    gmsh.model.mesh.generate(3)
    quality = sizes = ()
    elements = 0
    types, tags, _ = gmsh.model.mesh.getElements(3)
    if len(tags):
        ids = [t for group in tags for t in group]
        elements = len(ids)
        quality = gmsh.model.mesh.getElementQualities(ids, "minSICN")
        sizes = gmsh.model.mesh.getElementQualities(ids, "volume")
    inverted = None
    if elements and curved:
        gmsh.model.mesh.setOrder(2)
        inverted = float((gmsh.model.mesh.getElementQualities(gmsh.model.mesh.getElementsByType(TEN_NODES)[0], "minSICN") < 0).mean())
    return {"volumes": len(volumes), "imported": len(found), "elements": elements, "exact_mm3": exact,
            "mesh_mm3": float(sum(sizes)), "min_quality": float(min(quality)) if elements else None, "inverted": inverted}


def check(model_or_path, expected: dict) -> dict:
    seconds = expected.get("mesh_seconds", 300)
    if not seconds:
        return verdict([], skipped=True)
    path = Path(getattr(model_or_path, "path", model_or_path))
    most_inverted = expected.get("most_inverted")
    command = [sys.executable, "-m", "checks.meshable", "--curved" if most_inverted is not None else "--mesh", str(path.resolve()),
               str(expected.get("radius_mm", 1.0))]
    here = Path(__file__).resolve().parent.parent
    done = timebox.run(command, seconds, cwd=here)
    if done is None:
        return verdict([f"no mesh in {seconds:g} CPU s"])
    lines = [line for line in done.stdout.splitlines() if line.startswith("{")]
    if not lines:
        said = (done.stderr or done.stdout).strip().splitlines()
        return verdict([f"gmsh: {said[-1] if said else f'exit code {done.returncode}'}"])
    found = json.loads(lines[-1])
    why = []
    if found["volumes"] != expected.get("components", 1):
        why.append(f"gmsh sees {found['volumes']} volumes, wanted {expected.get('components', 1)}")
    if not found["elements"]:
        why.append("no tetrahedra")
    else:
        if not found["min_quality"] >= QUALITY_LIMIT:
            why.append(f"smallest element quality {found['min_quality']:.3g}, wanted at least {QUALITY_LIMIT}")
        if most_inverted is not None and not found["inverted"] <= most_inverted:
            why.append(f"a share of {found['inverted']:.2g} of curved elements is inside out, wanted at most {most_inverted:g}")
        off = abs(found["mesh_mm3"] / found["exact_mm3"] - 1)
        if not off <= VOLUME_LIMIT:
            why.append(f"mesh volume {found['mesh_mm3']:.6g} mm3, the solid's {found['exact_mm3']:.6g}")
    return verdict(why, **found)


if __name__ == "__main__":
    if sys.argv[1:2] in (["--mesh"], ["--curved"]):
        print(json.dumps(mesh(sys.argv[2], float(sys.argv[3]), sys.argv[1] == "--curved")))
    else:
        main(check)

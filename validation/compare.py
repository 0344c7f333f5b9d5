"""Our CPU time beside that of a boolean union by OCC 8 (build123d) and of a mesh union by manifold3d, on the same lattices in one run.

    validation/.venv/bin/python validation/compare.py          writes docs/comparison.md

Ours is the user and system time of the whole program, reading, checks and writing included, on one thread. Theirs is the union alone (peers.py).
"""

from __future__ import annotations

import json
import platform
import sys
from pathlib import Path

import generated
import peers
import program
import timebox
from markdown import table

HERE = Path(__file__).resolve().parent
PAGE = HERE.parent / "docs" / "comparison.md"
MOST_SECONDS = 1800  # CPU, of a peer
OURS = {"ours, each node built": ["--no-cache"], "ours": []}
PEERS = {"occ": "OCC 8, boolean union", "manifold": "manifold3d, mesh union"}

HEAD = ["lattice", "struts", "program", "CPU, s", "struts a CPU second", "times as fast", "faces a strut", "kB a strut", "solids", "valid in OCC 8", "volume, mm³"]


def lattices(out: Path) -> list[tuple[str, str, Path]]:
    """(name, peer, graph)"""
    blocks = [(f"BCC {n}x{n}x{n}", "occ", generated.bcc(n, out / f"bcc{n}.json")) for n in (1, 2, 3, 4)]
    moved = [(f"BCC {n}x{n}x{n}, nodes moved", "occ", generated.jittered(n, out / f"moved{n}.json")) for n in (3, 4)]
    large = [("BCC 10x10x10", "manifold", generated.bcc(10, out / "bcc10.json")),
             ("tetrahedral mesh of a part", "manifold", generated.tetrahedral(4.8, out / "tetrahedral.json"))]
    return blocks + moved + large


def aside(*words: str | Path) -> dict:
    """What peers.py answers; why not, under `error`."""
    done = timebox.run([sys.executable, str(HERE / "peers.py"), *map(str, words)], MOST_SECONDS)
    if done is None:
        return {"error": f"stopped after {MOST_SECONDS} CPU s"}
    return json.loads(done.stdout) if done.returncode == 0 else {"error": f"exit code {done.returncode}: {done.stderr.strip()[-200:]}"}


def ours(graph: Path, options: list[str], is_judged: bool) -> dict:
    step, report = graph.with_suffix(".step"), graph.with_suffix(".report.json")
    done = program.run("export", graph, "-q", "--threads", "1", "--overlaps", "keep", "-o", step, "--report", report, *options)
    if not done.ok:
        return {"error": f"exit code {done.code}: {done.last_words}"}
    said = json.loads(report.read_text())
    found = {"cpu_s": done.cpu_s, "faces": said["counts"]["faces"], "solids": said["counts"]["components"], "bytes": said["bytes"], "volume_mm3": said["volume_mm3"]}
    if is_judged:
        judged = aside("judge", step)
        found["valid"] = judged.get("valid", False) and judged["solids"] == found["solids"]
    step.unlink()
    return found


def measure(name: str, peer: str, graph: Path) -> dict:
    """{name, struts, peer, found: {program: figures}}, the peer first."""
    struts = len(json.loads(graph.read_text())["struts"])
    found = {PEERS[peer]: aside(peer, graph)}
    for label, options in OURS.items():
        found[label] = ours(graph, options, is_judged=peer == "occ")
    return {"name": name, "struts": struts, "peer": PEERS[peer], "found": found}


def rows(measured: list[dict]) -> list[list]:
    out = []
    for m in measured:
        theirs = m["found"][m["peer"]].get("cpu_s")
        for label, f in m["found"].items():
            if "error" in f:
                out.append([m["name"], m["struts"], label, f["error"].replace("|", "/").replace("\n", " "), *[""] * 7])
                continue
            is_peer = label == m["peer"]
            valid = "" if "valid" not in f or label == PEERS["manifold"] else "yes" if f["valid"] else "**no**"
            out.append([m["name"], m["struts"], label, f"{f['cpu_s']:.2f}", f"{m['struts'] / f['cpu_s']:.0f}", "" if is_peer or theirs is None else f"{theirs / f['cpu_s']:.1f}",
                        f"{f['faces'] / m['struts']:.1f}", f"{f['bytes'] / m['struts'] / 1e3:.1f}", f["solids"], valid, f"{f['volume_mm3']:.5g}"])
    return out


def page(measured: list[dict]) -> str:
    text = f"""# Beside a boolean kernel and a mesh union

Written by `validation/.venv/bin/python validation/compare.py`, all of it in one run, on {platform.machine()} under {platform.system()}; CPU time, one thread of ours.

- **Theirs**: a cylinder for each strut, from node to node, and a sphere of the struts' radius at each node where struts meet, as one union. Sharp where struts meet.
  OCC: build123d's `fuse` of all parts in one call. manifold3d: struts and spheres of {peers.SEGMENTS} sides in one `batch_boolean`; triangles, no CAD. Only the union is timed; its size is that of a STEP file or a binary STL.
- **Ours**: the whole program, from reading the graph to the written STEP file, checks included. "Each node built" is with `--no-cache`.
- BCC: cells of {generated.SIZE_MM:g} mm, radius {generated.RADIUS_MM:g} mm. Nodes moved: each by at most {generated.MOVED:g} of the cell along each axis, seed {generated.SEED}. The part: a plate with a boss and two bores meshed by gmsh, radius the shortest edge over {generated.SHARE}; `--overlaps keep`.
- "Times as fast" is the peer's CPU time over ours. "Valid" is OCC's check of the shape; ours is read from the file and must also be as many solids as it states.

"""
    return text + "\n".join(table(HEAD, rows(measured)))


def main() -> int:
    out = HERE / "out"
    out.mkdir(exist_ok=True)
    measured = []
    for lattice in lattices(out):
        measured.append(measure(*lattice))
        for row in rows(measured[-1:]):
            print(*row, sep="  ", flush=True)
    PAGE.write_text(page(measured))
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except program.NotBuilt as fault:
        sys.exit(f"compare: {fault}")

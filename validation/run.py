"""Exports a set of lattices with `lattice-brep` and runs every check on every file. Exit code 1 if anything failed.

    validation/run --quick            cells 1x1x1 and BCC 2x2x2 in both kernels, 20 random nodes, 6 of mixed radii (for CI)
    validation/run                    cells 3x3x3, 200 random nodes, 60 of mixed radii; writes validation/report.md
    validation/run --only TEXT        only cases whose name contains TEXT; joins the results that validation/out holds
    validation/run --lattices DIR     the lattices of a folder besides, whole and a block of each (or LATTICES=DIR)
    validation/run --samples DIR      small lattices of a folder besides, in OCC 8
    validation/run --pictures         only renders docs/pictures/*.png
"""

from __future__ import annotations

import argparse
import hashlib
import json
import multiprocessing
import os
import sys
import time
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import assembly
import blocks
import cases
import checks
import checks.valid  # loads OCC once, before the workers are forked, and makes their common lock
import lattices
import program
from result import cost, fell, finish, told

HERE = Path(__file__).resolve().parent
OUT = HERE / "out"
KEPT = OUT / "results"


def figures_of(check: str, found: dict) -> str:
    """The few figures worth a place on a check's line."""
    if found.get("skipped"):
        return "left out"
    pick = {
        "counts": ("struts", "patches", "caps", "euler"),
        "radii": ("cones", "rim radius off", "half-angle off"),
        "tolerances": ("edge_mm", "vertex_mm"),
        "continuity": ("rim_max_deg", "inside_max_deg", "gap_mm"),
        "fold": ("lowest_cosine",),
        "volume_bound": ("above_union", "in_zones"),
        "meshable": ("elements", "min_quality", "inverted"),
        "text": ("bytes",),
        "one_solid": ("solids",),
    }.get(check, ())
    line = ", ".join(f"{k} {found[k]:.4g}" if isinstance(found.get(k), float) else f"{k} {found.get(k)}" for k in pick)
    if check == "volume_area":
        line = f"worst off {max((v for k, v in found.items() if k.endswith(' off')), default=float('nan')):.1e}"
    if check == "valid" and "freecad" in found:
        line = f"OCC 8 and {found['freecad'].get('version', 'FreeCAD')}, {found['freecad'].get('check_cpu_s', '?')} CPU s"
    return line


def judge(case: cases.Case) -> dict:
    """Makes, exports and checks one case: {name, ok, checks: {name: answer}, ...}."""
    start = time.monotonic()
    stem = OUT / case.name.replace(" ", "-").replace(",", "")
    result = {"name": case.name, "detail": case.detail, "checks": {}, "radius_mm": case.radius_mm}
    try:
        graph_path = case.graph
        if case.cell:
            graph_path = stem.with_suffix(".graph.json")
            made = program.run("cell", case.cell[0], "--size", f"{cases.SIZE_MM:g}", "--repeat", case.cell[1],
                               "--radius", f"{case.radius_mm:g}", "-o", graph_path, seconds=600)
            if not made.ok:
                return fell(result, "cell", made)
        step, report_path = stem.with_suffix(".step"), stem.with_suffix(".report.json")
        crop = (f"--crop={case.crop}",) if case.crop else ()
        done = program.run("export", graph_path, "-o", step, "--report", report_path, *crop, *case.options)
        result["export"] = cost(done)
        if not done.ok:
            return fell(result, "export", done)
        graph = json.loads(Path(graph_path).read_text())
        report = json.loads(report_path.read_text())
        expected = cases.expected(case, graph, report)
        result.update(told(step, report))
    except Exception as fault:  # noqa: BLE001 - a case that cannot be made is a failed case
        result["checks"]["export"] = checks.verdict([f"{type(fault).__name__}: {fault}"])
        return finish(result, start)
    result["checks"]["export"] = checks.verdict([])
    from model import Model

    model = Model(step)
    for name in checks.ALL:
        if name in case.skip or name == "radii" and result["shrunk"]["struts"]:  # the graph's radii are not those of the solid
            continue
        begin = time.monotonic()
        found = checks.run(name, model, expected)
        found["wall_s"] = round(time.monotonic() - begin, 2)
        result["checks"][name] = found
    return finish(result, start)


def tell(result: dict, whole: bool) -> None:
    """One line a check; for the many random nodes one line a node unless something failed."""
    name, width = result["name"], 24
    if not whole and result["ok"]:
        found = result["checks"].get("continuity", {})
        print(f"{name:{width}} ok    {len(result['checks'])} checks; {figures_of('continuity', found)}; {result['wall_s']} s", flush=True)
        return
    for check, found in result["checks"].items():
        state = "ok  " if found["ok"] else "FAIL"
        print(f"{name:{width}} {check:18} {state}  {figures_of(check, found) if found['ok'] else '; '.join(found['why'][:4])}", flush=True)


def determinism() -> dict:
    """Same bytes with 1, 2 and 8 threads, and again."""
    result = {"name": "determinism", "detail": {}, "checks": {}}
    start = time.monotonic()
    graph = OUT / "determinism.graph.json"
    made = program.run("cell", "octet", "--size", "10", "--repeat", "2x2x2", "--radius", "0.5", "-o", graph)
    if not made.ok:
        return fell(result, "cell", made)
    seen = {}
    for threads in (1, 2, 8, 1):
        step, report = OUT / "determinism.step", OUT / "determinism.report.json"
        done = program.run("export", graph, "-o", step, "--report", report, "--threads", threads)
        if not done.ok:
            return fell(result, "export", done)
        seen.setdefault(hashlib.sha256(step.read_bytes()).hexdigest(), []).append(threads)
    why = [] if len(seen) == 1 else [f"{len(seen)} different files: threads {list(seen.values())}"]
    result["checks"]["same_bytes"] = checks.verdict(why)
    return finish(result, start)


def keep(result: dict, quick: bool) -> None:
    """Keeps a case's answers for the report; quick runs leave the report alone."""
    if not quick:
        KEPT.mkdir(exist_ok=True)
        (KEPT / (result["name"].replace(" ", "-").replace(",", "") + ".json")).write_text(json.dumps(result, default=str))


def kept() -> list[dict]:
    """The newest answer of every case, cells first."""
    results = [json.loads(path.read_text()) for path in sorted(KEPT.glob("*.json"))]
    order = {case.name: i for i, case in enumerate(cases.cells("2x2x2", True) + cases.cells("3x3x3", True))}
    return sorted(results, key=lambda r: (order.get(r["name"], len(order)), r["name"]))


def main() -> int:
    say = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    say.add_argument("--quick", action="store_true", help="the small subset, for CI; validation/report.md stays as it is")
    say.add_argument("--lattices", type=Path, default=os.environ.get("LATTICES"), help="a folder of lattices (JSON, 3MF)")
    say.add_argument("--largest", type=int, default=20_000, help="leave out lattices with more struts than this")
    say.add_argument("--samples", type=Path, help="a folder of small lattices (JSON), as `lattice-brep bench --keep` writes them, to judge whole in OCC 8")
    say.add_argument("--only", help="only cases whose name contains this; validation/report.md then joins the newest result of each case")
    say.add_argument("--jobs", type=int, default=os.cpu_count(), help="cases judged at a time")
    say.add_argument("--pictures", action="store_true", help="render docs/pictures/*.png and do nothing else")
    say.add_argument("--keep", action="store_true", help="keep the STEP files in validation/out")
    args = say.parse_args()

    try:
        program.binary()
    except program.NotBuilt as fault:
        print(f"validation: {fault}", file=sys.stderr)
        return 1
    OUT.mkdir(exist_ok=True)
    if args.pictures:
        import pictures

        return pictures.render_all(OUT)

    start = time.monotonic()
    if args.quick:
        todo = cases.cells("1x1x1", True) + [case for case in cases.cells("2x2x2", True) if case.name == "bcc 2x2x2"]
    else:
        todo = [case for case in cases.cells("2x2x2", False) if case.cell[0] in cases.MESHED] + cases.cells("3x3x3", False)
    whole: list[Path] = []
    if args.lattices:
        whole = lattices.found(Path(args.lattices), OUT)
        todo += [lattices.block(path) for path in whole]
        whole = [path for path in whole if lattices.struts(path) <= args.largest]
    # The slow ones first, so that no worker is left alone with them at the end.
    todo = todo[::-1] + cases.random_nodes(cases.QUICK_NODES if args.quick else cases.RANDOM_NODES, OUT)
    todo += cases.curved_node(OUT)
    todo += cases.mixed_nodes(cases.QUICK_MIXED if args.quick else cases.MIXED_NODES, OUT)
    if args.samples:
        todo += cases.samples(Path(args.samples))
    wanted = (lambda name: args.only in name) if args.only else (lambda name: True)

    results = []
    with multiprocessing.get_context("fork").Pool(args.jobs, maxtasksperchild=8) as pool:
        for result in pool.imap_unordered(judge, [case for case in todo if wanted(case.name)]):
            results.append(result)
            keep(result, args.quick)
            tell(result, not result["name"].startswith(("random", "mixed", "sample")))
            if not args.keep:
                (OUT / result["name"].replace(" ", "-").replace(",", "")).with_suffix(".step").unlink(missing_ok=True)
    if wanted("determinism"):
        results.append(determinism())
        keep(results[-1], args.quick)
        tell(results[-1], True)
    if wanted(f"assembly of {assembly.CELL} {assembly.REPEAT}"):
        results.append(assembly.judge(OUT))
        keep(results[-1], args.quick)
        tell(results[-1], True)
    if wanted(f"blocks of {blocks.CELL} {blocks.REPEAT}"):
        results.append(blocks.judge(OUT))
        keep(results[-1], args.quick)
        tell(results[-1], True)
    for path in whole:
        for name in (f"{lattices.name(path)} whole", f"{lattices.name(path)} whole, shrunk"):
            if wanted(name):
                results.append(lattices.whole(path, name, shrink=name.endswith("shrunk"), out=OUT))
                keep(results[-1], args.quick)
                tell(results[-1], True)

    seconds = time.monotonic() - start
    if not args.quick:
        import markdown

        markdown.write(HERE / "report.md", kept())
    failed = [r["name"] for r in results if not r["ok"] and not r.get("refused")]
    for name in failed:
        print(f"failed: {name}")
    print(f"validation: {sum(len(r['checks']) for r in results)} checks on {len(results)} cases in {seconds:.0f} s")
    print(f"{len(results) - len(failed)} passed, {len(failed)} failed")
    return 1 if failed or not results else 0


if __name__ == "__main__":
    sys.exit(main())

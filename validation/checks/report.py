"""Does our report say of the lattice what the graph says? Components, genus and tapered struts (cones) exactly; nodes and struts too, save that straight nodes of
degree 2 may have been taken out, one strut with each. And how many nodes went down the ladder?

`expected`: report_counts; graph_counts where the graph is known; report; g0_allowed (nodes on the G0 rung: 0); lowered_allowed (nodes
below the first rung: any).
"""

from __future__ import annotations

import report_fields
from checks import main, verdict


def check(model_or_path, expected: dict) -> dict:
    told, graph = expected.get("report_counts"), expected.get("graph_counts")
    if not told:
        return verdict(["the report has no counts"])
    why = []
    needed = {"nodes", "struts", "patches", "caps", "faces", "circles", "components", "genus"}
    if needed - told.keys():
        why.append(f"the report lacks {', '.join(sorted(needed - told.keys()))}")
    report = expected.get("report", {})
    if graph:
        same_radii = report_fields.shrunk(report)["struts"] == 0
        for name in ("components", "genus", *(("cones",) if same_radii else ())):
            if told.get(name) != graph.get(name):
                why.append(f"{name}: report {told.get(name)}, graph {graph[name]}")
        dropped = graph["nodes"] - told.get("nodes", 0)
        if dropped < 0 or graph["struts"] - told.get("struts", 0) != dropped:
            why.append(f"report has {told.get('nodes')} nodes and {told.get('struts')} struts, graph {graph['nodes']} and {graph['struts']}")
    if told.get("circles") != 2 * told.get("struts", 0):
        why.append(f"report has {told.get('circles')} circles for {told.get('struts')} struts, wanted two each")
    for what, found, allowed in (("on the G0 rung", report_fields.on_g0_rung(report), expected.get("g0_allowed", 0)),
                                 ("below the first rung", report_fields.below_first_rung(report), expected.get("lowered_allowed"))):
        if allowed is not None and found > allowed:
            why.append(f"{found} nodes {what}, allowed {allowed}")
    on_rungs = sum(report_fields.rungs(report).values())
    if report.get("rungs") and told.get("nodes") and not (0 < on_rungs <= told["nodes"] or on_rungs == told.get("patches")):
        why.append(f"the rungs hold {on_rungs} of {told['nodes']} nodes")
    return verdict(why, rungs=report_fields.rungs(report))


if __name__ == "__main__":
    main(check)

"""What a lattice graph promises by itself: degrees, tapered struts, components, genus."""

from __future__ import annotations

import numpy as np


def degrees(graph: dict) -> np.ndarray:
    out = np.zeros(len(graph["nodes"]), int)
    for s in graph["struts"]:
        out[s["a"]] += 1
        out[s["b"]] += 1
    return out


def least_radius(graph: dict) -> float:
    return min(min(s["ra"], s["rb"]) for s in graph["struts"])


def is_tapered(strut: dict) -> bool:
    """Radii equal but for round-off (1e-12 of them) are one radius."""
    return abs(strut["ra"] - strut["rb"]) > 1e-12 * max(strut["ra"], strut["rb"])


def components(graph: dict) -> int:
    parent = list(range(len(graph["nodes"])))

    def root(i: int) -> int:
        while parent[i] != i:
            parent[i] = parent[parent[i]]
            i = parent[i]
        return i

    for s in graph["struts"]:
        parent[root(s["a"])] = root(s["b"])
    used = degrees(graph) > 0
    return len({root(i) for i in range(len(parent)) if used[i]})


def summary(graph: dict) -> dict:
    """genus = struts - nodes + components, summed over the components."""
    nodes, struts, parts = int((degrees(graph) > 0).sum()), len(graph["struts"]), components(graph)
    return {"nodes": nodes, "struts": struts, "cones": sum(map(is_tapered, graph["struts"])), "components": parts,
            "genus": struts - nodes + parts}

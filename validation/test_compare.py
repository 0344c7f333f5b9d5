"""The comparison on lattices of a few struts. Run by pytest."""

from __future__ import annotations

import json

import numpy as np

import compare
import generated
from graphs import summary


def test_all_build_the_same_lattice(tmp_path):
    graph = generated.bcc(1, tmp_path / "bcc1.json")
    measured = [compare.measure("cell", peer, graph) for peer in compare.PEERS]
    for m in measured:
        assert m["struts"] == 8 and len(m["found"]) == 3
        assert all("error" not in found and found["solids"] == 1 for found in m["found"].values()), m
        volumes = [found["volume_mm3"] for found in m["found"].values()]
        assert max(volumes) < 1.05 * min(volumes), volumes
    assert all(found["valid"] for found in measured[0]["found"].values())
    lines = compare.page(measured).splitlines()
    assert sum(line.startswith("| cell |") for line in lines) == 6


def test_a_peer_that_fails_is_a_row_with_its_reason(tmp_path):
    graph = tmp_path / "bad.json"
    graph.write_text(json.dumps({"nodes": [[0, 0, 0], [0, 0, 0]], "struts": [{"a": 0, "b": 1, "ra": 1, "rb": 1}]}))
    measured = compare.measure("no length", "occ", graph)
    assert all("error" in found for found in measured["found"].values())
    assert len(compare.rows([measured])) == 3


def test_a_part_becomes_a_lattice(tmp_path):
    graph = json.loads(generated.tetrahedral(15, tmp_path / "part.json").read_text())
    nodes, found = np.array(graph["nodes"]), summary(graph)
    assert found["components"] == 1 and found["nodes"] == len(nodes)
    lengths = [np.linalg.norm(nodes[s["a"]] - nodes[s["b"]]) for s in graph["struts"]]
    assert all(np.isclose(8 * s["ra"], min(lengths)) for s in graph["struts"])
    assert np.allclose([nodes.min(axis=0), nodes.max(axis=0)], [[0, 0, 0], [80, 50, 40]])


def test_moved_nodes_stay_near_and_are_the_same_each_time(tmp_path):
    still, moved, again = (json.loads(make(2, tmp_path / "g.json").read_text())["nodes"] for make in (generated.bcc, generated.jittered, generated.jittered))
    assert moved == again
    assert 0.5 < np.abs(np.array(moved) - np.array(still)).max() <= 1

"""Does the file hold what the graph promises?

One cylinder face a strut of one radius, one cone face a tapered strut; two CIRCLE entities a strut in the file's text; faces = struts + patches + caps; one skin a node
of degree 2 or more; V - E + F = 2 (nodes - struts), which is 2 sum (1 - genus) over the components. Counted in the text and in the
kernel's shape: a kernel that repairs on import shows up as a difference.
`expected`: nodes, struts, cylinders, cones, patches, caps, faces, skins; each optional.
"""

from __future__ import annotations

from collections import Counter

from checks import main, verdict
from model import STRUT_KINDS, load
from skins import skins


def check(model_or_path, expected: dict) -> dict:
    model = load(model_or_path)
    why = []

    def want(what: str, found, wanted) -> None:
        if wanted is not None and found != wanted:
            why.append(f"{what}: {found}, wanted {wanted}")

    kinds = Counter(face.kind for face in model.faces)
    struts = sum(kinds[k] for k in STRUT_KINDS)
    patches = kinds["spline"]
    caps = kinds["plane"] + kinds["sphere"]
    faces = len(model.faces)
    edges = sum(1 for edge in model.edges if not edge.degenerate)
    euler = len(model.vertices) - edges + faces
    text = model.text.entities

    want("strut faces", struts, expected.get("struts"))
    for kind in STRUT_KINDS:
        want(f"{kind}s", kinds[kind], expected.get(f"{kind}s"))
    want("patches", patches, expected.get("patches"))
    want("caps", caps, expected.get("caps"))
    want("faces", faces, expected.get("faces"))
    want("faces of other kinds", kinds["other"], 0)
    want("faces = struts + patches + caps", faces, struts + patches + caps)
    want("CIRCLE entities", text["CIRCLE"], 2 * struts + kinds["sphere"])  # a sphere cap's seam is a circle too
    if {"nodes", "struts"} <= expected.keys():
        want("Euler number", euler, 2 * (expected["nodes"] - expected["struts"]))
    want("skins", len(skins(model)), expected.get("skins"))
    want("ADVANCED_FACE in the text against faces read", faces, text["ADVANCED_FACE"])
    want("EDGE_CURVE in the text against edges read", edges, text["EDGE_CURVE"])
    want("VERTEX_POINT in the text against vertices read", len(model.vertices), text["VERTEX_POINT"])
    return verdict(why, struts=struts, cones=kinds["cone"], patches=patches, caps=caps, faces=faces, edges=edges,
                   vertices=len(model.vertices), circles=text["CIRCLE"], euler=euler)


if __name__ == "__main__":
    main(check)

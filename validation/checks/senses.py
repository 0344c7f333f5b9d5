"""Are the senses in the file right as written? OCC turns wrong faces and shells round while it reads, so no kernel's answer shows this;
another reader may not be so kind. Read from the text alone:

1. each EDGE_CURVE is used twice, in opposite senses (ORIENTED_EDGE times FACE_BOUND);
2. a patch's loop runs round its surface's normal: it passes the corners of the control net, which run counter-clockwise about du x dv,
   in that order, turned by the face's same_sense;
3. a strut's face has same_sense .T. (its normal leaves the axis), and each rim runs counter-clockwise about the direction to the other rim;
4. a cap's normal leads away from the strut, and its loop runs round it.
Together with 1, one right face makes its whole shell face outward; an ORIENTED_CLOSED_SHELL or a void shell is refused.
"""

from __future__ import annotations

import re
from collections import Counter

import numpy as np

from checks import main, verdict
from model import load

REF = re.compile(r"#(\d+)")
NET = re.compile(r"B_SPLINE_SURFACE(?:_WITH_KNOTS)?\s*\(\s*(?:'[^']*'\s*,)?\s*\d+\s*,\s*\d+\s*,\s*\((\(.*?\))\s*\)\s*,", re.S)
ROW = re.compile(r"\(([^()]*)\)")
FLAG = re.compile(r"\.([TF])\.")


class Entities:
    def __init__(self, text: str):
        self.body = {i: b for i, b in re.findall(r"^\s*#(\d+)\s*=\s*(.*?);\s*$", text, re.M | re.S)}
        self.points: dict[str, np.ndarray] = {}

    def of(self, name: str):
        return ((i, b) for i, b in self.body.items() if b.startswith(name))

    def refs(self, i: str) -> list[str]:
        return REF.findall(self.body[i])

    def triple(self, i: str) -> np.ndarray:
        """Coordinates of a point or direction."""
        if i not in self.points:
            inner = self.body[i][self.body[i].rindex("(") + 1:]
            self.points[i] = np.array([float(x) for x in inner.rstrip(") \n").split(",")])
        return self.points[i]

    def flag(self, i: str) -> bool:
        return FLAG.findall(self.body[i])[-1] == "T"


def runs_round(corners: np.ndarray, loop: list[np.ndarray]) -> bool:
    """Whether a loop's vertices pass the four corners, counter-clockwise about the normal, in that order."""
    at = [int(np.argmin(np.linalg.norm(np.array(loop) - c, axis=1))) for c in corners]
    steps = [(b - a) % len(loop) for a, b in zip(at, at[1:] + at[:1])]
    return min(steps) > 0 and sum(steps) == len(loop)


class Step:
    """One edge as a loop walks it."""

    def __init__(self, e: Entities, oriented: str, bound: bool):
        self.edge = e.refs(oriented)[0]
        self.forward = e.flag(oriented) == bound
        a, b, curve = e.refs(self.edge)
        while e.body[curve].startswith(("SURFACE_CURVE", "INTERSECTION_CURVE", "SEAM_CURVE")):
            curve = e.refs(curve)[0]
        self.start = e.triple(e.refs(a if self.forward else b)[0])
        self.turn = None  # for an arc: its centre and the axis about which it is walked counter-clockwise
        if e.body[curve].startswith("CIRCLE"):
            place = e.refs(e.refs(curve)[0])
            along = self.forward == e.flag(self.edge)
            self.turn = (e.triple(place[0]), e.triple(place[1]) * (1 if along else -1))


def check(model_or_path, expected: dict) -> dict:
    e = Entities(load(model_or_path).text.text)
    uses: Counter = Counter()
    bad = {"edges": 0, "patches": 0, "struts": 0, "caps": 0}
    first: dict[str, str] = {}

    def fault(kind: str, i: str) -> None:
        bad[kind] += 1
        first.setdefault(kind, i)

    caps, inward = [], {}
    faces = [f for i, _ in e.of("CLOSED_SHELL") for f in e.refs(i)]
    for i in faces:
        *bounds, surface = e.refs(i)
        same = e.flag(i)
        walk = [Step(e, o, e.flag(b)) for b in bounds for o in e.refs(e.refs(b)[0])[:: 1 if e.flag(b) else -1]]
        uses.update((s.edge, s.forward) for s in walk)
        kind = e.body[surface]
        net = NET.search(kind)
        if net:
            rows = [REF.findall(r) for r in ROW.findall(net.group(1))]
            corners = np.array([e.triple(p) for p in (rows[0][0], rows[-1][0], rows[-1][-1], rows[0][-1])])
            if not runs_round(corners if same else corners[::-1], [s.start for s in walk]):
                fault("patches", i)
        elif kind.startswith(("CYLINDRICAL", "CONICAL")):
            arcs = [s for s in walk if s.turn]
            middle = np.mean([s.turn[0] for s in arcs], axis=0)
            # `middle` lies between the two rims' centres, so the way to it is the way to the other rim.
            if not same or any(np.dot(s.turn[1], middle - s.turn[0]) <= 0 for s in arcs):
                fault("struts", i)
            inward.update({s.edge: middle - s.turn[0] for s in arcs})
        elif kind.startswith("PLANE"):
            normal = e.triple(e.refs(e.refs(surface)[0])[1]) * (1 if same else -1)
            if any(s.turn and np.dot(s.turn[1], normal) <= 0 for s in walk):
                fault("caps", i)
            caps.append((i, normal, walk))
    for i, normal, walk in caps:
        if any(np.dot(normal, inward[s.edge]) >= 0 for s in walk if s.edge in inward):
            fault("caps", i)
    for i, _ in e.of("EDGE_CURVE"):
        if uses[i, True] != 1 or uses[i, False] != 1:
            fault("edges", i)

    words = {"edges": "not used once in each sense", "patches": "with a loop against their normal",
             "struts": "facing inward or with a rim run backwards", "caps": "facing inward or run backwards"}
    why = [f"{n} {kind} {words[kind]}, the first #{first[kind]}" for kind, n in bad.items() if n]
    orphans = {i for i, _ in e.of("ADVANCED_FACE")} ^ set(faces)
    if orphans or len(faces) != len(set(faces)):
        why.append(f"{len(orphans)} faces in no shell, {len(faces) - len(set(faces))} in two")
    for name in ("ORIENTED_CLOSED_SHELL", "BREP_WITH_VOIDS", "OPEN_SHELL"):
        if any(True for _ in e.of(name)):
            why.append(f"{name} in the file")
    return verdict(why, **{f"bad_{k}": n for k, n in bad.items()})


if __name__ == "__main__":
    main(check)

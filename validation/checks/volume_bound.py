"""Is the solid as big as its struts say? A bound on the volume that knows the graph and nothing of our surfaces.

From below: the union of the struts' cylinders and the nodes' spheres (manifold3d), since a blend fills crotches.
From above: the same union with the convex hull of every node's rims added (read from the file), since a skin hardly leaves it.
Cylinders and spheres are polygons here, widened to the true cross-section's area; what is left is below 1e-3.
`expected["graph"]` = {nodes, struts} is required, as in the lattice JSON.
"""

from __future__ import annotations

import manifold3d
import numpy as np
from OCP.BRepGProp import BRepGProp
from OCP.GProp import GProp_GProps

from checks import main, verdict
from model import load
from skins import skins

SEGMENTS = 48
BELOW, ABOVE = 1e-3, 1e-2  # allowed shortfall and excess, relative: polygon error, and the film's own small bulges


def turned(direction) -> np.ndarray:
    """A rotation whose z column is the direction."""
    z = direction / np.linalg.norm(direction)
    x = np.cross(z, np.eye(3)[np.argmin(np.abs(z))])
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def fair_radius(r: float) -> float:
    """Radius of the regular polygon whose area is the circle's."""
    return r * np.sqrt(2 * np.pi / (SEGMENTS * np.sin(2 * np.pi / SEGMENTS)))


def strut(a, b, ra, rb):
    length = float(np.linalg.norm(b - a))
    body = manifold3d.Manifold.cylinder(length, fair_radius(ra), fair_radius(rb), SEGMENTS)
    return body.transform(np.column_stack([turned(b - a), a]))


def ball(at, r):
    ball = manifold3d.Manifold.sphere(1.0, SEGMENTS)
    return ball.scale([r * (4 / 3 * np.pi / ball.volume()) ** (1 / 3)] * 3).translate(list(at))


def bodies(graph: dict):
    nodes = np.array(graph["nodes"], float)
    degree, largest = np.zeros(len(nodes), int), np.zeros(len(nodes))
    out = []
    for s in graph["struts"]:
        for end, r in ((s["a"], s["ra"]), (s["b"], s["rb"])):
            degree[end] += 1
            largest[end] = max(largest[end], r)
        out.append(strut(nodes[s["a"]], nodes[s["b"]], s["ra"], s["rb"]))
    out += [ball(nodes[i], largest[i]) for i in range(len(nodes)) if degree[i] > 1]  # an end of degree 1 has a flat cap
    return out


def hulls(model):
    """Convex hull of each skin's rims, from points sampled on them."""
    from OCP.BRepAdaptor import BRepAdaptor_Curve

    rims: dict[int, list] = {}
    owner = {}
    found = skins(model)
    for i, skin in enumerate(found):
        for patch in skin.patches:
            owner[patch.index] = i
    for use in model.edges:
        sorts = {f.kind: f for f, _ in use.uses}
        if "spline" in sorts and ("cylinder" in sorts or "cone" in sorts):
            curve = BRepAdaptor_Curve(use.edge)
            for t in np.linspace(curve.FirstParameter(), curve.LastParameter(), 9):
                p = curve.Value(t)
                rims.setdefault(owner[sorts["spline"].index], []).append((p.X(), p.Y(), p.Z()))
    return [manifold3d.Manifold.hull_points(np.array(points)) for points in rims.values()]


def check(model_or_path, expected: dict) -> dict:
    if "graph" not in expected:
        return verdict(["no graph to compare with"])
    model = load(model_or_path)
    measured = GProp_GProps()
    BRepGProp.VolumeProperties_s(model.shape, measured)
    volume = measured.Mass()
    parts = bodies(expected["graph"])
    union = manifold3d.Manifold.batch_boolean(parts, manifold3d.OpType.Add)
    low = union.volume()
    high = manifold3d.Manifold.batch_boolean([union, *hulls(model)], manifold3d.OpType.Add).volume()
    why = []
    if volume < low * (1 - BELOW):
        why.append(f"volume {volume:.6g} mm3 is below the union of struts and spheres, {low:.6g}, by {1 - volume / low:.2e} of it")
    if volume > high * (1 + ABOVE):
        why.append(f"volume {volume:.6g} mm3 is above the union with the nodes' hulls, {high:.6g}, by {volume / high - 1:.2e} of it")
    return verdict(why, volume_mm3=volume, union_mm3=low, hulls_mm3=high, above_union=volume / low - 1)


if __name__ == "__main__":
    main(check)

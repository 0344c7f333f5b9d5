"""Is the solid as big as its struts say? A bound on the volume that knows the graph and nothing of our surfaces (manifold3d).

From below: the union of the struts' cylinders, each ending flat at its node's centre; a faired skin may fall short of it by a little inside
the nodes' zones (their rims' hulls, read from the file), where it rounds off ridges. Spheres at the nodes are not part of the bound:
a smooth elbow lies inside them on its outer side (measured: by 0.84 r^3 at a bend of 70 degrees), so they are only reported.
From above: the same union with the zones filled, since a skin hardly leaves its rims' hull.
Cylinders and spheres are polygons here, widened to the true cross-section's area.
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
POLYGONS = 1e-3  # relative error of the union, from polygons
# Shortfall allowed inside the nodes' zones, of the union's volume there. Measured on 260 random nodes: median 0.6 %, all but one at most 4 %, and
# 11.2 % on the one whose four struts lie within 41 degrees of one axis, where the skin rounds off all their ends behind the node.
IN_ZONES = 0.15
ABOVE = 1e-2  # excess over the filled zones, relative: a skin's small bulges


def turned(direction) -> np.ndarray:
    """A rotation whose z column is the direction."""
    z = direction / np.linalg.norm(direction)
    x = np.cross(z, np.eye(3)[np.argmin(np.abs(z))])
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def fair_radius(r: float, segments: int) -> float:
    """Radius of the regular polygon whose area is the circle's."""
    return r * np.sqrt(2 * np.pi / (segments * np.sin(2 * np.pi / segments)))


def strut(a, b, ra, rb, segments: int = SEGMENTS):
    length = float(np.linalg.norm(b - a))
    body = manifold3d.Manifold.cylinder(length, fair_radius(ra, segments), fair_radius(rb, segments), segments)
    return body.transform(np.column_stack([turned(b - a), a]))


def ball(at, r, segments: int):
    ball = manifold3d.Manifold.sphere(1.0, segments)
    return ball.scale([r * (4 / 3 * np.pi / ball.volume()) ** (1 / 3)] * 3).translate(list(at))


def bodies(graph: dict, segments: int = SEGMENTS):
    """The struts' cylinders (or cones), and the spheres of the nodes where struts meet."""
    nodes = np.array(graph["nodes"], float)
    degree, largest, struts = np.zeros(len(nodes), int), np.zeros(len(nodes)), []
    for s in graph["struts"]:
        for end, r in ((s["a"], s["ra"]), (s["b"], s["rb"])):
            degree[end] += 1
            largest[end] = max(largest[end], r)
        struts.append(strut(nodes[s["a"]], nodes[s["b"]], s["ra"], s["rb"], segments))
    return struts, [ball(nodes[i], largest[i], segments) for i in range(len(nodes)) if degree[i] > 1]  # a free end has a flat cap


def union(parts):
    return manifold3d.Manifold.batch_boolean(parts, manifold3d.OpType.Add)


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
    struts, spheres = bodies(expected["graph"])
    low, zones = union(struts), union(hulls(model))
    crossing = (low ^ zones).volume()
    least = low.volume() * (1 - POLYGONS) - IN_ZONES * crossing
    most = union([low, zones]).volume() * (1 + ABOVE)
    why = []
    if volume < least:
        why.append(f"volume {volume:.6g} mm3 is {low.volume() - volume:.3g} below the union of the struts, allowed {low.volume() - least:.3g}")
    if volume > most:
        why.append(f"volume {volume:.6g} mm3 is above the struts with the nodes' zones filled, {most:.6g}")
    return verdict(why, volume_mm3=volume, struts_mm3=low.volume(), zones_mm3=zones.volume(),
                   above_union=volume / low.volume() - 1, in_zones=(volume - low.volume()) / crossing if crossing else 0.0,
                   above_spheres=volume / union([low, *spheres]).volume() - 1)


if __name__ == "__main__":
    main(check)

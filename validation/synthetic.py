"""Writes by hand the smallest lattice that is right by construction, or wrong in one chosen way: the known answer for the checks.

One straight node of radius 1 on the z axis between two struts with flat caps. The struts are cylinders, 1 <= |z| <= 4, or cones whose
radius falls by t (grows, if below 0) per length away from the node; the node is eight rational patches of degree 2 x 4 whose profile radius is
1 + h (1 - z^2)^2 + t/2 (1 - z^2): circles exact, tangent to the struts, smooth at z = 0.
Volume and area are known in closed form (area to round-off by Gauss quadrature).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import comb

import numpy as np

BULGE = 0.02  # a hundredth of the volume: within what `volume_bound` allows a skin to rise over its rims' hull
HALF_NODE, HALF_LENGTH = 1.0, 4.0
QUARTERS = 4


@dataclass
class Fault:
    """What to get wrong; the default is nothing."""

    rim_deg: float = 0.0  # slope of the patches at the rim z = +1
    inside_deg: float = 0.0  # crease at z = 0
    gap_mm: float = 0.0  # the patches' rim stands off the circle by this
    fold: bool = False  # the profile runs back on itself
    drop_face: bool = False
    flip_face: bool = False
    inside_out: bool = False
    volume_factor: float = 1.0  # validation property and true volume
    extra_circle: bool = False
    copies: int = 1  # further solids along x
    taper: float = 0.0  # no fault: fall of the struts' radius per length
    pcurves: str = "fitted"  # rims on the patches: "none", "line" (right place, wrong speed) or "fitted" to the circle's own parameter


def profile(fault: Fault) -> tuple[np.ndarray, np.ndarray]:
    """(radius, z) of the Bezier control points, bottom half and top half, 2 x 5 x 2."""
    # 1 + h (1 - z^2)^2 on z in [0, 1] as a Bezier curve of degree 4: monomials 1, -2z^2, z^4.
    top = 1 + BULGE * (1 - 2 * np.array([0, 0, 1 / 6, 1 / 2, 1]) + np.array([0, 0, 0, 0, 1]))
    top = top + fault.taper / 2 * (1 - np.array([0, 0, 1 / 6, 1 / 2, 1]))  # z^2 in the same basis
    radius = np.array([top[::-1], top])
    z = np.array([np.linspace(-1, 0, 5), np.linspace(0, 1, 5)])
    radius[1, 3] -= np.tan(np.radians(fault.rim_deg)) * 0.25
    radius[1, 1] -= np.tan(np.radians(fault.inside_deg)) * 0.25
    radius[1, 4] += fault.gap_mm
    if fault.fold:
        z[1] = [0, 1.6, 0.5, -0.6, 1]  # runs ahead, back and ahead again
    return radius, z


def end_radius(taper: float) -> float:
    return 1 - taper * (HALF_LENGTH - HALF_NODE)


def truth(taper: float = 0.0) -> dict:
    x, w = np.polynomial.legendre.leggauss(40)
    r, slope = 1 + BULGE * (1 - x**2) ** 2 + taper / 2 * (1 - x**2), -4 * BULGE * x * (1 - x**2) - taper * x
    length, end = HALF_LENGTH - HALF_NODE, end_radius(taper)
    volume = np.pi * (np.sum(w * r**2) + 2 / 3 * length * (1 + end + end**2))
    area = 2 * np.pi * (np.sum(w * r * np.sqrt(1 + slope**2)) + (1 + end) * np.hypot(length, 1 - end) + end**2)
    return {"volume_mm3": float(volume), "area_mm2": float(area), "centroid_mm": [0.0, 0.0, 0.0]}


def expected(taper: float = 0.0) -> dict:
    """What the checks should be told of the solid without a fault."""
    middle, end, cones = 1 + taper * HALF_NODE, end_radius(taper), 2 if taper else 0
    graph = {"nodes": [[0, 0, -4], [0, 0, 0], [0, 0, 4]],
             "struts": [{"a": 0, "b": 1, "ra": end, "rb": middle}, {"a": 1, "b": 2, "ra": middle, "rb": end}]}
    return {"nodes": 3, "struts": 2, "cylinders": 2 - cones, "cones": cones, "patches": 8, "caps": 2, "faces": 12, "circles": 4, "skins": 1,
            "components": 1, "radius_mm": 1.0, "graph": graph, "lattice": graph,
            "report_counts": {"nodes": 3, "struts": 2, "cylinders": 2 - cones, "cones": cones, "patches": 8, "caps": 2, "faces": 12,
                              "circles": 4, "components": 1, "genus": 0},
            "graph_counts": {"nodes": 3, "struts": 2, "cones": cones, "components": 1, "genus": 0},
            "report": {"rungs": {"soap_film": 1}},
            **truth(taper)}


def real(x) -> str:
    """A STEP real: a point always, the exponent in upper case (OCC 7.6 reads `6.1e-17` as 6.1)."""
    mantissa, _, exponent = repr(float(x)).partition("e")
    return (mantissa if "." in mantissa else mantissa + ".") + (f"E{exponent}" if exponent else "")


class Writer:
    def __init__(self, inside_out: bool = False):
        self.lines: list[str] = []
        self.inside_out = inside_out

    def add(self, text: str) -> str:
        self.lines.append(text)
        return f"#{len(self.lines)}"

    def point(self, p) -> str:
        return self.add(f"CARTESIAN_POINT('',({','.join(map(real, p))}))")

    def direction(self, d) -> str:
        return self.add(f"DIRECTION('',({','.join(map(real, d))}))")

    def placement(self, p, z, x=(1, 0, 0)) -> str:
        return self.add(f"AXIS2_PLACEMENT_3D('',{self.point(p)},{self.direction(z)},{self.direction(x)})")

    def vertex(self, p) -> str:
        return self.add(f"VERTEX_POINT('',{self.point(p)})")

    def edge(self, a, b, curve) -> str:
        return self.add(f"EDGE_CURVE('',{a},{b},{curve},.T.)")

    def loop(self, edges) -> str:
        oriented = [self.add(f"ORIENTED_EDGE('',*,*,{e},.{'T' if forward else 'F'}.)") for e, forward in edges]
        ring = self.add(f"EDGE_LOOP('',({','.join(oriented)}))")
        return self.add(f"FACE_OUTER_BOUND('',{ring},.{'F' if self.inside_out else 'T'}.)")

    def face(self, bound, surface, same=True) -> str:
        return self.add(f"ADVANCED_FACE('',({bound}),{surface},.{'T' if same != self.inside_out else 'F'}.)")


def clamped(degree: int) -> str:
    return f"({degree + 1},{degree + 1}),(0.,1.),.UNSPECIFIED."


def curve(w: Writer, points, weights=None) -> str:
    names, degree = ",".join(w.point(p) for p in points), len(points) - 1
    if weights is None:
        return w.add(f"B_SPLINE_CURVE_WITH_KNOTS('',{degree},({names}),.UNSPECIFIED.,.F.,.F.,{clamped(degree)})")
    return w.add(f"(BOUNDED_CURVE() B_SPLINE_CURVE({degree},({names}),.UNSPECIFIED.,.F.,.F.) B_SPLINE_CURVE_WITH_KNOTS({clamped(degree)}) "
                 f"CURVE() GEOMETRIC_REPRESENTATION_ITEM() RATIONAL_B_SPLINE_CURVE(({','.join(map(real, weights))})) REPRESENTATION_ITEM(''))")


def rim_pcurve(w: Writer, mode: str, surface: str, q: int, v: float, plane: str) -> str:
    """u over the circle's angle: tan of half the angle from the arc's middle, as a polynomial of degree 9 (error 1e-10)."""
    start, half = q * np.pi / 2, np.pi / 4
    points = [(0.0, v), (1.0, v)]
    if mode == "fitted":
        degree = 9
        t = 0.5 - 0.5 * np.cos(np.pi * (np.arange(degree + 1)) / degree)
        u = 0.5 + 0.5 * np.tan((2 * t - 1) * half / 2) / np.tan(half / 2)
        basis = np.array([[comb(degree, i) * x**i * (1 - x) ** (degree - i) for i in range(degree + 1)] for x in t])
        points = [(x, v) for x in np.linalg.solve(basis, u)]
    degree = len(points) - 1
    names = ",".join(w.point(p) for p in points)
    line = w.add(f"B_SPLINE_CURVE_WITH_KNOTS('',{degree},({names}),.UNSPECIFIED.,.F.,.F.,({degree + 1},{degree + 1}),"
                 f"({real(start)},{real(start + 2 * half)}),.UNSPECIFIED.)")
    return w.add(f"PCURVE('',{surface},{w.add(f'DEFINITIONAL_REPRESENTATION({chr(39)}{chr(39)},({line}),{plane})')})")


def solid(w: Writer, fault: Fault, shift: float) -> str:
    radius, z = profile(fault)
    root = 0.5**0.5
    at = lambda r, angle, height: (r * np.cos(angle) + shift, r * np.sin(angle), height)  # noqa: E731
    angles = [2 * np.pi * q / QUARTERS for q in range(QUARTERS)]

    def arc_points(r, q, height):
        a, b = angles[q], angles[q] + np.pi / 2
        c, s = np.cos(a), np.sin(a)
        return [at(r, a, height), (r * (c - s) + shift, r * (s + c), height), at(r, b, height)]

    levels = [-HALF_NODE, 0.0, HALF_NODE]
    rings = [[w.vertex(at([1, radius[0, 4], 1][i], a, h)) for a in angles] for i, h in enumerate(levels)]
    circles = {i: w.add(f"CIRCLE('',{w.placement((shift, 0, levels[i]), (0, 0, 1))},1.)") for i in (0, 2)}
    sides = [[w.edge(rings[h][q], rings[h + 1][q], curve(w, [at(r, angles[q], y) for r, y in zip(radius[h], z[h])])) for q in range(QUARTERS)]
             for h in range(2)]
    surfaces = {}
    for h in range(2):
        for q in range(QUARTERS):
            net = [",".join(w.point(p) for p in column)
                   for column in zip(*[arc_points(r, q, y) for r, y in zip(radius[h], z[h])])]
            grid = ",".join(f"({row})" for row in net)
            weights = ",".join("(" + ",".join([real(x)] * 5) + ")" for x in (1.0, root, 1.0))
            surfaces[h, q] = w.add(
                f"(BOUNDED_SURFACE() B_SPLINE_SURFACE(2,4,({grid}),.UNSPECIFIED.,.F.,.F.,.F.) "
                f"B_SPLINE_SURFACE_WITH_KNOTS((3,3),(5,5),(0.,1.),(0.,1.),.UNSPECIFIED.) GEOMETRIC_REPRESENTATION_ITEM() "
                f"RATIONAL_B_SPLINE_SURFACE(({weights})) REPRESENTATION_ITEM('') SURFACE())")
    flat = w.add("(GEOMETRIC_REPRESENTATION_CONTEXT(2) PARAMETRIC_REPRESENTATION_CONTEXT() REPRESENTATION_CONTEXT('',''))")
    arcs = []
    for i in range(3):
        arcs.append([])
        for q in range(QUARTERS):
            line = circles[i] if i != 1 else curve(w, arc_points(radius[0, 4], q, 0.0), [1.0, root, 1.0])
            if i != 1 and fault.pcurves != "none":
                line = w.add(f"SURFACE_CURVE('',{line},({rim_pcurve(w, fault.pcurves, surfaces[i // 2, q], q, i / 2, flat)}),.CURVE_3D.)")
            arcs[i].append(w.edge(rings[i][q], rings[i][(q + 1) % QUARTERS], line))
    faces = []
    for h in range(2):
        for q in range(QUARTERS):
            bound = w.loop([(arcs[h][q], True), (sides[h][(q + 1) % QUARTERS], True), (arcs[h + 1][q], False), (sides[h][q], False)])
            faces.append(w.face(bound, surfaces[h, q], not (fault.flip_face and h == 0 and q == 0)))
    for sign, i in ((-1, 0), (1, 2)):
        thin = end_radius(fault.taper)
        end = w.vertex(at(thin, 0, sign * HALF_LENGTH))
        ring = w.add(f"CIRCLE('',{w.placement((shift, 0, sign * HALF_LENGTH), (0, 0, 1))},{real(thin)})")
        rim = w.edge(end, end, ring)
        tall = np.hypot(1, fault.taper)
        upward = w.direction((-sign * fault.taper / tall, 0, 1 / tall))
        line = w.add(f"LINE('',{w.point(at(1, 0, sign * HALF_NODE))},{w.add(f'VECTOR({chr(39)}{chr(39)},{upward},1.)')})")
        low, high = (end, rings[0][0]) if sign < 0 else (rings[2][0], end)
        seam = w.edge(low, high, line)
        inner = [(e, True) for e in arcs[i]]
        if sign > 0:
            ordered = inner + [(seam, True), (rim, False), (seam, False)]
        else:
            ordered = [(rim, True), (seam, True)] + [(e, False) for e, _ in reversed(inner)] + [(seam, False)]
        if fault.taper:
            # At the rim from which the radius grows: the half-angle of a cone is above 0.
            at_rim, away = (HALF_LENGTH, -sign) if fault.taper > 0 else (HALF_NODE, sign)
            place = w.placement((shift, 0, sign * at_rim), (0, 0, away))
            side = w.add(f"CONICAL_SURFACE('',{place},{real(min(thin, 1))},{real(np.arctan(abs(fault.taper)))})")
        else:
            side = w.add(f"CYLINDRICAL_SURFACE('',{w.placement((shift, 0, 0), (0, 0, 1))},1.)")
        faces.append(w.face(w.loop(ordered), side))
        plane = w.add(f"PLANE('',{w.placement((shift, 0, sign * HALF_LENGTH), (0, 0, sign))})")
        faces.append(w.face(w.loop([(rim, sign > 0)]), plane))
    if fault.drop_face:
        faces.pop(0)
    shell = w.add(f"CLOSED_SHELL('',({','.join(faces)}))")
    return w.add(f"MANIFOLD_SOLID_BREP('',{shell})")


def step(fault: Fault = Fault()) -> str:
    w = Writer(fault.inside_out)
    app = w.add("APPLICATION_CONTEXT('automotive_design')")
    w.add(f"APPLICATION_PROTOCOL_DEFINITION('international standard','automotive_design',2000,{app})")
    product = w.add(f"PRODUCT('control','control','',({w.add(f'PRODUCT_CONTEXT({chr(39)}{chr(39)},{app},{chr(39)}mechanical{chr(39)})')}))")
    formation = w.add(f"PRODUCT_DEFINITION_FORMATION('','',{product})")
    definition = w.add(f"PRODUCT_DEFINITION('design','',{formation},{w.add(f'PRODUCT_DEFINITION_CONTEXT({chr(39)}part definition{chr(39)},{app},{chr(39)}design{chr(39)})')})")
    shape = w.add(f"PRODUCT_DEFINITION_SHAPE('','',{definition})")
    mm = w.add("(LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(.MILLI.,.METRE.))")
    rad = w.add("(NAMED_UNIT(*) PLANE_ANGLE_UNIT() SI_UNIT($,.RADIAN.))")
    sr = w.add("(NAMED_UNIT(*) SI_UNIT($,.STERADIAN.) SOLID_ANGLE_UNIT())")
    error = w.add(f"UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(1.E-07),{mm},'distance_accuracy_value','')")
    context = w.add(f"(GEOMETRIC_REPRESENTATION_CONTEXT(3) GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT(({error})) "
                    f"GLOBAL_UNIT_ASSIGNED_CONTEXT(({mm},{rad},{sr})) REPRESENTATION_CONTEXT('',''))")
    solids = [solid(w, fault, 3.0 * k) for k in range(fault.copies)]
    brep = w.add(f"ADVANCED_BREP_SHAPE_REPRESENTATION('',({w.placement((0, 0, 0), (0, 0, 1))},{','.join(solids)}),{context})")
    w.add(f"SHAPE_DEFINITION_REPRESENTATION({shape},{brep})")
    known = truth(fault.taper)
    cubic = w.add(f"DERIVED_UNIT(({w.add(f'DERIVED_UNIT_ELEMENT({mm},3.)')}))")
    square = w.add(f"DERIVED_UNIT(({w.add(f'DERIVED_UNIT_ELEMENT({mm},2.)')}))")
    for item in (f"MEASURE_REPRESENTATION_ITEM('volume measure',VOLUME_MEASURE({real(known['volume_mm3'] * fault.volume_factor)}),{cubic})",
                 f"MEASURE_REPRESENTATION_ITEM('surface area measure',AREA_MEASURE({real(known['area_mm2'])}),{square})",
                 "CARTESIAN_POINT('centre point',(0.,0.,0.))"):
        named = w.add(f"PROPERTY_DEFINITION('geometric validation property','',{shape})")
        w.add(f"PROPERTY_DEFINITION_REPRESENTATION({named},{w.add(f'REPRESENTATION({chr(39)}{chr(39)},({w.add(item)}),{context})')})")
    if fault.extra_circle:
        w.add(f"CIRCLE('',{w.placement((0, 0, 0), (0, 0, 1))},1.)")
    data = "\n".join(f"#{i}={line};" for i, line in enumerate(w.lines, 1))
    return ("ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('','',(''),(''),'','','');\n"
            "FILE_SCHEMA(('AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }'));\nENDSEC;\nDATA;\n" + data + "\nENDSEC;\nEND-ISO-10303-21;\n")

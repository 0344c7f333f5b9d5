"""Proves that the checks can fail: each is shown a body that is wrong in a known way and must object, and good ones it must pass.

Run by `.venv/bin/python test_controls.py` or by pytest in the same environment.
"""

from __future__ import annotations

import copy
import sys
import tempfile
from functools import lru_cache
from pathlib import Path
from types import SimpleNamespace

sys.path.insert(0, str(Path(__file__).resolve().parent))

import checks
import numpy as np

import controls
import deviation
import synthetic
import timebox
from checks import valid
from model import Model
from synthetic import Fault

TAPER = 0.05  # of the struts of the tapered node
FOLDER = Path(tempfile.mkdtemp(prefix="lattice-brep-controls-"))


@lru_cache(maxsize=None)
def straight_node(**fault) -> Model:
    path = FOLDER / ("node" + "".join(f"-{k}-{v}" for k, v in fault.items()) + ".step")
    path.write_text(synthetic.step(Fault(**fault)))
    return Model(path)


@lru_cache(maxsize=None)
def control(name: str) -> Model:
    return Model(controls.make(name, FOLDER))


def edited(name: str, old: str, new: str, **fault) -> Model:
    """The good node's file with its text changed once."""
    text = synthetic.step(Fault(**fault))
    assert old in text
    path = FOLDER / f"{name}.step"
    path.write_text(text.replace(old, new, 1))
    return Model(path)


def passes(check: str, model: Model, expected: dict | None = None) -> dict:
    found = checks.run(check, model, synthetic.expected() if expected is None else expected)
    assert found["ok"], f"{check} on {model.path.name}: {found['why']}"
    return found


def fails(check: str, model: Model, because: str, expected: dict | None = None) -> dict:
    found = checks.run(check, model, synthetic.expected() if expected is None else expected)
    assert not found["ok"], f"{check} passed {model.path.name}"
    assert any(because in why for why in found["why"]), f"{check} on {model.path.name}: wanted '{because}' in {found['why']}"
    return found


def told(taper: float = 0.0, **changes) -> dict:
    return {**copy.deepcopy(synthetic.expected(taper)), **changes}


# --- the good bodies pass ---------------------------------------------------------------------------------------------------------


def test_all_checks_pass_the_known_answer():
    for check in checks.ALL:
        passes(check, straight_node())
        passes(check, straight_node(taper=TAPER), told(TAPER))


def test_sound_bodies_pass():
    for name in ("cylinder", "filleted_box"):
        for check in ("text", "senses", "valid", "one_solid", "tolerances", "continuity", "self_intersection", "meshable"):
            passes(check, control(name), {})


# --- each check objects -----------------------------------------------------------------------------------------------------------


def test_report():
    good = synthetic.expected()["report_counts"]
    fails("report", straight_node(), "the report has no counts", {})
    fails("report", straight_node(), "genus: report 1, graph 0", told(report_counts={**good, "genus": 1}))
    fails("report", straight_node(), "cones: report 1, graph 0", told(report_counts={**good, "cones": 1}))
    fails("report", straight_node(), "components", told(report_counts={**good, "components": 2}))
    fails("report", straight_node(), "nodes and", told(report_counts={**good, "struts": 1}))
    passes("report", straight_node(), told(report_counts={**good, "struts": 1, "nodes": 2, "circles": 2}))  # a straight node taken out
    fails("report", straight_node(), "wanted two each", told(report_counts={**good, "circles": 5}))
    fails("report", straight_node(), "lacks faces", told(report_counts={k: v for k, v in good.items() if k != "faces"}))
    fails("report", straight_node(), "G0 rung", told(report={"rungs": {"soap_film": 0, "sharp": [{"node": 1, "degree": 2, "reasons": ["folds"]}]}}))
    level = {"soap_film": 0, "level_set": [{"node": 1, "degree": 2, "reasons": ["folds"]}]}
    passes("report", straight_node(), told(report={"rungs": level}))
    fails("report", straight_node(), "below the first rung", told(report={"rungs": level}, lowered_allowed=0))
    fails("report", straight_node(), "rungs hold 0 of 3", told(report={"rungs": {"soap_film": 0}}))


def test_text_finds_what_a_forgiving_reader_swallows():
    good = "CARTESIAN_POINT('centre point',(0.,0.,0.))"
    fails("text", edited("lower-case", good, good.replace("0.,0.,0.", "1.5e-17,0.,0.")), "illegal numbers")
    fails("text", edited("no-point", good, good.replace("0.,0.,0.", "1E5,0.,0.")), "illegal numbers")
    fails("text", edited("dangling", "CLOSED_SHELL('',(#", "CLOSED_SHELL('',(#99999,#"), "references to nothing")
    fails("text", edited("two-schemas", "ENDSEC;", "FILE_SCHEMA(('CONFIG_CONTROL_DESIGN'));\nENDSEC;"), "FILE_SCHEMA")
    fails("text", edited("cut-short", "END-ISO-10303-21;", ""), "tail")


def test_senses_finds_what_occ_repairs_on_reading():
    flipped, turned = straight_node(flip_face=True), straight_node(inside_out=True)
    fails("senses", flipped, "patches with a loop against their normal")
    fails("senses", turned, "struts facing inward")
    fails("senses", turned, "caps facing inward")
    fails("senses", straight_node(drop_face=True), "edges not used once in each sense")
    fails("senses", control("open_shell"), "OPEN_SHELL", {})
    for repaired in (flipped, turned):  # why the check is there: the kernel's own view is clean
        passes("valid", repaired)
        passes("one_solid", repaired)


def test_valid_needs_both_kernels():
    tube = control("tube_through_itself")
    found = fails("valid", tube, "SelfIntersect", {})
    assert found["occ8"], "OCC 8 alone finds nothing wrong with a tube through itself"
    fails("valid", control("overlapping_boxes"), "SelfIntersect", {"components": 2})
    fails("valid", control("open_shell"), "0 solids", {})
    fails("valid", straight_node(pcurves="none"), "InvalidCurveOnSurface")  # OCC's own fit of the rim is 3e-7 off, over its 1e-7
    fails("valid", straight_node(pcurves="line"), "InvalidCurveOnSurface")
    # What OCC 7.6 makes of exponents in lower case: 6.1e-17 is read as 6.1, and the solid falls apart. OCC 8 reads them well.
    lower = FOLDER / "exponents.step"
    lower.write_text(synthetic.step().replace("E-17", "e-17"))
    assert fails("valid", Model(lower), "isValid says no")["occ8"]
    # OCC 8 repairs whatever comes from a file, so its BRepCheck is shown a shape that never was in one.
    assert any("OCC 8" in why for why in valid.in_occ8(SimpleNamespace(shape=controls.bow_tie_face())))


def test_one_solid():
    fails("one_solid", straight_node(drop_face=True), "0 solids")
    fails("one_solid", straight_node(drop_face=True), "free")
    fails("one_solid", straight_node(copies=2), "2 solids, wanted 1")
    passes("one_solid", straight_node(copies=2), told(components=2))
    fails("one_solid", control("open_shell"), "belong to no solid", {})
    fails("one_solid", control("overlapping_boxes"), "2 solids, wanted 1", {})


def test_counts():
    fails("counts", straight_node(extra_circle=True), "CIRCLE entities: 5, wanted 4")
    fails("counts", straight_node(drop_face=True), "patches: 7, wanted 8")
    fails("counts", straight_node(drop_face=True), "Euler number")
    fails("counts", straight_node(copies=2), "skins: 2, wanted 1")
    fails("counts", straight_node(taper=TAPER), "cylinders: 0, wanted 2")
    for figure in ("struts", "cylinders", "cones", "patches", "caps", "faces", "skins"):
        fails("counts", straight_node(), "wanted", told(**{figure: synthetic.expected()[figure] + 1}))
    fails("counts", straight_node(), "Euler number", told(nodes=4))


def test_radii():
    def lattice(taper: float, factor: float) -> dict:
        graph = copy.deepcopy(synthetic.expected(taper)["lattice"])
        graph["struts"][1]["ra"] *= factor
        return graph

    for taper in (TAPER, -TAPER):
        found = passes("radii", straight_node(taper=taper), told(taper))
        assert found["cones"] == 2 and found["half-angle off"] < 1e-12, found
        fails("radii", straight_node(taper=taper), "rim radius of strut 1", told(taper, lattice=lattice(taper, 1 + 1e-8)))
    fails("radii", straight_node(), "is a cylinder", told(lattice=lattice(0.0, 1 + 1e-8)))
    fails("radii", straight_node(taper=TAPER), "is a cone")
    fails("radii", straight_node(), "no lattice", {})
    # What no kernel minds: a half-angle off by 1e-8 of it moves the surface by 1.5e-9 mm at the other rim, within the tolerance of 1e-7 mm.
    angle = float(np.arctan(TAPER))
    wrong = edited("half-angle", f",{synthetic.real(angle)})", f",{synthetic.real(angle * (1 + 1e-8))})", taper=TAPER)
    passes("valid", wrong, told(TAPER))
    fails("radii", wrong, "half-angle of strut 0", told(TAPER))


def test_volume_area():
    fails("volume_area", straight_node(volume_factor=1.00001), "volume in file")
    truth = synthetic.truth()
    for figure in ("volume_mm3", "area_mm2"):
        fails("volume_area", straight_node(), "in report", told(**{figure: truth[figure] * (1 + 3e-6)}))
    fails("volume_area", straight_node(), "centre in report", told(centroid_mm=[0, 0, 1e-4]))
    fails("volume_area", control("filleted_box"), "lacks validation properties", {})


def test_volume_bound():
    graph = synthetic.expected()["graph"]
    thicker = {**graph, "struts": [{**s, "ra": 1.04, "rb": 1.04} for s in graph["struts"]]}
    thinner = {**graph, "struts": [{**s, "ra": 0.9, "rb": 0.9} for s in graph["struts"]]}
    fails("volume_bound", straight_node(), "below the union of the struts", told(graph=thicker))
    fails("volume_bound", straight_node(), "above the struts", told(graph=thinner))
    fails("volume_bound", straight_node(), "no graph", {})


def test_tolerances():
    fails("tolerances", straight_node(gap_mm=3e-6), "edge tolerance")
    fails("tolerances", straight_node(gap_mm=1e-4), "vertex tolerance")


def test_continuity():
    for degrees in (0.06, 1.0):
        found = fails("continuity", straight_node(rim_deg=degrees), "rim: jump")
        assert abs(found["rim_max_deg"] - degrees) < 1e-3 * degrees and found["inside_max_deg"] < 1e-6, found
    for degrees in (0.11, 1.0):
        found = fails("continuity", straight_node(inside_deg=degrees), "inside: jump")
        assert abs(found["inside_max_deg"] - degrees) < 1e-3 * degrees and found["rim_max_deg"] < 1e-6, found
    passes("continuity", straight_node(rim_deg=0.04))
    found = fails("continuity", straight_node(taper=TAPER, rim_deg=1.0), "rim: jump", told(TAPER))
    assert abs(found["rim_max_deg"] - 1.0) < 0.01, found  # the slope is added to the taper: tangents do not quite add
    passes("continuity", control("round_cone"), {})
    fails("continuity", control("bulging_cone"), "round end: jump", {})
    fails("continuity", straight_node(gap_mm=3e-6), "gap")
    prism = fails("continuity", control("crease_prism"), "inside: jump 90", {})
    assert any(abs(jump - 1.0) < 1e-6 for jump in prism["jumps"]["inside"]), "the crease of 1 degree is not seen"
    fails("continuity", control("open_shell"), "not used twice", {})


def test_fold():
    fails("fold", straight_node(fold=True), "turn against the ray")
    passes("continuity", straight_node(fold=True))  # a fold away from the borders: no other check of borders sees it
    fails("fold", control("crease_prism"), "touch no strut", {})


def test_self_intersection():
    fails("self_intersection", control("tube_through_itself"), "cuts itself", {})
    fails("self_intersection", control("overlapping_boxes"), "cuts itself", {})


def test_time_limits_are_failures():
    sleepy = [sys.executable, "-c", "while True: pass"]
    assert timebox.run(sleepy, 0.5) is None
    assert timebox.run([sys.executable, "-c", "print(1)"], 5).stdout == "1\n"
    fails("valid", straight_node(), "no answer", told(freecad_seconds=1e-3))
    fails("self_intersection", control("overlapping_boxes"), "cuts itself", {"self_intersection_seconds": 60})


def test_meshable():
    fails("meshable", control("tube_through_itself"), "PLC Error", {})
    fails("meshable", control("open_shell"), "no tetrahedra", {})
    fails("meshable", straight_node(copies=2), "2 volumes, wanted 1")


def test_deviation():
    axes = np.array([(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)], float)
    points = np.array([(1, 1, 0), (3, 1.25, 0), (0.5, 0.5, 0)], float) * [[0.5**0.5], [1], [1]]
    # inside on a diagonal the nearest point is on the crease of both cylinders, at sqrt 2
    true = np.array([1 - 2**0.5, 0.25, 0.5**0.5 - 2**0.5])
    found = deviation.compare(axes, points, true)
    assert (found["off"], found["wrong side"]) == (0, 0), found
    bound = np.array([0.5**0.5 - 1, 0.25, -0.5])
    assert deviation.compare(axes, points, bound)["off"] == 2
    assert deviation.compare(axes, points, -true)["wrong side"] == 3


def test_every_check_is_shown_something_bad():
    shown = {name.removeprefix("test_").split("_finds")[0].split("_needs")[0] for name in globals() if name.startswith("test_")}
    assert set(checks.ALL) <= shown, set(checks.ALL) - shown


if __name__ == "__main__":
    tests = [(name, test) for name, test in globals().items() if name.startswith("test_")]
    failed = 0
    for name, test in tests:
        try:
            test()
            print(f"ok    {name}")
        except AssertionError as fault:
            failed += 1
            print(f"FAIL  {name}: {fault}")
    print(f"{len(tests) - failed} passed, {failed} failed")
    sys.exit(1 if failed else 0)

"""The guard on instruction counts can fail. Run by pytest."""

from __future__ import annotations

import json
import sys

import instructions

RECORDED = {"regular": {"instructions": 1000}, "irregular": {"instructions": 2000}}


def test_growth_above_a_tenth_is_named():
    assert instructions.grown(RECORDED, {"regular": 1100, "irregular": 1000}) == []
    assert instructions.grown(RECORDED, {"regular": 1101, "irregular": 2200}) == ["regular: 1,101 instructions, +10.1% of the record 1,000"]


def test_the_command_fails_on_a_record_that_is_exceeded(tmp_path, monkeypatch, capsys):
    """A node against half of what it takes, and against what it takes."""
    row = {"graph": "tests/examples/irregular.json", "export": "export {graph} -q --threads 1 --levels 0 -o {step}"}
    counted = instructions.count(row)
    record = tmp_path / "record.json"
    monkeypatch.setattr(instructions, "RECORD", record)
    monkeypatch.setattr(instructions, "VECTORS", instructions.vectors())  # compared on any machine
    monkeypatch.setattr(sys, "argv", ["instructions"])
    for recorded, code in ((counted // 2, 1), (counted, 0)):
        record.write_text(json.dumps({"one": {**row, "instructions": recorded}}))
        assert instructions.main() == code
        assert ("--record" in capsys.readouterr().err) == bool(code)

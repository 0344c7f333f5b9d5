"""What a STEP file says of itself in plain text: how many entities of a kind, and its validation properties.

No kernel takes part here, so that a kernel's repairs on import cannot hide what the file holds.
"""

from __future__ import annotations

import re
from collections import Counter
from functools import cached_property
from pathlib import Path

NUMBER = r"[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?"
_ENTITY = re.compile(r"#(\d+)\s*=\s*\(?\s*([A-Z0-9_]+)\s*\(")
_PROPERTY = re.compile(
    r"MEASURE_REPRESENTATION_ITEM\s*\(\s*'(volume measure|surface area measure)'\s*,\s*[A-Z_]*\s*\(?\s*(" + NUMBER + ")", re.I
)
_CENTRE = re.compile(
    r"CARTESIAN_POINT\s*\(\s*'centre point'\s*,\s*\(\s*(" + NUMBER + r")\s*,\s*(" + NUMBER + r")\s*,\s*(" + NUMBER + ")", re.I
)


class StepText:
    def __init__(self, path: str | Path):
        self.text = Path(path).read_text(encoding="latin-1")

    @cached_property
    def entities(self) -> Counter:
        """Count of simple entities by name: CIRCLE, ADVANCED_FACE, ..."""
        return Counter(m.group(2) for m in _ENTITY.finditer(self.text))

    @cached_property
    def volumes_mm3(self) -> list[float]:
        return [float(value) for name, value in _PROPERTY.findall(self.text) if name.lower() == "volume measure"]

    @cached_property
    def areas_mm2(self) -> list[float]:
        return [float(value) for name, value in _PROPERTY.findall(self.text) if name.lower() == "surface area measure"]

    @cached_property
    def centroids_mm(self) -> list[tuple[float, float, float]]:
        return [tuple(map(float, point)) for point in _CENTRE.findall(self.text)]

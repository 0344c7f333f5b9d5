"""Is the file good STEP text by itself? What a forgiving reader swallows and another one stumbles over.

Numbers as the standard wants them (a decimal point, an upper-case exponent: OCC 7.6 reads `6.1e-17` as 6.1; no NaN, no infinity), each
entity id once, every reference defined, ASCII, one schema, head and tail in place.
"""

from __future__ import annotations

import re
from collections import Counter

from checks import main, verdict
from model import load

STRING = re.compile(r"'(?:[^']|'')*'")
BAD_NUMBER = re.compile(r"(?<![\w.#])[-+]?(?:\d+\.?\d*e[-+]?\d+|\d+E[-+]?\d+|\.\d+|nan\b|inf\b|NaN\b|Infinity\b)")


def check(model_or_path, expected: dict) -> dict:
    raw = load(model_or_path).text.text
    why = []
    if not raw.startswith("ISO-10303-21;") or not raw.rstrip().endswith("END-ISO-10303-21;"):
        why.append("head or tail of the file missing")
    if not raw.isascii():
        why.append("not ASCII")
    if len(re.findall(r"FILE_SCHEMA\s*\(", raw)) != 1:
        why.append("not exactly one FILE_SCHEMA")
    bare = STRING.sub("''", raw)
    bad = BAD_NUMBER.findall(bare)
    if bad:
        why.append(f"{len(bad)} illegal numbers, the first {bad[0].strip()}")
    ids = Counter(re.findall(r"^\s*#(\d+)\s*=", bare, re.M))
    twice = [i for i, n in ids.items() if n > 1]
    if twice:
        why.append(f"{len(twice)} ids defined twice, the first #{twice[0]}")
    missing = set(re.findall(r"#(\d+)\b(?!\s*=)", bare)) - ids.keys()
    if missing:
        why.append(f"{len(missing)} references to nothing, the first #{min(missing, key=int)}")
    return verdict(why, entities=len(ids), bytes=len(raw))


if __name__ == "__main__":
    main(check)

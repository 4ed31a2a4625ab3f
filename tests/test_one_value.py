"""A constant that has a unit in its name has one value, wherever it stands: two lengths need two names."""

from __future__ import annotations

import ast
import re
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

PACKAGES = ("gcode", "testbench", "compensation")
UNIT = re.compile(r"[A-Z].*_(S|HZ|MM|N|C|OHM|NATS|MM_PER_S|MM_PER_S2|SAMPLES|DOTS_PER_INCH)")


def constants(path: Path) -> Iterator[tuple[str, object]]:
    """Names and values of the constants of a file that are written down as numbers."""
    for line in ast.parse(path.read_text(encoding="utf-8")).body:
        if not isinstance(line, ast.Assign):
            continue
        (target,) = line.targets
        several = isinstance(target, ast.Tuple) and isinstance(line.value, ast.Tuple)
        pairs = zip(target.elts, line.value.elts, strict=True) if several else ((target, line.value),)
        for name, value in pairs:
            if isinstance(name, ast.Name) and isinstance(value, ast.Constant):
                yield name.id, value.value


def test_a_constant_with_a_unit_has_one_value():
    found = defaultdict(dict)
    for path in (path for package in PACKAGES for path in Path(__file__).parents[1].joinpath(package).rglob("*.py")):
        for name, value in constants(path):
            if UNIT.fullmatch(name):
                found[name].setdefault(value, path.name)
    assert len(found) > 50
    assert {name: values for name, values in found.items() if len(values) > 1} == {}

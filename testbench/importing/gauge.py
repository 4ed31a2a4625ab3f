"""Displacement over a strain column is the gauge length; the length that a person said must agree with it."""

from __future__ import annotations

import numpy as np

from testbench.importing.choice import Choice
from testbench.importing.columns import Read
from testbench.importing.sheet import Sheet
from testbench.importing.vocabulary.notation import numbers
from testbench.recordings.doubts import correlation

APART = 0.02  # relative; a gauge length is measured with a ruler
ALIKE = 0.999  # correlation of the two; below it, the strain is that of something else


def gauge_doubts(sheet: Sheet, choice: Choice, read: Read, gauge_length_mm: float | None) -> list[str]:
    """What speaks against the gauge length, a sentence for each column of strain that is of another one.

    A strain without a unit may be a ratio or %.
    """
    if "displacement" not in choice.taken or not gauge_length_mm:
        return []
    doubts = []
    moved_mm = read.values["displacement"]
    for column in choice.unused:
        if "strain" not in dict(column.heading.roles):
            continue
        values, _ = numbers(sheet.body([column.number])[column.number], sheet.decimal)
        unit = column.heading.unit(column.unit_text)
        factors = [unit.factor] if unit and unit.quantity == "ratio" else [1.0, 0.01]
        length_mm = _slope(values[read.rows - sheet.layout.first_row], moved_mm)
        lengths_mm = [length_mm / factor for factor in factors]
        if length_mm and min(abs(one / gauge_length_mm - 1) for one in lengths_mm) > APART:
            said = " or ".join(f"{one:.4g} mm" for one in lengths_mm)
            doubts.append(
                f"{column.label} is that of a gauge length of {said}, and --gauge-length-mm says {gauge_length_mm:g}"
            )
    return doubts


def _slope(strain: np.ndarray, moved_mm: np.ndarray) -> float:
    """Millimetres for a unit of strain; 0 where the two do not move together."""
    good = np.isfinite(strain) & np.isfinite(moved_mm)
    strain, moved_mm = strain[good], moved_mm[good]
    if len(strain) < 3 or correlation(strain, moved_mm) <= ALIKE:
        return 0.0
    return float(np.polyfit(strain, moved_mm, 1)[0])

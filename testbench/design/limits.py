"""What was said of `testbench.Bounds`, made into them: the one place that knows which fields one may say."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields

from gcode.support.errors import UserError
from testbench.design.protocols import Bounds

# The gauge length is the sensor's, which is said once, beside them.
ALLOWED = tuple(one.name for one in fields(Bounds) if one.name != "gauge_length_mm")


def bounds_with(said: Mapping[str, float], gauge_length_mm: float) -> Bounds:
    """The bounds with the fields that were said, for a sensor of this length.

    Parameters
    ----------
    said : mapping
        Fields of `testbench.Bounds` that differ from its defaults.
    gauge_length_mm : float

    Raises
    ------
    UserError
        If there is no such field, a value is not positive, or another gauge length was said than the sensor has.
    """
    if "gauge_length_mm" in said and said["gauge_length_mm"] != gauge_length_mm:
        raise UserError(
            f"bounds: the gauge length is {gauge_length_mm:g} mm, got {said['gauge_length_mm']!r}; for a sensor of "
            "another length give gauge_length_mm beside bounds"
        )
    if strange := sorted(map(str, set(said) - {*ALLOWED, "gauge_length_mm"})):
        raise UserError(f"bounds: allowed are {', '.join(ALLOWED)}; got {', '.join(strange)}")
    return Bounds(**{**said, "gauge_length_mm": gauge_length_mm})

"""Whether the arguments of `make_case` make sense."""

from __future__ import annotations

from collections.abc import Sequence

from gcode.support.errors import UserError
from testbench.recordings.channels import FORCE, RESISTANCE, TEMPERATURE
from worlds_third.protocols import PROTOCOLS

FEWEST = 60  # samples


def check_arguments(
    strength: float,
    minutes: float,
    rate_hz: float,
    noise: float,
    protocol: str,
    channels: Sequence[str],
    max_strain: float | None,
) -> None:
    """Raise `UserError` naming the argument, what is allowed and what came."""
    _within("strength", strength, 0.1, 1000.0)
    _within("minutes", minutes, 1.0, 240.0)
    _within("rate_hz", rate_hz, 0.2, 200.0)
    _within("noise", noise, 0.1, 30.0)
    if max_strain is not None:
        _within("max_strain", max_strain, 0.005, 3.0)
    if minutes * 60 * rate_hz < FEWEST:
        raise UserError(f"make_case: {minutes:g} min at {rate_hz:g} Hz is below {FEWEST} samples; record longer")
    if protocol not in PROTOCOLS:
        raise UserError(f"make_case: no protocol {protocol!r}; there are {', '.join(PROTOCOLS)}")
    allowed = (FORCE, RESISTANCE, TEMPERATURE)
    strange = [name for name in channels if name not in allowed]
    if strange or not {FORCE, RESISTANCE} & set(channels):
        came = ", ".join(channels) or "none"
        raise UserError(f"make_case: channels are {', '.join(allowed)}, one of the first two at least; got {came}")


def _within(name: str, value: float, low: float, high: float) -> None:
    if not low <= value <= high:
        raise UserError(f"make_case: {name} must be between {low:g} and {high:g}, got {value:g}")

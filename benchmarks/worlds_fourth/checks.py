"""Whether the arguments of `make_case` make sense."""

from __future__ import annotations

from collections.abc import Sequence

from gcode.support.errors import UserError
from testbench.recordings.channels import FORCE, RESISTANCE

PROTOCOLS = ("mixed",)


def check_arguments(
    strength: float, minutes: float, rate_hz: float, noise: float, protocol: str, channels: Sequence[str]
) -> None:
    """Raise `UserError` naming the argument, what is allowed and what came."""
    _within("strength", strength, 0.1, 1000.0)
    _within("minutes", minutes, 1.0, 240.0)
    _within("rate_hz", rate_hz, 10.0, 100.0)
    _within("noise", noise, 0.1, 30.0)
    if protocol not in PROTOCOLS:
        raise UserError(f"make_case: no protocol {protocol!r}; there is {', '.join(PROTOCOLS)}")
    allowed = (FORCE, RESISTANCE)
    if not channels or any(name not in allowed for name in channels):
        came = ", ".join(channels) or "none"
        raise UserError(f"make_case: channels are {' and '.join(allowed)}, one of them at least; got {came}")


def _within(name: str, value: float, low: float, high: float) -> None:
    if not low <= value <= high:
        raise UserError(f"make_case: {name} must be between {low:g} and {high:g}, got {value:g}")

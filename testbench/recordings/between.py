"""What happened to the sensor between the recording that a model is fitted on and the one that it is judged on."""

from __future__ import annotations

from dataclasses import dataclass

from gcode.support.errors import UserError
from gcode.support.kinds import number

MOST_REST_S = 86_400.0


@dataclass(frozen=True)
class Between:
    """Between two recordings.

    Attributes
    ----------
    clamp_play_mm : float
        The sensor was clamped anew: by how much the zero of its displacement may lie elsewhere (standard deviation).
        0: it was not.
    rest_s : float, optional
        The other recording is of the same specimen, so long after the first one; by default it is of a fresh one.
    """

    clamp_play_mm: float = 0.0
    rest_s: float | None = None

    def __post_init__(self) -> None:
        if self.rest_s is not None and not 0 < number("rest_s", self.rest_s) < MOST_REST_S:
            raise UserError(f"rest_s: must be more than 0 and less than {MOST_REST_S:g} s, got {self.rest_s:g}")


FRESH = Between()

"""What is left of an error above the noise floor."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Remains:
    """Errors before and after an idea was put in.

    Attributes
    ----------
    before, after : float
        Of the worst channel, in noise floors.
    share : float
        Of the error above the noise floor (squared, channels together) that is still there.
    """

    before: float
    after: float
    share: float


def remains(before: Mapping[str, float], after: Mapping[str, float], floors: Mapping[str, float]) -> Remains:
    """Compare errors by channel, all in the units of `floors`."""
    share = _excess(after, floors) / max(_excess(before, floors), 1e-12)
    return Remains(_worst(before, floors), _worst(after, floors), share)


def _worst(errors: Mapping[str, float], floors: Mapping[str, float]) -> float:
    return max(value / max(floors[channel], 1e-300) for channel, value in errors.items())


def _excess(errors: Mapping[str, float], floors: Mapping[str, float]) -> float:
    return sum(max((value / max(floors[channel], 1e-300)) ** 2 - 1, 0.0) for channel, value in errors.items())

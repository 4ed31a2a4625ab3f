"""Where a model fails, as a stretch of time to look at and in words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gcode.support.arrays import FloatArray
from testbench.comparing.numbers import over_noise
from testbench.comparing.words import NOISE_REACHED, no_place_in_words
from testbench.report.downsample import liveliest

LOOK_S, LOOK_SAMPLES = 30.0, 200  # how much is shown around a place: so long, and at least so many samples


@dataclass(frozen=True)
class Spot:
    """One place where the model fails, the worst first.

    Attributes
    ----------
    words : str
    share_of_error : float
        Of the squared error, 0 to 1.
    span_s : (start_s, end_s)
        The stretch of time in which it is seen best.
    """

    words: str
    share_of_error: float
    span_s: tuple[float, float]


def beyond_noise(comparison: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """The worst places of ``testbench compare --json``, in channels that have not reached their noise."""
    channels = comparison["channels"]
    return [place for place in comparison["worst"] if channels[place["channel"]]["over_noise"] > NOISE_REACHED]


def spots(
    comparison: Mapping[str, Any],
    time_s: FloatArray,
    residual: Mapping[str, FloatArray],
    where: Mapping[str, FloatArray],
    counts: NDArray[np.bool_],
) -> list[Spot]:
    """Each worst place with the stretch in which it adds most to the squared error.

    Parameters
    ----------
    comparison : mapping
        As ``testbench compare --json`` writes it.
    time_s : ndarray, shape (n,)
        Uniform grid.
    residual : mapping of channel to ndarray, shape (n,)
    where : mapping of coordinate to ndarray, shape (n,)
        With ``direction``: +1 stretching, -1 releasing, 0 hold.
    counts : ndarray of bool, shape (n,)
        Samples that errors are counted over.
    """
    found = []
    for place in beyond_noise(comparison):
        inside = counts & in_cell(place, where)
        energy = np.where(inside, residual[place["channel"]] ** 2, 0.0)
        span_s = liveliest(time_s, energy, LOOK_S, LOOK_SAMPLES)
        found.append(Spot(place["words"], place["share_of_error"], span_s))
    return found


def in_cell(place: Mapping[str, Any], where: Mapping[str, FloatArray]) -> NDArray[np.bool_]:
    """Rows that lie in the cell of a place, shape (n,)."""
    cell, values = place["cell"], where[place["coordinate"]]
    inside = (values >= cell["low"]) & (values <= cell["high"])
    return inside & (where["direction"] == cell["direction"]) if cell["direction"] else inside


def why_no_place(channels: Mapping[str, Mapping[str, Any]]) -> str:
    """Why no worst place is named, as a sentence; `channels` of ``testbench compare --json``."""
    over = {name: entry["over_noise"] for name, entry in channels.items()}
    quick = {name: over_noise(entry["quick"], entry["noise_floor"]) for name, entry in channels.items()}
    said = no_place_in_words(over, quick)
    return f"{said[0].upper()}{said[1:]}."


def noise_reached(channels: Mapping[str, Mapping[str, Any]]) -> Sequence[str]:
    """The channels in which nothing but noise is left."""
    return [name for name, entry in channels.items() if entry["over_noise"] <= NOISE_REACHED]

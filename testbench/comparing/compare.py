"""Model against measurement: how large the misfit is, and where it sits."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from gcode.support.read_only import Unchanging
from testbench.comparing.cell import Cell
from testbench.comparing.model_errors import channel_name, noise_floors, rms_errors
from testbench.comparing.numbers import over_noise
from testbench.comparing.residual_coordinates import COORDINATES, coordinates
from testbench.comparing.words import NOISE_REACHED, no_place_in_words, place_in_words
from testbench.knit.effect import FloatArray
from testbench.knit.model import KnitModel
from testbench.measurements.measurement import Measurement
from testbench.measurements.responses import UNIT_OF

BINS = 10
CELL_BLOCK_S = 20.0  # samples closer than this are not taken as independent
MIN_SHARE = 0.005  # a place must hold this share of the samples to be named
MIN_T = 3.0  # and stand out by this many standard errors
LEAST_SHARE = 0.01  # of the squared error; less is not worth a look


@dataclass(frozen=True)
class Place:
    """One of the worst places.

    Attributes
    ----------
    channel, coordinate : str
    cell : Cell
        The stretch of the coordinate, and the residual there.
    share_of_error : float
        Of the channel's squared residual.
    words : str
        What the model does wrong there, in a sentence.
    """

    channel: str
    coordinate: str
    cell: Cell
    share_of_error: float
    words: str


@dataclass(frozen=True)
class Comparison(Unchanging):
    """Result of `compare`.

    Attributes
    ----------
    rms, noise_floor : dict of channel to float
        In N and in ln S, at the samples as recorded.
    quick : dict of channel to float
        The part of `rms` that the averages of the grid do not hold: what comes and goes within one of its steps.
    maps : dict of channel to dict of coordinate to tuple of Cell
    worst : tuple of Place
        At most three, the worst first.
    """

    rms: Mapping[str, float]
    noise_floor: Mapping[str, float]
    quick: Mapping[str, float]
    maps: Mapping[str, Mapping[str, tuple[Cell, ...]]]
    worst: tuple[Place, ...]

    @property
    def over_noise(self) -> dict[str, float]:
        """The error of each channel over its noise floor."""
        return {channel: over_noise(rms, self.noise_floor[channel]) for channel, rms in self.rms.items()}

    @property
    def noise_reached(self) -> list[str]:
        """The channels in which nothing but noise is left."""
        return [channel for channel, times in self.over_noise.items() if times <= NOISE_REACHED]

    @property
    def places(self) -> tuple[str, ...]:
        """The worst places, a sentence each, and what there is to say where none is named."""
        return tuple(filter(None, [*(place.words for place in self.worst), self.unplaced]))

    @property
    def unplaced(self) -> str:
        """Why no place is named of a channel; empty where each has one, or nothing but noise is left beside it."""
        named = {place.channel for place in self.worst}
        left = {channel: times for channel, times in self.over_noise.items() if channel not in named}
        if named and all(times <= NOISE_REACHED for times in left.values()):
            return ""
        quick = {channel: over_noise(self.quick[channel], self.noise_floor[channel]) for channel in left}
        return no_place_in_words(left, quick)

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready form; the shape is documented in docs/finding-effects.md."""
        over_noise = self.over_noise
        channels = {
            channel: {
                "unit": UNIT_OF[channel],
                "rms": self.rms[channel],
                "noise_floor": self.noise_floor[channel],
                "over_noise": over_noise[channel],
                "quick": self.quick[channel],
                "maps": {
                    coordinate: [vars(cell) | {"t": cell.t} for cell in cells]
                    for coordinate, cells in self.maps[channel].items()
                },
            }
            for channel in self.rms
        }
        worst = [
            {"channel": p.channel, "coordinate": p.coordinate, "words": p.words, "share_of_error": p.share_of_error}
            | {"cell": vars(p.cell) | {"t": p.cell.t}}
            for p in self.worst
        ]
        return {
            "noise_floor_from": "estimated from the samples (second differences)",
            "channels": channels,
            "worst": worst,
        }


def compare(model: KnitModel, measurement: Measurement, free_offset: bool = False) -> Comparison:
    """Compare a model with a measurement and find the places where it fails.

    Parameters
    ----------
    model : KnitModel
    measurement : Measurement
    free_offset : bool
        As in `testbench.comparing.model_errors.rms_errors`.
    """
    residual = measurement.residual(model)
    errors, floors = rms_errors(model, measurement, free_offset), noise_floors(measurement)
    where = {name: values[measurement.counts] for name, values in coordinates(measurement).items()}
    quick, maps, places = {}, {}, []
    for channel, values in residual.items():
        counting = values[measurement.counts]
        if free_offset:
            counting = counting - counting.mean()
        quick[channel] = float(max(errors[channel] ** 2 - np.mean(counting**2), 0.0)) ** 0.5
        maps[channel] = residual_maps(counting, where)
        if over_noise(errors[channel], floors[channel]) > NOISE_REACHED:
            places += _places(channel, maps[channel], counting)
    worst = distinct(sorted(places, key=lambda place: -place.share_of_error))
    return Comparison(errors, floors, quick, maps, tuple(worst))


def residual_maps(residual: FloatArray, where: Mapping[str, FloatArray]) -> dict[str, tuple[Cell, ...]]:
    """Mean residual over bins of every coordinate, apart for stretching and releasing where that makes sense."""
    elapsed_s = where["elapsed_s"] - where["elapsed_s"][0]
    block = np.floor(elapsed_s / CELL_BLOCK_S + 1e-9).astype(int)
    direction = where["direction"]
    maps = {}
    for coordinate in COORDINATES:
        if coordinate not in where:
            continue
        values = where[coordinate]
        edges = _edges(values[values > 0] if coordinate == "since_hold_s" else values)
        cells: list[Cell] = []
        for low, high in itertools.pairwise(edges):
            inside = (values >= low) & ((values < high) | (high == edges[-1]))
            sides = (1, -1) if coordinate in ("strain", "since_reversal_s", "largest_strain") else (0,)
            for side in sides:
                rows = inside & (direction == side) if side else inside
                cells += _cell(residual[rows], block[rows], (low, high, side), len(residual))
        maps[coordinate] = tuple(cells)
    return maps


def _edges(values: FloatArray) -> FloatArray:
    """Bin edges with about as many samples in each bin."""
    if len(values) == 0:
        return np.zeros(1)
    return np.unique(np.quantile(values, np.linspace(0, 1, BINS + 1)))


def _cell(residual: FloatArray, block: FloatArray, place: tuple[float, float, int], total: int) -> list[Cell]:
    if len(residual) < 10:
        return []
    names, index = np.unique(block, return_inverse=True)
    # Too few blocks say no better than their samples.
    error = _standard_error(residual, index) if len(names) > 2 else float(np.std(residual))
    low, high, side = place
    return [Cell(float(low), float(high), side, float(residual.mean()), error, len(residual) / total)]


def _standard_error(values: FloatArray, block: np.ndarray) -> float:
    """Of the mean of samples that are alike within a block: a jackknife over the blocks.

    It is no less than that of as many independent samples as there are blocks: where one block holds nearly all
    samples, the others say nothing of how much such means differ. Efron & Tibshirani, An Introduction to the
    Bootstrap (1993), ch. 11.
    """
    sums, sizes = np.bincount(block, weights=values), np.bincount(block)
    without = (values.sum() - sums) / (len(values) - sizes)
    jackknife = np.sqrt(np.sum((without - values.mean()) ** 2) * (len(sums) - 1) / len(sums))
    return float(max(jackknife, np.std(values) / np.sqrt(len(sums))))


def _places(channel: str, maps: Mapping[str, tuple[Cell, ...]], residual: FloatArray) -> list[Place]:
    total = float(np.mean(residual**2)) or 1.0
    found = []
    for coordinate, cells in maps.items():
        for cell in cells:
            share = cell.share * cell.mean**2 / total
            if cell.share >= MIN_SHARE and abs(cell.t) >= MIN_T and share >= LEAST_SHARE:
                words = place_in_words(channel_name(channel), coordinate, cell)
                found.append(Place(channel, coordinate, cell, share, words))
    return found


def distinct(places: list[Place]) -> list[Place]:
    """The worst three that do not tell the same story, one a channel and coordinate; each channel has one of them."""
    kept: list[Place] = []
    for place in places:
        if all((place.channel, place.coordinate) != (other.channel, other.coordinate) for other in kept):
            kept.append(place)
    first = {place.channel: place for place in reversed(kept)}
    return sorted(sorted(kept, key=lambda place: place != first[place.channel])[:3], key=kept.index)

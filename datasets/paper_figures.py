"""The figures by which a simulated campaign is compared with the published ones.

Aigner and Stöckl, "Machine Learning Based Compensation for Inconsistencies in Knitted Force Sensors" (2023,
arXiv:2306.12129). A campaign is five recordings of one sensor, one after another: T to train on, A and B to judge on,
then two of the fast set. Each is standardised by itself (docs/decisions/0015-scaler-of-the-paper.md).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import NamedTuple

import numpy as np

from compensation.memories.ema import smooth, smoothing_factors
from compensation.paper.reproduction import over_seeds
from compensation.series.preprocessing import Series
from compensation.series.score import r2, standardised
from compensation.series.score import r2_before as r2_before
from compensation.training.options import Options
from gcode.trajectories.planning import plan
from gcode.trajectories.presets import preset as trajectory
from testbench.knit.effect import FloatArray
from testbench.knit.model import KnitModel, inputs
from testbench.rig.simulation.played import DEFAULT_REST_S

SLOW, FAST = ("paper-1", "paper-2", "paper-3"), ("fast", "fast")
RECORDINGS = SLOW + FAST
GAUGE_LENGTH_MM, RATE_HZ = 25.0, 20.0
COUNT, FACTOR, FINER = 7, 2.5, 1.75
STARTS = 5
EVERY = 10  # rows that the surrogate learns from; neighbours at 20 Hz tell nothing new
TARGETS = {"force_N": "force", "strain": "displacement"}
# What is trained on, what is judged, what is learned, smoothing factor: one row a figure after compensation.
T, A, B, FAST_T, FAST_A = range(5)
Wanted = tuple[int, tuple[int, ...], str, float]
AFTER: tuple[Wanted, ...] = (
    (T, (T, A, B), "force_N", FACTOR),
    (T, (T, A, B), "strain", FACTOR),
    (FAST_T, (FAST_A,), "force_N", FACTOR),
    (FAST_T, (FAST_A,), "force_N", FINER),
    (T, (FAST_A,), "force_N", FACTOR),
)


class Recording(NamedTuple):
    """Signals of one simulated recording, each shape (n,)."""

    strain: FloatArray
    force_N: FloatArray
    conductance_S: FloatArray


@cache
def motion(name: str, seed: int) -> tuple[FloatArray, FloatArray]:
    """Time and nominal strain of one of the paper's trajectories."""
    planned = plan(trajectory(name), seed, GAUGE_LENGTH_MM)
    return planned.time_s, planned.position_mm / GAUGE_LENGTH_MM


def campaign(model: KnitModel, seed: int, runs: tuple[str, ...] = RECORDINGS) -> list[Recording]:
    """Recordings of one sensor, one after another with rests between, as ``testbench run --after`` does.

    T is the first stretch of a new sensor. Each has a trajectory seed of its own: with one seed, the paper's three
    trajectories are nearly the same motion.
    """
    motions = [motion(name, len(RECORDINGS) * seed + index)[1] for index, name in enumerate(runs)]
    rest = np.zeros(round(DEFAULT_REST_S * RATE_HZ))
    strain = np.concatenate([part for one in motions for part in (one, rest)])
    out = model.simulate(inputs(np.arange(len(strain)) / RATE_HZ, strain), 1 / RATE_HZ)
    recordings, start = [], 0
    for one in motions:
        rows = slice(start, start + len(one))
        recordings.append(Recording(one, out["force_N"][rows], out["conductance_S"][rows]))
        start += len(one) + len(rest)
    return recordings


def drift(recording: Recording) -> float:
    """Mean conductance of the last three minutes over that of the first three."""
    rows = int(180 * RATE_HZ)
    return float(recording.conductance_S[-rows:].mean() / recording.conductance_S[:rows].mean())


def quickly_compensated(recordings: list[Recording]) -> list[float]:
    """r2 after a quadratic ridge regression on the bank, a surrogate for the network; in the order of `AFTER`."""
    signals = [standardised(r.conductance_S) for r in recordings]
    monomials = {
        factor: [_monomials(smooth(x, smoothing_factors(factor, COUNT), RATE_HZ)[::EVERY]) for x in signals]
        for factor in (FACTOR, FINER)
    }
    found = []
    for training, tests, target, factor in AFTER:
        truth = [standardised(getattr(recording, target))[::EVERY] for recording in recordings]
        weights = _ridge(monomials[factor][training], truth[training])
        found += [r2(truth[test], monomials[factor][test] @ weights) for test in tests]
    return found


def compensated(recordings: list[Recording], engine: str = "fast", wanted: Sequence[Wanted] = AFTER) -> list[float]:
    """The same by the paper's network (4, 2, 2), mean over the live ones of `STARTS` seeds."""
    found: list[float] = []
    for training, tests, target, factor in wanted:
        series = [
            Series(np.arange(len(r.strain)) / RATE_HZ, r.conductance_S, getattr(r, target), "simulated")
            for r in recordings
        ]
        options = Options(engine=engine, factor=factor, count=COUNT, per_recording=True)
        seeds = over_seeds(series[training], [series[test] for test in tests], TARGETS[target], STARTS, options)
        found += list((seeds.live if len(seeds.live) else seeds.r2).mean(axis=0))
    return found


def _monomials(x: FloatArray) -> FloatArray:
    first, second = np.triu_indices(x.shape[1])
    return np.column_stack([np.ones(len(x)), x, x[:, first] * x[:, second]])


def _ridge(x: FloatArray, y: FloatArray) -> FloatArray:
    return np.linalg.solve(x.T @ x + 3 * np.eye(x.shape[1]), x.T @ y)

"""The figures by which a simulated campaign is compared with the published ones.

Aigner and Stöckl, "Machine Learning Based Compensation for Inconsistencies in Knitted Force Sensors" (2023,
arXiv:2306.12129). A campaign is three recordings of one sensor: T to train on, A and B to judge on.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import numpy as np

from gcode.generate import plan
from gcode.presets import preset as trajectory
from testbench.knit.effect import FloatArray
from testbench.knit.model import KnitModel, inputs
from testbench.rig.past import DEFAULT_REST_S

RECORDINGS = ("paper-1", "paper-2", "paper-3")
GAUGE_LENGTH_MM, RATE_HZ = 25.0, 20.0
ALPHAS = 2.5 ** -np.arange(1.0, 8.0)
EVERY = 10  # rows that the stand-in learns from; neighbours at 20 Hz tell nothing new
TARGETS = {"force_N": "force", "strain": "displacement"}


class Recording(NamedTuple):
    """Signals of one simulated recording, each shape (n,)."""

    strain: FloatArray
    force_N: FloatArray
    conductance_S: FloatArray


@dataclass(frozen=True)
class Published:
    """Figures of one sensor: before compensation for T, A, B; after it, as the mean over A and B."""

    force_before: tuple[float, float, float]
    displacement_before: tuple[float, float, float]
    force_after: float
    displacement_after: float


PUBLISHED = {
    "pes": Published((0.423, 0.471, 0.526), (0.319, 0.319, 0.260), 0.78, 0.68),
    "lycra": Published((0.703, 0.667, 0.734), (0.337, 0.479, 0.490), 0.83, 0.65),
}


@cache
def motion(name: str, seed: int) -> tuple[FloatArray, FloatArray]:
    """Time and nominal strain of one of the paper's trajectories."""
    planned = plan(trajectory(name), seed, GAUGE_LENGTH_MM)
    return planned.time_s, planned.position_mm / GAUGE_LENGTH_MM


def campaign(model: KnitModel, seed: int) -> list[Recording]:
    """Recordings T, A and B of one sensor, one after another with rests between, as ``testbench run --after`` does.

    T is the first stretch of a new sensor. Each has a trajectory seed of its own: with one seed, the paper's three
    trajectories are nearly the same motion.
    """
    motions = [motion(name, len(RECORDINGS) * seed + index)[1] for index, name in enumerate(RECORDINGS)]
    rest = np.zeros(round(DEFAULT_REST_S * RATE_HZ))
    strain = np.concatenate([part for one in motions for part in (one, rest)])
    out = model.simulate(inputs(np.arange(len(strain)) / RATE_HZ, strain), 1 / RATE_HZ)
    recordings, start = [], 0
    for one in motions:
        rows = slice(start, start + len(one))
        recordings.append(Recording(one, out["force_N"][rows], out["conductance_S"][rows]))
        start += len(one) + len(rest)
    return recordings


def r2_before(truth: FloatArray, conductance_S: FloatArray) -> float:
    """The paper's r2 of the raw signal, both standardised: 2 rho - 1."""
    return float(2 * np.corrcoef(truth, conductance_S)[0, 1] - 1)


def r2(truth: FloatArray, prediction: FloatArray) -> float:
    """The paper's r2 (mean of the prediction in the denominator)."""
    return float(1 - np.sum((truth - prediction) ** 2) / np.sum((truth - prediction.mean()) ** 2))


def drift(recording: Recording) -> float:
    """Mean conductance of the last three minutes over that of the first three."""
    rows = int(180 * RATE_HZ)
    return float(recording.conductance_S[-rows:].mean() / recording.conductance_S[:rows].mean())


def smoothing_banks(recordings: list[Recording]) -> list[FloatArray]:
    """The paper's seven exponential smoothings of the conductance, scaled by T's mean and spread, each (n, 7)."""
    from compensation.ema import smooth

    mean, spread = recordings[0].conductance_S.mean(), recordings[0].conductance_S.std()
    return [smooth((r.conductance_S - mean) / spread, ALPHAS, RATE_HZ) for r in recordings]


def quickly_learned(recordings: list[Recording], banks: list[FloatArray], target: str) -> float:
    """Held-out r2, mean over A and B, of a quadratic ridge regression on T's bank: a stand-in for the network.

    Parameters
    ----------
    recordings : list of Recording
        T, A, B.
    banks : list of ndarray, each shape (n, 7)
        Their `smoothing_banks`.
    target : {"force_N", "strain"}
    """
    truth = [getattr(recording, target)[::EVERY] for recording in recordings]
    mean, spread = truth[0].mean(), truth[0].std()
    features = [_monomials(bank[::EVERY]) for bank in banks]
    weights = _ridge(features[0], (truth[0] - mean) / spread)
    held_out = zip(truth[1:], features[1:], strict=True)
    return float(np.mean([r2((y - mean) / spread, x @ weights) for y, x in held_out]))


def learned(recordings: list[Recording], target: str, engine: str = "exact") -> float:
    """Held-out r2, mean over A and B, of the paper's compensator trained on every row of T.

    It is the one of ``compensation train``: network (4, 2, 2), the best of five starts by training score (single
    starts are often dead), scaled by T's mean and spread, since a sensor in use knows no other.
    """
    from compensation.preprocessing import Series
    from compensation.training import Options, train_on_series

    series = [
        Series(np.arange(len(r.strain)) / RATE_HZ, r.conductance_S, getattr(r, target), "simulated")
        for r in recordings
    ]
    trained = train_on_series(series[:1], TARGETS[target], Options(engine=engine))
    return float(np.mean([r2(part.truth, trained.predict_series(part)) for part in series[1:]]))


def _monomials(x: FloatArray) -> FloatArray:
    first, second = np.triu_indices(x.shape[1])
    return np.column_stack([np.ones(len(x)), x, x[:, first] * x[:, second]])


def _ridge(x: FloatArray, y: FloatArray) -> FloatArray:
    return np.linalg.solve(x.T @ x + 3 * np.eye(x.shape[1]), x.T @ y)

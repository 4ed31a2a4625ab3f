"""The figures by which a simulated campaign is compared with the published ones.

Aigner and Stöckl, "Machine Learning Based Compensation for Inconsistencies in Knitted Force Sensors" (2023,
arXiv:2306.12129). A campaign is three recordings of one sensor: T to train on, A and B to judge on.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from gcode.generate import plan
from gcode.presets import preset as trajectory
from testbench.knit.effect import FloatArray
from testbench.knit.model import KnitModel, inputs

RECORDINGS = ("paper-1", "paper-2", "paper-3")
GAUGE_LENGTH_MM, RATE_HZ = 25.0, 20.0
ALPHAS = 2.5 ** -np.arange(1.0, 8.0)
EVERY = 10  # rows used for learning; neighbours at 20 Hz tell nothing new


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
    """Recordings T, A and B.

    Each has a trajectory seed of its own: with one seed, the paper's three trajectories are nearly the same motion.
    """
    recordings = []
    for index, name in enumerate(RECORDINGS):
        time_s, strain = motion(name, len(RECORDINGS) * seed + index)
        out = model.simulate(inputs(time_s, strain), 1 / RATE_HZ)
        recordings.append(Recording(strain, out["force_N"], out["conductance_S"]))
    return recordings


def r2_before(truth: FloatArray, conductance_S: FloatArray) -> float:
    """The paper's r2 of the raw signal, both standardised: 2 rho - 1."""
    return float(2 * np.corrcoef(truth, conductance_S)[0, 1] - 1)


def r2(truth: FloatArray, prediction: FloatArray) -> float:
    """The paper's r2 (mean of the prediction in the denominator)."""
    return float(1 - np.sum((truth - prediction) ** 2) / np.sum((truth - prediction.mean()) ** 2))


def drift(recordings: list[Recording]) -> float:
    """Mean conductance of the last three minutes over that of the first three."""
    rows = int(180 * RATE_HZ)
    return float(np.mean([r.conductance_S[-rows:].mean() / r.conductance_S[:rows].mean() for r in recordings]))


def smoothing_bank(conductance_S: FloatArray) -> FloatArray:
    """The paper's seven exponential smoothings of the standardised conductance, shape (n, 7)."""
    from scipy.signal import lfilter

    x = (conductance_S - conductance_S.mean()) / conductance_S.std()
    columns = []
    for alpha in ALPHAS:
        start = x[: int(np.ceil(1 / (RATE_HZ * alpha) - 1e-9))].mean()
        columns.append(lfilter([alpha], [1, alpha - 1], x, zi=[(1 - alpha) * start])[0])
    return np.column_stack(columns)


def learned(recordings: list[Recording], banks: list[FloatArray], target: str, network_starts: int = 0) -> float:
    """Held-out r2, mean over A and B, of what a learner makes of T.

    Parameters
    ----------
    recordings : list of Recording
        T, A, B.
    banks : list of ndarray, each shape (n, 7)
        Their `smoothing_bank`.
    target : {"force_N", "strain"}
    network_starts : int
        0: a quadratic ridge regression on the bank, a quick stand-in that follows the network's score closely.
        Else the paper's network (4, 2, 2), best of so many starts by training loss (single starts are often dead).
    """
    truth = [getattr(r, target) for r in recordings]
    mean, spread = truth[0].mean(), truth[0].std()
    truth = [(y - mean) / spread for y in truth]
    if network_starts:
        network = _network(banks[0][::EVERY], truth[0][::EVERY], network_starts)
        return float(np.mean([r2(y, network.predict(x)) for x, y in zip(banks[1:], truth[1:], strict=True)]))
    weights = _quadratic(banks[0][::EVERY], truth[0][::EVERY])
    predictions = [_monomials(x[::EVERY]) @ weights for x in banks[1:]]
    return float(np.mean([r2(y[::EVERY], p) for y, p in zip(truth[1:], predictions, strict=True)]))


def _monomials(x: FloatArray) -> FloatArray:
    first, second = np.triu_indices(x.shape[1])
    return np.column_stack([np.ones(len(x)), x, x[:, first] * x[:, second]])


def _quadratic(x: FloatArray, y: FloatArray) -> FloatArray:
    m = _monomials(x)
    return np.linalg.solve(m.T @ m + 3 * np.eye(m.shape[1]), m.T @ y)


def _network(x: FloatArray, y: FloatArray, starts: int) -> Any:
    from sklearn.neural_network import MLPRegressor

    networks = [
        MLPRegressor(hidden_layer_sizes=(4, 2, 2), max_iter=10_000, random_state=seed).fit(x, y)
        for seed in range(starts)
    ]
    return min(networks, key=lambda network: network.loss_)

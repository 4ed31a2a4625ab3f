"""The methods that `bench_compensators.py` holds `train --method auto` against; none of them is built in.

Each learns from the same recordings, as the same series at 20 Hz, and predicts a recording from its first sample on.
What a rival needs beyond the signal (standardisation, a shift of the state by 0.1 standard deviations for the linear
and the sequence models, penalties) is given to it, so that it loses for what it is and not for how it was trained.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from sequence_networks import Gru, Tcn, adam

from compensation.memories.history import History
from compensation.model.compensator import Scaling
from compensation.paper.reproduction import regressors
from compensation.series.preprocessing import Series
from compensation.training.lessons import STATE_SHIFT
from compensation.training.options import Options
from compensation.training.training import METHODS
from compensation.training.tuning import MOTION_TAUS_S, PLAY_RADII
from compensation.training.untrained import training_arrays, untrained
from gcode.support.arrays import FloatArray

STRIDE = 5  # rows a regressor learns from: neighbours 50 ms apart are the same row to a forest
SEQUENCE_EVERY = 4  # 20 Hz -> 5 Hz
PIECE_S, WARM_S, PIECES = 200.0, 40.0, 6
RESERVOIR = 300


@dataclass(frozen=True)
class Fitted:
    """A trained rival.

    Attributes
    ----------
    predict : callable
        Series -> prediction at each of its samples, in the target's unit.
    parameters : int
        Numbers that were learned; of a forest or boosted trees, thresholds and leaves.
    """

    predict: Callable[[Series], FloatArray]
    parameters: int


Rival = Callable[[Sequence[Series], str, int], Fitted]
Scales = tuple[Scaling, Scaling]


def line(series: Sequence[Series], target: str, seed: int) -> Fitted:
    """A straight line through the conductance."""
    x = np.concatenate([part.conductance_S for part in series])
    slope, offset = np.polyfit(x / x.mean(), np.concatenate([part.truth for part in series]), 1)
    return Fitted(lambda part: slope * part.conductance_S / x.mean() + offset, 2)


def regressor(make: Callable[[int], object], parameters: Callable[[object], int]) -> Rival:
    """One of scikit-learn's kind, on the paper's smoothing bank."""

    def fit(series: Sequence[Series], target: str, seed: int) -> Fitted:
        blank = untrained(series, target, Options())
        features, truth = training_arrays(blank, series)
        model = make(seed)
        model.fit(features[::STRIDE], truth[::STRIDE])  # type: ignore[attr-defined]

        def predict(part: Series) -> FloatArray:
            inputs = blank.features(part.time_s, part.conductance_S)
            return blank.scaling_out.invert(np.asarray(model.predict(inputs)))  # type: ignore[attr-defined]

        return Fitted(predict, parameters(model))

    return fit


def ridge(series: Sequence[Series], target: str, seed: int) -> Fitted:
    """Linear in bank, motion and play, on the recordings and two copies of shifted state: 15 numbers."""
    blank = untrained(series, target, Options(history=History(MOTION_TAUS_S, PLAY_RADII)))
    copies = [
        [Series(p.time_s, p.conductance_S + by * blank.scaling_in.scale, p.truth, p.source) for p in series]
        for by in (0.0, STATE_SHIFT, -STATE_SHIFT)
    ]
    arrays = [training_arrays(blank, copy) for copy in copies]
    features, truth = (np.concatenate(columns) for columns in zip(*arrays, strict=True))
    centre, spread = features.mean(axis=0), features.std(axis=0)
    x = (features - centre) / spread
    weights = np.linalg.solve(x.T @ x / len(x) + 0.01 * np.eye(x.shape[1]), x.T @ (truth - truth.mean()) / len(x))

    def predict(part: Series) -> FloatArray:
        inputs = (blank.features(part.time_s, part.conductance_S) - centre) / spread
        return blank.scaling_out.invert(inputs @ weights + truth.mean())

    return Fitted(predict, len(weights) + 1)


def reservoir(series: Sequence[Series], target: str, seed: int) -> Fitted:
    """Echo state network: random leaky units of many time constants, a ridge regression on them.

    Jaeger, "The echo state approach to analysing and training recurrent neural networks" (2001).
    """
    rng = np.random.default_rng(seed)
    inputs, bias = rng.uniform(-1, 1, (2, RESERVOIR))
    inner = rng.standard_normal((RESERVOIR, RESERVOIR)) * (rng.random((RESERVOIR, RESERVOIR)) < 0.1)
    inner *= 0.7 / np.abs(np.linalg.eigvals(inner)).max()
    leak = np.exp(rng.uniform(np.log(0.003), 0.0, RESERVOIR))
    scales = _scales(series)

    def states(x: FloatArray) -> FloatArray:
        out, state = np.empty((len(x), RESERVOIR + 2)), np.zeros(RESERVOIR)
        for _ in range(100):
            state = state + leak * (np.tanh(inputs * x[0] + inner @ state + bias) - state)
        for row, value in enumerate(x):
            state = state + leak * (np.tanh(inputs * value + inner @ state + bias) - state)
            out[row, 2:], out[row, :2] = state, (1.0, value)
        return out

    lessons = [_slow(part, scales) for part in series]
    x = np.concatenate([states(signal + by) for signal, _ in lessons for by in (0.0, STATE_SHIFT, -STATE_SHIFT)])
    truth = np.concatenate([np.tile(values, 3) for _, values in lessons])
    weights = np.linalg.solve(x.T @ x / len(x) + 1e-3 * np.eye(x.shape[1]), x.T @ truth / len(x))
    return Fitted(lambda part: _fast(part, lambda signal: states(signal) @ weights, scales), len(weights))


def sequence(network: Gru | Tcn, steps: int, rate: float) -> Rival:
    """A recurrent or convolutional network, trained on pieces of 200 s that begin anywhere, in shifted states."""

    def fit(series: Sequence[Series], target: str, seed: int) -> Fitted:
        rng, scales = np.random.default_rng(seed), _scales(series)
        lessons = [_slow(part, scales) for part in series]
        length = min(int(PIECE_S * 5), *(len(signal) for signal, _ in lessons))
        counts = np.ones((PIECES, length))
        counts[:, : min(int(WARM_S * 5), length // 2)] = 0.0

        def pieces(step: int):
            x, truth = np.empty((2, PIECES, length))
            for row in range(PIECES):
                signal, values = lessons[rng.integers(len(lessons))]
                begin = rng.integers(len(signal) - length + 1)
                x[row] = signal[begin : begin + length] + STATE_SHIFT * rng.standard_normal()
                truth[row] = values[begin : begin + length]
            return x, truth, counts

        flat = adam(network.loss, network.start(rng), pieces, steps, rate)
        return Fitted(
            lambda part: _fast(part, lambda signal: network(flat, signal[None, :])[0], scales),
            network.parameter_count,
        )

    return fit


def ours(method: str) -> Rival:
    """`compensation train --method METHOD`, as it comes."""

    def fit(series: Sequence[Series], target: str, seed: int) -> Fitted:
        compensator = METHODS[method](series, target, Options(seed=seed))
        return Fitted(compensator.predict_series, compensator.parameter_count)

    return fit


def _scales(series: Sequence[Series]) -> Scales:
    columns = [[part.conductance_S for part in series], [part.truth for part in series]]
    scaling_in, scaling_out = (Scaling.of(np.concatenate(column)) for column in columns)
    return scaling_in, scaling_out


def _slow(part: Series, scales: Scales, first: int = SEQUENCE_EVERY - 1) -> tuple[FloatArray, FloatArray]:
    """Standardised signal and truth of every fourth sample: the signal's mean over it and the three before."""
    earlier = np.full(SEQUENCE_EVERY - 1, part.conductance_S[0])
    signal = np.convolve(np.append(earlier, part.conductance_S), np.full(SEQUENCE_EVERY, 1 / SEQUENCE_EVERY), "valid")
    rows = slice(first, None, SEQUENCE_EVERY)
    return scales[0].apply(signal[rows]), scales[1].apply(part.truth[rows])


def _fast(part: Series, run: Callable[[FloatArray], FloatArray], scales: Scales) -> FloatArray:
    """At 20 Hz and in units, from four runs, each of which begins a sample later: none sees what is to come."""
    out = np.empty(len(part))
    for first in range(SEQUENCE_EVERY):
        out[first::SEQUENCE_EVERY] = run(_slow(part, scales, first)[0])
    return scales[1].invert(out)


def _of_the_paper(name: str) -> Callable[[int], object]:
    return lambda seed: regressors(seed)[name]


def _boosted(seed: int) -> object:
    from lightgbm import LGBMRegressor

    return LGBMRegressor(
        n_estimators=200,
        num_leaves=7,
        learning_rate=0.05,
        min_child_samples=50,
        random_state=seed,
        n_jobs=1,
        verbose=-1,
    )


RIVALS: dict[str, Rival] = {
    "line": line,
    "linear": regressor(_of_the_paper("linear"), lambda model: 8),
    "polynomial 3": regressor(_of_the_paper("polynomial, 3rd order"), lambda model: model[-1].n_features_in_ + 1),
    "polynomial 4": regressor(_of_the_paper("polynomial, 4th order"), lambda model: model[-1].n_features_in_ + 1),
    "random forest": regressor(
        _of_the_paper("random forest"), lambda model: sum(tree.tree_.node_count for tree in model.estimators_)
    ),
    "LightGBM": regressor(_boosted, lambda model: model.n_estimators_ * 13),
    "ridge": ridge,
    "ESN": reservoir,
    "GRU": sequence(Gru(8), 300, 2e-2),
    "TCN": sequence(Tcn(8, 9), 500, 1e-2),
}
OURS: dict[str, Rival] = {name: ours(name) for name in ("paper", "tuned", "auto")}


def available() -> tuple[dict[str, Rival], list[str]]:
    """The rivals that can run here, and a sentence for each that cannot."""
    from importlib.util import find_spec

    if find_spec("lightgbm"):
        return RIVALS, []
    rest = {name: rival for name, rival in RIVALS.items() if name != "LightGBM"}
    return rest, ["LightGBM is left out: it is not installed (pip install lightgbm)"]


def seed_of(*names: str) -> int:
    """The same number for the same names, on any machine."""
    return zlib.crc32(" ".join(names).encode()) % 1000

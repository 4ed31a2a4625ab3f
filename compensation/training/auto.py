"""The method chosen by the data: whichever blocked cross-validation finds best, and never worse than a straight line.

The rivals, from the simplest on:

- *line*: a straight line through the conductance.
- *ridge*: linear in the smoothing bank, motion and play operators, learned from shifted copies as well.
- *paper*: the bank and (4, 2, 2), the best of five starts by training score.
- *networks*: several small networks on bank, motion and play with strong L2; memories and L2 chosen within.
- *blend*: the mean of ridge and networks.

Each predicts every fold from the others and makes all its own choices there, on the training part alone. Folds are
whole recordings where there are three or more, contiguous fifths of all rows otherwise; each fold is predicted as a
recording of its own, its memories beginning with its first sample. The best is taken unless its
lead over the line is within one standard error; then the line is, and that is said.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from compensation.engines.engine import Fit, engine
from compensation.engines.network import Network
from compensation.memories.history import NO_HISTORY, History
from compensation.model.compensator import Compensator
from compensation.model.runtime import ready_for_use
from compensation.series import score
from compensation.series.preprocessing import Series
from compensation.training.arrays import describe, training_arrays
from compensation.training.lessons import Lessons, lessons
from compensation.training.options import PAPER_SIZES, Options
from compensation.training.tuning import MOTION_TAUS_S, PLAY_RADII
from gcode.support.errors import UserError

FloatArray = NDArray[np.float64]
Mask = NDArray[np.bool_]

FOLDS, GROUPS_FROM = 5, 3
WHOLE = History(MOTION_TAUS_S, PLAY_RADII)
RIDGE_PENALTIES = (1e-4, 1e-3, 1e-2, 3e-2, 0.1, 0.3)
NETWORK_SIZES, NETWORK_PENALTIES = (8,), (0.1, 0.3, 1.0)
STARTS, ENSEMBLE = 5, 8
COVERAGE = 0.90
SURE = 1.0


@dataclass(frozen=True)
class Learned:
    """A fitted method: networks on features as they come, and the settings that were chosen within."""

    networks: tuple[Network, ...]
    settings: Mapping[str, Any]


class Learner:
    """One rival on one set of recordings: fits on the rows that are kept, predicts all of them."""

    name = ""
    options = Options()

    def __init__(self, series: Sequence[Series], target: str, options: Options) -> None:
        self.options = replace(self.options, rate_hz=options.rate_hz, irregular=options.irregular, seed=options.seed)
        self.lessons: Lessons = lessons(series, target, self.options, starts=True)
        # Each fold is predicted as a recording of its own, from its first sample on.
        cut = _cut(series, folds_of(series))
        self.fresh = (training_arrays(self.lessons.blank, cut)[0] - self.lessons.shift) * self.lessons.scale

    @property
    def features(self) -> FloatArray:
        """Of the recordings as they are, standardised by the lessons: shape (n, k)."""
        return self.lessons.versions[0]

    def fit(self, kept: Mask) -> Learned:
        """Learn from the rows that are kept; networks take standardised features."""
        raise NotImplementedError

    def predict(self, learned: Learned, rows: Mask) -> FloatArray:
        """Standardised target of a fold's rows."""
        return np.mean([network(self.fresh[rows]) for network in learned.networks], axis=0)


class Line(Learner):
    """A straight line through the conductance."""

    name, options = "line", Options(alphas=(1.0,), sizes=(), l2=0.0)

    def fit(self, kept: Mask) -> Learned:
        x, y = self.features[kept, 0], self.lessons.truth[kept]
        slope = float(np.mean((x - x.mean()) * (y - y.mean())) / max(float(x.var()), 1e-12))
        return Learned((linear(np.array([slope]), float(y.mean() - slope * x.mean())),), {"l2": 0.0})


class Ridge(Learner):
    """Linear in bank, motion and play; the penalty from cross-validation within the rows that are kept."""

    name, options = "ridge", Options(history=WHOLE, sizes=())

    def fit(self, kept: Mask) -> Learned:
        fold = np.cumsum(kept) * FOLDS // (kept.sum() + 1)
        parts = [_Sums.of(self.lessons, kept & (fold == number)) for number in range(FOLDS)]
        errors = [self._error(parts, l2) for l2 in RIDGE_PENALTIES]
        l2 = RIDGE_PENALTIES[int(np.argmin(errors))]
        return Learned((linear(*_Sums.total(parts).solved(l2)),), {"l2": l2})

    @staticmethod
    def _error(parts: Sequence[_Sums], l2: float) -> float:
        held_out = 0.0
        for number, part in enumerate(parts):
            rest = _Sums.total([other for index, other in enumerate(parts) if index != number])
            held_out += part.error(*rest.solved(l2))
        return held_out


class Paper(Learner):
    """The paper's network, best of five starts by training score."""

    name, options = "paper", Options(sizes=PAPER_SIZES, engine="fast")

    def fit(self, kept: Mask) -> Learned:
        x, y, options = self.features[kept], self.lessons.truth[kept], self.options
        fits = [
            engine(options.engine)(x, y, options.sizes, options.seed + start, options.l2) for start in range(STARTS)
        ]
        best = max(fits, key=lambda fit: score.r2(y, fit.network(x)))
        return Learned((best.network,), {"l2": options.l2, "restarts": STARTS})


class Networks(Learner):
    """Several small networks; memories and L2 from halves of the rows that are kept."""

    name, options = "networks", Options(history=WHOLE, sizes=NETWORK_SIZES, engine="fast")

    def fit(self, kept: Mask) -> Learned:
        half = np.cumsum(kept) * 2 // (kept.sum() + 1)
        errors = {
            (history, l2): self._error(kept, half, history, l2)
            for history in (NO_HISTORY, WHOLE)
            for l2 in NETWORK_PENALTIES
        }
        history, l2 = min(errors, key=lambda key: errors[key])
        networks = tuple(self._one(kept, history, l2, self.options.seed + number) for number in range(ENSEMBLE))
        live = tuple(one for one in networks if not one.is_dead(self.features[kept])) or networks[:1]
        return Learned(live, {"l2": l2, "restarts": ENSEMBLE, "memories": history.count})

    def _error(self, kept: Mask, half: NDArray[np.int64], history: History, l2: float) -> float:
        total = 0.0
        for number in (0, 1):
            network = self._one(kept & (half != number), history, l2, 0)
            rows = kept & (half == number)
            total += float(np.sum((self.lessons.truth[rows] - network(self.features[rows])) ** 2))
        return total

    def _one(self, kept: Mask, history: History, l2: float, seed: int) -> Network:
        filters = len(self.lessons.blank.alphas)
        lesson = self.lessons if history.count else _without_history(self.lessons, filters)
        network = lesson.fit(kept, replace(self.options, l2=l2), seed)
        if history.count:
            return network
        unused = np.zeros((WHOLE.count, network.weights[0].shape[1]))
        return replace(network, weights=(np.concatenate([network.weights[0], unused]), *network.weights[1:]))


LEARNERS: tuple[type[Learner], ...] = (Line, Ridge, Paper, Networks)
BLEND = "blend"


def train_automatically(
    series: Sequence[Series],
    target: str,
    options: Options,
    progress: Callable[[str], None] = lambda note: None,
) -> Compensator:
    """Choose by cross-validation, train the chosen on everything.

    Parameters
    ----------
    series : sequence of Series
        Training recordings; nothing else is looked at.
    target : {"force", "displacement"}
    options : Options
        Seed and sampling; everything else is chosen.
    progress : callable
        Told about each fold of each method: `steps` times.

    Returns
    -------
    Compensator
        Its recipe says what was tried, what was taken and what cross-validation promises of it.
    """
    if options.per_recording:
        raise UserError(
            "--method auto learns for use, where no recording's own mean is known; leave --per-recording out"
        )
    folds = folds_of(series)
    learners = [learner(series, target, options) for learner in LEARNERS]
    predictions: dict[str, FloatArray] = {}
    for learner in learners:
        predictions[learner.name] = _cross_validated(learner, folds, progress)
    predictions[BLEND] = (predictions["ridge"] + predictions["networks"]) / 2
    truth = learners[0].lessons.truth
    chosen = choose(predictions, truth, learners[0].lessons.block_rows)
    compensator = _trained(chosen, {learner.name: learner for learner in learners}, series, options)
    progress(f"trained {chosen} on everything")
    scale = compensator.scaling_out.scale
    tried = {name: figures(truth, values, scale) for name, values in predictions.items()}
    residual = (truth - predictions[chosen]) * scale
    low, high = margins_of(residual, folds, len(series) >= GROUPS_FROM)
    promise = tried[chosen] | {
        "r2_interval": list(_interval(truth, predictions[chosen], series, folds)),
        "raw_r2": float(np.mean([score.r2_before(p.truth, p.conductance_S, compensator.sign) for p in series])),
        "line_r2": tried["line"]["r2"],
        "folds": int(folds.max()) + 1,
        "whole_recordings": len(series) >= GROUPS_FROM,
    }
    recipe = dict(compensator.recipe) | {"chosen": chosen, "tried": tried, "cross_validated": promise}
    return replace(compensator, recipe=recipe, margins=(float(low), float(high)))


def steps() -> int:
    """How often `train_automatically` reports progress, with one recording."""
    return FOLDS * len(LEARNERS) + 1


def folds_of(series: Sequence[Series]) -> NDArray[np.int64]:
    """Number of the fold of every row: recordings shared out, or contiguous parts of all rows."""
    lengths = [len(part) for part in series]
    if len(series) >= GROUPS_FROM:
        count = min(len(series), FOLDS)
        return np.repeat(np.arange(len(series)) * count // len(series), lengths)
    total = sum(lengths)
    return np.arange(total) * FOLDS // total


def _cut(series: Sequence[Series], folds: NDArray[np.int64]) -> list[Series]:
    found, begin = [], 0
    for part in series:
        own = folds[begin : begin + len(part)]
        found += [part.rows(rows) for rows in np.split(np.arange(len(part)), np.flatnonzero(np.diff(own)) + 1)]
        begin += len(part)
    return found


def choose(predictions: Mapping[str, FloatArray], truth: FloatArray, block_rows: int) -> str:
    """The method with the smallest error, unless its lead over the line is within its standard error over blocks."""
    errors = {
        name: np.array(
            [block.mean() for block in np.array_split((truth - values) ** 2, max(len(truth) // block_rows, 5))]
        )
        for name, values in predictions.items()
    }
    best = min(errors, key=lambda name: float(errors[name].mean()))
    lead = errors["line"] - errors[best]
    unsure = float(lead.std(ddof=1)) / np.sqrt(len(lead))
    return best if lead.mean() > SURE * unsure else "line"


def margins_of(residual: FloatArray, folds: NDArray[np.int64], whole_recordings: bool) -> tuple[float, float]:
    """Ends of the interval for an error to come.

    Folds that are recordings lie from one another as one to come will: the quantiles of all errors. Parts of one
    recording lie nearer to one another than the next recording will: the widest of the parts' own quantiles.
    """
    shares = [(1 - COVERAGE) / 2, (1 + COVERAGE) / 2]
    groups = [residual] if whole_recordings else [residual[folds == number] for number in np.unique(folds)]
    ends = [np.quantile(group, shares) for group in groups]
    return float(min(low for low, _ in ends)), float(max(high for _, high in ends))


def figures(truth: FloatArray, prediction: FloatArray, scale: float) -> dict[str, float]:
    """The paper's r2, the ordinary one, and the RMS error in units."""
    return {
        "r2": score.r2(truth, prediction),
        "r2_ordinary": score.r2_ordinary(truth, prediction),
        "rms_error": float(np.sqrt(np.mean((truth - prediction) ** 2))) * scale,
    }


def linear(weights: FloatArray, bias: float) -> Network:
    """A network without a hidden layer."""
    return Network((weights[:, None],), (np.array([bias]),))


def _cross_validated(learner: Learner, folds: NDArray[np.int64], progress: Callable[[str], None]) -> FloatArray:
    prediction = np.empty(len(folds))
    for number in range(int(folds.max()) + 1):
        held_out = folds == number
        prediction[held_out] = learner.predict(learner.fit(~held_out), held_out)
        progress(f"{learner.name}, fold {number + 1}")
    return prediction


def _trained(chosen: str, learners: Mapping[str, Learner], series: Sequence[Series], options: Options) -> Compensator:
    everything = np.ones(len(learners["line"].lessons.truth), dtype=bool)
    names = ("ridge", "networks") if chosen == BLEND else (chosen,)
    parts = [learners[name].fit(everything) for name in names]
    learner = learners[names[-1]]
    lesson, count = learner.lessons, sum(len(part.networks) for part in parts)
    networks = [
        _scaled(network, count / len(parts) / len(part.networks)).absorbing(lesson.shift, lesson.scale)
        for part in parts
        for network in part.networks
    ]
    settings = dict(parts[-1].settings)
    fits = [Fit(network, np.empty(0)) for network in networks]
    own = replace(learner.options, l2=settings["l2"])
    recipe = describe(series, own, fits[:0], np.empty((len(everything), 0))) | {
        "method": "auto",
        "engine": "fast",
        "seed": options.seed,
        "restarts": settings.get("restarts", 1),
        "dead_networks": settings.get("restarts", 1) - len(parts[-1].networks) if names[-1] == "networks" else 0,
        "settings": settings,
    }
    return ready_for_use(replace(lesson.blank, networks=tuple(networks), recipe=recipe), series)


def _scaled(network: Network, times: float) -> Network:
    """The same network with `times` its output."""
    return Network(
        (*network.weights[:-1], network.weights[-1] * times), (*network.biases[:-1], network.biases[-1] * times)
    )


def _without_history(lesson: Lessons, filters: int) -> Lessons:
    return replace(lesson, versions=tuple(version[:, :filters] for version in lesson.versions))


def _interval(
    truth: FloatArray, prediction: FloatArray, series: Sequence[Series], folds: NDArray[np.int64]
) -> tuple[float, float]:
    """95 % of r2: whole recordings drawn again where they are the folds, else blocks of 60 s."""
    if len(series) < GROUPS_FROM:
        step_s = sum(part.time_s[-1] - part.time_s[0] for part in series) / len(truth)
        return score.block_interval(truth, prediction, np.arange(len(truth)) * step_s)
    owner = np.repeat(np.arange(len(series)), [len(part) for part in series])
    rng, draws = np.random.default_rng(0), []
    rows = [np.flatnonzero(owner == number) for number in range(len(series))]
    for _ in range(500):
        drawn = np.concatenate([rows[number] for number in rng.integers(len(series), size=len(series))])
        draws.append(score.r2(truth[drawn], prediction[drawn]))
    low, high = np.quantile(draws, [0.025, 0.975])
    return float(low), float(high)


@dataclass(frozen=True)
class _Sums:
    """What least squares need to know of some rows: of all versions to learn from, of the first to judge by."""

    learn: FloatArray  # (k + 2, k + 2) products of features, one, target
    judge: FloatArray

    @classmethod
    def of(cls, lesson: Lessons, rows: Mask) -> _Sums:
        products = []
        for version in lesson.versions:
            x = np.column_stack([version[rows], np.ones(rows.sum()), lesson.truth[rows]])
            products.append(x.T @ x)
        return cls(np.sum(products, axis=0) / len(products), products[0])

    @classmethod
    def total(cls, parts: Sequence[_Sums]) -> _Sums:
        return cls(sum(part.learn for part in parts), sum(part.judge for part in parts))  # type: ignore[arg-type]

    def solved(self, l2: float) -> tuple[FloatArray, float]:
        """Weights and bias; the penalty is on features of unit variance, in shares of the number of rows."""
        count = self.learn[-2, -2]
        mean = self.learn[:-2, -2] / count
        covariance = self.learn[:-2, :-2] / count - np.outer(mean, mean)
        target_mean = self.learn[-1, -2] / count
        cross = self.learn[:-2, -1] / count - mean * target_mean
        spread = np.sqrt(np.maximum(np.diag(covariance), 1e-12))
        scaled = covariance / np.outer(spread, spread) + l2 * np.eye(len(spread))
        weights = np.linalg.solve(scaled, cross / spread) / spread
        return weights, float(target_mean - mean @ weights)

    def error(self, weights: FloatArray, bias: float) -> float:
        """Sum of squared errors on these rows."""
        w = np.concatenate([weights, [bias, -1.0]])
        return float(w @ self.judge @ w)

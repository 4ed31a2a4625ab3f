"""The better compensator: more memory, stronger L2, several networks; every choice from the training recording alone.

Four things make it better than the paper's network at the same input:

- Memories that smoothing cannot have (`compensation.history`), where cross-validation finds that they help.
- L2 as strong as cross-validation finds right, and small-step training whose weights are averaged.
- The state of a knit is never the same twice: the network is trained on the recording as it is and with its
  conductance shifted a little up and down, so that it learns from changes rather than from absolute values.
- The mean over several starts; dead ones are left out.

Cross-validation predicts each half of the recording from the other: neighbouring samples are alike, so folds of
single samples would judge nothing, and a test is at least as far from the training as its halves are from one
another. Chosen is not the smallest error but the simplest choice within one standard error of it (Breiman, Friedman,
Olshen and Stone, Classification and Regression Trees, 1984): a recording is a small sample.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from compensation.adam import BATCH, train_adam
from compensation.compensator import Compensator
from compensation.engines import Fit
from compensation.history import NO_HISTORY, History
from compensation.network import Network
from compensation.preprocessing import Series
from compensation.score import BLOCK_S, r2
from compensation.training import Options, describe, training_arrays, untrained

FloatArray = NDArray[np.float64]

# In the order of preference where the error does not tell.
MOTION_TAUS_S, PLAY_RADII = (0.5, 2.0, 8.0, 32.0), (0.2, 0.5, 1.0)
HISTORIES = (NO_HISTORY, History((), PLAY_RADII), History(MOTION_TAUS_S), History(MOTION_TAUS_S, PLAY_RADII))
PENALTIES = (3.0, 1.0, 0.3, 0.1, 0.03)
BANKS = ((2.5, 7), (2.5, 8), (1.75, 10))
SIZES: tuple[tuple[int, ...], ...] = ((8,), (16, 8))
FOLDS, FOLD_NETWORKS, ENSEMBLE = 2, 4, 8
# The history's features are standardised to this spread: a little more penalised than the bank's, which have about 1.
HISTORY_SPREAD = 0.5
STATE_SHIFT = 0.1
ROWS, SMALL_BATCH, RATE, AVERAGING, MAX_EPOCHS = 2_000, 40, 4e-3, 0.9, 1_000


@dataclass(frozen=True)
class Choice:
    """One combination and its cross-validated error, block by block (in variances of the target)."""

    options: Options
    errors: FloatArray
    r2: float


@dataclass(frozen=True)
class Lessons:
    """What networks learn from: features of the recording as it is, and with its conductance shifted.

    Attributes
    ----------
    blank : Compensator
        Scalers, bank and history.
    versions : tuple of ndarray, each shape (n, k)
        The first is the recording as it is.
    truth : ndarray, shape (n,)
        Standardised target.
    shift, scale : ndarray, shape (k,)
        ``versions`` hold ``(feature - shift) * scale``.
    block_rows : int
        Rows of a minute.
    """

    blank: Compensator
    versions: tuple[FloatArray, ...]
    truth: FloatArray
    shift: FloatArray
    scale: FloatArray
    block_rows: int

    def fit(self, kept: NDArray[np.bool_], options: Options, seed: int) -> Network:
        """Train one network, on standardised features, on the rows that are kept."""
        step = max(len(self.truth) // ROWS, 1)
        # Each version is thinned out at rows of its own, so that together they cover the recording.
        picks = [
            np.arange(index * step // len(self.versions), len(kept), step) for index in range(len(self.versions))
        ]
        picks = [rows[kept[rows]] for rows in picks]
        features = np.concatenate([version[rows] for version, rows in zip(self.versions, picks, strict=True)])
        truth = np.concatenate([self.truth[rows] for rows in picks])
        # MLPRegressor divides L2 by the batch size: as much of it here as in batches of its own size.
        l2 = options.l2 * SMALL_BATCH / BATCH
        network, _ = train_adam(
            features, truth, options.sizes, seed, l2, MAX_EPOCHS, batch=SMALL_BATCH, rate=RATE, averaging=AVERAGING
        )
        return network


def lessons(series: Sequence[Series], target: str, options: Options) -> Lessons:
    """Features and target of all training recordings, one after the other."""
    blank = untrained(series, target, options)
    features, truth = training_arrays(blank, series)
    shift, scale = np.zeros(blank.input_count), np.ones(blank.input_count)
    own = features[:, len(blank.alphas) :]
    shift[len(blank.alphas) :] = own.mean(axis=0)
    scale[len(blank.alphas) :] = HISTORY_SPREAD / np.maximum(own.std(axis=0), 1e-9)
    moved = [training_arrays(_shifted(blank, by), series)[0] for by in (STATE_SHIFT, -STATE_SHIFT)]
    versions = tuple((values - shift) * scale for values in (features, *moved))
    duration_s = sum(part.time_s[-1] - part.time_s[0] for part in series)
    block_rows = max(int(len(truth) * BLOCK_S / duration_s), 1)
    return Lessons(blank, versions, truth, shift, scale, block_rows)


def tune(
    series: Sequence[Series],
    target: str,
    options: Options,
    progress: Callable[[str], None] = lambda note: None,
) -> Compensator:
    """Choose by cross-validation (`choose`), then average several networks (`ensemble`).

    Parameters
    ----------
    series : sequence of Series
        Training recordings; nothing else is looked at.
    target : {"force", "displacement"}
    options : Options
        Seed and sampling; sizes, factors, history and penalty are replaced by the chosen ones. The engine does not
        matter: small batches of thinned-out rows are always used.
    progress : callable
        Told about each combination and each network: `steps` times.
    """
    return ensemble(series, target, choose(series, target, options, progress), options.seed, progress)


def choose(
    series: Sequence[Series],
    target: str,
    options: Options,
    progress: Callable[[str], None] = lambda note: None,
) -> tuple[Choice, list[Choice]]:
    """Choose history and penalty, then the bank, then the size; return the chosen and all that were tried.

    The seeds of cross-validation are fixed: the choice depends on the recording alone.
    """
    tried: list[Choice] = []
    chosen = None
    for stage in (histories_and_penalties, banks, sizes):
        for candidate in stage(options if chosen is None else chosen.options):
            tried.append(cross_validated(series, target, candidate))
            progress(_note(tried[-1]))
        chosen = simplest(tried)
    assert chosen is not None
    return chosen, tried


def steps() -> int:
    """How often `tune` reports progress."""
    return len(HISTORIES) * len(PENALTIES) + len(BANKS) - 1 + len(SIZES) - 1 + ENSEMBLE


def histories_and_penalties(options: Options) -> list[Options]:
    """Every history with every penalty, with the first bank and size."""
    (factor, count), size = BANKS[0], SIZES[0]
    start = replace(options, factor=factor, count=count, sizes=size)
    return [replace(start, history=history, l2=l2) for l2 in PENALTIES for history in HISTORIES]


def banks(options: Options) -> list[Options]:
    """The other banks, with everything else as it is."""
    return [replace(options, factor=factor, count=count) for factor, count in BANKS[1:]]


def sizes(options: Options) -> list[Options]:
    """The other sizes, with everything else as it is."""
    return [replace(options, sizes=size) for size in SIZES[1:]]


def simplest(tried: Sequence[Choice]) -> Choice:
    """The first of those whose error is within one standard error of the smallest; earlier ones are simpler."""
    best = min(tried, key=lambda choice: float(choice.errors.mean()))

    def near(choice: Choice) -> bool:
        more = choice.errors - best.errors
        return bool(more.mean() <= more.std(ddof=1) / np.sqrt(len(more)))

    return next(choice for choice in tried if choice is best or near(choice))


def cross_validated(series: Sequence[Series], target: str, options: Options) -> Choice:
    """Predict each of `FOLDS` contiguous blocks by networks that have not seen it."""
    learned = lessons(series, target, options)
    fold = np.arange(len(learned.truth)) * FOLDS // len(learned.truth)
    prediction = np.empty_like(learned.truth)
    for held_out in range(FOLDS):
        kept = fold != held_out
        fits = [learned.fit(kept, options, start) for start in range(FOLD_NETWORKS)]
        prediction[~kept] = np.mean([network(learned.versions[0][~kept]) for network in fits], axis=0)
    blocks = np.array_split((learned.truth - prediction) ** 2, max(len(prediction) // learned.block_rows, FOLDS))
    return Choice(options, np.array([block.mean() for block in blocks]), r2(learned.truth, prediction))


def ensemble(
    series: Sequence[Series],
    target: str,
    choice: tuple[Choice, Sequence[Choice]],
    seed: int,
    progress: Callable[[str], None] = lambda note: None,
) -> Compensator:
    """The mean of `ENSEMBLE` networks from `seed` on, made as `choose` says."""
    chosen, tried = choice
    options, learned = replace(chosen.options, seed=seed), lessons(series, target, chosen.options)
    everything, networks = np.ones(len(learned.truth), dtype=bool), []
    for start in range(seed, seed + ENSEMBLE):
        networks.append(learned.fit(everything, options, start))
        progress(f"network {start}")
    plain = learned.versions[0]
    live = [network for network in networks if not network.is_dead(plain)] or networks
    prediction = np.mean([network(plain) for network in live], axis=0)
    fits = [Fit(network, np.empty(0)) for network in networks]
    recipe = describe(series, options, fits, plain) | {
        "method": "tuned",
        "engine": "fast",
        "restarts": ENSEMBLE,
        "seed": options.seed,
        "history": {name: list(values) for name, values in vars(options.history).items()},
        "training_r2": r2(learned.truth, prediction),
        "cross_validated_r2": chosen.r2,
        "cross_validation": [_summary(choice) for choice in tried],
    }
    trained = tuple(network.absorbing(learned.shift, learned.scale) for network in live)
    return replace(learned.blank, networks=trained, recipe=recipe)


def _shifted(blank: Compensator, by: float) -> Compensator:
    """Reads a conductance as if it were higher by `by` standard deviations."""
    scaling = blank.scaling_in
    return replace(blank, scaling_in=replace(scaling, mean=scaling.mean - by * scaling.scale))


def _note(choice: Choice) -> str:
    options = choice.options
    return (
        f"a = {options.factor:g}, N = {options.count}, {_named(options.history)}, {options.sizes}, "
        f"L2 {options.l2:g}: cross-validated r2 {choice.r2:.4f}"
    )


def _named(history: History) -> str:
    parts = [name for name, used in (("motion", history.motion_taus_s), ("play", history.play_radii)) if used]
    return " and ".join(parts) or "no history"


def _summary(choice: Choice) -> dict[str, float | int | str | list[int]]:
    options = choice.options
    return {
        "factor": options.factor,
        "count": options.count,
        "history": _named(options.history),
        "l2": options.l2,
        "sizes": list(options.sizes),
        "r2": choice.r2,
    }

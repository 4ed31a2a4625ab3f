"""Training a compensator on one or more recordings."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from compensation.compensator import Compensator, Scaling
from compensation.ema import PAPER_COUNT, PAPER_FACTOR, PAPER_RATE_HZ, given_factors, smoothing_factors
from compensation.engines import DEFAULT_L2, Fit, engine
from compensation.history import NO_HISTORY, History
from compensation.preprocessing import Series, series_of
from compensation.runtime import ready_for_use
from compensation.score import r2
from testbench.recordings.recording import Recording

FloatArray = NDArray[np.float64]

PAPER_SIZES = (4, 2, 2)
MORE_STARTS = 6


@dataclass(frozen=True)
class Options:
    """Choices of a training run; the defaults are the paper's, with restarts.

    Attributes
    ----------
    sizes : tuple of int
        Hidden layers.
    factor, count : float, int
        Smoothing factors ``alpha_i = factor^-i``, i = 1..count.
    alphas : tuple of float, optional
        Smoothing factors set by hand, in place of those.
    l2 : float
        MLPRegressor's ``alpha``.
    seed : int
        Seed of the first start; the others follow it.
    restarts : int
        Networks trained; the one with the best training score is kept. The paper: 1.
    irregular : bool
        Use the samples at their own times instead of resampling to 20 Hz.
    per_recording : bool
        Standardise each recording by itself (needs the whole recording).
    engine : {"exact", "fast", "sklearn"}
    rate_hz : float
        Rate of resampling, and the one that the smoothing factors refer to.
    history : History
        Memories beside the bank; the paper has none.
    """

    sizes: tuple[int, ...] = PAPER_SIZES
    factor: float = PAPER_FACTOR
    count: int = PAPER_COUNT
    l2: float = DEFAULT_L2
    seed: int = 0
    restarts: int = 5
    irregular: bool = False
    per_recording: bool = False
    engine: str = "exact"
    rate_hz: float = PAPER_RATE_HZ
    history: History = NO_HISTORY
    alphas: tuple[float, ...] | None = None

    @property
    def bank(self) -> FloatArray:
        """Smoothing factors, set or calculated."""
        return smoothing_factors(self.factor, self.count) if self.alphas is None else given_factors(self.alphas)


def train(
    recordings: Sequence[Recording],
    target: str,
    options: Options | None = None,
    progress: Callable[[str], None] = lambda note: None,
    tuned: bool = False,
) -> Compensator:
    """Train a compensator; scalers and networks see these recordings only.

    Parameters
    ----------
    recordings : sequence of Recording
        Each starts with a fresh smoothing bank: no history leaks over a boundary.
    target : {"force", "displacement"}
    options : Options, optional
    progress : callable
        Told about each network that is done.
    tuned : bool
        Choose factors, penalty and size from the data and average several networks: see `compensation.tuning`.
    """
    from compensation.tuning import tune

    options = options or Options()
    rate_hz = None if options.irregular else options.rate_hz
    series = [series_of(rec, target, rate_hz) for rec in recordings]
    return (tune if tuned else train_on_series)(series, target, options, progress)


def train_on_series(
    series: Sequence[Series],
    target: str,
    options: Options,
    progress: Callable[[str], None] = lambda note: None,
) -> Compensator:
    """As `train`, on prepared series."""
    blank = untrained(series, target, options)
    features, truth = training_arrays(blank, series)
    fits: list[Fit] = []
    # One start is the publication's, dead or not; where several are asked for, one that lives is looked for.
    tries = options.restarts if options.restarts < 2 else MORE_STARTS * options.restarts
    while len(fits) < options.restarts or (len(fits) < tries and all(f.network.is_dead(features) for f in fits)):
        seed = options.seed + len(fits)
        fits.append(engine(options.engine)(features, truth, options.sizes, seed, options.l2))
        progress(f"seed {seed}: training r2 {r2(truth, fits[-1].network(features)):.4f}")
    scores = [r2(truth, fit.network(features)) for fit in fits]
    best = int(np.argmax(scores))
    recipe = describe(series, options, fits, features) | {"seed": options.seed + best, "training_r2": scores[best]}
    return ready_for_use(replace(blank, networks=(fits[best].network,), recipe=recipe), series)


def untrained(series: Sequence[Series], target: str, options: Options) -> Compensator:
    """Scalers, bank and history without a network."""
    conductance = np.concatenate([part.conductance_S for part in series])
    truth = np.concatenate([part.truth for part in series])
    return Compensator(
        target=target,
        rate_hz=options.rate_hz,
        alphas=options.bank,
        scaling_in=Scaling.of(conductance),
        scaling_out=Scaling.of(truth),
        networks=(),
        irregular=options.irregular,
        per_recording=options.per_recording,
        history=options.history,
        sign=float(np.sign(np.corrcoef(conductance, truth)[0, 1]) or 1.0),
    )


def training_arrays(blank: Compensator, series: Sequence[Series]) -> tuple[FloatArray, FloatArray]:
    """Features (n, k) and standardised target (n,) of all recordings, one after the other."""
    features = [blank.features(part.time_s, part.conductance_S) for part in series]
    truth = [scaling_of_target(blank, part).apply(part.truth) for part in series]
    return np.concatenate(features), np.concatenate(truth)


def scaling_of_target(blank: Compensator, part: Series) -> Scaling:
    """By which a recording's target is standardised: its own, or the training's."""
    return Scaling.of(part.truth) if blank.per_recording else blank.scaling_out


def describe(series: Sequence[Series], options: Options, fits: Sequence[Fit], features: FloatArray) -> dict[str, Any]:
    """What a reader of the saved file wants to know."""
    return {
        "method": "paper",
        "trained_on": [part.source for part in series],
        "samples": len(features),
        "sizes": list(options.sizes),
        "factor": options.factor,
        "count": options.count,
        "alphas": options.bank.tolist(),
        "l2": options.l2,
        "restarts": len(fits),
        "dead_networks": sum(fit.network.is_dead(features) for fit in fits),
        "engine": options.engine,
    }

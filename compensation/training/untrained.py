"""What every method starts from: scalers without a network, and the arrays that networks learn from."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from compensation.engines.network import Network
from compensation.model.compensator import Scaling, TrainedCompensator
from compensation.series.preprocessing import Series
from compensation.training.options import Options
from gcode.support.arrays import FloatArray


def untrained(series: Sequence[Series], target: str, options: Options) -> TrainedCompensator:
    """Scalers, bank and history without a network."""
    conductance = np.concatenate([part.conductance_S for part in series])
    truth = np.concatenate([part.truth for part in series])
    # Whether it rises or falls with the target is said within recordings: their levels say nothing.
    together = sum(float((part.conductance_S - part.conductance_S.mean()) @ part.truth) for part in series)
    return TrainedCompensator(
        target=target,
        rate_hz=options.rate_hz,
        alphas=options.bank,
        scaling_in=Scaling.of(conductance),
        scaling_out=Scaling.of(truth),
        networks=(),
        irregular=options.irregular,
        per_recording=options.per_recording,
        history=options.history,
        sign=float(np.sign(together) or 1.0),
    )


def training_arrays(blank: TrainedCompensator, series: Sequence[Series]) -> tuple[FloatArray, FloatArray]:
    """Features (n, k) and standardised target (n,) of all recordings, one after the other."""
    features = [blank.features(part.time_s, part.conductance_S) for part in series]
    truth = [scaling_of_target(blank, part).apply(part.truth) for part in series]
    return np.concatenate(features), np.concatenate(truth)


def scaling_of_target(blank: TrainedCompensator, part: Series) -> Scaling:
    """By which a recording's target is standardised: its own, or the training's."""
    return Scaling.of(part.truth) if blank.per_recording else blank.scaling_out


def describe(
    series: Sequence[Series], options: Options, networks: Sequence[Network], features: FloatArray
) -> dict[str, Any]:
    """What a reader of the saved file wants to know; `networks` are all that were tried, dead ones among them."""
    return {
        "method": "paper",
        "trained_on": [part.source for part in series],
        "trained_digests": [part.digest for part in series],
        "trained_marks": [mark for part in series for mark in part.marks],
        "samples": len(features),
        "sizes": list(options.sizes),
        "factor": options.factor,
        "count": options.count,
        "alphas": options.bank.tolist(),
        "l2": options.l2,
        "restarts": len(networks),
        "dead_networks": sum(network.is_dead(features) for network in networks),
        "engine": options.engine,
    }

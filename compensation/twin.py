"""From the twin: learn on campaigns simulated from the fitted knit model, finish on a short measurement.

Two minutes of measurement do not show the drift of twenty. A knit model fitted on those two minutes does, as far as
it is right; a network pre-trained on what it predicts starts from the right memory, and the measurement then corrects
what the model gets wrong.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from compensation.adam import BATCH, train_adam
from compensation.compensator import Compensator
from compensation.engines import Fit
from compensation.lessons import AVERAGING, MAX_EPOCHS, RATE, SMALL_BATCH
from compensation.network import Network
from compensation.preprocessing import Series
from compensation.score import r2
from compensation.training import Options, describe, training_arrays, untrained
from testbench.knit.model import KnitModel

FloatArray = NDArray[np.float64]

TWIN_SEEDS = (901, 902, 903)
# Two minutes correct the model's errors, but in many epochs would also teach the network to forget the drift.
FINISH_EPOCHS, NETWORKS = (0, 5, 20, 60), 5
SIZES, L2 = (16, 8), 0.1
THINNING = 15


def simulated(
    model: KnitModel, target: str, gauge_length_mm: float, amplitude: float, rate_hz: float, seeds: Sequence[int]
) -> list[Series]:
    """Campaigns that the model predicts: the paper's trajectory from new seeds, scaled to `amplitude` strain.

    The first samples rest where the trajectory begins, so the model starts unloaded, as a measurement does.
    """
    from gcode.output import make
    from gcode.planner import play
    from gcode.presets import preset
    from gcode.reader import read_program
    from testbench.knit.model import inputs

    found = []
    for seed in seeds:
        played = play(read_program(make(preset("paper-1"), seed, gauge_length_mm).program), rate_hz=rate_hz)
        travel_mm = played.position_mm - played.position_mm.min()
        strain = amplitude * travel_mm / travel_mm.max()
        signals = model.simulate(inputs(played.time_s, strain), 1.0 / rate_hz)
        truth = signals["force_N"] if target == "force" else strain * gauge_length_mm
        found.append(Series(played.time_s, signals["conductance_S"], truth, f"twin, seed {seed}"))
    return found


def train_from_twin(
    model: KnitModel,
    measured: Series,
    target: str,
    gauge_length_mm: float,
    amplitude: float,
    options: Options | None = None,
    progress: Callable[[str], None] = lambda note: None,
) -> Compensator:
    """Pre-train on the model's campaigns, finish on the measurement.

    How long to finish is chosen on the measurement alone: pre-trained networks are finished on its first half for
    each number of `FINISH_EPOCHS` and judged on the second.

    Parameters
    ----------
    model : KnitModel
        Fitted on (at least) this measurement: `testbench fit`.
    measured : Series
        The short measurement.
    gauge_length_mm, amplitude : float
        Of the sensor; largest strain of the campaigns to come.
    """
    options = replace(options or Options(), sizes=SIZES, l2=L2)
    return finished(pretrained(model, target, gauge_length_mm, amplitude, options, progress), measured, options)


def pretrained(
    model: KnitModel,
    target: str,
    gauge_length_mm: float,
    amplitude: float,
    options: Options,
    progress: Callable[[str], None] = lambda note: None,
) -> Compensator:
    """Networks that know the model's campaigns only."""
    twins = simulated(model, target, gauge_length_mm, amplitude, options.rate_hz, TWIN_SEEDS)
    # Scales come from the twin: the measurement is too short to have seen the range that drift leads to.
    blank = untrained(twins, target, options)
    features, truth = training_arrays(blank, twins)
    starts = []
    for seed in range(options.seed, options.seed + NETWORKS):
        starts.append(_learned(features[::THINNING], truth[::THINNING], seed, options))
        progress(f"network {seed}")
    live = tuple(network for network in starts if not network.is_dead(features)) or tuple(starts[:1])
    return replace(blank, networks=live, recipe={"twin_campaigns": [part.source for part in twins]})


def finished(start: Compensator, measured: Series, options: Options) -> Compensator:
    """The same networks after some epochs on the measurement."""
    seen, wanted = training_arrays(start, [measured])
    starts = start.networks
    epochs = _finishing_epochs(starts, seen, wanted, options)
    networks = tuple(_finished(network, seen, wanted, epochs, options) for network in starts)
    mean = np.mean([network(seen) for network in networks], axis=0)
    fits = [Fit(network, np.empty(0)) for network in networks]
    recipe = (
        dict(start.recipe)
        | describe([measured], options, fits, seen)
        | {
            "method": "twin",
            "engine": "fast",
            "restarts": NETWORKS,
            "dead_networks": NETWORKS - len(starts),
            "finishing_epochs": epochs,
            "training_r2": r2(wanted, mean),
        }
    )
    return replace(start, networks=networks, recipe=recipe)


def _learned(features: FloatArray, truth: FloatArray, seed: int, options: Options) -> Network:
    l2 = options.l2 * SMALL_BATCH / BATCH
    return train_adam(
        features, truth, options.sizes, seed, l2, MAX_EPOCHS, batch=SMALL_BATCH, rate=RATE, averaging=AVERAGING
    )[0]


def _finished(start: Network, seen: FloatArray, wanted: FloatArray, epochs: int, options: Options) -> Network:
    return train_adam(seen, wanted, options.sizes, options.seed, options.l2, epochs, start)[0]


def _finishing_epochs(starts: Sequence[Network], seen: FloatArray, wanted: FloatArray, options: Options) -> int:
    """The number of epochs after which the first half of the measurement has taught most about the second."""
    half = len(wanted) // 2

    def error(epochs: int) -> float:
        finished = [_finished(start, seen[:half], wanted[:half], epochs, options) for start in starts]
        return float(np.mean((np.mean([network(seen[half:]) for network in finished], axis=0) - wanted[half:]) ** 2))

    return min(FINISH_EPOCHS, key=error)

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

from compensation.adam import train_adam
from compensation.compensator import Compensator
from compensation.engines import MAX_EPOCHS, Fit
from compensation.preprocessing import Series
from compensation.score import r2
from compensation.training import Options, describe, training_arrays, untrained
from testbench.knit.model import KnitModel

FloatArray = NDArray[np.float64]

TWIN_SEEDS = (901, 902, 903)
# Few: two minutes correct the model's errors, but would also teach the network to forget the drift.
FINISH_EPOCHS, NETWORKS = 20, 8
SIZES, L2 = (16, 8), 0.1


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
    twins = simulated(model, target, gauge_length_mm, amplitude, options.rate_hz, TWIN_SEEDS)
    # Scales come from the twin: the measurement is too short to have seen the range that drift leads to.
    blank = untrained(twins, target, options)
    features, truth = training_arrays(blank, twins)
    seen, wanted = training_arrays(blank, [measured])
    fits = []
    for seed in range(options.seed, options.seed + NETWORKS):
        start, _ = train_adam(features, truth, options.sizes, seed, options.l2, MAX_EPOCHS)
        fits.append(Fit(*train_adam(seen, wanted, options.sizes, seed, options.l2, FINISH_EPOCHS, start)))
        progress(f"network {seed}")
    networks = tuple(fit.network for fit in fits if not fit.network.is_dead(features)) or (fits[0].network,)
    mean = np.mean([network(seen) for network in networks], axis=0)
    recipe = describe([measured], options, fits, seen) | {
        "method": "twin",
        "restarts": NETWORKS,
        "training_r2": r2(wanted, mean),
        "twin_campaigns": [part.source for part in twins],
    }
    return replace(blank, networks=networks, recipe=recipe)

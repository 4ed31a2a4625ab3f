"""What a recording cannot judge, in sentences."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from testbench.comparing.residual_coordinates import coordinates
from testbench.knit.kernels import turns
from testbench.measurements.measurement import Measurement
from testbench.measurements.responses import CONDUCTANCE_CHANNEL, FORCE_CHANNEL

FEW_TURNS, LONG_HOLD_S = 6, 10.0
TWOFOLD = 2.0


def not_judged(measurement: Measurement) -> Iterator[str]:
    """One sentence for each kind of law that this recording could not have shown."""
    where = coordinates(measurement)
    inside = measurement.counts
    duration_s = float(measurement.signals["time_s"][inside][-1])
    if FORCE_CHANNEL not in measurement.channels:
        yield "no force was recorded: whether the knit or its contacts changed cannot be told"
    if CONDUCTANCE_CHANNEL not in measurement.channels:
        yield "no resistance was recorded: nothing is said of contacts and yarn"
    if "temperature_C" not in measurement.signals:
        yield "no temperature was recorded: a law of the room's temperature would look like one of time"
    yield f"memories longer than about {0.5 * duration_s:.0f} s, half of the recording, look like drift"
    strain = where["strain"]
    count = turns(np.ascontiguousarray(strain), max(0.02 * float(np.ptp(strain)), 1e-5))[2]
    if float(count[-1]) < FEW_TURNS:
        yield f"the motion turns {int(count[-1])} times: a law of direction or reversals cannot be told from strain"
    if float(where["since_hold_s"].max()) < LONG_HOLD_S:
        yield f"no hold is longer than {LONG_HOLD_S:.0f} s: what happens at rest is known only from slow motion"
    moving = np.abs(where["strain_rate"])
    moving = moving[moving > 0.1 * float(np.median(moving[moving > 0]))] if np.any(moving > 0) else moving
    if len(moving) and float(np.quantile(moving, 0.95)) < TWOFOLD * float(np.quantile(moving, 0.3)):
        yield "the speed hardly varies: a law of the speed cannot be told from one of direction"

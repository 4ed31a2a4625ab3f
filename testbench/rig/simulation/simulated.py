"""The simulated rig: a knit model on a moving stage, read by the instruments, as the bytes of the wire protocol."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import count, repeat

import numpy as np
from numpy.random import default_rng

from gcode.support.arrays import IntArray
from gcode.support.errors import UserError
from testbench.knit.effect import FloatArray
from testbench.knit.model import KnitModel, inputs
from testbench.recordings.instruments import Instruments, Truth
from testbench.rig.protocol.wire import MICROS_WRAP, Sample, encode

SIMULATED_HZ = 200.0
# A line of integers has no infinity: an open circuit reads as 1 TOhm.
OPEN_CIRCUIT_OHM = 1e12


@dataclass(frozen=True)
class Motion:
    """The stage's true displacement on a uniform grid, each shape (n,)."""

    time_s: FloatArray
    displacement_mm: FloatArray

    @property
    def duration_s(self) -> float:
        """From start to end."""
        return float(self.time_s[-1])

    def held(self, hold_s: float) -> Motion:
        """The same motion, holding its last position for `hold_s`."""
        extra = np.arange(1, round(hold_s * SIMULATED_HZ) + 1) / SIMULATED_HZ
        return Motion(
            np.concatenate([self.time_s, self.time_s[-1] + extra]),
            np.concatenate([self.displacement_mm, np.full(len(extra), self.displacement_mm[-1])]),
        )


@dataclass(frozen=True)
class Readings:
    """The device's samples as columns of whole numbers, in the units of the wire, each shape (n,).

    Attributes
    ----------
    boot : int
    micros : ndarray
        The device's clock, modulo 2^32.
    displacement_nm : ndarray
    force_uN, resistance_mohm, temperature_mC : ndarray or None
        None where there is no such channel.
    """

    boot: int
    micros: IntArray
    displacement_nm: IntArray
    force_uN: IntArray | None
    resistance_mohm: IntArray | None
    temperature_mC: IntArray | None

    @property
    def channels(self) -> tuple[IntArray | None, ...]:
        """The channels in the order of a `Sample`."""
        return self.force_uN, self.resistance_mohm, self.displacement_nm, self.temperature_mC

    def sample(self, number: int) -> Sample:
        """The sample of this index, counted from 0."""
        channels = (None if channel is None else int(channel[number]) for channel in self.channels)
        return Sample(self.boot, number, int(self.micros[number]), *channels)  # type: ignore[arg-type]

    def lines(self) -> Iterator[bytes]:
        """All samples as lines of the wire protocol."""
        columns = (repeat(None) if channel is None else channel.tolist() for channel in self.channels)
        return map(encode, map(Sample, repeat(self.boot), count(), self.micros.tolist(), *columns))


@dataclass(frozen=True)
class SimulatedRig:
    """Everything that the bytes depend on. The same values give the same bytes.

    Attributes
    ----------
    model : KnitModel
    motion : Motion
    gauge_length_mm : float
    seed : int
        Of sampling times, noise, boot id and the device clock's start.
    instruments : Instruments
    past_mm : ndarray, shape (m,)
        The stage's displacement before the motion, on the motion's grid; empty: the sensor has never been stretched.
        See `testbench.rig.simulation.played`.
    before : int
        How many recordings were made of the sensor before: with one seed, each has chance of its own.
    """

    model: KnitModel
    motion: Motion
    gauge_length_mm: float
    seed: int
    instruments: Instruments = field(default_factory=Instruments)
    past_mm: FloatArray = field(default_factory=lambda: np.zeros(0))
    before: int = 0

    def truth(self) -> Truth:
        """The signals before any instrument saw them.

        Raises
        ------
        UserError
            If the model makes neither force nor conductance, or values that are not finite.
        """
        motion, past = self.motion, len(self.past_mm)
        dt_s = float(motion.time_s[1] - motion.time_s[0])
        time_s = np.concatenate([motion.time_s[0] + np.arange(-past, 0) * dt_s, motion.time_s])
        displacement_mm = np.concatenate([self.past_mm, motion.displacement_mm])
        room, temperature_C = self.instruments.room, None
        if room is not None:
            temperature_C = room.temperature_C(time_s, default_rng([self.seed, 1, self.before]))
        signals = inputs(time_s, displacement_mm / self.gauge_length_mm, temperature_C)
        state = {name: values[past:] for name, values in self.model.simulate(signals, dt_s).items()}
        force_N, conductance_S = state.get("force_N"), state.get("conductance_S")
        if force_N is None and conductance_S is None:
            raise UserError("the model makes neither force_N nor conductance_S; put a law for one of them in it")
        for name, values in (("force_N", force_N), ("conductance_S", conductance_S)):
            if values is not None and not np.isfinite(values).all():
                raise UserError(f"the model makes {name} that is not finite; check its parameters")
        return Truth(motion.time_s, motion.displacement_mm, force_N, conductance_S, state.get("temperature_C"))

    def readings(self) -> Readings:
        """What the device reads, in order."""
        sampling, force_noise, divider_noise, device = (
            default_rng(child) for child in np.random.SeedSequence([self.seed, self.before]).spawn(4)
        )
        truth, tools = self.truth(), self.instruments
        times_s = tools.clock.times(self.motion.duration_s, sampling)
        boot, micros = (int(number) for number in device.integers(0, MICROS_WRAP, 2))
        force = resistance = temperature = None
        if truth.force_N is not None:
            force = _whole(tools.load_cell.read(truth, times_s, force_noise), 1e6)
        if truth.conductance_S is not None:
            ohm = tools.divider.read(truth, times_s, divider_noise)
            resistance = _whole(np.minimum(ohm, OPEN_CIRCUIT_OHM), 1e3)
        if tools.room is not None:
            temperature = _whole(tools.room.read(truth, times_s), 1e3)
        displacement = _whole(tools.encoder.read(truth, times_s), 1e6)
        stamps = (_whole(times_s, 1e6) + micros) % MICROS_WRAP
        return Readings(boot, stamps, displacement, force, resistance, temperature)

    def lines(self) -> Iterator[bytes]:
        """The samples as lines of the wire protocol."""
        return self.readings().lines()


def _whole(values: FloatArray, scale: float) -> IntArray:
    return np.rint(values * scale).astype(np.int64)

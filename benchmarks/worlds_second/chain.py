"""From the motion of the clamps to both read-outs, with an opening after each stage for a hidden effect.

Stages in their order, and the signal that an effect of that stage replaces:

==================  ===============  =============================================
stage               signal           what it is
==================  ===============  =============================================
kinematics          ``e``            strain of the sample over the largest strain
mechanics           ``f``            force over full scale
pressure            ``drive``        what presses the contacts (force or strain, 0..1)
contact             ``ln_contact``   ln of the contacts' relative conductance
electrical          ``ln_g``         ln of the sensor's conductance in S
force_readout       ``force_N``      force as read
resistance_readout  ``ln_read``      ln conductance as read
force_adc           ``force_N``      the same after noise
resistance_adc      ``ln_read``      the same after noise
==================  ===============  =============================================
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from simulated_case import stream

from worlds_second.kernels import Array
from worlds_second.laws.contact import STRAIN_DRIVEN, around
from worlds_second.protocols import Motion
from worlds_second.sensor import Sensor

SIGNAL = {
    "kinematics": "e",
    "mechanics": "f",
    "pressure": "drive",
    "contact": "ln_contact",
    "electrical": "ln_g",
    "force_readout": "force_N",
    "resistance_readout": "ln_read",
    "force_adc": "force_N",
    "resistance_adc": "ln_read",
}


@dataclass(frozen=True)
class Scales:
    """Sizes of the sensor without an effect, over its calibration: what an effect's magnitude is relative to."""

    rate: float = 1.0
    ln_low: float = 0.0
    ln_high: float = 1.0
    force_low_N: float = 0.0
    force_high_N: float = 1.0


@dataclass
class Signals:
    """All signals of one run, each an ndarray of shape (n,) on the fine grid; set as the chain reaches them."""

    motion: Motion
    sensor: Sensor
    scales: Scales
    seed: int
    t: Array
    dt: Array
    room_K: Array
    e: Array = field(default_factory=lambda: np.empty(0))
    f: Array = field(default_factory=lambda: np.empty(0))
    drive: Array = field(default_factory=lambda: np.empty(0))
    ln_contact: Array = field(default_factory=lambda: np.empty(0))
    ln_g: Array = field(default_factory=lambda: np.empty(0))
    force_N: Array = field(default_factory=lambda: np.empty(0))
    ln_read: Array = field(default_factory=lambda: np.empty(0))
    chance: np.random.Generator = field(default_factory=np.random.default_rng)

    @property
    def rate(self) -> Array:
        """Rate of the strain over its root mean square of the calibration."""
        return np.diff(self.e, prepend=self.e[0]) / self.dt / self.scales.rate

    @property
    def travel(self) -> Array:
        """Path of the strain so far, in whole strokes."""
        return np.cumsum(np.abs(np.diff(self.e, prepend=self.e[0])))


@dataclass(frozen=True)
class Hook:
    """What an effect does at one stage: the new signal from all signals so far."""

    stage: str
    change: Callable[[Signals], Array]


@dataclass(frozen=True)
class Readings:
    """What a noise-free rig would read at the samples."""

    time_s: Array
    x: Array
    room_K: Array
    force_N: Array
    ln_conductance: Array
    strain_rate: float


def simulate(
    sensor: Sensor, motion: Motion, hooks: Sequence[Hook], scales: Scales, seed: int
) -> tuple[Readings, Signals]:
    """Run the chain; the converters' stage is left to `converted`, since noise comes before it."""
    s = Signals(motion, sensor, scales, seed, motion.t, motion.dt, motion.room_K)
    s.e = motion.x + sensor.pretension + motion.shift
    _open(s, "kinematics", hooks)
    s.e = np.maximum(s.e, 0.0)
    _mechanics(s, hooks)
    _electrics(s, hooks)
    s.force_N = s.sensor.force_full_N * (s.f + motion.zero)
    s.ln_read = s.ln_g
    _open(s, "force_readout", hooks)
    _open(s, "resistance_readout", hooks)
    rows = slice(None, None, motion.every)
    rate = float(np.sqrt(np.mean((np.diff(s.e) / s.dt[1:]) ** 2)))
    readings = Readings(s.t[rows], motion.x[rows], s.room_K[rows], s.force_N[rows], s.ln_read[rows], rate)
    return readings, s


def _open(s: Signals, stage: str, hooks: Sequence[Hook]) -> None:
    for hook in hooks:
        if hook.stage == stage:
            s.chance = stream(s.seed, "chance", stage, str(s.motion.index))
            setattr(s, SIGNAL[stage], hook.change(s))


def _mechanics(s: Signals, hooks: Sequence[Hook]) -> None:
    elasticity = s.sensor.laws["elasticity"]
    elastic = elasticity(s.e) / float(elasticity(1.0))
    s.f = elastic + s.sensor.laws["force_loops"](s.e, elastic)
    _open(s, "mechanics", hooks)


def _electrics(s: Signals, hooks: Sequence[Hook]) -> None:
    laws = s.sensor.laws
    network, creep = laws["contact"], laws["drift"](s.t)
    on_contacts = laws["drift_place"].name == "contacts"
    s.drive = s.e if network.name in STRAIN_DRIVEN else s.f
    _open(s, "pressure", hooks)
    s.ln_contact = network(s.drive, s.e) + laws["resistance_loops"](s.e, s.f)
    s.ln_contact = s.ln_contact + creep if on_contacts else s.ln_contact
    _open(s, "contact", hooks)
    s.ln_g = around(network.name, s.ln_contact, s.e, network.parameters) - np.log(s.sensor.resistance_full_ohm)
    s.ln_g = s.ln_g if on_contacts else s.ln_g + creep
    _open(s, "electrical", hooks)


def converted(s: Signals, force_N: Array, ln_read: Array, hooks: Sequence[Hook]) -> tuple[Array, Array]:
    """Both read-outs after the converters; the arrays are at the samples."""
    s.force_N, s.ln_read = force_N, ln_read
    _open(s, "force_adc", hooks)
    _open(s, "resistance_adc", hooks)
    return s.force_N, s.ln_read


def measure(readings: Readings) -> Scales:
    """The scales of a run without an effect."""
    return Scales(
        rate=readings.strain_rate,
        ln_low=float(readings.ln_conductance.min()),
        ln_high=float(readings.ln_conductance.max()),
        force_low_N=float(readings.force_N.min()),
        force_high_N=float(readings.force_N.max()),
    )

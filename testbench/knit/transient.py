"""Conductance that answers motion before it answers stretch: overshoot, shoulders, rate."""

from __future__ import annotations

from typing import Any

import numpy as np

from testbench.knit.effect import Effect, FloatArray, Signals, Stage, parameter
from testbench.knit.filters import lagging_rate, lowpass, rate, shifted

# Spikes to try: sudden ones, and ones that rise as slowly as they settle.
SPIKES: list[dict[str, Any]] = [
    *({"tau_s": tau_s, "rise_s": 0.05} for tau_s in (0.7, 2.0, 6.0, 20.0)),
    *({"tau_s": tau_s, "rise_s": tau_s} for tau_s in (1.0, 3.0, 8.0)),
]


class ElectricalOvershoot(Effect):
    """After each change of strain the conductance overshoots and comes back.

    ln G += gain * (e - y),   tau y' = e - y        (high-pass of the strain: signed)

    Source: Zhang et al., J. Polym. Sci. B 38 (2000) 2739 (time-dependent piezoresistance of filled polymers);
    first-order high-pass as the simplest law.
    Valid: small overshoot; up while stretching, down while releasing (negative gain: the reverse).
    """

    name = "electrical_overshoot"
    stage = Stage.ELECTRICAL
    reads, writes = ("strain", "conductance_S"), ("conductance_S",)
    strength = "gain"
    look = "conductance shoots beyond its final value after every move and settles within seconds"

    gain: float = parameter(0.5, unit="1", low=-20, high=20, doc="change of ln G per unit of sudden strain")
    # Slower than this it is a relaxation of the contacts.
    tau_s: float = parameter(3.0, unit="s", low=0.1, high=30, scale="log", doc="time in which it settles")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        sudden = signals["strain"] - lowpass(signals["strain"], self.tau_s, dt_s)
        return {"conductance_S": shifted(signals["conductance_S"], self.gain * sudden)}


class ElectricalOvershootConductance(Effect):
    """The conductance overshoots with its own changes, most where it changes most with the strain.

    ln G += gain * (ln G - y),   tau y' = ln G - y

    Source: as `electrical_overshoot`, in proportion to what the contacts do.
    Valid: small overshoot.
    """

    name = "electrical_overshoot_conductance"
    idea = "electrical_overshoot"
    stage = Stage.ELECTRICAL
    reads, writes = ("conductance_S",), ("conductance_S",)
    strength = "gain"
    look = "conductance shoots beyond its final value, always by the same share of its change"

    gain: float = parameter(0.2, unit="1", low=0, high=5, doc="share of a sudden change of ln G that is too much")
    tau_s: float = parameter(3.0, unit="s", low=0.1, high=30, scale="log", doc="time in which it settles")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        conductance = signals["conductance_S"]
        log_g = np.log(np.maximum(conductance, 1e-300))
        return {"conductance_S": shifted(conductance, self.gain * (log_g - lowpass(log_g, self.tau_s, dt_s)))}


class ElectricalOvershootMagnitude(Effect):
    """Any motion, in either direction, shakes the contacts: the conductance shifts and comes back at rest.

    ln G += gain * y,   y' = |e'| - y / tau

    Source: simplest law of a disturbance in proportion to the speed that heals exponentially.
    Valid: small shift.
    """

    name = "electrical_overshoot_magnitude"
    idea = "electrical_overshoot"
    stage = Stage.ELECTRICAL
    reads, writes = ("strain", "conductance_S"), ("conductance_S",)
    strength = "gain"
    look = "conductance shifts the same way during stretch and release and comes back in a hold"

    gain: float = parameter(0.5, unit="1", low=-20, high=20, doc="change of ln G per unit of strain path")
    tau_s: float = parameter(3.0, unit="s", low=0.1, high=300, scale="log", doc="time in which it heals")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        speed = np.abs(lagging_rate(signals["strain"], dt_s))
        shaken = self.tau_s * lowpass(speed, self.tau_s, dt_s)
        return {"conductance_S": shifted(signals["conductance_S"], self.gain * shaken)}


class ElectricalOvershootMotion(Effect):
    """While it moves at all, the conductance stands at another level.

    ln G += gain * y,   tau y' = tanh(|e'| / rate0) - y

    Source: simplest law of contacts that slide, or do not: the level hardly depends on how fast.
    Valid: small shift; a long `tau_s` makes the level come and go slowly.
    """

    name = "electrical_overshoot_motion"
    idea = "electrical_overshoot"
    stage = Stage.ELECTRICAL
    reads, writes = ("strain", "conductance_S"), ("conductance_S",)
    strength = "gain"
    look = "conductance steps to another level when motion begins and back when it ends"

    gain: float = parameter(0.05, unit="1", low=-3, high=3, doc="change of ln G in motion")
    tau_s: float = parameter(0.5, unit="s", low=0.02, high=100, scale="log", doc="time in which the level changes")
    rate0_per_s: float = parameter(0.02, unit="1/s", low=1e-4, high=1, scale="log", doc="rate that counts as motion")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        moving = np.tanh(np.abs(rate(signals["strain"], dt_s)) / self.rate0_per_s)
        return {"conductance_S": shifted(signals["conductance_S"], self.gain * lowpass(moving, self.tau_s, dt_s))}

    def data_grid(self, signals: Signals, residual: Signals, dt_s: float) -> list[dict[str, Any]]:
        return [{"tau_s": tau_s, "rate0_per_s": r} for tau_s in (0.1, 1.0, 5.0) for r in (0.005, 0.02, 0.08)]


class ElectricalOvershootReversal(Effect):
    """Each reversal of the motion sends a transient of the same size, whatever the speed.

    ln G += gain * (s - y) / 2,   tau y' = s - y,   rise s' = tanh(e' / rate0) - s: the smoothed direction

    Source: simplest law of yarns that turn over at their contacts when the motion turns.
    Valid: rate0 is far below the speeds in the recording.
    """

    name = "electrical_overshoot_reversal"
    idea = "electrical_overshoot"
    stage = Stage.ELECTRICAL
    reads, writes = ("strain", "conductance_S"), ("conductance_S",)
    strength = "gain"
    look = "a spike of the conductance after every reversal, equally high for slow and fast motion"

    gain: float = parameter(0.05, unit="1", low=-3, high=3, doc="change of ln G at a reversal")
    tau_s: float = parameter(2.0, unit="s", low=0.5, high=100, scale="log", doc="time in which it settles")
    rate0_per_s: float = parameter(
        0.003, unit="1/s", low=1e-4, high=0.1, scale="log", doc="rate below which the knit counts as still"
    )
    rise_s: float = parameter(0.05, unit="s", low=0.02, high=30, scale="log", doc="time in which the spike rises")

    def data_grid(self, signals: Signals, residual: Signals, dt_s: float) -> list[dict[str, Any]]:
        return SPIKES

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        direction = lowpass(np.tanh(rate(signals["strain"], dt_s) / self.rate0_per_s), self.rise_s, dt_s)
        turned = direction - lowpass(direction, self.tau_s, dt_s)
        return {"conductance_S": shifted(signals["conductance_S"], 0.5 * self.gain * turned)}


class ElectricalOvershootTurn(Effect):
    """Each turn of the motion sends a transient; stopping and going on the same way sends none.

    ln G += gain * (s - y) / 2,   tau y' = s - y,   rise s' = d - s
    d = stop operator of the strain over `back`, from -1 (releasing) to 1 (stretching); it stays in a hold

    Source: as `electrical_overshoot_reversal`, with the memory of a stop operator (Visintin, Differential Models of
    Hysteresis (1994)) in the place of the rate.
    Valid: turns that come back by more than `back`.
    """

    name = "electrical_overshoot_turn"
    idea = "electrical_overshoot"
    stage = Stage.ELECTRICAL
    reads, writes = ("strain", "conductance_S"), ("conductance_S",)
    strength = "gain"
    look = "a spike of the conductance after every turn of the motion, none when it stops or goes on after a hold"

    gain: float = parameter(0.05, unit="1", low=-3, high=3, doc="change of ln G at a turn")
    tau_s: float = parameter(2.0, unit="s", low=0.5, high=100, scale="log", doc="time in which it settles")
    back: float = parameter(0.004, unit="1", low=2e-4, high=0.1, scale="log", doc="half the strain that makes a turn")
    rise_s: float = parameter(0.05, unit="s", low=0.02, high=30, scale="log", doc="time in which the spike rises")

    def data_grid(self, signals: Signals, residual: Signals, dt_s: float) -> list[dict[str, Any]]:
        return SPIKES

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        from testbench.knit.kernels import mean_stop

        heading = mean_stop(np.ascontiguousarray(signals["strain"]), np.array([self.back]))
        direction = lowpass(heading, self.rise_s, dt_s)
        turned = direction - lowpass(direction, self.tau_s, dt_s)
        return {"conductance_S": shifted(signals["conductance_S"], 0.5 * self.gain * turned)}


def _between_samples(x: FloatArray, at: np.ndarray) -> FloatArray:
    """Where the extremes of `x` at the samples `at` really are, by the parabola through their neighbours."""
    if len(x) < 3:
        return at.astype(float)
    middle = np.clip(at, 1, len(x) - 2)
    before, here, after = x[middle - 1], x[middle], x[middle + 1]
    bend = before - 2 * here + after
    off = np.divide(before - after, 2 * bend, out=np.zeros(len(at)), where=bend != 0)
    return np.where(at == middle, at + np.clip(off, -0.5, 0.5), at)


class ElectricalOvershootAnew(Effect):
    """Each turn of the motion starts a transient anew and breaks the one before off.

    ln G += gain * d * (exp(-t / tau) - exp(-t / rise)) * tau / (tau - rise)
    t = time since the last turn,   d = 1 while stretching, -1 while releasing

    Source: as `electrical_overshoot_reversal`; contacts that are made anew at each turn: Rabinowicz, Proc. Phys. Soc.
    71 (1958) 668.
    Valid: a turn counts once the knit has come back by `back`; `early` says whether the time runs from there (0) or
    from the turn itself (1).
    """

    name = "electrical_overshoot_anew"
    idea = "electrical_overshoot"
    stage = Stage.ELECTRICAL
    reads, writes = ("strain", "conductance_S"), ("conductance_S",)
    strength = "gain"
    look = "a spike of the conductance after every turn of the motion, the same however soon the next one follows"

    gain: float = parameter(0.05, unit="1", low=-3, high=3, doc="change of ln G at a turn")
    tau_s: float = parameter(2.0, unit="s", low=0.3, high=30, scale="log", doc="time in which it settles")
    rise_s: float = parameter(0.05, unit="s", low=0.02, high=10, scale="log", doc="time in which the spike rises")
    back: float = parameter(0.01, unit="1", low=5e-4, high=0.2, scale="log", doc="strain that makes a turn")
    early: float = parameter(1.0, unit="1", low=0, high=1, doc="0: time runs from the way back, 1: from the turn")

    def data_grid(self, signals: Signals, residual: Signals, dt_s: float) -> list[dict[str, Any]]:
        # No gradient leads from one number of turns to another. What rises slowly hardly shows where it began.
        spikes = [
            spike | {"early": early} for spike in SPIKES for early in (0.0, 1.0) if early or spike["rise_s"] < 0.1
        ]
        return [{"back": back} | spike for back in (0.002, 0.003, 0.005, 0.007, 0.01) for spike in spikes]

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        from testbench.knit.kernels import turns

        strain = np.ascontiguousarray(signals["strain"])
        turned, known, _ = turns(strain, self.back)
        at = turned.astype(int)
        since_s = (np.arange(len(strain)) - known + self.early * (known - _between_samples(strain, at))) * dt_s
        heading = np.sign(strain - strain[at])
        slow_s, quick_s = max(self.tau_s, self.rise_s), min(self.tau_s, self.rise_s)
        faster = 1 / quick_s - 1 / slow_s
        # (exp(-t / slow) - exp(-t / quick)) / faster, which is t exp(-t / tau) where both times are the same
        risen_s = -np.expm1(-faster * since_s) / faster if faster > 1e-9 else since_s
        spike = np.exp(-since_s / slow_s) * risen_s / self.rise_s
        return {"conductance_S": shifted(signals["conductance_S"], self.gain * heading * spike)}


class ShoulderPeak(Effect):
    """On release the conductance of carbon-filled composites dips (or peaks) a second time.

    ln G += gain * (y - e)+,   tau y' = e - y        (the matrix is still long when the filler is let go)

    Source: Flandin, Hiltner & Baer, Polymer 42 (2001) 827 (carbon-black elastomers under cyclic strain); the
    one-sided lag is the simplest law that shows it.
    Valid: release only; negative gain: resistance has a second peak.
    """

    name = "shoulder_peak"
    cost = 0.15
    stage = Stage.ELECTRICAL
    reads, writes = ("strain", "conductance_S"), ("conductance_S",)
    strength = "gain"
    look = "a second peak of the resistance on the way back, none on the way out"

    gain: float = parameter(-1.0, unit="1", low=-50, high=50, doc="change of ln G per unit of strain lag")
    tau_s: float = parameter(10.0, unit="s", low=0.1, high=1000, scale="log", doc="how slowly the matrix follows")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        lag = np.maximum(lowpass(signals["strain"], self.tau_s, dt_s) - signals["strain"], 0.0)
        return {"conductance_S": shifted(signals["conductance_S"], self.gain * lag)}


class RateResistance(Effect):
    """The conductance depends on the speed itself.

    ln G += gain * e' / 0.1 per s

    Source: Eyring-type activation linearised; the strain-rate dependence of filled elastomers.
    Valid: small changes.
    """

    name = "rate_resistance"
    # A conductance that answers to motion: one idea, whatever the law.
    idea = "electrical_overshoot"
    stage = Stage.ELECTRICAL
    reads, writes = ("strain", "conductance_S"), ("conductance_S",)
    strength = "gain"
    look = "conductance is shifted while the knit moves and is back at once when it stops"

    gain: float = parameter(0.05, unit="1", low=-3, high=3, doc="change of ln G at 10 % strain per second")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        speed = rate(signals["strain"], dt_s) / 0.1
        return {"conductance_S": shifted(signals["conductance_S"], self.gain * speed)}


class RateResistanceMagnitude(Effect):
    """The conductance depends on how fast the knit moves, in either direction.

    ln G += gain * ln(1 + |e'| / rate0)

    Source: as `rate_resistance`; logarithm as in Eyring's law.
    Valid: small changes.
    """

    name = "rate_resistance_magnitude"
    idea = "electrical_overshoot"
    stage = Stage.ELECTRICAL
    reads, writes = ("strain", "conductance_S"), ("conductance_S",)
    strength = "gain"
    look = "conductance is shifted the same way in both directions of motion and is back at once when it stops"

    gain: float = parameter(0.02, unit="1", low=-1, high=1, doc="change of ln G per e-fold of the rate")
    rate0_per_s: float = parameter(0.01, unit="1/s", low=1e-5, high=1, scale="log", doc="rate where it sets in")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        decades = np.log1p(np.abs(rate(signals["strain"], dt_s)) / self.rate0_per_s)
        return {"conductance_S": shifted(signals["conductance_S"], self.gain * decades)}

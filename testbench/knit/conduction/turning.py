"""Conductance that spikes at each turn of the motion, or ages from one turn to the next."""

from __future__ import annotations

import numpy as np

from testbench.knit.conduction.contact_relaxation import SpotsLaw
from testbench.knit.conduction.transient import OvershootLaw
from testbench.knit.effect import FloatArray, Points, Signals, parameter
from testbench.knit.filters import highpass, lowpass, moving

# Spikes to try: sudden ones, and ones that rise as slowly as they settle.
SPIKES: Points = [
    *({"tau_s": tau_s, "rise_s": 0.05} for tau_s in (0.7, 2.0, 6.0, 20.0)),
    *({"tau_s": tau_s, "rise_s": tau_s} for tau_s in (1.0, 3.0, 8.0)),
]


class ElectricalOvershootReversal(OvershootLaw):
    """Each reversal of the motion sends a transient of the same size, whatever the speed.

    ln G += gain * (s - y) / 2,   tau y' = s - y,   rise s' = tanh(e' / rate0) - s: the smoothed direction

    Source: simplest law of yarns that turn over at their contacts when the motion turns.
    Valid: rate0 is far below the speeds in the recording.
    """

    name = "electrical_overshoot_reversal"
    look = "a spike of the conductance after every reversal, equally high for slow and fast motion"

    gain: float = parameter(0.05, unit="1", low=-3, high=3, doc="change of ln G at a reversal")
    tau_s: float = parameter(2.0, unit="s", low=0.5, high=100, scale="log", doc="time in which it settles")
    rate0_per_s: float = parameter(0.003, unit="1/s", low=1e-4, high=0.1, scale="log", doc="still below this rate")
    rise_s: float = parameter(0.05, unit="s", low=0.02, high=30, scale="log", doc="time in which the spike rises")

    def starts(self, signals: Signals, residual: Signals) -> Points:
        return SPIKES

    def log_change(self, signals: Signals, dt_s: float) -> FloatArray:
        direction = lowpass(np.tanh(moving(signals["strain"], dt_s) / self.rate0_per_s), self.rise_s, dt_s)
        return 0.5 * self.gain * highpass(direction, self.tau_s, dt_s)


class ElectricalOvershootTurn(OvershootLaw):
    """Each turn of the motion sends a transient; stopping and going on the same way sends none.

    ln G += gain * (s - y) / 2,   tau y' = s - y,   rise s' = d - s
    d = stop operator of the strain over `back`, from -1 (releasing) to 1 (stretching); it stays in a hold

    Source: as `electrical_overshoot_reversal`, with the memory of a stop operator (Visintin, Differential Models of
    Hysteresis (1994)) in the place of the rate.
    Valid: turns that come back by more than `back`.
    """

    name = "electrical_overshoot_turn"
    look = "a spike of the conductance after every turn of the motion, none when it stops or goes on after a hold"

    gain: float = parameter(0.05, unit="1", low=-3, high=3, doc="change of ln G at a turn")
    tau_s: float = parameter(2.0, unit="s", low=0.5, high=100, scale="log", doc="time in which it settles")
    back: float = parameter(0.004, unit="1", low=2e-4, high=0.1, scale="log", doc="half the strain that makes a turn")
    rise_s: float = parameter(0.05, unit="s", low=0.02, high=30, scale="log", doc="time in which the spike rises")

    def starts(self, signals: Signals, residual: Signals) -> Points:
        return SPIKES

    def log_change(self, signals: Signals, dt_s: float) -> FloatArray:
        from testbench.knit.kernels import mean_stop

        heading = mean_stop(np.ascontiguousarray(signals["strain"]), np.array([self.back]))
        direction = lowpass(heading, self.rise_s, dt_s)
        return 0.5 * self.gain * highpass(direction, self.tau_s, dt_s)


def since_turn_s(
    strain: FloatArray, back: float, dt_s: float, early: float = 1.0
) -> tuple[FloatArray, np.ndarray, np.ndarray]:
    """Time since the last turn (before any: since the start), its sample, and whether there was one, each shape (n,).

    Parameters
    ----------
    back : float
        A turn counts once the strain has come back by so much.
    early : float
        0: time runs from when the turn counts; 1: from the turn itself, which lies between samples.
    """
    from testbench.knit.kernels import turns

    turned, known, count = turns(strain, back)
    at = turned.astype(int)
    since = np.arange(len(strain)) - known + early * (known - _between_samples(strain, at))
    return since * dt_s, at, count > 0


def _between_samples(x: FloatArray, at: np.ndarray) -> FloatArray:
    """Where the extremes of `x` at the samples `at` really are, by the parabola through their neighbours."""
    if len(x) < 3:
        return at.astype(float)
    middle = np.clip(at, 1, len(x) - 2)
    before, here, after = x[middle - 1], x[middle], x[middle + 1]
    bend = before - 2 * here + after
    off = np.divide(before - after, 2 * bend, out=np.zeros(len(at)), where=bend != 0)
    return np.where(at == middle, at + np.clip(off, -0.5, 0.5), at)


class ElectricalOvershootAnew(OvershootLaw):
    """Each turn of the motion starts a transient anew and breaks the one before off.

    ln G += gain * d * (exp(-t / tau) - exp(-t / rise)) * tau / (tau - rise)
    t = time since the last turn,   d = 1 while stretching, -1 while releasing, 0 before the first turn

    Source: as `electrical_overshoot_reversal`; contacts that are made anew at each turn: Rabinowicz, Proc. Phys. Soc.
    71 (1958) 668.
    Valid: a turn counts once the knit has come back by `back`; `early` says whether the time runs from there (0) or
    from the turn itself (1).
    """

    name = "electrical_overshoot_anew"
    jumps = ("back",)
    look = "a spike of the conductance after every turn of the motion, the same however soon the next one follows"

    gain: float = parameter(0.05, unit="1", low=-3, high=3, doc="change of ln G at a turn")
    tau_s: float = parameter(2.0, unit="s", low=0.3, high=30, scale="log", doc="time in which it settles")
    rise_s: float = parameter(0.05, unit="s", low=0.02, high=10, scale="log", doc="time in which the spike rises")
    back: float = parameter(0.01, unit="1", low=5e-4, high=0.2, scale="log", doc="strain that makes a turn")
    early: float = parameter(1.0, unit="1", low=0, high=1, doc="0: time runs from the way back, 1: from the turn")

    def starts(self, signals: Signals, residual: Signals) -> Points:
        # No gradient leads from one number of turns to another. What rises slowly hardly shows where it began.
        spikes = [
            spike | {"early": early} for spike in SPIKES for early in (0.0, 1.0) if early or spike["rise_s"] < 0.1
        ]
        return [{"back": back} | spike for back in (0.002, 0.003, 0.005, 0.007, 0.01) for spike in spikes]

    def log_change(self, signals: Signals, dt_s: float) -> FloatArray:
        strain = np.ascontiguousarray(signals["strain"])
        since_s, turned_at, has_turned = since_turn_s(strain, self.back, dt_s, self.early)
        heading = np.where(has_turned, np.sign(strain - strain[turned_at]), 0.0)
        slow_s, quick_s = max(self.tau_s, self.rise_s), min(self.tau_s, self.rise_s)
        faster = 1 / quick_s - 1 / slow_s
        # (exp(-t / slow) - exp(-t / quick)) / faster, which is t exp(-t / tau) where both times are the same
        risen_s = -np.expm1(-faster * since_s) / faster if faster > 1e-9 else since_s
        spike = np.exp(-since_s / slow_s) * risen_s / self.rise_s
        return self.gain * heading * spike


class ContactAgeing(SpotsLaw):
    """A turn of the motion makes the contacts anew; from then on they grow with the logarithm of time.

    ln G += gain * ln(1 + t / tau),   t = time since the last turn; before the first since the start

    Source: Rabinowicz, Proc. Phys. Soc. 71 (1958) 668; Dieterich, J. Geophys. Res. 77 (1972) 3690 (contacts at rest
    strengthen with the logarithm of time).
    Valid: contacts that stick between turns; a turn counts once the knit has come back by `back`.
    """

    name = "contact_ageing"
    jumps = ("back",)
    look = "conductance falls at each turn of the motion and creeps up until the next, fast at first"

    gain: float = parameter(0.05, unit="1", low=-2, high=2, doc="change of ln G per e-fold of time")
    tau_s: float = parameter(1.0, unit="s", low=0.05, high=100, scale="log", doc="when the growth sets in")
    back: float = parameter(0.01, unit="1", low=5e-4, high=0.2, scale="log", doc="strain that makes a turn")

    def log_change(self, signals: Signals, dt_s: float) -> FloatArray:
        age_s, _, _ = since_turn_s(np.ascontiguousarray(signals["strain"]), self.back, dt_s)
        return self.gain * np.log1p(age_s / self.tau_s)

    def starts(self, signals: Signals, residual: Signals) -> Points:
        return [{"back": back, "tau_s": tau_s} for back in (0.002, 0.005, 0.01, 0.02) for tau_s in (0.3, 2.0)]

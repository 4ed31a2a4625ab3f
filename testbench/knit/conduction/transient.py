"""Conductance that answers motion before it answers stretch: overshoot, shoulders, rate."""

from __future__ import annotations

import numpy as np

from testbench.knit.additive import ConductanceLaw
from testbench.knit.effect import FloatArray, Points, Signals, Vector, parameter, zeros
from testbench.knit.filters import highpass, log_conductance, lowpass, memory, moving, rate

SETTLING_S = (0.1, 0.3, 1.0, 3.0, 10.0, 30.0)
SMALLEST_TURN = 0.02  # of the span; wobbles below are no turns


class OvershootLaw(ConductanceLaw):
    """Base of the laws of a conductance that answers motion before it answers stretch."""

    mechanism = "electrical_overshoot"


class ElectricalOvershoot(OvershootLaw):
    """After each change of strain the conductance overshoots and comes back.

    ln G += gain * (e - y),   tau y' = e - y        (high-pass of the strain: signed)

    Source: Zhang et al., J. Polym. Sci. B 38 (2000) 2739 (time-dependent piezoresistance of filled polymers);
    first-order high-pass as the simplest law.
    Valid: small overshoot; up while stretching, down while releasing (negative gain: the reverse).
    """

    name = "electrical_overshoot"
    look = "conductance shoots beyond its final value after every move and settles within seconds"

    gain: float = parameter(0.5, unit="1", low=-20, high=20, doc="change of ln G per unit of sudden strain")
    # Slower than this it is a relaxation of the contacts.
    tau_s: float = parameter(3.0, unit="s", low=0.1, high=30, scale="log", doc="time in which it settles")

    def log_change(self, signals: Signals, dt_s: float) -> FloatArray:
        return self.gain * highpass(signals["strain"], self.tau_s, dt_s)


class ElectricalOvershootConductance(OvershootLaw):
    """The conductance overshoots with its own changes, most where it changes most with the strain.

    ln G += gain * (ln G - y),   tau y' = ln G - y

    Source: as `electrical_overshoot`, in proportion to what the contacts do.
    Valid: small overshoot.
    """

    name = "electrical_overshoot_conductance"
    reads = ("conductance_S",)
    look = "conductance shoots beyond its final value, always by the same share of its change"

    gain: float = parameter(0.2, unit="1", low=0, high=5, doc="share of a sudden change of ln G that is too much")
    tau_s: float = parameter(3.0, unit="s", low=0.1, high=30, scale="log", doc="time in which it settles")

    def log_change(self, signals: Signals, dt_s: float) -> FloatArray:
        return self.gain * highpass(log_conductance(signals["conductance_S"]), self.tau_s, dt_s)


class ElectricalOvershootProny(OvershootLaw):
    """After each change of strain the conductance overshoots, and comes back over any spectrum of times.

    ln G += sum_k w_k * (e - y_k) / span,   tau_k y_k' = e - y_k,   tau_k = 0.1, 0.3, ... 30 s

    Source: as `electrical_overshoot`, with a Prony series at fixed times (Tschoegl, 1989, ch. 3).
    Valid: small overshoot.
    """

    name = "electrical_overshoot_prony"
    strength = "weights"
    look = "conductance shoots beyond its final value after every move and settles over whatever times"

    weights: Vector = zeros(len(SETTLING_S), unit="1", most=5, doc="change of ln G by a sudden strain of `span`")
    span: float = parameter(0.3, unit="1", low=1e-3, high=5, doc="strain by which it is counted")

    def log_change(self, signals: Signals, dt_s: float) -> FloatArray:
        strain = signals["strain"] / self.span
        lagging = memory(strain, np.array(SETTLING_S), np.array(self.weights), dt_s)
        return sum(self.weights) * (strain - strain[0]) - lagging


class ElectricalOvershootMotion(OvershootLaw):
    """While it moves at all, the conductance stands at another level.

    ln G += gain * y,   tau y' = tanh(|e'| / rate0) - y

    Source: simplest law of contacts that slide, or do not: the level hardly depends on how fast.
    Valid: small shift; a long `tau_s` makes the level come and go slowly.
    """

    name = "electrical_overshoot_motion"
    look = "conductance steps to another level when motion begins and back when it ends"

    gain: float = parameter(0.05, unit="1", low=-3, high=3, doc="change of ln G in motion")
    tau_s: float = parameter(0.5, unit="s", low=0.02, high=100, scale="log", doc="time in which the level changes")
    rate0_per_s: float = parameter(0.02, unit="1/s", low=1e-4, high=1, scale="log", doc="rate that counts as motion")

    def log_change(self, signals: Signals, dt_s: float) -> FloatArray:
        in_motion = np.tanh(np.abs(moving(signals["strain"], dt_s)) / self.rate0_per_s)
        return self.gain * lowpass(in_motion, self.tau_s, dt_s)

    def starts(self, signals: Signals, residual: Signals) -> Points:
        return [{"tau_s": tau_s, "rate0_per_s": r} for tau_s in (0.1, 1.0, 5.0) for r in (0.005, 0.02, 0.08)]


class ShoulderPeak(ConductanceLaw):
    """On release the conductance of carbon-filled composites dips (or peaks) a second time.

    ln G += gain * (y - e)+,   tau y' = e - y        (the matrix is still long when the filler is let go)

    Source: Flandin, Hiltner & Baer, Polymer 42 (2001) 827 (carbon-black elastomers under cyclic strain); the
    one-sided lag is the simplest law that shows it.
    Valid: release only; negative gain: resistance has a second peak.
    """

    name = "shoulder_peak"
    look = "a second peak of the resistance on the way back, none on the way out"

    gain: float = parameter(-1.0, unit="1", low=-50, high=50, doc="change of ln G per unit of strain lag")
    tau_s: float = parameter(10.0, unit="s", low=0.1, high=1000, scale="log", doc="how slowly the matrix follows")

    def log_change(self, signals: Signals, dt_s: float) -> FloatArray:
        return self.gain * np.maximum(-highpass(signals["strain"], self.tau_s, dt_s), 0.0)


class ShoulderBumps(ConductanceLaw):
    """Base of the laws of peaks of the resistance at some places of the way back, none on the way out.

    ln G += b(z) * sum_j w_j B_j(place),   dz/|de| = (sgn(de) - z) / (travel * span)
    b = max((1 - z) / 2 - late, 0) / (1 - late),   z = 1 at the start: what was mounted came there on the way out

    Source: Flandin, Hiltner & Baer, Polymer 42 (2001) 827; penalised splines, Eilers & Marx, Statist. Sci. 11 (1996)
    89.
    """

    mechanism = "shoulder_peak"
    strength = "weights"

    weights: Vector = zeros(14, unit="1", most=5, doc="height of each bump, by place")
    travel: float = parameter(0.06, unit="1", low=1e-3, high=1, scale="log", doc="spans until a turn is forgotten")
    late: float = parameter(0.0, unit="1", low=0, high=0.9, doc="share of a turn after which a way back begins")
    span: float = parameter(0.3, unit="1", low=1e-3, high=5, doc="largest strain")

    def bumps(self, e: FloatArray) -> FloatArray:
        """What a way back would add to ln G, were it known at once, shape (n,)."""
        raise NotImplementedError

    def over(self, place: FloatArray) -> FloatArray:
        """The bumps at places of the way back, shape (n,): what lies beyond 0 to 1 has none of its own."""
        from testbench.knit.shapes.splines import bspline

        return bspline(place, np.array(self.weights))

    def log_change(self, signals: Signals, dt_s: float) -> FloatArray:
        e = signals["strain"]
        return on_the_way_back(e, self.travel * self.span, self.late) * self.bumps(e)


class ShoulderPeakAnywhere(ShoulderBumps):
    """Peaks of the resistance at some strains on the way back, none on the way out.

    place = e / span;   else as `ShoulderBumps`

    Source: as `ShoulderBumps`.
    Valid: inside the strain seen in the fit.
    """

    name = "shoulder_peak_anywhere"
    look = "a second peak of the resistance at one strain on the way back, at any speed"

    def bumps(self, e: FloatArray) -> FloatArray:
        return self.over(e / self.span)


class ShoulderPeakAfterTurn(ShoulderBumps):
    """Peaks of the resistance on the way back, at some shares of the stretch from which the knit came back.

    place = e / e_turn;   else as `ShoulderBumps`

    e_turn is the strain of the last turn.

    Source: as `ShoulderBumps`.
    Valid: turns far above the rest length.
    """

    name = "shoulder_peak_after_turn"
    look = "a second peak of the resistance on the way back, later after a higher turn, at any speed"

    def bumps(self, e: FloatArray) -> FloatArray:
        from testbench.knit.kernels import last_turn

        smallest = SMALLEST_TURN * self.span
        return self.over(e / np.maximum(e[last_turn(e, smallest)], smallest))


class ShoulderPeakWayBack(ShoulderBumps):
    """Peaks of the resistance once the knit has come back by some way, the higher the further out it comes from.

    place = (e_top - e) / span;   as `ShoulderBumps`, times e_top / span

    e_top is where the knit last turned, or is, if it has gone beyond that.

    Source: as `ShoulderBumps`; that friction gives way after a fixed way back: Al-Bender, Lampaert & Swevers, Chaos
    14 (2004) 446.
    Valid: ways back longer than a fiftieth of the span.
    """

    name = "shoulder_peak_way_back"
    look = "a second peak of the resistance once the knit has come back by a certain way, from wherever"

    def bumps(self, e: FloatArray) -> FloatArray:
        from testbench.knit.memories import last_top

        top = last_top(e, SMALLEST_TURN * self.span) / self.span
        return top * self.over(top - e / self.span)


def on_the_way_back(strain: FloatArray, travel: float, late: float) -> FloatArray:
    """0 on the way out and at the start, 1 on the way back, shape (n,).

    `travel` in strain, `late` as a share of a turn.
    """
    from testbench.knit.kernels import bouc_wen_of_exponent_1

    return np.maximum(0.5 * (1 - bouc_wen_of_exponent_1(strain, travel, 0.0, 1.0)) - late, 0.0) / (1 - late)


class RateResistance(OvershootLaw):
    """The conductance depends on the speed itself.

    ln G += gain * e' / 0.1 per s

    Source: Eyring-type activation linearised; the strain-rate dependence of filled elastomers.
    Valid: small changes.
    """

    name = "rate_resistance"
    look = "conductance is shifted while the knit moves and is back at once when it stops"

    gain: float = parameter(0.05, unit="1", low=-3, high=3, doc="change of ln G at 10 % strain per second")

    def log_change(self, signals: Signals, dt_s: float) -> FloatArray:
        return self.gain * rate(signals["strain"], dt_s) / 0.1


class RateResistanceMagnitude(OvershootLaw):
    """The conductance depends on how fast the knit moves, in either direction.

    ln G += gain * ln(1 + |e'| / rate0)

    Source: as `rate_resistance`; logarithm as in Eyring's law.
    Valid: small changes.
    """

    name = "rate_resistance_magnitude"
    look = "conductance is shifted the same way in both directions of motion and is back at once when it stops"

    gain: float = parameter(0.02, unit="1", low=-1, high=1, doc="change of ln G per e-fold of the rate")
    rate0_per_s: float = parameter(0.01, unit="1/s", low=1e-5, high=1, scale="log", doc="rate where it sets in")

    def log_change(self, signals: Signals, dt_s: float) -> FloatArray:
        return self.gain * np.log1p(np.abs(rate(signals["strain"], dt_s)) / self.rate0_per_s)


class RateResistanceTwoWays(RateResistanceMagnitude):
    """The conductance depends on how fast the knit moves, on the way back by another share.

    ln G += gain * h * ln(1 + |e'| / rate0),   h = 1 on the way out, back on the way back

    Source: as `rate_resistance_magnitude`; loops that are pulled open rub otherwise than loops that close.
    Valid: small changes.
    """

    name = "rate_resistance_two_ways"
    look = "conductance is shifted while the knit moves, by more in one direction, and is back at once when it stops"

    back: float = parameter(0.3, unit="1", low=-1, high=1, doc="share of it on the way back")

    def log_change(self, signals: Signals, dt_s: float) -> FloatArray:
        share = np.where(rate(signals["strain"], dt_s) >= 0, 1.0, self.back)
        return share * super().log_change(signals, dt_s)

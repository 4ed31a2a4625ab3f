"""The knit grows longer for good: laws of the permanent set of textiles and polymers."""

from __future__ import annotations

import numpy as np

from testbench.knit.effect import FloatArray, Points, Signals, parameter
from testbench.knit.filters import lowpass
from testbench.knit.kinematics.length import TAUT, Lengthening, overload_s
from testbench.knit.mechanics.damage import cycled_strain

RENEWED = 0.5
LIMP_OR_TAUT = (0.0, TAUT)  # pretension: a knit that hangs limp as soon as it has grown, and one that never does


class PermanentSetLaw(Lengthening):
    """Base of the laws of permanent set: the knit itself grows longer."""

    mechanism = "permanent_set"
    strength = "fraction"

    def points(self, top: float) -> Points:
        """Where a fit may start on a recording whose largest strain is `top`; not of what `Lengthening` declares."""
        raise NotImplementedError

    def starts(self, signals: Signals, residual: Signals) -> Points:
        """Whether the added length stretches with the rest is for the data to say: a search from halfway finds it."""
        points = self.points(float(np.max(signals["strain"])))
        return [point | {"renewed": RENEWED, "pretension": at} for point in points for at in LIMP_OR_TAUT]


class PermanentSet(PermanentSetLaw):
    """The knit grows longer for good: part of the largest (slowly followed) stretch does not come back.

    e -= fraction * (m(t) - m(0)),   m = largest value so far of y,   tau y' = e - y

    A long `tau_s` makes the set grow over minutes, a short one with the first stretches.

    Source: Hearle, Grosberg & Backer, Structural Mechanics of Fibers, Yarns, and Fabrics (1969) (unrecovered
    extension of fabrics); the lag is ours.
    Valid: no recovery within the recording.
    """

    name = "permanent_set"
    look = "force comes back to zero before the clamps do, smoothly more so after larger or longer stretches"

    fraction: float = parameter(0.1, unit="1", low=0, high=0.9, doc="share of the stretch that stays")
    tau_s: float = parameter(1.0, unit="s", low=0.01, high=5000, scale="log", doc="how slowly the set follows")

    def added(self, signals: Signals, dt_s: float) -> FloatArray:
        followed = np.maximum.accumulate(lowpass(signals["strain"], self.tau_s, dt_s))
        return self.fraction * (followed - followed[0])

    def points(self, top: float) -> Points:
        return [{"tau_s": tau_s} for tau_s in (0.1, 1.0, 10.0, 60.0, 300.0, 1500.0)]


class PermanentSetYield(PermanentSetLaw):
    """A set that begins beyond an elastic limit and grows with a power of the largest stretch.

    e -= fraction * span * (x(m(t)) - x(m(0))),   x(m) = ((m - limit)+ / span)^power,   m = largest strain so far

    Source: as `permanent_set`; the limit is the yield point of a crimped yarn, the power that of its hardening
    (Ludwik's law, read the other way round).
    Valid: no recovery within the recording; `span` is the largest strain of the recording.
    """

    name = "permanent_set_yield"
    look = "force comes back to zero before the clamps do, the more so after large stretches"

    fraction: float = parameter(
        0.2, unit="1", low=0, high=0.9, doc="set after a stretch of `span` beyond the limit, as a share of it"
    )
    limit: float = parameter(0.05, unit="1", low=0.002, high=2, scale="log", doc="elastic limit, as strain")
    power: float = parameter(1.0, unit="1", low=0.5, high=4, scale="log", doc="how the set grows beyond the limit")
    span: float = parameter(0.3, unit="1", low=1e-3, high=5, doc="strain over which the power is counted")

    def added(self, signals: Signals, dt_s: float) -> FloatArray:
        beyond = np.maximum(np.maximum.accumulate(signals["strain"]) - self.limit, 0.0) / self.span
        grown = beyond**self.power
        return self.fraction * self.span * (grown - grown[0])

    def points(self, top: float) -> Points:
        linear = [{"limit": share * top} for share in (0.05, 0.15, 0.3, 0.5, 0.7)]
        hardening = [{"limit": 0.02 * top, "power": power} for power in (1.7, 2.5)]
        return [*linear, *hardening]


class PermanentSetViscoplastic(PermanentSetLaw):
    """A knit that flows beyond its yield strain, the faster the further beyond; the yield point rises as it flows.

    s' = rate * span * ((e - s - limit - hardening s)+ / span)^power,   e -= s

    Source: Perzyna, Adv. Appl. Mech. 9 (1966) 243 (overstress flow), with linear hardening, written for strain.
    Valid: no recovery within the recording; `span` is the largest strain of the recording.
    """

    name = "permanent_set_viscoplastic"
    strength = "rate_per_s"
    nonlinear = True
    look = "time spent at high stretch makes the knit longer, ever more slowly, and only where it pulls hard"

    rate_per_s: float = parameter(0.01, unit="1/s", low=0, high=1, doc="flow at an overload of `span`, over `span`")
    limit: float = parameter(0.12, unit="1", low=0.002, high=2, scale="log", doc="strain where the flow begins")
    hardening: float = parameter(1.0, unit="1", low=0, high=30, doc="rise of that strain per unit of set")
    power: float = parameter(1.3, unit="1", low=1, high=5, scale="log", doc="how the flow grows with the overload")
    span: float = parameter(0.3, unit="1", low=1e-3, high=5, doc="strain by which the overload is counted")

    def added(self, signals: Signals, dt_s: float) -> FloatArray:
        from testbench.knit.lags import overstress_flow

        over = (signals["strain"] - self.limit) / self.span
        return self.span * overstress_flow(over, self.rate_per_s * dt_s, 1 + self.hardening, self.power)

    def points(self, top: float) -> Points:
        return [{"limit": share * top} for share in (0.1, 0.35, 0.6)]


class PermanentSetRecovering(PermanentSetLaw):
    """A set that follows the mean stretch and recovers as slowly as it came (delayed elasticity).

    e -= fraction * (y - e(0)),   tau y' = e - y

    Source: Ferry, Viscoelastic Properties of Polymers (1980), ch. 1 (Kelvin-Voigt element in series).
    Valid: small set. What comes back within seconds is no set, but relaxation (`stress_relaxation_series`).
    """

    name = "permanent_set_recovering"
    look = "the knit sags during long work and recovers in a rest"

    fraction: float = parameter(0.1, unit="1", low=0, high=0.9, doc="share of the mean stretch that is given up")
    tau_s: float = parameter(300.0, unit="s", low=30, high=1e4, scale="log", doc="time constant of set and recovery")

    def added(self, signals: Signals, dt_s: float) -> FloatArray:
        strain = signals["strain"]
        return self.fraction * (lowpass(strain, self.tau_s, dt_s) - strain[0])

    def points(self, top: float) -> Points:
        return [{"tau_s": tau_s} for tau_s in (40.0, 150.0, 500.0, 1500.0)]


class PermanentSetWorked(PermanentSetLaw):
    """A set that is worked in along the strain path: every cycle ratchets the knit a little longer.

    e -= amount * y,   scale dy/ds = (m / span)^power - y,   m = largest strain so far,   s = path

    The path is the integral of |de|, 0.004 less at each turn. With `power` 0 the size of the stretches does not
    matter: y = 1 - exp(-s / scale).

    Source: Chaboche, Int. J. Plasticity 5 (1989) 247 (saturating ratcheting over the accumulated strain).
    Valid: no recovery within the recording; `span` is the largest strain of the recording.
    """

    name = "permanent_set_worked"
    strength = "amount"
    look = "each cycle the force starts to rise at a slightly greater displacement"

    amount: float = parameter(0.02, unit="1", low=0, high=0.5, doc="set in the end, as strain")
    scale: float = parameter(20.0, unit="1", low=0.01, high=1e5, scale="log", doc="strain path for 63 % of it")
    power: float = parameter(0.0, unit="1", low=0, high=4, doc="how it grows with the largest stretch")
    span: float = parameter(0.3, unit="1", low=1e-3, high=5, doc="strain after which it is `amount`")

    def added(self, signals: Signals, dt_s: float) -> FloatArray:
        from testbench.knit.lags import varying_lowpass

        path = cycled_strain(signals)
        goal = (np.maximum(np.maximum.accumulate(signals["strain"]), 0.0) / self.span) ** self.power
        followed = varying_lowpass(goal, np.exp(-np.diff(path, prepend=path[0]) / self.scale))
        return self.amount * (followed - goal[0] * np.exp(-path / self.scale))

    def points(self, top: float) -> Points:
        steady = [{"scale": scale} for scale in (0.5, 3.0, 15.0, 60.0, 300.0)]
        return [*steady, *({"scale": spans * top, "power": power} for spans in (0.3, 2.0) for power in (1.0, 2.0))]


class PermanentSetCreep(PermanentSetLaw):
    """A set that creeps with the logarithm of the time under stretch, which counts with a power of the stretch.

    e -= amount * ln(1 + w / scale_s),   w = integral of (e+ / span)^power dt

    Source: Cottrell, J. Mech. Phys. Solids 1 (1952) 53 (logarithmic creep); Norton, The Creep of Steel at High
    Temperatures (1929) (a power of the load).
    Valid: no recovery within the recording; `span` is the largest strain of the recording.
    """

    name = "permanent_set_creep"
    strength = "amount"
    look = "the knit grows longer with every minute under stretch, fast at first and never quite to an end"

    amount: float = parameter(0.01, unit="1", low=0, high=0.5, doc="set for each e-fold of time, as strain")
    scale_s: float = parameter(30.0, unit="s", low=0.5, high=3000, scale="log", doc="time at `span` where it begins")
    power: float = parameter(1.0, unit="1", low=0.5, high=8, scale="log", doc="how much more a large stretch counts")
    span: float = parameter(0.3, unit="1", low=1e-3, high=5, doc="strain by which time is weighed")

    def added(self, signals: Signals, dt_s: float) -> FloatArray:
        share = np.maximum(signals["strain"], 0.0) / self.span
        return self.amount * np.log1p(overload_s(share**self.power, 0.0, dt_s) / self.scale_s)

    def points(self, top: float) -> Points:
        return [{"scale_s": scale_s, "power": power} for scale_s in (3.0, 20.0, 150.0) for power in (1.0, 2.5)]

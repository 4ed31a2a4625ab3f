"""Viscous stiffening: a faster stretch takes more force."""

from __future__ import annotations

import itertools

import numpy as np

from testbench.knit.additive import ForceFactor, ForceLaw
from testbench.knit.effect import FloatArray, Points, Signals, Vector, parameter, step_s, zeros
from testbench.knit.filters import highpass, rate
from testbench.knit.mechanics.hysteresis import pressed_on
from testbench.knit.shapes.curves import LAW_TERMS, curve

REFERENCE_RATE_PER_S = 0.1


class PressedDashpot(ForceLaw):
    """Base of the laws of a viscous force, all or a share of which the tension presses on (see `PressedFriction`).

    F += force * (1 - pressed + pressed * max(F, 0) / tension) * w(e')
    """

    mechanism = "viscous_rate_stiffening"

    pressed: float = parameter(0.0, unit="1", low=0, high=1, doc="share of it that grows with the tension")
    tension_N: float = parameter(3.0, unit="N", low=1e-3, high=1e4, doc="force at which the viscous force is given")

    def at_rates(self, rates_per_s: FloatArray) -> FloatArray:
        """Viscous force at `tension_N` (N), shape (n,) as the strain rates."""
        raise NotImplementedError

    def change(self, signals: Signals, dt_s: float) -> FloatArray:
        acts = pressed_on(signals["force_N"], self.pressed, self.tension_N)
        return acts * self.at_rates(rate(signals["strain"], dt_s))

    def pressed_or_not(self, **values: tuple[float, ...]) -> Points:
        """All combinations of starting values, none of it pressed on and all of it."""
        points = itertools.product((0.0, 1.0), *values.values())
        return [dict(zip(("pressed", *values), point, strict=True)) for point in points]


class RateFactor(ForceFactor):
    """Base of the laws of viscous stiffening in proportion to the force of the knit."""

    mechanism = "viscous_rate_stiffening"
    strength = "gain"


class ViscousRateStiffening(PressedDashpot):
    """A dashpot beside the knit: force grows with the rate of strain, by a power of it.

    F += force * p * v (v^2 + v0^2)^((exponent - 1) / 2),   v = e' / 0.1 per s,   v0 = rate0 / 0.1 per s
    p = 1 - pressed + pressed * max(F, 0) / tension

    `exponent` 1 is Newton's dashpot (Kelvin-Voigt); towards 0 it becomes dry friction. Below `rate0` it is Newton's.
    With `pressed` 1 the whole force grows with the rate: the loss of soft tissue grows with its stress.

    Source: Ferry, Viscoelastic Properties of Polymers (1980), ch. 1 (Kelvin-Voigt element); power law after
    Ostwald - de Waele, with the plateau of Carreau, Trans. Soc. Rheol. 16 (1972) 99; Fung, Biomechanics (1993),
    section 7.6 (in proportion to the stress).
    Valid: rates within about two decades of each other.
    """

    name = "viscous_rate_stiffening"
    strength = "force_at_rate_N"
    look = "the faster the stretch the higher the force, the faster the release the lower"

    force_at_rate_N: float = parameter(
        0.2, unit="N", low=0, high=100, doc="viscous force at 10 % strain per second, where `rate0` is far below that"
    )
    exponent: float = parameter(1.0, unit="1", low=0.2, high=1.5, doc="1: linear dashpot; smaller: shear thinning")
    rate0_per_s: float = parameter(
        1e-4, unit="1/s", low=1e-5, high=0.1, scale="log", doc="rate below which the viscosity no longer grows"
    )

    def starts(self, signals: Signals, residual: Signals) -> Points:
        return self.pressed_or_not(exponent=(0.3, 0.6, 1.0, 1.3), rate0_per_s=(1e-4, 4e-3))

    def at_rates(self, rates_per_s: FloatArray) -> FloatArray:
        v, v0 = rates_per_s / REFERENCE_RATE_PER_S, self.rate0_per_s / REFERENCE_RATE_PER_S
        return self.force_at_rate_N * v * (v**2 + v0**2) ** (0.5 * (self.exponent - 1))


class ViscousRateStiffeningMaxwell(ForceLaw):
    """A dashpot that hangs on a spring beside the knit: what a stretch adds is gone within a second.

    F += force * (D - y) / (tau * 0.1 per s),   tau y' = D - y,   D = span sgn(e) (|e| / span)^power

    At slow rates it is Newton's dashpot; a sudden stretch meets the spring. An arm with a power above 1 stiffens.

    Source: Maxwell, Phil. Trans. R. Soc. 157 (1867) 49; Ferry, Viscoelastic Properties of Polymers (1980), ch. 1
    (standard linear solid). What lasts for longer shows in a hold: `stress_relaxation`.
    Valid: one time, shorter than a stroke; `span` is the largest strain of the recording.
    """

    name = "viscous_rate_stiffening_maxwell"
    mechanism = "viscous_rate_stiffening"
    strength = "force_at_rate_N"
    look = "the faster the stretch the higher the force, which is gone within a second after the motion has stopped"

    force_at_rate_N: float = parameter(0.2, unit="N", low=0, high=100, doc="viscous force at 10 % strain per second")
    tau_s: float = parameter(0.3, unit="s", low=0.05, high=1, scale="log", doc="time in which 63 % of it is gone")
    power: float = parameter(1.0, unit="1", low=0.5, high=4, scale="log", doc="1: the arm is as stiff at any strain")
    span: float = parameter(0.3, unit="1", low=1e-3, high=5, doc="strain over which the power is counted")

    def starts(self, signals: Signals, residual: Signals) -> Points:
        return [{"tau_s": tau_s, "power": power} for tau_s in (0.1, 0.3, 0.8) for power in (1.0, 2.0)]

    def change(self, signals: Signals, dt_s: float) -> FloatArray:
        from testbench.knit.memories import power_of

        driving = self.span * power_of(signals["strain"] / self.span, self.power)
        return self.force_at_rate_N * highpass(driving, self.tau_s, dt_s) / (self.tau_s * REFERENCE_RATE_PER_S)


class ViscousRateStiffeningEyring(PressedDashpot):
    """Thermally activated sliding of chains: force grows with the logarithm of the rate.

    F += force * (1 - pressed + pressed * max(F, 0) / tension) * asinh(e' / rate0)

    Source: Eyring, J. Chem. Phys. 4 (1936) 283.
    Valid: linear below rate0, logarithmic above.
    """

    name = "viscous_rate_stiffening_eyring"
    strength = "force_per_efold_N"
    look = "every tenfold speed adds the same force"

    force_per_efold_N: float = parameter(0.05, unit="N", low=0, high=50, doc="force per e-fold of the rate")
    rate0_per_s: float = parameter(0.01, unit="1/s", low=1e-5, high=1, scale="log", doc="rate where the log sets in")

    def starts(self, signals: Signals, residual: Signals) -> Points:
        return self.pressed_or_not(rate0_per_s=(1e-4, 1e-3, 0.01, 0.1))

    def at_rates(self, rates_per_s: FloatArray) -> FloatArray:
        return self.force_per_efold_N * np.arcsinh(rates_per_s / self.rate0_per_s)


class ViscousRateStiffeningLog(RateFactor):
    """All of the force grows with the logarithm of the rate's magnitude.

    F *= 1 + gain * ln(1 + |e'| / rate0)

    Source: Johnson & Cook, Proc. 7th Int. Symp. on Ballistics (1983) 541 (rate factor), smoothed at zero rate.
    Valid: out and back about as fast: where the way back is faster, any factor of the speed alone gives more work
    than it took, in proportion to `gain`, as no material can.
    """

    name = "viscous_rate_stiffening_log"
    look = "the knit is stiffer in fast motion, in both directions"

    gain: float = parameter(0.02, unit="1", low=0, high=1, doc="relative gain of force per e-fold of the rate")
    rate0_per_s: float = parameter(0.01, unit="1/s", low=1e-5, high=1, scale="log", doc="rate where it sets in")

    def change(self, signals: Signals, dt_s: float) -> FloatArray:
        return 1 + self.gain * np.log1p(np.abs(rate(signals["strain"], dt_s)) / self.rate0_per_s)


class ViscousRateStiffeningMagnitude(RateFactor):
    """The whole force grows with a power of the speed, whichever way the knit moves.

    F *= 1 + gain * (|e'| / 0.1 per s)^exponent

    Source: Cowper & Symonds, Brown University Applied Mathematics Report 28 (1957); exponent = 1/q there.
    Valid: as `viscous_rate_stiffening_log`.
    """

    name = "viscous_rate_stiffening_magnitude"
    look = "the faster, the stiffer, stretching and releasing alike"

    gain: float = parameter(0.1, unit="1", low=0, high=3, doc="relative force added at a strain rate of 0.1 / s")
    exponent: float = parameter(0.4, unit="1", low=0.1, high=1.5, scale="log", doc="power of the rate")

    def change(self, signals: Signals, dt_s: float) -> FloatArray:
        speed = np.abs(rate(signals["strain"], dt_s)) / REFERENCE_RATE_PER_S
        return 1 + self.gain * speed**self.exponent


class ViscousRateStiffeningCurve(RateFactor):
    """The whole force depends on the strain rate along a smooth curve of any form.

    F *= exp( curve(v) - curve(1/2) ),   v = asinh(30 e' / reach) / (2 asinh(30)) + 1/2

    Source: smoothing splines as a cosine series, Wahba, Spline Models for Observational Data (1990), ch. 2, over a
    rate that is stretched around rest.
    Valid: rates up to `reach_per_s`, the largest of the recording.
    """

    name = "viscous_rate_stiffening_curve"
    strength = "weights"
    look = "the force depends on how fast the knit moves, in each direction in its own way"

    weights: Vector = zeros(LAW_TERMS, unit="1", most=3, doc="weights of the curve")
    reach_per_s: float = parameter(0.1, unit="1/s", low=1e-6, high=10, scale="log", doc="largest rate")

    def starts(self, signals: Signals, residual: Signals) -> Points:
        return [{"reach_per_s": float(np.max(np.abs(rate(signals["strain"], step_s(signals)))))}]

    def change(self, signals: Signals, dt_s: float) -> FloatArray:
        v = np.arcsinh(30 * rate(signals["strain"], dt_s) / self.reach_per_s) / (2 * np.arcsinh(30)) + 0.5
        stiffer = curve(v, 0.0, 1.0, self.weights) - curve(np.full(1, 0.5), 0.0, 1.0, self.weights)
        return np.exp(stiffer)

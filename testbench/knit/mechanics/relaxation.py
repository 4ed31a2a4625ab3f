"""Stress relaxation: force that decays under constant strain."""

from __future__ import annotations

import numpy as np

from testbench.knit import spectra
from testbench.knit.additive import ForceLaw
from testbench.knit.effect import Effect, FloatArray, Points, Signals, Stage, Vector, parameter, zeros
from testbench.knit.filters import (
    activated_memory,
    lowpass,
    memory,
    memory_of_box,
    memory_of_decades,
    memory_of_two_times,
)

PRONY_S = (1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0)
STARTS_OF_A_POWER = [{"tau_s": tau_s, "exponent": exponent} for tau_s in (0.1, 1.0, 10.0) for exponent in (0.3, 1.0)]


class StressRelaxationLaw(Effect):
    """Base of the laws of stress relaxation: force that decays while the strain is held."""

    mechanism = "stress_relaxation"
    stage = Stage.MECHANICS
    reads, writes = ("force_N",), ("force_N",)
    strength = "fraction"

    def lost_N(self, force_N: FloatArray, dt_s: float) -> FloatArray:
        """What has decayed of a force that the knit would answer with at once, shape (n,)."""
        raise NotImplementedError

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        return {"force_N": signals["force_N"] - self.lost_N(signals["force_N"], dt_s)}


class StressRelaxation(StressRelaxationLaw):
    """Force decays exponentially under constant strain: one term of a Prony series.

    F(t) = F_e(t) - fraction * integral of (1 - exp(-(t - s) / tau)) dF_e(s)

    Several terms are several instances in one model (`stress_relaxation`, `stress_relaxation_2`).

    Source: Fung, Biomechanics: Mechanical Properties of Living Tissues (1993), section 7.6 (quasi-linear
    viscoelasticity); Ferry, Viscoelastic Properties of Polymers (1980).
    Valid: relaxation in proportion to the elastic force; the knit has rested before the recording.
    """

    name = "stress_relaxation"
    look = "in a hold the force sinks, quickly at first; after a release it recovers"

    fraction: float = parameter(0.15, unit="1", low=0, high=1, doc="share of the force that is lost in the end")
    # What is quicker shows in no hold: it is a stiffening with the rate.
    tau_s: float = parameter(10.0, unit="s", low=0.5, high=3000, scale="log", doc="time in which 63 % of it is lost")

    def lost_N(self, force_N: FloatArray, dt_s: float) -> FloatArray:
        return self.fraction * (lowpass(force_N, self.tau_s, dt_s) - force_N[0])


class StressRelaxationTwoTimes(StressRelaxationLaw):
    """Force decays in two steps, a quick one and a slow one: two terms of a Prony series.

    F(t) = F_e(t) - fraction * integral of phi(t - s) dF_e(s)
    phi(t) = share (1 - exp(-t / fast)) + (1 - share) (1 - exp(-t / max(slow, fast)))

    Source: as `stress_relaxation`.
    Valid: as `stress_relaxation`.
    """

    name = "stress_relaxation_two_times"
    look = "in a hold the force sinks within seconds, and then on for minutes"

    fraction: float = parameter(0.2, unit="1", low=0, high=1, doc="share of the force that is lost in the end")
    fast_s: float = parameter(5.0, unit="s", low=0.1, high=100, scale="log", doc="time of the quick step")
    slow_s: float = parameter(100.0, unit="s", low=10, high=1e4, scale="log", doc="time of the slow step")
    share: float = parameter(0.5, unit="1", low=0, high=1, doc="share of the quick step")

    def lost_N(self, force_N: FloatArray, dt_s: float) -> FloatArray:
        return memory_of_two_times(force_N, self.fraction, self.share, self.fast_s, self.slow_s, dt_s)

    def starts(self, signals: Signals, residual: Signals) -> Points:
        return [{"fast_s": fast_s, "slow_s": slow_s} for fast_s in (1.5, 6.0, 20.0) for slow_s in (60.0, 300.0)]


class StressRelaxationSpectrum(StressRelaxationLaw):
    """Force decays with a whole box of relaxation times: nearly like the logarithm of time between two times.

    F(t) = F_e(t) - fraction * integral of phi(t - s) dF_e(s)
    phi(t) = mean of 1 - exp(-t / tau) over ln(tau) from `shortest_s` to `longest_s`, if that is longer

    Source: Fung, Biomechanics (1993), section 7.6 (box spectrum).
    Valid: as `stress_relaxation`.
    """

    name = "stress_relaxation_spectrum"
    look = "in a hold the force sinks for decades of time, ever more slowly"

    fraction: float = parameter(0.2, unit="1", low=0, high=1, doc="share of the force that is lost in the end")
    shortest_s: float = parameter(1.0, unit="s", low=0.05, high=100, scale="log", doc="shortest relaxation time")
    longest_s: float = parameter(100.0, unit="s", low=1, high=1e5, scale="log", doc="longest relaxation time")

    def lost_N(self, force_N: FloatArray, dt_s: float) -> FloatArray:
        return memory_of_box(force_N, self.fraction, self.shortest_s, self.longest_s, dt_s)


class StressRelaxationPower(StressRelaxationLaw):
    """Force decays with a power of time (fractional viscoelasticity).

    F(t) = integral of (1 + (t - s) / tau)^-exponent dF_e(s)

    Source: Nutting, J. Franklin Inst. 191 (1921) 679 (power law); Findley, Lai & Onaran, Creep and Relaxation of
    Nonlinear Viscoelastic Materials (1976).
    Valid: as `stress_relaxation`; the exponent of polymers is mostly below 0.3.
    """

    name = "stress_relaxation_power"
    strength = "exponent"
    look = "in a hold the force sinks as a straight line on log-log paper"

    exponent: float = parameter(0.05, unit="1", low=0, high=0.9, doc="slope of ln F over ln t in a long hold")
    tau_s: float = parameter(1.0, unit="s", low=0.05, high=300, scale="log", doc="when the power law sets in")

    def lost_N(self, force_N: FloatArray, dt_s: float) -> FloatArray:
        times, weights = spectra.power(self.tau_s, self.exponent)
        return memory(force_N, times, weights, dt_s)


class StressRelaxationFindley(StressRelaxationLaw):
    """Part of the force decays with a power of time, the rest lasts.

    F(t) = F_e(t) - fraction * integral of (1 - (1 + (t - s) / tau)^-exponent) dF_e(s)

    Source: Findley, Lai & Onaran, Creep and Relaxation of Nonlinear Viscoelastic Materials (1976), ch. 5 (power law
    with a part that lasts).
    Valid: as `stress_relaxation`; from a fraction of a second to days, as in elastomers.
    """

    name = "stress_relaxation_findley"
    look = "in a hold the force sinks over all times at once, towards a level that it keeps"

    fraction: float = parameter(0.4, unit="1", low=0, high=0.99, typical=0.7, doc="share of force lost in the end")
    exponent: float = parameter(0.3, unit="1", low=0.02, high=3, scale="log", doc="slope of the decay, log-log")
    tau_s: float = parameter(1.0, unit="s", low=0.01, high=300, scale="log", doc="when the power law sets in")

    def lost_N(self, force_N: FloatArray, dt_s: float) -> FloatArray:
        times, weights = spectra.power(self.tau_s, self.exponent)
        return self.fraction * memory(force_N, times, weights, dt_s)

    def starts(self, signals: Signals, residual: Signals) -> Points:
        return STARTS_OF_A_POWER


class StressRelaxationLog(StressRelaxationLaw):
    """Force decays with the logarithm of time.

    F(t) = integral of (1 - per_decade log10(1 + (t - s) / tau)) dF_e(s)

    Source: Findley, Lai & Onaran, Creep and Relaxation of Nonlinear Viscoelastic Materials (1976).
    Valid: until a good half of the force is gone.
    """

    name = "stress_relaxation_log"
    strength = "per_decade"
    look = "in a hold the force loses the same amount in every decade of time"

    per_decade: float = parameter(0.05, unit="1", low=0, high=0.3, doc="share of the force lost per decade of time")
    tau_s: float = parameter(1.0, unit="s", low=0.05, high=300, scale="log", doc="when the decay sets in")

    def lost_N(self, force_N: FloatArray, dt_s: float) -> FloatArray:
        return memory_of_decades(force_N, self.per_decade, self.tau_s, dt_s)


class StressRelaxationNonlinear(StressRelaxationLaw):
    """The more the knit is loaded, the larger the share of its force that decays.

    F(t) = F_e(t) - fraction * integral of (1 - exp(-(t - s) / tau)) dD(s),   D = span sgn(F_e) (|F_e| / span)^power

    Source: Schapery, Polym. Eng. Sci. 9 (1969) 295 (nonlinear viscoelasticity; here one exponential, driven by a
    power of the force).
    Valid: one dominant relaxation time; `span_N` is the range of the force.
    """

    name = "stress_relaxation_nonlinear"
    look = "in a hold the force decays by a larger share the higher it was"

    fraction: float = parameter(0.2, unit="1", low=0, high=3, doc="share of the force lost in the end, at full force")
    tau_s: float = parameter(20.0, unit="s", low=0.5, high=3000, scale="log", doc="time in which 63 % of it is lost")
    power: float = parameter(1.6, unit="1", low=0.4, high=4, scale="log", doc="1 loses the same share at any force")
    span_N: float = parameter(5.0, unit="N", low=1e-3, high=1e4, doc="range of the force")

    def lost_N(self, force_N: FloatArray, dt_s: float) -> FloatArray:
        from testbench.knit.memories import power_of

        driving_N = self.span_N * power_of(force_N / self.span_N, self.power)
        return self.fraction * (lowpass(driving_N, self.tau_s, dt_s) - driving_N[0])


class StressRelaxationActivated(StressRelaxationLaw):
    """The higher the force is, the sooner it decays.

    F(t) = F_e(t) - fraction * y,   tau(F_e) y' = F_e - F_e(0) - y,   tau(F_e) = tau exp(-activation |F_e| / span)

    Source: Eyring, J. Chem. Phys. 4 (1936) 283 (a load lowers the barrier, and the time falls exponentially).
    Valid: one time at each force; `span_N` is the range of the force.
    """

    name = "stress_relaxation_activated"
    look = "in a hold the force sinks, quickly where it is high"

    fraction: float = parameter(0.2, unit="1", low=0, high=1, doc="share of the force that is lost in the end")
    tau_s: float = parameter(60.0, unit="s", low=0.5, high=3000, scale="log", doc="relaxation time without load")
    activation: float = parameter(
        1.0, unit="1", low=0, high=5, doc="e-folds by which it is shorter at the full force"
    )
    span_N: float = parameter(5.0, unit="N", low=1e-3, high=1e4, doc="range of the force")

    def lost_N(self, force_N: FloatArray, dt_s: float) -> FloatArray:
        load = np.abs(force_N) / self.span_N
        return self.fraction * activated_memory(force_N, load, self.tau_s, self.activation, dt_s)

    def starts(self, signals: Signals, residual: Signals) -> Points:
        return [{"tau_s": tau_s, "activation": a} for tau_s in (15.0, 50.0, 150.0) for a in (0.7, 2.0)]


class StressRelaxationProny(StressRelaxationLaw):
    """Force decays with any spectrum of relaxation times: a Prony series of one term for each half decade.

    F(t) = F_e(t) - sum_k w_k * integral of (1 - exp(-(t - s) / tau_k)) dF_e(s),   tau_k = 1, 3, 10, ... 1000 s

    Source: Tschoegl, The Phenomenological Theory of Linear Viscoelastic Behavior (1989), ch. 3 (Prony series at fixed
    times).
    Valid: relaxation in proportion to the elastic force; the knit has rested before the recording.
    """

    name = "stress_relaxation_prony"
    strength = "fractions"
    look = "in a hold the force sinks, over whatever times"

    fractions: Vector = zeros(len(PRONY_S), unit="1", most=1, doc="share of the force that is lost at each time")

    def lost_N(self, force_N: FloatArray, dt_s: float) -> FloatArray:
        return memory(force_N, np.array(PRONY_S), np.array(self.fractions), dt_s)


class RelaxingArm(ForceLaw):
    """Base of the laws of an arm beside the knit whose force decays, while that of the knit and its friction stay."""

    mechanism = "stress_relaxation"
    strength = "arm_force_N"

    arm_force_N: float = parameter(0.3, unit="N", low=0, high=100, doc="force of the arm lost in the end at `span`")
    power: float = parameter(1.0, unit="1", low=0.3, high=4, scale="log", doc="1: the arm is as stiff at any strain")
    span: float = parameter(0.3, unit="1", low=1e-3, high=5, doc="strain over which the power is counted")

    def decayed(self, x: FloatArray, dt_s: float) -> FloatArray:
        """What has decayed of an arm that is stretched by `x`, shape (n,)."""
        raise NotImplementedError

    def change(self, signals: Signals, dt_s: float) -> FloatArray:
        from testbench.knit.memories import power_of

        return -self.arm_force_N * self.decayed(power_of(signals["strain"] / self.span, self.power), dt_s)


class StressRelaxationArm(RelaxingArm):
    """A spring and a dashpot in series beside the knit: their force decays, that of its friction does not.

    F = F_e - arm_force * integral of (1 - exp(-(t - s) / tau)) dD(s),   D = sgn(e) (|e| / span)^power

    F_e is what the knit answers with at once, the arm's part in it.

    Source: Ferry, Viscoelastic Properties of Polymers (1980), ch. 1 (standard linear solid); arms with a curve of
    their own: Huber & Tsakmakis, Mech. Mater. 32 (2000) 1.
    Valid: one dominant time; `span` is the largest strain of the recording. What is gone within a second is a
    stiffening with the rate (`viscous_rate_stiffening_maxwell`).
    """

    name = "stress_relaxation_arm"
    look = "in a hold the force sinks, but for what the friction makes of it, which stays"

    # What is quicker shows in no hold: it is a stiffening with the rate.
    tau_s: float = parameter(10.0, unit="s", low=0.5, high=3000, scale="log", doc="time in which 63 % of it is lost")

    def decayed(self, x: FloatArray, dt_s: float) -> FloatArray:
        return lowpass(x, self.tau_s, dt_s) - x[0]


class StressRelaxationArmPower(RelaxingArm):
    """Arms of many times beside the knit: their force decays with a power of time, that of its friction does not.

    F = F_e - arm_force * integral of (1 - (1 + (t - s) / tau)^-exponent) dD(s),   D = sgn(e) (|e| / span)^power

    Source: as `stress_relaxation_arm`; the power of time as in `stress_relaxation_findley`.
    Valid: as `stress_relaxation_arm`, over decades of time.
    """

    name = "stress_relaxation_arm_power"
    look = "in a hold the force sinks over all times at once, but for what the friction makes of it, which stays"

    exponent: float = parameter(0.3, unit="1", low=0.02, high=3, scale="log", doc="slope of the decay, log-log")
    tau_s: float = parameter(1.0, unit="s", low=0.01, high=300, scale="log", doc="when the power law sets in")

    def decayed(self, x: FloatArray, dt_s: float) -> FloatArray:
        return memory(x, *spectra.power(self.tau_s, self.exponent), dt_s)

    def starts(self, signals: Signals, residual: Signals) -> Points:
        return STARTS_OF_A_POWER


class StressRelaxationSeries(Effect):
    """Part of the knit gives way under its load within seconds, and comes back (delayed elasticity).

    F(t) = F_e(e - s),   s = fraction * (y - e(0)),   tau y' = e - y

    Held at constant strain, what gives way takes stretch from the rest, whose force sinks along its own curve. Unlike
    in `stress_relaxation`, what is lost follows the strain, whatever the curve of the force.

    Source: Ferry, Viscoelastic Properties of Polymers (1980), ch. 1 (Kelvin-Voigt element in series, the standard
    linear solid); Huber & Tsakmakis, Mech. Mater. 32 (2000) 1 (the same at finite strain).
    Valid: what gives way is as stiff as the rest at every strain. What takes minutes is a set that recovers
    (`permanent_set_recovering`).
    """

    name = "stress_relaxation_series"
    mechanism = "stress_relaxation"
    stage = Stage.KINEMATICS
    reads, writes = ("strain",), ("strain",)
    strength = "fraction"
    look = "loops that are wide for their force and open at slow rates; in a hold the force sinks"

    fraction: float = parameter(0.3, unit="1", low=0, high=0.95, doc="share of the stretch that gives way in the end")
    tau_s: float = parameter(10.0, unit="s", low=0.5, high=60, scale="log", doc="time in which 63 % of it gives way")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        strain = signals["strain"]
        return {"strain": strain - self.fraction * (lowpass(strain, self.tau_s, dt_s) - strain[0])}

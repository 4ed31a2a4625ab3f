"""What strain the knit really sees: set, backlash, screw, slack (slip of the clamps: `slip.py`)."""

from __future__ import annotations

from typing import Any

import numpy as np

from testbench.knit.damage import cycled_strain, share_of_strain
from testbench.knit.effect import Effect, FloatArray, Signals, Stage, parameter
from testbench.knit.filters import lowpass


class PermanentSet(Effect):
    """The knit grows longer for good: part of the largest (slowly followed) stretch does not come back.

    e -= fraction * (m(t) - m(0)),   m = largest value so far of y,   tau y' = e - y

    A long `tau_s` makes the set grow over minutes, a short one with the first stretches.

    Source: Hearle, Grosberg & Backer, Structural Mechanics of Fibers, Yarns, and Fabrics (1969) (unrecovered
    extension of fabrics); the lag is ours.
    Valid: no recovery within the recording.
    """

    name = "permanent_set"
    stage = Stage.KINEMATICS
    reads, writes = ("strain",), ("strain",)
    strength = "fraction"
    look = "force comes back to zero before the clamps do, smoothly more so after larger or longer stretches"

    fraction: float = parameter(0.1, unit="1", low=0, high=0.9, doc="share of the stretch that stays")
    tau_s: float = parameter(1.0, unit="s", low=0.01, high=5000, scale="log", doc="how slowly the set follows")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        from testbench.knit.kernels import running_max

        followed = running_max(lowpass(signals["strain"], self.tau_s, dt_s))
        return {"strain": signals["strain"] - self.fraction * (followed - followed[0])}


class PermanentSetYield(Effect):
    """A set that begins only beyond an elastic limit.

    e -= fraction * (max(m(t), limit) - max(m(0), limit)),   m = largest strain so far

    Source: as `permanent_set`; the limit is the yield point of a crimped yarn.
    Valid: no recovery within the recording.
    """

    name = "permanent_set_yield"
    idea = "permanent_set"
    stage = Stage.KINEMATICS
    reads, writes = ("strain",), ("strain",)
    strength = "fraction"
    look = "force comes back to zero before the clamps do, but only after large stretches"

    fraction: float = parameter(
        0.2, unit="1", low=0, high=0.9, doc="share of the stretch beyond the limit that stays"
    )
    limit: float = parameter(0.05, unit="1", low=0.002, high=2, scale="log", doc="elastic limit, as strain")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        from testbench.knit.kernels import running_max

        beyond = np.maximum(running_max(signals["strain"]) - self.limit, 0.0)
        return {"strain": signals["strain"] - self.fraction * (beyond - beyond[0])}

    def initial_guess(self, signals: Signals, dt_s: float) -> Effect:
        return share_of_strain(self, signals, limit=0.3)

    def data_grid(self, signals: Signals, residual: Signals, dt_s: float) -> list[dict[str, Any]]:
        top = float(np.max(signals["strain"]))
        return [{"limit": max(share * top, 0.002)} for share in (0.05, 0.15, 0.3, 0.5, 0.7)]


class PermanentSetRecovering(Effect):
    """A set that follows the mean stretch and recovers as slowly as it came (delayed elasticity).

    e -= fraction * (y - e(0)),   tau y' = e - y

    Source: Ferry, Viscoelastic Properties of Polymers (1980), ch. 1 (Kelvin-Voigt element in series).
    Valid: small set.
    """

    name = "permanent_set_recovering"
    idea = "permanent_set"
    stage = Stage.KINEMATICS
    reads, writes = ("strain",), ("strain",)
    strength = "fraction"
    look = "the knit sags during long work and recovers in a rest"

    fraction: float = parameter(0.1, unit="1", low=0, high=0.9, doc="share of the mean stretch that is given up")
    tau_s: float = parameter(300.0, unit="s", low=1, high=1e4, scale="log", doc="time constant of set and recovery")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        strain = signals["strain"]
        return {"strain": strain - self.fraction * (lowpass(strain, self.tau_s, dt_s) - strain[0])}


class PermanentSetWorked(Effect):
    """A set that grows with the strain path: every cycle ratchets the knit a little longer.

    e -= amount * (1 - exp(-path / scale)),   path = integral of |de|

    Source: Chaboche, Int. J. Plasticity 5 (1989) 247 (saturating ratcheting over the accumulated strain).
    Valid: cycles between similar extremes.
    """

    name = "permanent_set_worked"
    idea = "permanent_set"
    stage = Stage.KINEMATICS
    reads, writes = ("strain",), ("strain",)
    strength = "amount"
    look = "each cycle the force starts to rise at a slightly greater displacement"

    amount: float = parameter(0.02, unit="1", low=0, high=0.3, doc="set in the end, as strain")
    scale: float = parameter(20.0, unit="1", low=0.1, high=1e5, scale="log", doc="strain path for 63 % of it")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        return {"strain": signals["strain"] + self.amount * np.expm1(-cycled_strain(signals) / self.scale)}


class ActuatorBacklash(Effect):
    """Play in the drive: after each reversal the clamp stands still until the gap is crossed.

    e = play operator of the nominal strain with half width gap / 2

    Source: Visintin, Differential Models of Hysteresis (1994), ch. III.
    Valid: quasi-static; the drive rests in the middle of its gap at the start.
    """

    name = "actuator_backlash"
    stage = Stage.KINEMATICS
    reads, writes = ("strain",), ("strain",)
    strength = "gap"
    nonlinear = True
    imitated_by = "slip"
    look = "after each reversal force and conductance stand still for a fixed displacement"

    gap: float = parameter(0.004, unit="1", low=0, high=0.2, doc="full gap, as strain (divide mm by gauge length)")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        from testbench.knit.kernels import play

        return {"strain": play(signals["strain"], np.array([self.gap / 2]))[0]}


class ActuatorBacklashWindup(Effect):
    """A drive with friction winds up elastically after each reversal before the clamp follows.

    e -= (gap / 2) * z,   dz/de = (1 - z sign(de)) / travel,   z = 0 at the start

    Source: Dahl, A solid friction model, Aerospace Corp. TOR-0158(3107-18)-1 (1968) (friction that builds up over a
    short travel), times the compliance of the drive.
    Valid: quasi-static; `actuator_backlash` with a rounded corner.
    """

    name = "actuator_backlash_windup"
    idea = "actuator_backlash"
    stage = Stage.KINEMATICS
    reads, writes = ("strain",), ("strain",)
    strength = "gap"
    imitated_by = "slip"
    look = "after each reversal force and conductance are late by a displacement that builds up over a short travel"

    gap: float = parameter(0.004, unit="1", low=0, high=0.2, doc="lost motion between out and back, as strain")
    travel: float = parameter(0.004, unit="1", low=2e-4, high=0.1, scale="log", doc="strain over which it builds up")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        from testbench.knit.kernels import dahl

        return {"strain": signals["strain"] - 0.5 * self.gap * dahl(signals["strain"], self.travel)}


class LeadscrewRipple(Effect):
    """The screw advances unevenly within each turn.

    e += amplitude * (sin(2 pi e / pitch + phase) - its value at the start)

    Source: ISO 230-2 (periodic part of the positioning error of linear axes).
    Valid: encoder on the motor, not on the clamp.
    """

    name = "leadscrew_ripple"
    cost = 0.15
    stage = Stage.KINEMATICS
    reads, writes = ("strain",), ("strain",)
    strength = "amplitude"
    look = "a ripple of force and conductance with a fixed period in displacement, at any speed"

    amplitude: float = parameter(0.001, unit="1", low=0, high=0.02, doc="amplitude, as strain")
    pitch: float = parameter(0.08, unit="1", low=0.01, high=1, scale="log", doc="travel of one turn, as strain")
    phase_rad: float = parameter(0.0, unit="rad", low=-3.2, high=3.2, doc="phase at zero strain")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        strain = signals["strain"]
        wave = np.sin(2 * np.pi * strain / self.pitch + self.phase_rad)
        return {"strain": strain + self.amplitude * (wave - wave[0])}


class Slack(Effect):
    """The knit hangs through: a thin fabric bears no compression, the first stretch only takes up the slack.

    e = max(e - slack, min(e, 0))

    Source: ISO 13934-1:2013 asks for a pretension because of this.
    Valid: mounted without pretension.
    """

    name = "slack"
    cost = 0.15
    stage = Stage.KINEMATICS
    reads, writes = ("strain",), ("strain",)
    strength = "slack"
    nonlinear = True
    look = "near the start of the travel nothing happens at all"

    slack: float = parameter(0.02, unit="1", low=0, high=0.5, doc="strain that is taken up without force")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        strain = signals["strain"]
        return {"strain": np.maximum(strain - self.slack, np.minimum(strain, 0.0))}

"""What drive and mounting make of the strain: backlash, screw, slack (of the knit: `slip.py`, `permanent_set.py`)."""

from __future__ import annotations

import numpy as np

from testbench.knit.effect import Effect, FloatArray, Points, Signals, Stage, Vector, bounds_of, parameter
from testbench.knit.kinematics.jumps import SIGNAL, steepness
from testbench.knit.shapes.waves import harmonics_parameter, wave_of

TURN_STRAIN = 2e-4  # that the motion comes back by for a turn to count
MOST_TURNS, PITCHES = 40.0, 4  # turns of a screw within the motion; pitches to begin at
BEND_TURNS = 3.0  # fewer turns of a screw within the motion are a bend of the knit's own law
SEEN_END = 1.0  # spread of the lengths of yarns over their mean, below which one sees where they are straight
TAKEN_UP = (0.03, 0.1, 0.3, 0.6, 0.85)  # of the longest stretch
JOINTS = np.linspace(-1, 1, 5)  # relative gaps of a drive whose play closes little by little


class BacklashLaw(Effect):
    """Base of the laws of motion lost between out and back."""

    mechanism = "actuator_backlash"
    stage = Stage.KINEMATICS
    reads, writes = ("strain",), ("strain",)
    strength = "gap"


class ActuatorBacklash(BacklashLaw):
    """Play in the drive: after each reversal the clamp stands still until the gap is crossed.

    e = mean of play operators of the nominal strain with half widths gap / 2 * (1 +- spread)

    `spread` 0 is one gap; joints with play of their own, or a gap that closes elastically, close little by little.

    Source: Visintin, Differential Models of Hysteresis (1994), ch. III.
    Valid: quasi-static; the drive rests in the middle of its gap at the start.
    """

    name = "actuator_backlash"
    nonlinear = True
    look = "after each reversal force and conductance stand still for a fixed displacement"

    gap: float = parameter(0.004, unit="1", low=0, high=1, doc="full gap, as strain (divide mm by gauge length)")
    # Below 1: gaps of any size down to none are friction.
    spread: float = parameter(0.0, unit="1", low=0, high=0.8, doc="how gradually it closes: 0 all at once")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        from testbench.knit.kernels import play

        if not self.spread:
            return {"strain": play(signals["strain"], np.array([self.gap / 2]))[0]}
        half_widths = 0.5 * self.gap * (1 + self.spread * JOINTS)
        return {"strain": play(signals["strain"], half_widths).mean(axis=0)}

    def starts(self, signals: Signals, residual: Signals) -> Points:
        return [{"spread": spread} for spread in (0.0, 0.5)]


class ActuatorBacklashWindup(BacklashLaw):
    """A drive with friction winds up elastically after each reversal before the clamp follows.

    e -= (gap / 2) * z,   dz/de = (1 - z sign(de)) / travel,   z = 0 at the start

    Source: Dahl, A solid friction model, Aerospace Corp. TOR-0158(3107-18)-1 (1968) (friction that builds up over a
    short travel), times the compliance of the drive.
    Valid: quasi-static; `actuator_backlash` with a rounded corner.
    """

    name = "actuator_backlash_windup"
    look = "after each reversal force and conductance are late by a displacement that builds up over a short travel"

    gap: float = parameter(0.004, unit="1", low=0, high=1, doc="lost motion between out and back, as strain")
    travel: float = parameter(0.004, unit="1", low=2e-4, high=0.02, scale="log", doc="strain over which it builds up")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        from testbench.knit.kernels import bouc_wen_of_exponent_1

        strain = signals["strain"]
        return {"strain": strain - 0.5 * self.gap * bouc_wen_of_exponent_1(strain, self.travel, 0.0)}


class ActuatorBacklashCompensated(BacklashLaw):
    """A controller makes up for a play at every reversal, however short the stroke, and not by the right amount.

    e -= (gap / 2) * d * (1 - 2 exp(-s / travel)),   s = strain since the last turn,   d = 1 out, -1 back

    Source: reversal value of an axis, ISO 230-2:2014; backlash compensation of CNC controllers adds the whole gap at
    each turn.
    Valid: a turn counts once the motion has come back by 0.0002; gap > 0: lost motion, gap < 0: too much made up for.
    """

    name = "actuator_backlash_compensated"
    looks_ahead = True  # a controller knows its next stroke
    look = "after each reversal, also of the shortest stroke, force and conductance jump by the same displacement"

    gap: float = parameter(0.004, unit="1", low=-1, high=1, doc="motion lost at each turn, as strain")
    travel: float = parameter(0.004, unit="1", low=1e-5, high=0.02, scale="log", doc="strain over which it is")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        from testbench.knit.kernels import last_turn

        e = signals["strain"]
        # A stroke begins at its turn, not where that became known.
        begins = np.unique(last_turn(e, TURN_STRAIN))
        lengths, ends = np.diff(begins, append=len(e)), np.append(begins[1:], len(e) - 1)
        heading = np.repeat(np.sign(e[ends] - e[begins]), lengths)
        way = np.abs(e - np.repeat(e[begins], lengths))
        swing = np.repeat(np.where(begins > 0, 2.0, 1.0), lengths)  # before the first turn it rests in the middle
        wound = heading * (1 - swing * np.exp(-way / self.travel))
        return {"strain": e - 0.5 * self.gap * wound}


class LeadscrewRipple(Effect):
    """The screw advances unevenly within each turn.

    e += amplitude * (sin(2 pi e / pitch + phase) - its value at the start)

    Source: ISO 230-2 (periodic part of the positioning error of linear axes).
    Valid: encoder on the motor, not on the clamp.
    """

    name = "leadscrew_ripple"
    stage = Stage.KINEMATICS
    reads, writes = ("strain",), ("strain",)
    strength = "amplitude"
    look = "a ripple of force and conductance with a fixed period in displacement, at any speed"

    amplitude: float = parameter(0.001, unit="1", low=0, high=0.1, doc="amplitude, as strain")
    pitch: float = parameter(0.08, unit="1", low=0.001, high=1, scale="log", doc="travel of one turn, as strain")
    phase_rad: float = parameter(0.0, unit="rad", low=-6.3, high=6.3, doc="phase at zero strain")

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        strain = signals["strain"]
        wave = self.wave(2 * np.pi * strain / self.pitch + self.phase_rad)
        return {"strain": strain + self.amplitude * (wave - wave[0])}

    def wave(self, angle: FloatArray) -> FloatArray:
        """Over the turn of the screw, shape (n,) as the angle (rad)."""
        return np.sin(angle)

    def is_a_bend(self, signals: Signals) -> bool:
        return float(np.ptp(signals["strain"])) < BEND_TURNS * self.pitch

    def starts(self, signals: Signals, residual: Signals) -> Points:
        """The pitches whose waves over the strain, times the slope of the channel, follow the misfit best."""
        strain = signals["strain"]
        pitches = float(np.ptp(strain)) / np.arange(1.0, MOST_TURNS, 0.5)  # turns over the range of the strain
        pitches = pitches[pitches >= bounds_of(type(self).model_fields["pitch"])["low"]]
        waves = np.zeros((len(pitches), 3))  # share of the misfit that a pitch explains, its sine, its cosine
        for channel, misfit in residual.items():
            slope = steepness(strain, signals[SIGNAL[channel]], channel)
            misfit = misfit / max(float(np.linalg.norm(misfit)), 1e-300)
            for i, pitch in enumerate(pitches):
                sine, cosine = (slope * wave(2 * np.pi * strain / pitch) for wave in (np.sin, np.cos))
                s, c = float(sine @ misfit), float(cosine @ misfit)
                waves[i] += (s * s + c * c) / max(float(sine @ sine), 1e-300), s, c
        best = np.argsort(-waves[:, 0])[:PITCHES]
        return [{"pitch": float(pitches[i]), "phase_rad": float(np.arctan2(waves[i, 2], waves[i, 1]))} for i in best]


class LeadscrewRippleWave(LeadscrewRipple):
    """The screw advances unevenly within each turn, in any way: a worn thread, a bent screw beside an eccentric nut.

    e += amplitude * (w(a) - its value at the start),   a = 2 pi e / pitch + phase
    w(a) = sin(a) + sum_k (s_k sin(k a) + c_k cos(k a)),   k = 2 to 6

    Source: Fourier series; as `leadscrew_ripple`.
    Valid: encoder on the motor, not on the clamp.
    """

    name = "leadscrew_ripple_wave"
    look = "a ripple of fixed form in force and conductance, with a fixed period in displacement, at any speed"

    harmonics: Vector = harmonics_parameter()

    def wave(self, angle: FloatArray) -> FloatArray:
        return wave_of(angle, self.harmonics)


class SlackLaw(Effect):
    """Base of the laws of a knit that hangs through at first."""

    mechanism = "slack"
    stage = Stage.KINEMATICS
    reads, writes = ("strain",), ("strain",)
    strength = "slack"
    nonlinear = True

    slack: float = parameter(0.02, unit="1", low=0, high=1.5, doc="strain that is taken up without force")

    def starts(self, signals: Signals, residual: Signals) -> Points:
        """Slack that ends somewhere within the motion."""
        longest = float(np.max(signals["strain"]))
        return [{"slack": share * longest} for share in TAKEN_UP if share * longest > 0]


class Slack(SlackLaw):
    """The knit hangs through: a thin fabric bears no compression, the first stretch only takes up the slack.

    e = max(e - slack, min(e, 0))

    Source: ISO 13934-1:2013 asks for a pretension because of this.
    Valid: mounted without pretension.
    """

    name = "slack"
    look = "near the start of the travel nothing happens at all"

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        strain = signals["strain"]
        return {"strain": np.maximum(strain - self.slack, np.minimum(strain, 0.0))}


class SlackGradual(SlackLaw):
    """Yarns are crumpled to different lengths: one after the other is straight and begins to bear.

    e = w (S((e - slack) / w) - S(-slack / w)),   S(u) = ln(1 + exp(u)),   w = spread * slack,   for e > 0

    Source: sequential straightening, Lanir, J. Biomech. 16 (1983) 1, for a logistic distribution of the lengths.
    Valid: mounted without pretension, or crimped.
    """

    name = "slack_gradual"
    look = "near the start of the travel hardly anything happens, then more and more"

    spread: float = parameter(0.2, unit="1", low=0.02, high=2, scale="log", doc="spread of lengths over the slack")

    def is_a_bend(self, signals: Signals) -> bool:
        """Yarns of all lengths get straight all along, as in the elasticity of any knit: no end of it is seen."""
        return self.spread > SEEN_END

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        strain = signals["strain"]
        if self.slack == 0:
            return {"strain": strain.copy()}
        width = self.spread * self.slack
        out = np.maximum(strain, 0.0) / width
        straight = np.logaddexp(0.0, out - 1 / self.spread) - np.logaddexp(0.0, -1 / self.spread)
        return {"strain": np.minimum(strain, 0.0) + width * straight}

    def starts(self, signals: Signals, residual: Signals) -> Points:
        return [{**one, "spread": spread} for one in super().starts(signals, residual) for spread in (0.1, 0.4)]

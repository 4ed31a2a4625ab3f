"""Rate-independent memory of the yarn-to-yarn friction."""

from __future__ import annotations

import numpy as np

from testbench.knit.additive import ForceLaw
from testbench.knit.effect import FloatArray, Signals, parameter
from testbench.knit.shapes.recent import Recent

# Relative break-away strains of the slip elements: a wide, fixed distribution whose scale is a parameter.
SPREAD = np.geomspace(0.15, 2.5, 6)
QUANTILES = np.array([-1.383, -0.674, -0.210, 0.210, 0.674, 1.383])  # of a normal law, in the middle of six parts


def mean_slip(x: FloatArray, threshold: float) -> FloatArray:
    """Mean of the slip elements' relative deflections, in [-1, 1]: -1 or 1 when all slip, 0 at the start."""
    from testbench.knit.kernels import mean_stop

    return mean_stop(x, threshold * SPREAD)


def pressed_on(force_N: FloatArray, pressed: float, tension_N: float) -> FloatArray:
    """What a force is over that at `tension_N` if the tension presses on a share of it, shape (n,)."""
    load = np.maximum(force_N, 0.0) / tension_N
    return 1 - pressed + pressed * load


class FrictionLaw(ForceLaw):
    """Base of the laws of friction between the yarns."""

    mechanism = "hysteresis"
    in_base = True
    strength = "friction_N"
    exclusive = True


class Hysteresis(FrictionLaw):
    """Friction between the yarns: a Prandtl-Ishlinskii (Maxwell-slip) sum of stop operators.

    F += friction * (1 + growth e) * mean_k( stop_k(e) / r_k )
    stop_r(e) = e - play_r(e),   r_k = threshold * spread_k

    Source: Kuhnen, Eur. J. Control 9 (2003) 407, Eqs. 4-9; Iwan, J. Appl. Mech. 33 (1966) 893.
    Valid: slow, rate-independent friction. `growth` lets the loops widen with strain as normal forces rise.
    """

    name = "hysteresis"
    look = "force is higher while stretching than while releasing, at any speed"

    friction_N: float = parameter(0.3, unit="N", low=0, high=100, typical=0.05, doc="force when every element slips")
    threshold: float = parameter(0.02, unit="1", low=5e-5, high=2, scale="log", doc="strain from a turn to slip")
    growth: float = parameter(0.0, unit="1", low=-1, high=30, typical=2.0, doc="relative growth per unit strain")

    def change(self, signals: Signals, dt_s: float) -> FloatArray:
        e = signals["strain"]
        width = np.maximum(1 + self.growth * e, 0.0)
        return self.friction_N * width * mean_slip(e, self.threshold)


class PressedFriction(FrictionLaw):
    """Base of the laws of friction that the tension presses on: the more a knit is loaded, the harder its yarns rub.

    F += friction * (1 - pressed + pressed * max(F, 0) / tension) * z

    Source: Euler's capstan equation; of yarn on yarn: Howell, J. Text. Inst. 44 (1953) T359.
    """

    friction_N: float = parameter(0.3, unit="N", low=0, high=100, typical=0.05, doc="force at `tension_N`, slipping")
    pressed: float = parameter(
        0.5, unit="1", low=0, high=1, doc="share of it that the tension presses on; the rest is there without load"
    )
    tension_N: float = parameter(3.0, unit="N", low=1e-3, high=1e4, doc="force at which the friction is given")
    threshold: float = parameter(0.02, unit="1", low=5e-5, high=2, scale="log", doc="strain from a turn to slip")

    def deflection(self, e: FloatArray) -> FloatArray:
        """z, in [-1, 1], shape (n,): what part of the friction acts, and which way."""
        raise NotImplementedError

    def change(self, signals: Signals, dt_s: float) -> FloatArray:
        acts = pressed_on(signals["force_N"], self.pressed, self.tension_N)
        return self.friction_N * acts * self.deflection(signals["strain"])


class HysteresisOnTension(PressedFriction):
    """Friction that grows with the tension, of slip elements whose break-away strains differ as much as they do.

    F += friction * (1 - pressed + pressed * max(F, 0) / tension) * mean_k( stop_k(e) / r_k )
    r_k = threshold * exp(spread * q_k),   q_k: quantiles of a normal law in the middle of six equal parts

    Source: Iwan, J. Appl. Mech. 33 (1966) 893 (break-away strains of any spread); tension as in `PressedFriction`.
    Valid: slow, rate-independent friction.
    """

    name = "hysteresis_on_tension"
    look = "force is higher while stretching than while releasing, the more the higher it is"

    spread: float = parameter(1.0, unit="1", low=0.05, high=3, scale="log", doc="spread of ln break-away strain")

    def deflection(self, e: FloatArray) -> FloatArray:
        from testbench.knit.kernels import mean_stop

        return mean_stop(e, self.threshold * np.exp(self.spread * QUANTILES))


class HysteresisBoucWen(PressedFriction):
    """Friction that grows with the tension, as one smooth hysteretic variable (Bouc-Wen).

    F += friction * (1 - pressed + pressed * max(F, 0) / tension) * z
    dz/de = (1 - |z|^exponent ((1 - skew) sgn(z de) + skew)) / threshold

    With exponent 1, `skew` 0 is Dahl's friction. The way back from full slip begins with 2 (1 - skew) times the slope
    at rest: at 1/2 it is straight, towards 1 hardly any loop is left. The larger the exponent, the sharper the corner
    between sticking and slipping.

    Source: Wen, J. Eng. Mech. Div. ASCE 102 (1976) 249; the tension as in `PressedFriction`.
    Valid: slow, rate-independent friction.
    """

    name = "hysteresis_bouc_wen"
    look = "force is higher while stretching than while releasing, with smooth corners"

    skew: float = parameter(0.3, unit="1", low=0, high=0.9, doc="0: stiff after a turn, as dry friction; 1: no loop")
    exponent: float = parameter(1.0, unit="1", low=0.3, high=3, scale="log", doc="how sharply sticking turns to slip")

    def deflection(self, e: FloatArray) -> FloatArray:
        return kept_bouc_wen(e, self.threshold, self.skew, self.exponent)


@Recent
def kept_bouc_wen(e: FloatArray, threshold: float, skew: float, exponent: float) -> FloatArray:
    """`bouc_wen` of a strain that stays while other parameters change."""
    from testbench.knit.kernels import bouc_wen

    return bouc_wen(e, threshold, skew, exponent)

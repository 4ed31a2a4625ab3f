"""Warmth of the sensor's own current and of the room."""

from __future__ import annotations

import numpy as np

from worlds_second.chain import Signals
from worlds_second.draws import lin, log, pick
from worlds_second.effects.registry import form
from worlds_second.kernels import Array, joule_heat, lag

AT = "electrical"
SIGN = pick(-1.0, 1.0)


def _middle(s: Signals) -> Array:
    return s.ln_g - 0.5 * (s.scales.ln_low + s.scales.ln_high)


@form("self_heating", AT, 3.0, time_s=log(15.0, 150.0), feedback=lin(0.0, 0.3), sign=SIGN)
def constant_voltage(s: Signals, m: float, time_s: float, feedback: float, sign: float) -> Array:
    """Power is voltage squared times conductance."""
    return s.ln_g + sign * m * joule_heat(_middle(s), s.dt, time_s, sign * -feedback)


@form("self_heating", AT, 3.0, time_s=log(15.0, 150.0), feedback=lin(0.0, 0.3), sign=SIGN)
def constant_current(s: Signals, m: float, time_s: float, feedback: float, sign: float) -> Array:
    """Power is current squared times resistance."""
    return s.ln_g + sign * m * joule_heat(-_middle(s), s.dt, time_s, sign * feedback)


@form("self_heating", AT, 3.0, yarn_s=log(3.0, 20.0), body_s=log(60.0, 400.0), share=lin(0.3, 0.7), sign=SIGN)
def yarn_and_body(s: Signals, m: float, yarn_s: float, body_s: float, share: float, sign: float) -> Array:
    """The yarn warms within seconds, the fabric and the clamps within minutes."""
    power = np.exp(_middle(s))
    warm = share * lag(power, s.dt, yarn_s, start=0.0) + (1.0 - share) * lag(power, s.dt, body_s, start=0.0)
    return s.ln_g + sign * m * warm


@form("temperature_drift", AT, 0.3, sign=SIGN)
def with_the_room(s: Signals, m: float, sign: float) -> Array:
    """Conductance follows the room's temperature."""
    return s.ln_g + sign * m * s.room_K


@form("temperature_drift", AT, 0.3, time_s=log(20.0, 150.0), sign=SIGN)
def after_the_room(s: Signals, m: float, time_s: float, sign: float) -> Array:
    """Conductance follows the room's temperature later."""
    return s.ln_g + sign * m * lag(s.room_K, s.dt, time_s)


@form("temperature_drift", AT, 0.3, bend_per_K=lin(-0.12, 0.12), sign=SIGN)
def bent_coefficient(s: Signals, m: float, bend_per_K: float, sign: float) -> Array:
    """The coefficient of temperature changes with temperature."""
    return s.ln_g + sign * m * s.room_K * (1.0 + bend_per_K * s.room_K)

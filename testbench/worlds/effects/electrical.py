"""Hidden effects on the contacts and on the conductance.

It answers to motion, not to strain alone; contact spots grow slowly under pressure, until all yarns touch; the
measuring current warms the yarn, or the room does.
"""

from __future__ import annotations

import numpy as np

from testbench.worlds.chain import Scene, Shape
from testbench.worlds.effects.registry import form
from testbench.worlds.kernels import last_turning_point, lowpass, lowpass_two_way

BOTH_SIGNS = [-1.0, 1.0, 1.0]


@form("electrical_overshoot", "fades_with_time", "electrical", 5.0, tau=(1, 12), sign=BOTH_SIGNS)
def overshoot_highpass(s: Scene, a: float, p: Shape) -> None:
    s.ln_g = s.ln_g + p["sign"] * a * (s.e - lowpass(s.t, s.e, p["tau"])) / 0.3


@form("electrical_overshoot", "after_reversals", "electrical", 2.0, tau=(1, 6), sign=BOTH_SIGNS)
def overshoot_reversal(s: Scene, a: float, p: Shape) -> None:
    turn = last_turning_point(s.e, 0.01).astype(np.int64)
    since = s.t - s.t[turn]
    heading = np.where(turn > 0, np.sign(s.e - s.e[turn]), 0.0)  # the first sample is no reversal
    bump = heading * (since / p["tau"]) * np.exp(1 - since / p["tau"])
    s.ln_g = s.ln_g + p["sign"] * a * bump


@form(
    "electrical_overshoot", "speed_sets_level", "electrical", 2.0, speed=(0.01, 0.08), tau=(0.3, 3), sign=BOTH_SIGNS
)
def overshoot_speed(s: Scene, a: float, p: Shape) -> None:
    moving = np.tanh(np.abs(s.rate()) / p["speed"])
    s.ln_g = s.ln_g + p["sign"] * a * lowpass(s.t, moving, p["tau"])


@form("contact_relaxation", "area_follows_force", "pressure", 1.5, tau=(8, 120))
def area_follows(s: Scene, a: float, p: Shape) -> None:
    share = a / (1 + a)
    s.pressing = s.pressing + share * (lowpass(s.t, s.pressing, p["tau"]) - s.pressing)


@form("contact_relaxation", "ageing_since_reversal", "electrical", 0.5, onset=(0.3, 3))
def ageing(s: Scene, a: float, p: Shape) -> None:
    """Rabinowicz-Dieterich ageing: contacts renewed by sliding strengthen with the log of the time at rest."""
    sliding = lowpass(s.t, np.abs(s.rate()), 0.5) / 0.02
    age = lowpass(s.t, 1 / (1 + sliding**2), 8.0)
    turn = last_turning_point(s.e, 0.01).astype(np.int64)
    s.ln_g = s.ln_g + a * (np.log1p((s.t - s.t[turn]) / p["onset"]) + age)


@form("contact_relaxation", "quick_up_slow_down", "electrical", 2.0, up=(1, 6), down=(20, 150))
def quick_up_slow_down(s: Scene, a: float, p: Shape) -> None:
    s.ln_g = s.ln_g + a * lowpass_two_way(s.t, s.pressing / s.top_N, p["up"], p["down"])


@form("contact_saturation", "crowding", "pressure", 8.0, power=(2.5, 6))
def crowding(s: Scene, a: float, p: Shape) -> None:
    """Sips isotherm: the sites for contacts fill up. (Langmuir's own, power 1, is only another series path.)"""
    pushed = np.maximum(s.pressing, 0)
    full = (1 + (a * pushed / s.top_N) ** p["power"]) ** (1 / p["power"])
    s.pressing = np.where(s.pressing > 0, pushed / full, s.pressing)


@form("contact_saturation", "bend", "pressure", 0.98, above=(0.15, 0.5))
def saturation_bend(s: Scene, a: float, p: Shape) -> None:
    knee, width = p["above"] * s.top_N, 0.03 * s.top_N
    s.pressing = s.pressing - a * width * np.logaddexp(0, (s.pressing - knee) / width)


@form("contact_saturation", "ceiling", "electrical", 1.5, sharp=(12, 40))
def saturation_ceiling(s: Scene, a: float, p: Shape) -> None:
    low, top = s.usual.ln_g
    swing = top - low
    level = top - a * swing * 0.6
    width = swing / p["sharp"] * a / (a + 0.2)
    s.ln_g = s.ln_g - width * np.logaddexp(0, (s.ln_g - level) / width)


@form("self_heating", "one_mass", "electrical", 2.0, tau=(60, 400), sign=BOTH_SIGNS)
def heating_one(s: Scene, a: float, p: Shape) -> None:
    power = np.exp(s.ln_g - s.usual.mean_ln_g)
    power[0] = 0.0  # switched on at the start
    s.ln_g = s.ln_g + p["sign"] * 0.5 * a * lowpass(s.t, power, p["tau"])


@form("self_heating", "yarn_and_fabric", "electrical", 2.0, fast=(5, 25), slow=(150, 600), sign=BOTH_SIGNS)
def heating_two(s: Scene, a: float, p: Shape) -> None:
    power = np.exp(s.ln_g - s.usual.mean_ln_g)
    power[0] = 0.0
    warm = 0.5 * lowpass(s.t, power, p["fast"]) + 0.5 * lowpass(s.t, power, p["slow"])
    s.ln_g = s.ln_g + p["sign"] * 0.5 * a * warm


@form("self_heating", "in_a_divider", "electrical", 4.0, tau=(30, 200), match=(0.4, 2.5), sign=BOTH_SIGNS)
def heating_divider(s: Scene, a: float, p: Shape) -> None:
    """Power in the sensor of a divider, R / (R + R_d)^2, is largest where both are equal."""
    ratio = np.exp(-(s.ln_g - s.usual.mean_ln_g)) * p["match"]
    power = 4 * ratio / (1 + ratio) ** 2
    power[0] = 0.0
    s.ln_g = s.ln_g + p["sign"] * 0.5 * a * lowpass(s.t, power, p["tau"])


@form("temperature_drift", "measured", "electrical", 0.3, sign=BOTH_SIGNS, measured=[1])
@form("temperature_drift", "conductance_only", "electrical", 0.3, sign=BOTH_SIGNS, measured=[0])
def ambient_conductance(s: Scene, a: float, p: Shape) -> None:
    s.ln_g = s.ln_g + p["sign"] * a * s.ambient


@form("temperature_drift", "both_channels", "mechanics", 0.1, measured=[0], softening=(0.3, 1.0))
def ambient_softens(s: Scene, a: float, p: Shape) -> None:
    s.force = s.force * np.clip(1 - a * p["softening"] * s.ambient, 0.1, 3)


@form("temperature_drift", "both_channels", "electrical", 0.1)
def ambient_conducts(s: Scene, a: float, p: Shape) -> None:
    s.ln_g = s.ln_g + a * s.ambient


@form("temperature_drift", "measured_with_lag", "electrical", 0.3, sign=BOTH_SIGNS, measured=[1], tau=(60, 240))
def ambient_lagged(s: Scene, a: float, p: Shape) -> None:
    s.ln_g = s.ln_g + p["sign"] * a * lowpass(s.t, s.ambient, p["tau"])

"""Kinds of effect on wiring and instruments that no catalogue has."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np

from worlds_fourth.effects.effect import Effect, Form, form_of
from worlds_fourth.kernels.friction import switched
from worlds_fourth.operators import lowpass
from worlds_fourth.randoms import Rng
from worlds_fourth.signals import Array, State
from worlds_fourth.specimen import Specimen

FORMS: list[Form] = []
_telegraph = partial(form_of, FORMS, "telegraph_contact")
_clock = partial(form_of, FORMS, "clock_skew")
_range = partial(form_of, FORMS, "autorange_step")
_leak = partial(form_of, FORMS, "intermittent_leak")


def _switching(rng: Rng, count: int) -> Effect:
    closed_s, open_s = np.exp(rng.uniform(np.log(0.5), np.log(8), 2))

    def act(s: State, log_g: Array, size: float) -> Array:
        own, t = s.record.stream("rtn"), s.record.time_s
        bad = np.zeros(len(t))
        for _ in range(count):
            bad += np.searchsorted(_switches(own, t[-1], closed_s, open_s), t) % 2
        tight = 1 if count == 1 else np.clip(1.2 - s.share, 0.1, 2)
        return log_g - size * bad / math.sqrt(count) * tight

    text = f"{count} contacts switch at random, after {closed_s:.1f} and {open_s:.1f} s: ln R + a"
    return Effect(text, 0.4, {"conductance": act})


def _switches(rng: Rng, end_s: float, closed_s: float, open_s: float) -> list[float]:
    """Times at which a contact opens and closes."""
    times, now, is_open = [], 0.0, False
    while now < end_s:
        now += rng.exponential(open_s if is_open else closed_s)
        times.append(now)
        is_open = not is_open
    return times


@_telegraph()
def one_contact(rng: Rng, specimen: Specimen) -> Effect:
    """One bad contact is there or not, at random."""
    return _switching(rng, 1)


@_telegraph()
def four_contacts(rng: Rng, specimen: Specimen) -> Effect:
    """Four, that matter less where the knit is tight."""
    return _switching(rng, 4)


def _late(text: str, late: Callable[[Array], Array]) -> Effect:
    """Both readings come late by `size` times what `late` says of the share of the time."""

    def act(s: State, y: Array, size: float) -> Array:
        t = s.record.time_s
        return np.interp(t - size * late(t / t[-1]), t, y)

    return Effect(text, 1.0, {"force_reading": act, "resistance_reading": act})


@_clock()
def runaway(rng: Rng, specimen: Specimen) -> Effect:
    """The clock of the displacement runs away from that of the other channels."""
    return _late("both readings late by a s at the end", lambda share: share)


@_clock()
def one_jump(rng: Rng, specimen: Specimen) -> Effect:
    """Both other channels jump in time against the displacement."""
    at = rng.uniform(0.2, 0.8)
    return _late(f"both readings jump by a s, after {at:.2f} of the time", lambda q: np.where(q < at, -0.5, 0.5))


def _autorange(rng: Rng, specimen: Specimen, with_gain: bool) -> Effect:
    low, high = specimen.log_r_range
    level, half = low + (high - low) * rng.uniform(0.3, 0.7), (high - low) * rng.uniform(0.01, 0.08)
    gain = rng.uniform(-0.5, 0.5) if with_gain else 0.0

    def act(s: State, y: Array, size: float) -> Array:
        upper = switched(y, level + half, level - half, float(y[0] > level))
        return y + size * upper * (1 + gain * (y - level))

    return Effect(f"another range above {math.exp(level):.4g} ohm: ln R + a", 0.3, {"resistance_reading": act})


@_range()
def offset(rng: Rng, specimen: Specimen) -> Effect:
    """The ohmmeter changes its range, and the two differ by a factor."""
    return _autorange(rng, specimen, with_gain=False)


@_range()
def gain(rng: Rng, specimen: Specimen) -> Effect:
    """They differ by more the further it is from the change."""
    return _autorange(rng, specimen, with_gain=True)


def _leaking(rng: Rng, specimen: Specimen, smooth: bool) -> Effect:
    count, usual_s = int(rng.integers(3, 8)), rng.uniform(3, 20)

    def act(s: State, log_g: Array, size: float) -> Array:
        own, t = s.record.stream("leak"), s.record.time_s
        leak = np.zeros(len(t))
        for start in own.uniform(0.03, 0.97, count) * t[-1]:
            long_s = usual_s * own.uniform(0.3, 1.7)
            leak += ((t > start) & (t < start + long_s)) * own.uniform(0.4, 1)
        if smooth:
            leak = lowpass(leak, t, 2.0)
        about = np.log(size + 1e-12) + specimen.conduction.middle
        return np.logaddexp(log_g, about + np.log(leak + 1e-12))

    return Effect(f"{count} times, {usual_s:.0f} s or so: a of the mean G in parallel", 1.0, {"conductance": act})


@_leak()
def abrupt(rng: Rng, specimen: Specimen) -> Effect:
    """Now and then a leak in parallel, for some seconds."""
    return _leaking(rng, specimen, smooth=False)


@_leak()
def gradual(rng: Rng, specimen: Specimen) -> Effect:
    """It comes and goes within seconds."""
    return _leaking(rng, specimen, smooth=True)

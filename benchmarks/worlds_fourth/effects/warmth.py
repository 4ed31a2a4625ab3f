"""What warms the specimen: the room (force and conductance), and its own current. Sizes are for a unit of warmth."""

from __future__ import annotations

from functools import partial

import numpy as np

from worlds_fourth.effects.effect import Effect, Form, form_of
from worlds_fourth.kernels.followers import heat
from worlds_fourth.operators import lowpass
from worlds_fourth.randoms import Rng
from worlds_fourth.room import ROOMS, room_of
from worlds_fourth.signals import Array, State
from worlds_fourth.specimen import Specimen

FORMS: list[Form] = []
_softening = partial(form_of, FORMS, "thermal_softening")
_drift = partial(form_of, FORMS, "temperature_drift")
_heating = partial(form_of, FORMS, "self_heating")


@_softening()
def softer(rng: Rng, specimen: Specimen) -> Effect:
    """Softer in a warmer room."""
    room = str(rng.choice(ROOMS))

    def act(s: State, force: Array, size: float) -> Array:
        return force * (1 - size * room_of(s.record, room))

    return Effect(f"F (1 - a T), {room}", 0.12, {"force": act})


@_softening()
def entropic(rng: Rng, specimen: Specimen) -> Effect:
    """Stiffer as rubber is in warmth, and longer."""
    room, b, top_N = str(rng.choice(ROOMS)), rng.uniform(0.3, 1), specimen.top_N

    def act(s: State, force: Array, size: float) -> Array:
        longer = b * 0.5 * top_N * np.minimum(1, s.elastic_N / (0.2 * top_N))
        return force + (s.elastic_N - longer) * size * room_of(s.record, room)

    return Effect(f"F (1 + a T) less {b / 2:.2f} a T of the top, {room}", 0.1, {"force": act})


@_softening()
def activated(rng: Rng, specimen: Specimen) -> Effect:
    """Exponentially softer with the warmth (Arrhenius), by a power of the force."""
    room, n, top_N = str(rng.choice(ROOMS)), rng.uniform(1.3, 2), specimen.top_N

    def act(s: State, force: Array, size: float) -> Array:
        power = (np.maximum(s.elastic_N, 0) / top_N) ** n
        return force - size * top_N * power * np.expm1(room_of(s.record, room))

    return Effect(f"loses a (F/top)^{n:.2f} (exp(T) - 1) of the top, {room}", 0.09, {"force": act})


def _room(rng: Rng) -> tuple[str, int]:
    """Which room, and whether warmth raises or lowers the conductance."""
    return ROOMS[int(rng.integers(3))], int(rng.choice([-1, 1]))


@_drift()
def with_the_room(rng: Rng, specimen: Specimen) -> Effect:
    """ln G follows the room."""
    room, sign = _room(rng)

    def act(s: State, log_g: Array, size: float) -> Array:
        return log_g + sign * size * room_of(s.record, room)

    return Effect(f"ln G {sign:+d} a T, {room}", 0.15, {"conductance": act})


@_drift()
def of_the_contacts(rng: Rng, specimen: Specimen) -> Effect:
    """The same, less where the contacts are tight."""
    room, sign = _room(rng)
    b = rng.uniform(0.4, 1.2)

    def act(s: State, log_g: Array, size: float) -> Array:
        return log_g + sign * size * room_of(s.record, room) * (1 - b / 2 * s.share)

    return Effect(f"ln G {sign:+d} a T (1 - {b / 2:.2f} x), {room}", 0.15, {"conductance": act})


@_drift()
def slow_yarn(rng: Rng, specimen: Specimen) -> Effect:
    """The yarn follows the room slowly, its resistance as that of a metal."""
    room, sign = _room(rng)
    tau_s = rng.uniform(15, 50)

    def act(s: State, log_g: Array, size: float) -> Array:
        return log_g - np.log1p(sign * size * lowpass(room_of(s.record, room), s.record.time_s, tau_s))

    return Effect(f"R (1 {sign:+d} a T), T late by {tau_s:.0f} s, {room}", 0.25, {"conductance": act})


def _heated(rng: Rng, specimen: Specimen, source: str, mode: float, cooled: bool) -> Effect:
    sign = 1 if rng.random() < 0.65 else -1
    tau_s = rng.uniform(8, 60)
    cooling = rng.uniform(0.5, 3) if cooled else 0.0

    def act(s: State, log_g: Array, size: float) -> Array:
        steps_s, speed = np.gradient(s.record.time_s), np.abs(s.rate_per_s / 0.1)
        about = log_g - specimen.conduction.middle
        return log_g + sign * size * heat(about, steps_s, speed, tau_s, cooling, mode, sign * size)

    text = f"constant {source}, {tau_s:.0f} s, ln G {sign:+d} a T"
    return Effect(text + (f", cooled by motion ({cooling:.1f})" if cooled else ""), 0.35, {"conductance": act})


@_heating()
def constant_voltage(rng: Rng, specimen: Specimen) -> Effect:
    """U^2 G heats one mass."""
    return _heated(rng, specimen, "voltage", 1.0, cooled=False)


@_heating()
def constant_current(rng: Rng, specimen: Specimen) -> Effect:
    """I^2 R heats one mass."""
    return _heated(rng, specimen, "current", -1.0, cooled=False)


@_heating()
def cooled_by_motion(rng: Rng, specimen: Specimen) -> Effect:
    """U^2 G heats one mass, that loses more of it while it moves through the air."""
    return _heated(rng, specimen, "voltage", 1.0, cooled=True)

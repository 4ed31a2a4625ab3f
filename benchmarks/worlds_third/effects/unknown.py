"""Kinds of effect that no catalogue has: a diagnosis should say that something is there, and name nothing."""

from __future__ import annotations

from functools import partial

import numpy as np
from scipy.ndimage import maximum_filter1d

from worlds_third import kernels
from worlds_third.effects.form import Form, form_of
from worlds_third.signals import Array, Signals

FORMS: list[Form] = []
_pull = partial(form_of, FORMS, stage="mechanics", main="force")
_wire = partial(form_of, FORMS, stage="electrical", main="conductance")
_reads_force = partial(form_of, FORMS, stage="readout", main="force")
_reads_wire = partial(form_of, FORMS, stage="readout", main="conductance")
Rng = np.random.Generator


@_pull("serrated_stretching", limit=0.7, length=(0.03, 0.09), growth=(0.2, 1.0))
def serrated_stretching(s: Signals, size: float, rng: Rng, length: float, growth: float) -> None:
    """Courses give way one after the other while it is stretched: teeth over strain, none on the way back."""
    out = 0.5 * (1.0 + kernels.direction(s.strain, 0.02))
    s.force = s.force + size * out * (np.mod(s.strain / length, 1.0) - 0.5) * np.maximum(s.strain, 0.0) ** growth


@_pull("flipping_loops", limit=0.7, up=(0.5, 0.8), gap=(0.15, 0.35))
def flipping_loops(s: Signals, size: float, rng: Rng, up: float, gap: float) -> None:
    """Loops snap through above one strain and back below another: the force drops and rises again."""
    flipped = kernels.relays(s.strain, np.array([up]), np.array([up - gap]), np.array([1.0]))
    s.force = s.force - size * flipped


@_wire("flipping_contacts", limit=2.0, key=(0.0, 1e6))
def flipping_contacts(s: Signals, size: float, rng: Rng, key: float) -> None:
    """Three floats touch and part at strains far apart: steps of ln G, up and down at different strains."""
    own = np.random.default_rng(int(key))
    closes = own.uniform(0.4, 0.9, 3)
    opens = closes - own.uniform(0.1, 0.35, 3)
    s.log_g = s.log_g + size * kernels.relays(s.strain, closes, opens, own.uniform(0.5, 1.0, 3))


@_pull("alternating_cycles", limit=0.7)
def alternating_cycles(s: Signals, size: float, rng: Rng) -> None:
    """Two systems of yarn take the load in turn: every other cycle is stiffer."""
    moved = np.abs(np.diff(s.strain, prepend=s.strain[0]))
    turns = np.cumsum(kernels.half_strokes(s.strain, 0.03) > 0)
    side: Array = kernels.follow(np.where(turns // 2 % 2 == 0, 1.0, -1.0), moved, 0.05, 0.05, 0.0)
    s.force = s.force * (1.0 + size * side)


@_pull("ageing_friction", limit=0.5, reach=(0.01, 0.05))
def ageing_friction(s: Signals, size: float, rng: Rng, reach: float) -> None:
    """Rate-and-state friction (Dieterich and Ruina): stronger the longer the contacts were left alone."""
    age = kernels.ageing(s.strain, s.step_s, reach)
    s.force = s.force + size * np.log1p(age) * kernels.direction(s.strain, 0.5 * reach)


@_pull("breaking_yarns", limit=0.5, breaks=(2.0, 5.0))
def breaking_yarns(s: Signals, size: float, rng: Rng, breaks: float) -> None:
    """Single yarns break under strong pull: each time a share of the whole force is gone at once."""
    strong = np.flatnonzero(s.drive > 0.6 * s.drive.max())
    at = np.sort(rng.choice(strong, size=int(breaks), replace=False))
    left = np.ones(len(s.force))
    for k in at:
        left[k:] *= 1.0 - size * rng.uniform(0.3, 1.0)
    s.force = s.force * left


@_wire("telegraph_noise", limit=2.0, dwell_s=(1.0, 15.0), ratio=(0.3, 3.0))
def telegraph_noise(s: Signals, size: float, rng: Rng, dwell_s: float, ratio: float) -> None:
    """One bad contact is there or not, at random: less of it the tighter the knit."""
    count = int(4 * s.time_s[-1] / (dwell_s * (1 + ratio))) + 20
    dwells = rng.exponential(dwell_s, count) * np.where(np.arange(count) % 2 == 0, 1.0, ratio)
    state = np.searchsorted(np.cumsum(dwells), s.time_s) % 2
    s.log_g = s.log_g + size * state * (1.2 - np.clip(s.strain, 0.0, 1.0))


@_wire("rustling", limit=2.0, memory_s=(0.02, 0.3))
def rustling(s: Signals, size: float, rng: Rng, memory_s: float) -> None:
    """Contacts crackle while they slide: noise as large as the speed, none in a hold."""
    white = rng.normal(size=len(s.time_s))
    crackle = kernels.follow(white, s.step_s, memory_s, memory_s, 0.0) * np.sqrt(1.0 + 2.0 * memory_s * s.rate_hz)
    s.log_g = s.log_g + size * crackle * np.tanh(np.abs(s.rate) / s.usual_rate)


@_wire("recent_maximum", limit=2.0, window_s=(15.0, 60.0))
def recent_maximum(s: Signals, size: float, rng: Rng, window_s: float) -> None:
    """Remembers the largest stretch of the last seconds, sharply, and nothing before."""
    count = max(int(window_s / np.mean(s.step_s[1:])), 2)
    largest = maximum_filter1d(s.strain, count, origin=(count - 1) // 2)
    s.log_g = s.log_g - size * (largest - s.strain)


@_wire("swaying_cable", limit=2.0, hertz=(0.4, 2.0), damping=(0.03, 0.15))
def swaying_cable(s: Signals, size: float, rng: Rng, hertz: float, damping: float) -> None:
    """The cable sways after every jerk of the carriage and bends its plug."""
    frequency = min(hertz, 0.2 * s.rate_hz)
    speed = np.diff(s.drive, prepend=s.drive[0]) / np.maximum(s.step_s, 1e-6)
    smooth = kernels.follow(speed, s.step_s, 0.1, 0.1, 0.0)
    jerk = np.diff(smooth, prepend=0.0) / np.maximum(s.step_s, 1e-6) / s.usual_rate
    sway = kernels.oscillator(jerk, s.step_s, frequency, damping) * (2 * np.pi * frequency)
    s.log_g = s.log_g + size * sway


@_reads_wire("lazy_firmware", limit=60.0, change=(0.05, 0.3))
def lazy_firmware(s: Signals, size: float, rng: Rng, change: float) -> None:
    """Firmware smooths small changes over `size` s and lets large ones pass."""
    s.log_g = kernels.lazy_filter(s.log_g, s.step_s, size + 1e-9, change * (s.tops[2] - s.tops[1]))


@_reads_wire("frozen_readings", limit=20.0, pause_s=(10.0, 40.0))
def frozen_readings(s: Signals, size: float, rng: Rng, pause_s: float) -> None:
    """Now and then the last value is repeated, for about `size` s."""
    s.log_g = _frozen(s, s.log_g, size, pause_s, rng)


@_reads_force("frozen_force", limit=20.0, pause_s=(10.0, 40.0))
def frozen_force(s: Signals, size: float, rng: Rng, pause_s: float) -> None:
    """The same in the reading of force."""
    s.force = _frozen(s, s.force, size, pause_s, rng)


@_reads_wire("missing_codes", limit=0.5, every=(3.0, 6.0))
def missing_codes(s: Signals, size: float, rng: Rng, every: float) -> None:
    """A bad converter: steps of ln G, and every few codes one that never comes."""
    code = np.round(s.log_g / (size + 1e-12))
    s.log_g = (code + (np.mod(code, int(every)) == 0)) * (size + 1e-12)


@_reads_wire("wandering_delay", limit=8.0, pace_s=(8.0, 40.0))
def wandering_delay(s: Signals, size: float, rng: Rng, pace_s: float) -> None:
    """Readings come late by a time that wanders between 0 and `size` s, as from a busy radio."""
    knots = np.arange(0.0, s.time_s[-1] + 2 * pace_s, pace_s)
    late = np.interp(s.time_s, knots, rng.uniform(0.0, 1.0, len(knots)))
    s.log_g = np.interp(s.time_s - size * late, s.time_s, s.log_g)


@_reads_force("zero_tracking", limit=1.0, tau_s=(2.0, 15.0))
def zero_tracking(s: Signals, size: float, rng: Rng, tau_s: float) -> None:
    """The amplifier takes small forces for an error of its zero and takes them away."""
    s.force = kernels.zero_tracked(s.force, s.step_s, size, tau_s)


@_reads_wire("interleaved_converters", limit=1.0)
def interleaved_converters(s: Signals, size: float, rng: Rng) -> None:
    """Two converters take turns, and their gains differ: even and odd samples part with ln G."""
    sample = np.arange(len(s.log_g)) // s.parts
    s.log_g = s.log_g + size * np.where(sample % 2 == 0, 0.5, -0.5) * (s.log_g - s.tops[1])


@_reads_force("limited_slew", limit=120.0)
def limited_slew(s: Signals, size: float, rng: Rng) -> None:
    """The amplifier cannot follow quickly: `size` is the time in s that it takes for the full range."""
    s.force = kernels.limited(s.force, s.step_s, s.tops[0] / (size + 1e-9))


def _frozen(s: Signals, reading: Array, size: float, pause_s: float, rng: Rng) -> Array:
    count = int(3 * s.time_s[-1] / pause_s) + 5
    starts = np.cumsum(rng.exponential(pause_s, count) + 1.0)
    lengths = size * rng.uniform(0.3, 1.0, count)
    event = np.clip(np.searchsorted(starts, s.time_s, side="right") - 1, 0, count - 1)
    within = (s.time_s >= starts[event]) & (s.time_s < starts[event] + lengths[event])
    return np.where(within, np.interp(starts[event], s.time_s, reading), reading)

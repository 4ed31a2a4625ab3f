"""What the instruments write down: noise, clips and converters. At noise 1 they are those of the paper's rig."""

from __future__ import annotations

import math

import numpy as np
from scipy.signal import lfilter

from worlds_fourth.chain import Sized, respond
from worlds_fourth.randoms import Rng, stream
from worlds_fourth.signals import Array, Record, State
from worlds_fourth.specimen import Instruments, Specimen

NOISE = {"force": 5e-3, "conductance": 8e-4}  # RMS in N and ln R
DISPLACEMENT_MM = 1e-3  # the displacement is written to a micrometre


def observe(specimen: Specimen, record: Record, effects: Sized, noise: float) -> tuple[Array, Array, Array]:
    """Displacement in mm, force in N and resistance in ohm as they are written down, shape (n,) each."""
    force, log_r = respond(specimen, record, effects)
    rng = stream(specimen.seed, "noise", record.name)
    added_N, added = _noise(rng, specimen.instruments, len(force))
    force, log_r = force + noise * added_N, log_r + noise * added
    state = State(record, record.displacement_mm, record.strain)
    for effect, size in effects:  # what clips a reading clips its noise too
        if effect.clips == "force_reading":
            force = effect.hooks[effect.clips](state, force, size)
        if effect.clips == "resistance_reading":
            log_r = effect.hooks[effect.clips](state, log_r, size)
    step_N = specimen.instruments.step_N
    return np.round(record.displacement_mm, 3), np.round(force / step_N) * step_N, _divided(specimen, log_r)


def _noise(rng: Rng, instruments: Instruments, count: int) -> tuple[Array, Array]:
    force = NOISE["force"] * _coloured(rng, count, instruments.colour_force)
    log_r = NOISE["conductance"] * _coloured(rng, count, instruments.colour_resistance)
    if instruments.outliers:
        for noise in (force, log_r):
            which = rng.random(count) < instruments.outliers
            noise[which] *= rng.uniform(5, 12, which.sum())
    return force, log_r


def _coloured(rng: Rng, count: int, colour: float) -> Array:
    """Of unit RMS; each sample is like the one before by `colour`."""
    white = rng.normal(size=count)
    return lfilter([math.sqrt(1 - colour * colour)], [1, -colour], white) if colour else white


def _divided(specimen: Specimen, log_r: Array) -> Array:
    """Resistance in ohm as a divider with a reference and a converter reads it."""
    instruments = specimen.instruments
    resistance, codes = np.exp(log_r), 2**instruments.bits
    code = np.round(resistance / (resistance + instruments.reference_ohm) * codes)
    share = np.clip(code, 1, codes - 1) / codes
    return share * instruments.reference_ohm / (1 - share)

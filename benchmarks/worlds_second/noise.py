"""Noise of the read-outs: white, in some seeds with a milder coloured part."""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter
from simulated_case import stream

from worlds_second.kernels import Array

FORCE_N, LN_CONDUCTANCE, DISPLACEMENT_MM = 5e-3, 8e-4, 1e-3  # the rig of the paper
KINDS = ("white", "white and first-order", "white and pink")
CHANCES = (0.6, 0.2, 0.2)


def draw_kind(seed: int) -> str:
    """The kind of noise of a seed."""
    return str(stream(seed, "noise kind").choice(KINDS, p=CHANCES))


def draw_noise(rng: np.random.Generator, count: int, rms: float, kind: str, dt: float) -> Array:
    """Noise of exactly this root mean square; a coloured part has 15 to 35 % of it."""
    white, share, coloured = rng.normal(size=count), rng.uniform(0.15, 0.35), rng.normal(size=count)
    time_s = np.exp(rng.uniform(np.log(0.2), np.log(3.0)))
    noise = white
    if kind == KINDS[1]:
        keep = np.exp(-dt / time_s)
        noise = np.sqrt(1.0 - share**2) * white + share * _unit(lfilter([1.0], [1.0, -keep], coloured))
    elif kind == KINDS[2]:
        noise = np.sqrt(1.0 - share**2) * white + share * _unit(_pink(coloured))
    return rms * noise / np.sqrt(np.mean(noise**2))


def _unit(y: Array) -> Array:
    y = y - np.mean(y)
    return y / np.std(y)


def _pink(white: Array) -> Array:
    spectrum = np.fft.rfft(white)
    lines = np.arange(len(spectrum), dtype=float)
    return np.fft.irfft(spectrum / np.sqrt(np.maximum(lines, 3.0)), len(white))

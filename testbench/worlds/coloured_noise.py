"""Noise of the two channels: white and coloured, its size known."""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter

from gcode.support.arrays import FloatArray

KINDS = ("white", "ar1", "pink")


def _ar1(count: int, rate_hz: float, rng: np.random.Generator) -> FloatArray:
    tau = np.exp(rng.uniform(np.log(0.1), np.log(5)))
    keep = np.exp(-1 / (rate_hz * tau))
    return lfilter([np.sqrt(1 - keep**2)], [1, -keep], rng.standard_normal(count + 500))[500:]


def _pink(count: int, rate_hz: float, rng: np.random.Generator) -> FloatArray:
    """Power falling as 1/f from 1/200 Hz upwards; flat below, as instruments are zeroed before a run."""
    spectrum = np.fft.rfft(rng.standard_normal(count))
    frequency = np.fft.rfftfreq(count, 1 / rate_hz)
    return np.fft.irfft(spectrum / np.sqrt(np.maximum(frequency, 0.005)), count)


def unit_noise(kind: str, count: int, rate_hz: float, rng: np.random.Generator) -> FloatArray:
    """Noise of RMS 1 (exactly, in this recording), shape (count,): white, or a mixture with a coloured share."""
    white = rng.standard_normal(count)
    if kind != "white":
        share = rng.uniform(0.2, 0.6)
        coloured = _ar1(count, rate_hz, rng) if kind == "ar1" else _pink(count, rate_hz, rng)
        coloured = coloured / max(np.sqrt(np.mean(coloured**2)), 1e-12)
        white = np.sqrt(1 - share) * white + np.sqrt(share) * coloured
    return white / np.sqrt(np.mean(white**2))


def quantised(values: FloatArray, step: float) -> FloatArray:
    """Rounded to multiples of `step`."""
    return np.round(values / step) * step

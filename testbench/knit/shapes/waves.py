"""Waves of any shape as a Fourier series; the first harmonic has weight 1, the others are relative to it."""

from __future__ import annotations

from typing import Any

import numpy as np

from testbench.knit.effect import FloatArray, zeros

HARMONICS = 6


def harmonics_parameter() -> Any:
    """Parameter of an effect: the weights of a wave's harmonics from the second on."""
    doc = "sine, then cosine of the second harmonic over the first, and so on"
    return zeros(2 * (HARMONICS - 1), unit="1", most=3, typical=0.3, doc=doc)


def wave_of(angle: FloatArray, harmonics: tuple[float, ...]) -> FloatArray:
    """sin(a) + sum_k (s_k sin(k a) + c_k cos(k a)), k from 2; shape (n,) as the angle (rad)."""
    wave = np.sin(angle)
    for k, (sine, cosine) in enumerate(np.reshape(harmonics, (-1, 2)), start=2):
        if sine or cosine:
            wave += sine * np.sin(k * angle) + cosine * np.cos(k * angle)
    return wave

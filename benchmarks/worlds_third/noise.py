"""Noise of the instruments. At 1 it is that of the paper's rig; its RMS is as asked, whatever its kind."""

from __future__ import annotations

import numpy as np

from worlds_third.signals import Array

FORCE_N = 5e-3
LOG_G = 8e-4
KINDS = ("white", "white", "heavy_tailed", "divider")
TAIL = 6.0  # degrees of freedom of Student's t


def kind_of(rng: np.random.Generator) -> str:
    """White mostly; with tails, as where a motor disturbs; or larger where R is far from the divider's resistor."""
    return str(KINDS[int(rng.integers(len(KINDS)))])


def force_noise(rng: np.random.Generator, kind: str, count: int) -> Array:
    """Of unit RMS, shape (count,)."""
    return _tailed(rng, count) if kind == "heavy_tailed" else rng.normal(size=count)


def resistance_noise(rng: np.random.Generator, kind: str, log_g: Array) -> Array:
    """Of unit RMS over the recording, shape (n,).

    A divider with reference resistor Rr reads U/U0 = R/(R + Rr); even noise of U is noise of ln R as
    (R + Rr)^2/(R Rr), smallest where both are equal (here: in the middle of the recorded range).
    """
    noise = force_noise(rng, kind, len(log_g))
    if kind != "divider":
        return noise
    off = log_g - 0.5 * (log_g.min() + log_g.max())
    weight = 2.0 + 2.0 * np.cosh(off)
    return noise * weight / np.sqrt(np.mean(weight**2))


def _tailed(rng: np.random.Generator, count: int) -> Array:
    return rng.standard_t(TAIL, size=count) * np.sqrt((TAIL - 2) / TAIL)

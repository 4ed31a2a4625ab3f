"""Materials of which only the force was measured: a rubber tape that is held, a fabric stretched again and again.

The physics is written out here, apart from testbench.knit and from testbench.worlds.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import fftconvolve

from testbench.diagnosis import diagnose
from testbench.recordings.channels import DISPLACEMENT, FORCE
from testbench.recordings.recording import Recording

GAUGE_LENGTH_MM = 100.0


def recorded(time_s: np.ndarray, strain: np.ndarray, force_N: np.ndarray, noise_N: float, seed: int) -> Recording:
    """With 2 um of noise on the displacement, written to the micrometre."""
    rng = np.random.default_rng(seed)
    read_mm = np.round(GAUGE_LENGTH_MM * strain + rng.normal(0, 0.002, len(strain)), 3)
    read_N = force_N + rng.normal(0, noise_N, len(strain))
    return Recording(time_s, {DISPLACEMENT: read_mm, FORCE: read_N}, GAUGE_LENGTH_MM)


def hereditary(force_N: np.ndarray, kernel: np.ndarray) -> np.ndarray:
    """Quasi-linear viscoelasticity: every step of the elastic force fades by the kernel (Fung 1993)."""
    return fftconvolve(np.diff(force_N, prepend=0), kernel)[: len(force_N)]


def tape(levels: list[float], hold_s: float, seed: int, kernel: str, rate_hz: float = 10.0) -> Recording:
    """A rubber tape (neo-Hookean) at 5 %/s to each level, held there."""
    corners, values = [0.0, 5.0], [0.0, 0.0]
    for level in levels:
        reached_s = corners[-1] + abs(level - values[-1]) / 0.05
        corners, values = [*corners, reached_s, reached_s + hold_s], [*values, level, level]
    time_s = np.arange(0, corners[-1], 1 / rate_hz)
    strain = np.interp(time_s, corners, values)
    stretch = 1 + strain
    kernels = {
        "power": (1 + time_s / 0.5) ** -0.06,
        "logarithm": 1 - 0.05 * np.log10(1 + time_s),
        "Prony": 0.7 + sum(0.1 * np.exp(-time_s / tau_s) for tau_s in (3.0, 60.0, 600.0)),
    }
    return recorded(time_s, strain, hereditary(3 * (stretch - stretch**-2), kernels[kernel]), 0.004, seed)


def fabric(effect: str, seed: int, period_s: float, rate_hz: float) -> Recording:
    """A fabric (exponential law, three slip elements) in 40 triangles of 6 to 25 % strain."""
    amplitudes = np.random.default_rng(seed).uniform(0.06, 0.25, 40)
    time_s = np.arange(0, 40 * period_s, 1 / rate_hz)
    cycle = np.minimum((time_s / period_s).astype(int), 39)
    phase = time_s / period_s - cycle
    strain = amplitudes[cycle] * 2 * np.minimum(phase, 1 - phase)
    largest = np.maximum.accumulate(strain)
    felt = np.maximum(strain - 0.08 * largest, 0) if effect == "permanent_set" else strain
    elastic_N = 1.2 * np.expm1(6 * felt)
    force_N = {
        "mullins_softening": elastic_N * (1 - 0.25 * np.tanh((largest - strain) / 0.1)),
        "cyclic_fatigue": elastic_N * (1 - 0.04 * np.log1p(time_s / period_s)),
        "stress_relaxation": hereditary(elastic_N, 0.75 + 0.12 * np.exp(-time_s / 5) + 0.13 * np.exp(-time_s / 80)),
        "viscous_rate_stiffening": elastic_N * (1 + 0.024 * np.arcsinh(np.gradient(strain, time_s) / 0.002)),
    }.get(effect, elastic_N)
    slipping = sum(stop(felt, limit) / limit for limit in (0.006, 0.02, 0.04)) / 3
    return recorded(time_s, strain, force_N + 0.12 * slipping * (0.5 + 4 * felt), 0.006, seed)


def stop(strain: np.ndarray, limit: float) -> np.ndarray:
    """Deflection of a slip element."""
    deflection = np.zeros_like(strain)
    for i, step in enumerate(np.diff(strain), 1):
        deflection[i] = min(max(deflection[i - 1] + step, -limit), limit)
    return deflection


@pytest.mark.slow
@pytest.mark.parametrize("kernel", ["power", "logarithm", "Prony"])
@pytest.mark.parametrize("levels", [[0.3], [0.1, 0.2, 0.3, 0.4, 0.3, 0.2, 0.1]], ids=["one hold", "up and down"])
def test_a_tape_that_was_held_relaxes(levels, kernel):
    hold_s = 1800 / len(levels)
    held_out = tape([0.8 * level for level in levels], hold_s, 2, kernel)
    result = diagnose(tape(levels, hold_s, 1, kernel), held_out)
    assert (result.verdict, result.found[0].effect) == ("missing", "stress_relaxation")
    assert result.error_after["force"] < 0.3 * result.error_before["force"]


@pytest.mark.slow
@pytest.mark.parametrize("rate_hz", [12.0, 100.0])
@pytest.mark.parametrize(
    "effect",
    ["permanent_set", "mullins_softening", "cyclic_fatigue", "stress_relaxation", "viscous_rate_stiffening"],
)
def test_what_a_fabric_hides_is_named(effect, rate_hz):
    result = diagnose(fabric(effect, 1, 20.0, rate_hz), fabric(effect, 2, 25.0, rate_hz))
    assert result.verdict == "missing"
    # A clamp that slides and a knit that stays longer are one curve in this motion: both within the noise, they tie.
    assert effect in (result.tied or (result.found[0].effect,))
    # Laws that differ by less than 5 % of it tie; of two mechanisms that tie the wrong one may have been put in.
    floors = 2.0 if result.tied else 1.5
    assert result.error_after["force"] < floors * result.noise_floor["force"]


@pytest.mark.slow
@pytest.mark.parametrize("rate_hz", [12.0, 100.0])
def test_nothing_is_missing_from_a_fabric_that_hides_nothing(rate_hz):
    result = diagnose(fabric("none", 1, 20.0, rate_hz), fabric("none", 2, 25.0, rate_hz))
    assert result.verdict == "nothing_missing"

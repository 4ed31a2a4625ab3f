"""The looks of a few effects, as anybody would describe them: the known answers of the physics."""

import numpy as np
import pytest
from worlds_second import make_case
from worlds_second.effects import KNOWN

from testbench.recordings.channels import DISPLACEMENT, FORCE, RESISTANCE

LOUD, LOUD_QUIETLY = 40.0, 40e3
HOLDS = {"protocol": "staircase", "minutes": 6.0, "noise": 1e-3, "rate_hz": 10.0}


def changes(effect, seed, **keywords):
    """Change of force over full scale and of ln G by an effect, over the relative stroke."""
    plain, case = (make_case(one, LOUD_QUIETLY, seed, **keywords) for one in ("none", effect))
    a, b = plain.calibration, case.calibration
    way = a[DISPLACEMENT] / a[DISPLACEMENT].max()
    full = case.truth["base"]["force_full_N"]
    return a.time_s, way, (b[FORCE] - a[FORCE]) / full, np.log(a[RESISTANCE] / b[RESISTANCE])


@pytest.mark.parametrize("form", KNOWN["stress_relaxation"])
def test_relaxing_force_sinks_in_a_hold(form):
    time_s, way, force, _ = changes(f"stress_relaxation:{form}", 3, **HOLDS)
    still = (np.abs(np.gradient(way, time_s)) < 1e-6) & (way > 0.9)
    runs = np.split(np.flatnonzero(still), np.flatnonzero(np.diff(np.flatnonzero(still)) > 1) + 1)
    longest = max(runs, key=len)
    assert force[longest[-1]] < force[longest[0]] < 0


@pytest.mark.parametrize("form", KNOWN["coating_cracks"])
def test_cracks_stay(form):
    _, way, _, ln_g = changes(f"coating_cracks:{form}", 3, minutes=4.0, noise=1e-3, rate_hz=20.0)
    after = np.argmax(way) + 1
    assert np.all(ln_g[after:] < 0)
    if form != "cracks_that_gape":
        assert np.ptp(ln_g[after:]) < 0.1 * np.abs(ln_g).max()


@pytest.mark.parametrize("form", KNOWN["jamming_stiffening"])
def test_jamming_is_above_an_edge(form):
    _, way, force, _ = changes(f"jamming_stiffening:{form}", 3, minutes=4.0, noise=1e-3, rate_hz=20.0)
    assert force[way > 0.97].min() > 20 * np.abs(force[way < 0.3]).max()


@pytest.mark.parametrize("form", KNOWN["shoulder_peak"])
def test_shoulder_is_on_the_way_back(form):
    time_s, way, _, ln_g = changes(
        f"shoulder_peak:{form}", 3, protocol="cyclic", minutes=4.0, noise=1e-3, rate_hz=20.0
    )
    back = np.gradient(way, time_s) < -1e-3
    out = np.gradient(way, time_s) > 1e-3
    assert ln_g[back].min() < 5 * ln_g[out].mean()
    assert np.mean(ln_g[back] ** 2) > 2 * np.mean(ln_g[out] ** 2)


@pytest.mark.parametrize("form", ["conductance_clipped_high", "conductance_clipped_low"])
def test_a_clipped_reading_repeats_one_value(form):
    recording = make_case(f"adc_saturation:{form}", LOUD, 3, minutes=4.0, rate_hz=20.0).calibration
    values, counts = np.unique(recording[RESISTANCE], return_counts=True)
    extreme = {"conductance_clipped_high": 0, "conductance_clipped_low": -1}[form]
    assert counts.max() == counts[extreme] > 20
    assert values[extreme] == recording[RESISTANCE].min() or values[extreme] == recording[RESISTANCE].max()


def test_hum_is_one_line_of_the_spectrum():
    *_, ln_g = changes("periodic_interference:hum", 3, minutes=4.0, noise=1e-3, rate_hz=20.0)
    power = np.abs(np.fft.rfft(ln_g * np.hanning(len(ln_g)))) ** 2
    at = int(np.argmax(power[5:])) + 5
    assert power[at - 4 : at + 5].sum() > 0.8 * power[5:].sum()


def test_fading_loop_fades():
    time_s, *_, ln_g = changes("fading_gauge_loop", 3, minutes=20.0, rate_hz=10.0, noise=1e-3)
    early, late = time_s < 300, time_s > 900
    assert np.std(ln_g[late]) < 0.5 * np.std(ln_g[early])

"""A running compensator cannot be poisoned, says what it has not seen, and starts well at any moment."""

from __future__ import annotations

import shutil
import subprocess
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from compensation.export.export_c import c_header
from compensation.export.export_onnx import write_onnx
from compensation.export.onnx_stream import OnnxStream
from compensation.memories.history import History
from compensation.model import files as compensator_files
from compensation.model.runtime import READINGS_S, STEPS_S, Status
from compensation.model.streaming import CompensatorStream
from compensation.series.preprocessing import series_of
from compensation.training.options import Options
from compensation.training.training import train_on_series
from gcode.support.errors import UserError
from gcode.support.files import write_json
from gcode.support.strict import read_json
from tests.compensation.conftest import simulated_recording, train

needs_gcc = pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc on this machine")
BAD_READINGS = (np.nan, np.inf, -np.inf, 0.0, -1e-6)
BAD_STEPS = (np.nan, np.inf, -0.05, -20.0, 0.0, 2 * STEPS_S[1])
FAULTS = Status.BAD_READING | Status.BAD_STEP
PROGRAM = """
#include <stdio.h>
#include "k.h"
int main(void) {
    k_state s;
    double g, dt;
    k_reset(&s);
    while (scanf("%lf %lf", &g, &dt) == 2) {
        const float value = k_update(&s, (float)g, (float)dt);
        printf("%.9g %u\\n", value, (unsigned)s.status);
    }
    return 0;
}
"""
MARATHON = """
#include <stdio.h>
#include <stdint.h>
#include "k.h"
#include "d.h"
int main(void) {
    k_state s; d_state t;
    uint64_t random = 1u;
    double g = @MEAN@, worst = 0.0;
    k_reset(&s); d_reset(&t);
    for (uint32_t i = 0u; i < @COUNT@u; i++) {
        random = random * 6364136223846793005u + 1442695040888963407u;
        const double u = (double)(random >> 40) / 16777216.0 - 0.5;
        g += 0.02 * (@MEAN@ - g) + 0.5 * @SPREAD@ * u;
        const float reading = (float)g;
        const float p = k_update(&s, reading, i % 7u == 0u ? 0.04f : 0.05f);
        const double q = d_update(&t, reading, i % 7u == 0u ? 0.04f : 0.05f);
        const double apart = p > q ? p - q : q - p;
        if (!(apart <= worst)) { worst = apart; }
    }
    printf("%.9g\\n", worst);
    return 0;
}
"""


@pytest.fixture(scope="module")
def compensator(recordings):
    """All memories."""
    history = History((0.5, 8.0), (0.2, 0.5, 1.0))
    return train(recordings[:1], "force", Options(sizes=(6, 3), restarts=1, history=history, engine="fast"))


@pytest.fixture(scope="module")
def on_chip(compensator, tmp_path_factory):
    return compiled(compensator, tmp_path_factory.mktemp("chip"))


def compiled(compensator, folder, *how: str):
    """The C header, under the sanitisers unless told how to compile it: feed it samples, get values and flags."""
    (folder / "k.h").write_text(c_header(compensator, "k"))
    (folder / "main.c").write_text(PROGRAM)
    flags = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-Wconversion"]
    sanitised = ("-O1", "-fsanitize=undefined,address,float-divide-by-zero", "-fno-sanitize-recover=all")
    subprocess.run(["gcc", *flags, *(how or sanitised), "main.c", "-o", "main"], cwd=folder, check=True)

    def run(samples):
        lines = "\n".join(f"{g!r} {dt!r}" for g, dt in samples)
        printed = subprocess.run([folder / "main"], input=lines, capture_output=True, text=True, check=True).stdout
        pairs = [line.split() for line in printed.splitlines()]
        return np.array([float(value) for value, _ in pairs]), [Status(int(flag)) for _, flag in pairs]

    return run


@pytest.fixture(scope="module")
def in_onnx(compensator, tmp_path_factory):
    pytest.importorskip("onnxruntime")
    path = tmp_path_factory.mktemp("onnx") / "k.onnx"
    write_onnx(compensator, path)
    return lambda samples: fed(OnnxStream(path), samples)


def fed(stream, samples) -> tuple[np.ndarray, list[Status]]:
    values, flags = [], []
    for conductance, dt in samples:
        values.append(stream.update(conductance, dt))
        flags.append(stream.status)
    return np.array(values), flags


def samples_of(recording, count: int) -> list[tuple[float, float]]:
    steps = np.diff(recording.time_s, prepend=recording.time_s[0] - 0.05)
    return list(zip(recording.conductance_S[:count].tolist(), steps[:count].tolist(), strict=True))


def spoiled(samples, seed: int = 0) -> tuple[list[tuple[float, float]], np.ndarray]:
    """The samples with faulty ones put between, and where those are."""
    rng, out, bad = np.random.default_rng(seed), [], []
    for index, (conductance, dt) in enumerate(samples):
        while rng.random() < 0.3:
            # The first sample's step is not looked at.
            step = dt if not index or rng.random() < 0.5 else float(rng.choice(BAD_STEPS))
            reading = float(rng.choice(BAD_READINGS)) if step == dt else conductance
            out.append((reading, step))
            bad.append(True)
        out.append((conductance, dt))
        bad.append(False)
    return out, np.array(bad)


def test_faulty_samples_change_nothing(compensator, recordings):
    good = samples_of(recordings[1], 300)
    mixed, bad = spoiled(good)
    assert 50 < bad.sum() < 250
    values, flags = fed(CompensatorStream(compensator), mixed)
    np.testing.assert_array_equal(values[~bad], fed(CompensatorStream(compensator), good)[0])
    np.testing.assert_array_equal(values[1:][bad[1:]], values[:-1][bad[1:]])
    assert all(bool(flag & FAULTS) == wrong for flag, wrong in zip(flags, bad, strict=True))


@needs_gcc
def test_chip_and_onnx_do_the_same(compensator, recordings, on_chip, in_onnx):
    mixed, _ = spoiled(samples_of(recordings[2], 1500), seed=1)
    mixed[700:700] = [(1e30, 0.05), (1e-30, 0.05), (20 * mixed[0][0], 0.05), (mixed[0][0], 3000.0)]
    values, flags = fed(CompensatorStream(compensator), mixed)
    assert np.isfinite(values).all()
    for other in (on_chip, in_onnx):
        theirs, said = other(mixed)
        np.testing.assert_allclose(theirs, values, atol=1e-5 * compensator.scaling_out.scale)
        # Single precision may see the edge of a range on the other side.
        assert np.mean([one != two for one, two in zip(flags, said, strict=True)]) < 0.002


@needs_gcc
def test_every_runtime_has_the_same_limits(compensator, on_chip, in_onnx):
    """The single-precision numbers on, below and above each limit; a microsecond is a step like any other."""

    def near(limit: float) -> list[float]:
        ends = (np.float32(-np.inf), np.float32(np.inf))
        one = np.float32(limit)
        return [float(one), *(float(np.nextafter(one, end)) for end in ends)]

    usual = compensator.scaling_in.mean
    readings = [(one, 0.05) for limit in READINGS_S for one in near(limit)]
    steps = [(usual, one) for limit in STEPS_S for one in near(limit)]
    samples = [(usual, 0.05), *readings, *steps, (usual, 1e-6)]
    _, flags = fed(CompensatorStream(compensator), samples)
    refused = [flag & FAULTS for flag in flags]
    good, reading, step = Status.GOOD, Status.BAD_READING, Status.BAD_STEP
    lowest, highest = (lambda fault: [good, fault, good]), (lambda fault: [good, good, fault])
    assert refused == [good, *lowest(reading), *highest(reading), *lowest(step), *highest(step), good]
    for other in (on_chip, in_onnx):
        assert [flag & FAULTS for flag in other(samples)[1]] == refused


@needs_gcc
def test_a_rail_that_the_training_stood_at_is_no_news_to_a_chip(recordings, tmp_path):
    """A converter that stood at its end in the training stands there in use; rounded, that reading lay beyond it."""
    part = series_of(recordings[0], "force", 20.0)
    railed = replace(part, conductance_S=np.clip(part.conductance_S, *np.quantile(part.conductance_S, [0.2, 0.8])))
    trained = train_on_series([railed], "force", Options(sizes=(2,), restarts=1, engine="fast"))
    samples = [(conductance, 0.05) for conductance in railed.conductance_S.tolist()]
    for flags in (fed(CompensatorStream(trained), samples)[1], compiled(trained, tmp_path)(samples)[1]):
        assert not any(flag & Status.UNSEEN_READING for flag in flags)


anything = st.one_of(
    st.floats(allow_nan=True, allow_infinity=True), st.sampled_from(BAD_READINGS), st.floats(1e-7, 1e-4)
)


@needs_gcc
@given(st.lists(st.tuples(anything, anything), min_size=1, max_size=40))
@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_whatever_is_fed_values_stay_finite_and_alike(compensator, on_chip, in_onnx, samples):
    usual = [(compensator.scaling_in.mean, 0.05)] * 3
    values, flags = fed(CompensatorStream(compensator), samples + usual)
    assert np.isfinite(values).all()
    assert not flags[-1] & FAULTS
    for other in (on_chip, in_onnx):
        theirs, said = other(samples + usual)
        # A single that is nearly the limit of a double may be on its other side: then the histories differ.
        if [flag & FAULTS for flag in said] == [flag & FAULTS for flag in flags]:
            np.testing.assert_allclose(theirs, values, atol=2e-5 * compensator.scaling_out.scale)
        assert np.isfinite(theirs).all()


def test_what_was_not_seen_is_said(compensator, recordings):
    good = samples_of(recordings[0], 600)
    _, flags = fed(CompensatorStream(compensator), good)
    assert flags[-1] == Status.GOOD
    stream = CompensatorStream(compensator)
    fed(stream, good)
    value = stream.update(2.5 * max(conductance for conductance, _ in good), 0.05)
    assert stream.status & Status.UNSEEN_READING
    assert np.isfinite(value)
    # One spike is forgotten at the speed of the memories, and no faster than from the limit.
    stream.update(1.0, 0.05)
    after, _ = fed(stream, good[-40:])
    calm, _ = fed(primed(compensator, good), good[-40:])
    assert np.abs(after[-1] - calm[-1]) < 0.6 * compensator.scaling_out.scale


def primed(compensator, samples):
    stream = CompensatorStream(compensator)
    fed(stream, samples)
    return stream


def test_before_the_first_sample_the_mean_stands(compensator):
    stream = CompensatorStream(compensator)
    assert stream.status == Status.STARTING
    assert stream.update(np.nan) == pytest.approx(compensator.scaling_out.mean)
    assert stream.status == Status.BAD_READING


def cold_starts(compensator, recording, count: int = 30) -> tuple[float, float]:
    """RMS error from 1 to 20 s after switching on, and of a stream that has run all along, on the same samples."""
    grid = recording.resampled(20.0)
    conductance, truth = grid.conductance_S, grid["force_N"]
    running = np.array(fed(CompensatorStream(compensator), [(g, 0.05) for g in conductance])[0])
    cold, warm = [], []
    for begin in np.random.default_rng(0).integers(1200, len(grid) - 400, count):
        rows = slice(begin, begin + 400)
        fresh = fed(CompensatorStream(compensator), [(g, 0.05) for g in conductance[rows]])[0]
        cold.append((fresh - truth[rows])[20:] ** 2)
        warm.append((running - truth)[rows][20:] ** 2)
    return float(np.sqrt(np.mean(cold))), float(np.sqrt(np.mean(warm)))


def test_switched_on_in_use_it_is_nearly_as_good_as_one_that_ran(recordings):
    trained = train(recordings[:1], "force", Options(restarts=2, engine="fast"))
    cold, warm = cold_starts(trained, recordings[1])
    assert cold < 1.5 * warm
    naive, _ = cold_starts(replace(trained, beginning=None), recordings[1])
    assert cold < naive


@needs_gcc
@pytest.mark.slow
def test_a_hundred_million_samples_lose_nothing(compensator, tmp_path):
    header = c_header(compensator, "k")
    (tmp_path / "k.h").write_text(header)
    (tmp_path / "d.h").write_text(c_header(compensator, "d").replace("float", "double"))
    numbers = {"MEAN": compensator.scaling_in.mean, "SPREAD": compensator.scaling_in.scale, "COUNT": 10**8}
    program = MARATHON
    for name, value in numbers.items():
        program = program.replace(f"@{name}@", repr(value))
    (tmp_path / "main.c").write_text(program)
    subprocess.run(["gcc", "-std=c99", "-O2", "main.c", "-o", "main"], cwd=tmp_path, check=True)
    printed = subprocess.run([tmp_path / "main"], capture_output=True, text=True, check=True).stdout
    assert float(printed) < 1e-5 * compensator.scaling_out.scale


def test_a_beginning_of_another_number_of_memories_is_refused(compensator, tmp_path):
    path = tmp_path / "c.json"
    compensator_files.save(path, compensator)
    data = read_json(path, "compensator")
    data["beginning"]["gain"].append(1.0)
    write_json(path, data)
    with pytest.raises(UserError, match="must hold 12 numbers each"):
        compensator_files.load(path)


@pytest.mark.parametrize("rate_hz", [20.0, 80.0])
def test_where_to_begin_does_not_hang_on_how_often_was_sampled(recordings, rate_hz):
    """A start is the mean over a time, be it of 31 samples or of 122."""
    options = Options(restarts=1, engine="fast")
    expected = train(recordings[:1], "force", options).beginning
    found = train([recordings[0].resampled(rate_hz)], "force", replace(options, irregular=True)).beginning
    np.testing.assert_allclose(found.gain, expected.gain, atol=5e-3)
    np.testing.assert_allclose(found.offset, expected.offset, atol=5e-3)


def test_ranges_hold_the_training(recordings):
    two = [*recordings[:1], simulated_recording(9, 120.0)]
    trained = train(two, "force", Options(restarts=1, engine="fast"))
    for recording in two:
        x = trained.scaling_in.apply(recording.resampled(20.0).conductance_S)
        assert trained.seen.low <= x.min()
        assert x.max() <= trained.seen.high

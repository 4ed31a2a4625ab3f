"""The stream, the C header and the ONNX model all give the batch's numbers."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from compensation.cli import main
from compensation.export.export_c import PROMISED, c_header, code_bytes, cost, rounding
from compensation.export.export_onnx import write_onnx
from compensation.export.onnx_stream import OnnxStream
from compensation.memories.ema import start_samples
from compensation.memories.history import History
from compensation.model import files as compensator_files
from compensation.model.compensator import Scaling
from compensation.model.streaming import CompensatorStream
from compensation.series.preprocessing import series_of
from compensation.training.options import Options
from compensation.training.training import train_on_series
from gcode.support.errors import UserError
from tests.compensation.conftest import train
from tests.compensation.model.test_runtime import compiled, fed, needs_gcc

HISTORIES = [History(), History((0.1, 8.0), (0.2, 0.5, 1.0), settle_s=0.05), History((2.0,)), History((), (0.4,))]


@pytest.fixture(scope="module", params=HISTORIES, ids=["bank", "all", "motion", "play"])
def compensator(recordings, request):
    """Two networks, so that the mean over them is exercised."""
    options = Options(sizes=(6, 3), restarts=1, history=request.param, engine="fast")
    trained = [train(recordings[:1], "force", replace(options, seed=seed)) for seed in (0, 1)]
    return replace(trained[0], networks=trained[0].networks + trained[1].networks)


def samples_of(recording) -> list[tuple[float, float]]:
    """Conductance and step of every sample."""
    steps = np.diff(recording.time_s, prepend=recording.time_s[0])
    return list(zip(recording.conductance_S.tolist(), steps.tolist(), strict=True))


def streamed(compensator, recording) -> np.ndarray:
    return fed(CompensatorStream(compensator), samples_of(recording))[0]


def test_stream_is_the_causal_batch(compensator, recordings):
    recording = recordings[1].resampled(20.0)
    causal = replace(compensator, start="causal")
    batch = causal.predict(recording.time_s, recording.conductance_S)
    np.testing.assert_allclose(streamed(compensator, recording), batch, atol=1e-11)


def test_stream_is_the_papers_batch_once_every_filter_has_started(compensator, recordings):
    recording = recordings[1].resampled(20.0)
    compensator = replace(compensator, beginning=None)
    batch = compensator.predict(recording.time_s, recording.conductance_S)
    last = start_samples(compensator.alphas, 20.0).max() - 1
    np.testing.assert_allclose(streamed(compensator, recording)[last:], batch[last:], atol=1e-11)


def test_stream_takes_irregular_samples(compensator, recordings):
    recording = recordings[1]
    batch = replace(compensator, start="causal", irregular=True).predict(recording.time_s, recording.conductance_S)
    np.testing.assert_allclose(streamed(compensator, recording), batch, atol=1e-10)


def test_irregular_and_resampled_agree(compensator, recordings):
    recording = recordings[1]
    at_own_times = replace(compensator, irregular=True).predict(recording.time_s, recording.conductance_S)
    grid = recording.resampled(20.0)
    resampled = compensator.predict(grid.time_s, grid.conductance_S)
    difference = np.interp(grid.time_s, recording.time_s, at_own_times) - resampled
    assert np.sqrt(np.mean(difference**2)) < 0.05 * compensator.scaling_out.scale


@needs_gcc
@pytest.mark.parametrize("irregular", [False, True])
def test_c_header_compiled_equals_python(compensator, recordings, tmp_path, irregular):
    recording = recordings[2] if irregular else recordings[2].resampled(20.0)
    assert_c_equals_python(compensator, recording, tmp_path)


@needs_gcc
@pytest.mark.parametrize("rate_hz", [40.0, 200.0])
def test_c_header_equals_python_where_a_sample_falls_between_two_steps(compensator, recordings, tmp_path, rate_hz):
    """A filter's start ended just there, so that rounding decided which samples it was the mean of."""
    assert_c_equals_python(compensator, recordings[2].between(0, 40).resampled(rate_hz), tmp_path)


@needs_gcc
@pytest.mark.parametrize("slower", ["every step", "the second sample"])
def test_c_header_equals_python_where_only_the_first_sample_starts_filters(compensator, recordings, tmp_path, slower):
    """A slow meter, or a loose contact after the first sample, passes every filter's start in one step."""
    recording = recordings[2].resampled(20.0)
    steps = np.full(len(recording.time_s), 30.0 if slower == "every step" else 0.05)
    steps[1] = 30.0
    assert_c_equals_python(compensator, replace(recording, time_s=np.cumsum(steps)), tmp_path)


def assert_c_equals_python(compensator, recording, folder: Path) -> None:
    values, _ = compiled(compensator, folder, "-O2")(samples_of(recording))
    np.testing.assert_allclose(
        values, streamed(compensator, recording), atol=PROMISED * compensator.scaling_out.scale
    )


def test_c_header_links_no_library_and_uses_no_heap(compensator):
    text = c_header(compensator)
    assert text.count("#include") == 1
    assert "malloc" not in text
    assert f"{cost(compensator).state_bytes} bytes of RAM" in text


def test_cost_of_the_papers_network_by_hand(recordings):
    paper = train(recordings[:1], "force", Options(restarts=1))
    needs = cost(paper)
    # (7+1)4 + (4+1)2 + (2+1)2 + 3 = 51 parameters, 28+8+4+2 = 42 weights, 7 filters.
    assert paper.parameter_count == 51
    assert needs.constants_bytes == 4 * (51 + 35 + 14 + 4)
    assert needs.state_bytes == 4 * 32
    assert needs.multiplies == 42 + 28 + 1
    # Each gain takes 7; of the factor 0.4 the exponent is -0.51, which is halved and squared once.
    assert needs.multiplies_any_step == needs.multiplies + 7 * 7 + 2


def test_onnx_step_equals_python(compensator, recordings, tmp_path):
    pytest.importorskip("onnxruntime")
    write_onnx(compensator, tmp_path / "c.onnx")
    recording = recordings[1].between(0.0, 60.0)
    stream = OnnxStream(tmp_path / "c.onnx")
    got, _ = fed(stream, samples_of(recording))
    np.testing.assert_allclose(got, streamed(compensator, recording), atol=1e-9)
    for wrong, words in ((("x",), "conductance_S must be a number, got 'x'"), ((1e-6, "x"), "dt_s must be a number")):
        with pytest.raises(UserError, match=words):
            stream.update(*wrong)


def test_what_is_no_compensator_is_refused_by_name():
    with pytest.raises(UserError, match=r"a fitted compensation\.Compensator, got 'c\.json'"):
        c_header("c.json")


def test_per_recording_scaling_cannot_stream(compensator, tmp_path):
    whole = replace(compensator, per_recording=True)
    for attempt in (
        lambda: CompensatorStream(whole),
        lambda: c_header(whole),
        lambda: write_onnx(whole, tmp_path / "c.onnx"),
    ):
        with pytest.raises(UserError, match="needs the whole recording"):
            attempt()


@pytest.mark.parametrize("format_", ["c", "onnx"])
def test_command_writes_the_file(compensator, tmp_path, capsys, format_):
    compensator_files.save(tmp_path / "c.json", compensator)
    out = tmp_path / f"c.{format_}"
    assert main(["export", str(tmp_path / "c.json"), "--format", format_, "-o", str(out), "--name", "pes"]) == 0
    assert out.stat().st_size > 1000
    assert "wrote" in capsys.readouterr().out
    if format_ == "c":
        assert main(["export", str(tmp_path / "c.json"), "-o", str(out), "--name", "no good"]) == 2
        assert "C identifier" in capsys.readouterr().err


@needs_gcc
def test_single_precision_errs_as_far_as_it_says(recordings, tmp_path):
    """The same knit with so little gain that its mean is 350 standard deviations: the reading itself is the error."""
    parts = [series_of(recording, "force", 20.0) for recording in recordings[:2]]
    mean, scale = parts[0].conductance_S.mean(), parts[0].conductance_S.std()
    insensitive = [replace(part, conductance_S=1e-8 * (350 + (part.conductance_S - mean) / scale)) for part in parts]
    trained = train_on_series(insensitive[:1], "force", Options(sizes=(6, 3), restarts=1, engine="fast"))
    assert rounding(trained) == pytest.approx(350 * 2**-24)
    samples = [(conductance, 0.05) for conductance in insensitive[1].conductance_S.tolist()]
    (expected, _), (got, _) = fed(CompensatorStream(trained), samples), compiled(trained, tmp_path, "-O2")(samples)
    apart = np.abs(got - expected).max() / trained.scaling_out.scale
    assert PROMISED < apart < 2 * rounding(trained)


@pytest.mark.parametrize(("ratio", "warned"), [(150, False), (350, True), (-350, True)])
def test_a_sensor_that_single_precision_cannot_hold_is_said(compensator, tmp_path, capsys, ratio, warned):
    """Half a unit in the last place of a float32 is 6e-8 of the value; 1e-5 of a standard deviation is promised."""
    scale = compensator.scaling_in.scale
    compensator_files.save(
        tmp_path / "c.json", replace(compensator, scaling_in=Scaling(ratio * scale, scale), seen=None)
    )
    assert main(["export", str(tmp_path / "c.json"), "-o", str(tmp_path / "c.h")]) == 0
    assert ("warning: the conductance moves by little" in capsys.readouterr().out) == warned


@pytest.mark.parametrize(
    ("name", "words", "code"), [("e.onnx", [], 0), ("e.onnx", ["--format", "c"], 2), ("e.h", ["--format", "onnx"], 2)]
)
def test_the_ending_says_the_format_or_agrees_with_it(compensator, tmp_path, capsys, name, words, code):
    compensator_files.save(tmp_path / "c.json", compensator)
    assert main(["export", str(tmp_path / "c.json"), "-o", str(tmp_path / name), *words]) == code
    said = capsys.readouterr()
    assert ("one step; feed it" in said.out) if code == 0 else ("which is not --format" in said.err)
    assert (tmp_path / name).exists() == (code == 0)


@pytest.mark.parametrize("format_", ["c", "onnx"])
@pytest.mark.parametrize(("place", "said"), [("no/such/x", "its folder does not exist"), (".", "is a folder")])
def test_a_place_that_cannot_be_written_is_said_before_the_work(compensator, tmp_path, capsys, format_, place, said):
    compensator_files.save(tmp_path / "c.json", compensator)
    words = ["export", str(tmp_path / "c.json"), "--format", format_, "-o", str(tmp_path / place)]
    assert main(words) == 2
    error = capsys.readouterr().err
    assert said in error
    assert "Traceback" not in error
    assert [path.name for path in tmp_path.iterdir()] == ["c.json"]


def test_every_runtime_knows_the_interval(compensator, tmp_path):
    pytest.importorskip("onnxruntime")
    known = replace(compensator, margins=(-0.25, 0.5))
    assert CompensatorStream(known).margins == (-0.25, 0.5)
    header = c_header(known, "pes")
    assert "#define PES_MARGIN_LOW (-0.25f)" in header
    assert "#define PES_MARGIN_HIGH (0.5f)" in header
    assert "MARGIN" not in c_header(compensator, "pes")
    for one in (known, compensator):
        write_onnx(one, tmp_path / "c.onnx")
        assert OnnxStream(tmp_path / "c.onnx").margins == one.margins


def test_tools_that_cannot_size_a_program_leave_its_size_unknown(compensator, tmp_path, monkeypatch):
    for name in ("gcc", "size"):
        tool = tmp_path / name
        tool.write_text("#!/bin/sh\nexit 1\n")
        tool.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    assert code_bytes(c_header(compensator), "compensator") is None

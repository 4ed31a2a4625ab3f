"""A held-out recording that was clamped anew: the zero of its displacement is free, its own, and told."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gcode.support.errors import UserError
from testbench.cli import main
from testbench.comparing.clamping import TRIED_MM, may_be_clamped_anew, moved, zero_of
from testbench.comparing.ladder import on_the_ladder
from testbench.comparing.remounting import held_errors
from testbench.comparing.tables import errors_line
from testbench.fitting.fit import Fit, fit
from testbench.measurements.joining import last_of
from testbench.measurements.measurement import Measurement
from testbench.measurements.splitting import split
from testbench.recordings.between import FRESH, Between
from testbench.recordings.recording import Recording
from testbench.results.model_file import load_model_file
from tests.testbench.builders import NOISE_LN, NOISE_N, record, truth, write_csv

SHIFT_MM = 0.6


def clamped(recording: Recording, shift_mm: float) -> Recording:
    """The same pull, its displacement counted from a jaw that stands `shift_mm` higher."""
    channels = dict(recording.channels)
    channels["displacement_mm"] = channels["displacement_mm"] - shift_mm
    return replace(recording, channels=channels)


@pytest.fixture(scope="module")
def fitted() -> tuple[Fit, Measurement, Measurement]:
    """The true model fitted to one recording, and another one of the sensor put in anew."""
    calibration, held = split(record(truth(), 120, seed=1), clamped(record(truth(), 120, seed=2), SHIFT_MM))
    return fit(truth(), calibration), calibration, held


def test_the_zero_is_found_and_nothing_is_left_to_be_explained(fitted) -> None:
    result, _, held = fitted
    free = replace(held, clamp_play_mm=0.5)
    zero = zero_of(result.model, free)
    assert zero.shift_mm == pytest.approx(SHIFT_MM, abs=max(4 * zero.standard_error_mm, 0.02))
    assert zero.standard_error_mm < 0.05
    errors, bound = held_errors(result.model, free), held_errors(result.model, held)
    assert errors["force"] < 1.1 * NOISE_N
    assert errors["conductance"] < 1.1 * NOISE_LN
    assert bound["force"] > 3 * NOISE_N


def test_where_nothing_was_clamped_anew_nothing_is_free_and_none_is_found(fitted) -> None:
    result, _, _ = fitted
    _, same = split(record(truth(), 120, seed=1), record(truth(), 120, seed=2))
    zero = zero_of(result.model, replace(same, clamp_play_mm=0.5))
    assert abs(zero.shift_mm) < max(4 * zero.standard_error_mm, 0.02)
    assert may_be_clamped_anew(result.model, same) == ""


def test_the_prior_holds_what_the_data_do_not_tell(fitted) -> None:
    result, _, held = fitted
    tight = zero_of(result.model, replace(held, clamp_play_mm=1e-4))
    assert abs(tight.shift_mm) <= 4 * 1e-4
    assert tight.standard_error_mm <= 1e-4


def test_the_step_of_the_ladder_says_it_and_the_next_step_knows_it(fitted, tmp_path) -> None:
    result, calibration, held = fitted
    file = on_the_ladder(result, None, "baseline", calibration, replace(held, clamp_play_mm=0.5))
    file.save(tmp_path / "model.json")
    again = load_model_file(tmp_path / "model.json")
    assert again.between == Between(clamp_play_mm=0.5)
    assert again.history[-1]["zero"]["shift_mm"] == pytest.approx(SHIFT_MM, abs=0.1)
    assert f"its displacement counts from {-again.history[-1]['zero']['shift_mm']:+.3g} ±" in errors_line(
        again.history[-1]
    )
    assert on_the_ladder(result, None, "baseline", calibration, held).between == FRESH


def test_a_zero_that_would_explain_much_is_offered(fitted) -> None:
    result, _, held = fitted
    told = may_be_clamped_anew(result.model, held)
    assert f"counted {TRIED_MM:g} mm further" in told
    assert "`clamp_play_mm`" in told


@pytest.mark.parametrize("play_mm", [-0.1, 5.0, float("nan")])
def test_a_play_that_no_clamp_has_is_refused(play_mm: float) -> None:
    with pytest.raises(UserError, match=r"must be from 0 to 2\.5 mm"):
        split(record(truth(), 60), record(truth(), 60, seed=1), between=Between(clamp_play_mm=play_mm))


def test_the_last_third_was_not_clamped_anew(tmp_path, capsys) -> None:
    path = write_csv(record(truth(), 60), tmp_path / "a.csv")
    argv = ["fit", path, "--gauge-length-mm", "25", "--clamp-play-mm", "0.5", "-o", str(tmp_path / "m.json")]
    assert main(argv) == 2
    assert "the sensor was neither clamped anew" in capsys.readouterr().err


def test_only_the_last_of_several_recordings_is_moved() -> None:
    """What came before is one history of the specimen, as it was read."""
    recordings = [record(truth(), 60, seed=seed) for seed in (1, 2, 3)]
    last = last_of(recordings, [60.0, 60.0])
    shifted = moved(last, 0.5).signals["strain"] - last.signals["strain"]
    late = last.signals["time_s"] >= last.begins_s[-1]
    np.testing.assert_allclose(shifted[~late], 0.0, atol=0)
    np.testing.assert_allclose(shifted[late], 0.5 / recordings[0].gauge_length_mm)


def test_how_well_a_zero_is_known_is_no_matter_of_the_play(fitted) -> None:
    """Where the recording tells more of it than the play does."""
    result, _, held = fitted
    found = [zero_of(result.model, replace(held, clamp_play_mm=play_mm)) for play_mm in (0.2, 0.5, 2.5)]
    errors = [zero.standard_error_mm for zero in found]
    assert errors == pytest.approx([errors[0]] * 3, rel=0.02)
    assert [zero.shift_mm for zero in found] == pytest.approx([found[0].shift_mm] * 3, abs=0.1 * errors[0])

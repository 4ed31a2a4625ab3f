"""Several recordings of one specimen are one history, and each has zeros of its own where it was clamped anew."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

import testbench as tb
from gcode.support.errors import UserError
from testbench.cli import main
from testbench.comparing.carried_over import fails_elsewhere
from testbench.comparing.ladder import ladder_step
from testbench.comparing.same_specimen import with_same_specimen
from testbench.diagnosis import diagnose
from testbench.diagnosis.diagnosis import calibration_and_held_out, rest_between
from testbench.knit.kinematics.mounting import DisplacementZeros, ForceZeros
from testbench.knit.mechanics.damage import MullinsSoftening
from testbench.measurements.joining import joined, last_of
from testbench.recordings.between import Between
from testbench.recordings.recording import Recording
from testbench.results.model_file import ModelFile
from tests.testbench.builders import CATALOGUE, GAUGE_LENGTH_MM, PULL_S, REST_S, pulls_of, record, truth, write_csv

SOFTENS = truth().plus(MullinsSoftening(softening=0.4))
SHIFTS_MM = (0.0, 0.3, -0.2, 0.1)


def pulls(count: int) -> list[Recording]:
    """One history, recorded pull by pull, each with its own zero of the displacement."""
    made = []
    for one, shift_mm in zip(pulls_of(SOFTENS, count, ("force_N",)), SHIFTS_MM, strict=False):
        made.append(replace(one, channels={**one.channels, "displacement_mm": one["displacement_mm"] - shift_mm}))
    return made


def unshifted(count: int) -> Iterator[tuple[Recording, np.ndarray]]:
    """The pulls, and the displacement of each as it was before its zero was lost."""
    for one, shift_mm in zip(pulls(count), SHIFTS_MM, strict=False):
        yield one, one["displacement_mm"] + shift_mm


def test_zeros_shift_each_recording_but_the_first():
    signals = {"time_s": np.arange(5.0), "strain": np.full(5, 0.1), "force_N": np.ones(5)}
    moved = DisplacementZeros(begins_s=(2.0, 4.0), strain=(0.01, -0.02)).apply(signals, 1.0)["strain"]
    assert moved == pytest.approx([0.1, 0.1, 0.11, 0.11, 0.08])
    tared = ForceZeros(begins_s=(2.0, 4.0), force_N=(0.5, 0.0)).apply(signals, 1.0)["force_N"]
    assert tared == pytest.approx([1, 1, 1.5, 1.5, 1])


def test_of_one_recording_there_is_nothing_to_shift():
    signals = {"time_s": np.arange(5.0), "strain": np.full(5, 0.1)}
    assert np.array_equal(DisplacementZeros().apply(signals, 1.0)["strain"], signals["strain"])


def test_recordings_in_a_row_are_one_history_with_rests_that_do_not_count():
    first, second, *_ = pulls(2)
    both = joined([first, second], [REST_S])
    (begin_s,) = both.begins_s
    assert begin_s == pytest.approx(PULL_S + REST_S, abs=0.2)
    time_s = both.signals["time_s"]
    assert not both.counts[(time_s > PULL_S) & (time_s < begin_s)].any()
    assert both.counts[time_s > begin_s + 3.1].all()


def test_a_history_tells_where_its_knit_was_clamped_anew():
    parts = pulls(3)
    both = joined(parts, [REST_S] * 2, clamp_play_mm=1.0)
    time_s, clamping = both.signals["time_s"], both.signals["clamping"]
    assert [float(clamping[time_s >= begin_s][0]) for begin_s in (0.0, *both.begins_s)] == [0, 1, 2]
    assert np.all(np.diff(clamping) >= 0)
    assert "clamping" not in joined(parts, [REST_S] * 2).signals


def test_the_last_recording_comes_after_the_others():
    first, second, third = pulls(3)
    held = last_of([first, second, third], [REST_S, REST_S])
    assert held.recording.source == "pull 3"
    assert held.counts[held.signals["time_s"] > held.begins_s[-1] + 3.1].all()
    assert not held.counts[held.signals["time_s"] < held.begins_s[-1]].any()


def test_one_that_is_held_out_after_a_rest_is_of_a_softened_knit():
    """The true model is at the noise of it, and far from it where it is taken for a fresh one."""
    first, second = (replace(one, channels={**one.channels, "displacement_mm": mm}) for one, mm in unshifted(2))
    noise_N = float(np.std(np.diff(second["force_N"][-100:]))) / np.sqrt(2)
    left = []
    for rest_s in (REST_S, None):
        calibration, held = calibration_and_held_out([first], second, rest_s=rest_s)
        assert calibration.recording.source == "pull 1"
        left.append(float(np.std(held.residual(SOFTENS)["force"][held.counts])))
    assert left[0] < 2 * noise_N < 5 * noise_N < left[1]


def test_the_rest_between_recordings_is_decided_once():
    assert [rest_between(*asked) for asked in ((1, None), (2, None), (1, 5.0))] == [None, 60.0, 5.0]
    for odd in (0, -1, 86_400, float("nan"), "a"):
        with pytest.raises(UserError, match=r"^rest_s"):
            Between(rest_s=odd)


def test_a_rest_is_one_before_another_recording():
    with pytest.raises(UserError, match="pull 1: a rest comes before that of a held-out recording, and none"):
        tb.diagnose(pulls(1)[0], rest_s=30.0)


def test_recordings_of_another_gauge_length_are_no_history():
    first, second, third = pulls(3)
    with pytest.raises(
        UserError, match=r"pull 2: gauge length 30 mm, but pull 1 has 25 mm; give recordings of the same"
    ):
        diagnose([first, replace(second, gauge_length_mm=30.0)], third, catalogue=CATALOGUE)


def test_recordings_that_share_no_channel_are_no_history():
    first, second, third = pulls(3)
    columns = {
        "displacement_mm": second.channels["displacement_mm"],
        "resistance_ohm": 1000 + second.channels["force_N"],
    }
    with pytest.raises(UserError, match="the recordings share no channel, but pull 3 has force; all need the same"):
        diagnose([first, replace(second, channels=columns)], third, catalogue=CATALOGUE)


def test_a_held_out_recording_of_the_same_specimen_is_told_where_it_was_taken_for_a_fresh_one():
    first, second = (replace(one, channels={**one.channels, "displacement_mm": mm}) for one, mm in unshifted(2))
    for held_out in (first, second):
        step = ladder_step("+ mullins_softening", SOFTENS, *calibration_and_held_out([first], held_out))
        file = ModelFile(SOFTENS, GAUGE_LENGTH_MM, history=(step,))
        told = with_same_specimen(file, 1, first, held_out, 0.0)
        if held_out is first:
            assert told is file
    said = fails_elsewhere(told.history, 1)
    assert "that is for a fresh specimen. For the same one, after a rest of 60 s, it is 1.1 times as large" in said
    assert "what was found does not carry over" in fails_elsewhere(file.history, 1)


def test_no_recording_is_not_enough():
    with pytest.raises(UserError, match="recording: must be one or more, got none"):
        tb.diagnose([])


def test_several_recordings_need_one_to_judge_on():
    with pytest.raises(UserError, match="give another one to judge on as `held_out`"):
        diagnose(pulls(2), catalogue=CATALOGUE)


def test_the_command_takes_several(tmp_path, capsys):
    files = [write_csv(one, tmp_path / f"{number}.csv") for number, one in enumerate(pulls(2))]
    assert main(["diagnose", *files, "--gauge-length-mm", "25", "--quiet"]) == 2
    assert "several recordings are one history" in capsys.readouterr().err


@pytest.mark.parametrize("rest_s", [0.0, -1.0, np.nan, 1e9])
def test_a_rest_is_a_time(rest_s):
    first, second, third = pulls(3)
    with pytest.raises(UserError, match="rest_s: must be more than 0 and less than 86400 s, got"):
        diagnose([first, second], third, catalogue=CATALOGUE, rest_s=rest_s)


@pytest.mark.slow
def test_softening_shows_between_pulls_that_were_clamped_anew():
    *first, last = pulls(4)
    result = diagnose(first, last, catalogue=CATALOGUE, most=1, clamp_play_mm=0.3, rest_s=REST_S)
    assert result.found[0].effect == "mullins_softening"
    fitted = result.after.fit["parameters"]
    for number, shift_mm in enumerate(SHIFTS_MM[1:3]):
        shift = fitted[f"displacement_zeros.strain[{number}]"]["value"]
        assert shift == pytest.approx(shift_mm / GAUGE_LENGTH_MM, abs=0.002)
    assert not [name for name in result.after.model if name.endswith("_zeros")], "of the sensor, not of a recording"
    # The last pull is that of a knit which was softened before; what is left is what the zeros do to its history.
    assert result.error_after["force"] < 2 * result.noise_floor["force"]


@pytest.mark.slow
def test_a_recording_that_was_cut_in_two_says_the_same():
    model = truth().plus(CATALOGUE["stress_relaxation"]().replaced(fraction=0.1, tau_s=10.0))
    whole, held_out = (record(model, 240, 10.0, seed, ("force_N",)) for seed in (1, 2))
    rows = whole.time_s < 120
    halves = [
        replace(whole, time_s=whole.time_s[part], channels={n: v[part] for n, v in whole.channels.items()})
        for part in (rows, ~rows)
    ]
    one = diagnose(whole, held_out, catalogue=CATALOGUE, most=1)
    two = diagnose(halves, held_out, catalogue=CATALOGUE, most=1, rest_s=whole.time_s[1] - whole.time_s[0])
    assert one.found[0].effect == two.found[0].effect == "stress_relaxation"
    for name, chance in one.probabilities.items():
        assert two.probabilities[name] == pytest.approx(chance, abs=0.05), name
    left = [d.after.history[-1]["errors"]["calibration"]["force"] for d in (one, two)]
    assert left[1] == pytest.approx(left[0], rel=0.05)

"""Several clocks in one file, and several repeats."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gcode.support.errors import UserError
from testbench.cli import main
from testbench.importing.from_file import import_file
from testbench.importing.wish import Wish
from testbench.recordings.files import read_recording
from tests.testbench.importing import exports
from tests.testbench.importing.exports import import_csv


def test_tdms_channels_keep_their_clocks(tmp_path):
    recording = import_csv(exports.labview(tmp_path), Wish(40.0)).recording
    assert recording.time_s == pytest.approx(exports.TIME_S[::2], abs=1e-6)
    assert recording["displacement_mm"] == pytest.approx(exports.EXTENSION_MM[::2], abs=1e-6)
    assert recording["force_N"] == pytest.approx(exports.FORCE_N[::2], abs=1e-6)
    assert recording["resistance_ohm"] == pytest.approx(exports.RESISTANCE_OHM[::2])


TWO_CLOCKS = "t_R [s],R [ohm],t_F [s],F [N],t_x [s],x [mm]\n" + "".join(
    f"{t:.2f},{900 + t:.2f},{t + 0.01:.2f},{t:.2f},{t + 0.02:.2f},{2 * t:.2f}\n" for t in np.arange(0, 2, 0.1)
)


@pytest.mark.parametrize("role", ["force", "displacement", "resistance"])
def test_the_clock_of_one_channel_may_be_said_and_the_others_found(tmp_path, role):
    (tmp_path / "lab.csv").write_text(TWO_CLOCKS)
    clock = {"force": "t_F", "displacement": "t_x", "resistance": "t_R"}[role]
    found, said = (import_csv(tmp_path / "lab.csv", Wish(40.0, time_of=one)).recording for one in ({}, {role: clock}))
    assert said.time_s == pytest.approx(found.time_s)
    for name, values in found.channels.items():
        assert said[name] == pytest.approx(values)


@pytest.mark.parametrize(
    ("unit", "said"), [("t_F", "does not say its unit"), ("t_F [ticks]", "'ticks' cannot be read")]
)
def test_another_clocks_unit_says_nothing_of_this_one(tmp_path, unit, said):
    (tmp_path / "lab.csv").write_text(TWO_CLOCKS.replace("t_F [s]", unit))
    wish = Wish(40.0, columns={"time": "1"}, time_of={"force": "3", "displacement": "5"})
    with pytest.raises(UserError, match=f"the times of force: .*{said}.*; say --time-unit"):
        import_csv(tmp_path / "lab.csv", wish)
    recording = import_csv(tmp_path / "lab.csv", replace(wish, units={"time": "s"})).recording
    assert recording["force_N"] == pytest.approx(recording.time_s + 0.1 - 0.01, abs=1e-9)


def test_of_several_times_the_message_knows_clocks(tmp_path):
    (tmp_path / "lab.csv").write_text(TWO_CLOCKS.replace("t_x", "t_other"))
    with pytest.raises(UserError, match=r"say which, .* where a channel has a clock of its own, --time-of force="):
        import_csv(tmp_path / "lab.csv", Wish(40.0))


@pytest.mark.parametrize("name", ["{}", "Time [s]"])
def test_clocks_are_found_by_their_names_or_places(tmp_path, name):
    text = TWO_CLOCKS
    if name != "{}":
        for own in ("t_R [s]", "t_F [s]", "t_x [s]"):
            text = text.replace(own, name)
    (tmp_path / "lab.csv").write_text(text)
    recording = import_csv(tmp_path / "lab.csv", Wish(40.0)).recording
    assert recording["force_N"] == pytest.approx(recording.time_s + 0.1 - 0.01, abs=1e-9)
    assert recording["displacement_mm"] == pytest.approx(2 * (recording.time_s + 0.1 - 0.02), abs=1e-9)
    assert recording["resistance_ohm"] == pytest.approx(900.1 + recording.time_s)


def test_a_channel_without_a_clock_of_its_name_has_that_left_of_it(tmp_path):
    lines = [line.split(",") for line in TWO_CLOCKS.splitlines()]
    (tmp_path / "lab.csv").write_text("\n".join(",".join([*cells[:4], cells[5]]) for cells in lines))
    found = import_csv(tmp_path / "lab.csv", Wish(40.0))
    assert "its own times: column 3 't_F [s]'" in found.taken["displacement"]
    assert found.recording["displacement_mm"] == pytest.approx(2 * found.recording["force_N"])


REPEATS = "repeat,time_s,displacement_mm,force_N\n" + "".join(
    f"{repeat},{t:.1f},{repeat + t:.1f},{t:.1f}\n" for repeat in (1, 2, 3) for t in np.arange(0, 2, 0.1)
)


def test_repeats_become_recordings_of_their_own(tmp_path):
    path = tmp_path / "lab.csv"
    path.write_text(REPEATS)
    done = import_file(path, Wish(40.0, zero={"displacement": None}))
    assert [one.label for one in done] == ["1", "2", "3"]
    assert [float(one.recording["displacement_mm"][0]) for one in done] == [0, 0, 0]
    assert main(["import", str(path), "--gauge-length-mm", "40", "-o", str(tmp_path / "out")]) == 0
    assert [read_recording(tmp_path / f"out-{one}")["displacement_mm"][0] for one in (1, 2, 3)] == [1, 2, 3]
    assert main(["import", str(path), "--gauge-length-mm", "40", "--repeat", "2", "-o", str(tmp_path / "two")]) == 0
    assert read_recording(tmp_path / "two")["displacement_mm"][0] == 2
    assert main(["import", str(path), "--gauge-length-mm", "40", "--repeat", "7", "-o", str(tmp_path / "no")]) == 2


def test_clocks_that_do_not_overlap_are_told(tmp_path):
    late = "".join(f"{t:.2f},{900 + t:.2f},{t + 60:.2f},{t:.2f}\n" for t in np.arange(0, 2, 0.1))
    (tmp_path / "lab.csv").write_text("t_R [s],R [ohm],t_F [s],F [N]\n" + late)
    with pytest.raises(
        UserError, match=r"the clocks do not overlap: at no time of column 1 't_R .s.' is there a sample"
    ):
        import_csv(tmp_path / "lab.csv", Wish(40.0, drop_bad=True))


def counted(folder, times):
    path = folder / "lab.csv"
    rows = "".join(f"{time},{0.1 * n:.1f},{n}\n" for n, time in enumerate(times))
    path.write_text(f"Time [ms],Displacement [mm],Force [N]\n{rows}")
    return path


@pytest.mark.parametrize(("bits", "first"), [(16, 0), (32, 0), (16, -(2**15)), (32, -(2**31))])
def test_a_counter_that_begins_anew_goes_on(tmp_path, bits, first):
    """It was advised to sort, which put what came last before the first."""
    times = [(2**bits - 1005 + 100 * n) % 2**bits + first for n in range(40)]
    done = import_csv(counted(tmp_path, times), Wish(40.0))
    assert done.recording.time_s == pytest.approx(0.1 * np.arange(40))
    assert f"column 1 'Time [ms]' falls back by 2^{bits} in row 13, and was taken to go on" in done.notes


def test_a_counter_of_microseconds_begins_anew_in_milliseconds_too(tmp_path):
    times = [(2**32 - 1_005_000 + 100_000 * n) % 2**32 / 1e3 for n in range(40)]
    done = import_csv(counted(tmp_path, times), Wish(40.0))
    assert done.recording.time_s == pytest.approx(0.1 * np.arange(40))
    assert "column 1 'Time [ms]' falls back by 2^32 µs in row 13, and was taken to go on" in done.notes


@pytest.mark.parametrize("sort", [False, True])
def test_another_test_is_no_counter_that_begins_anew(tmp_path, sort):
    times = [60_000 + 100 * n for n in range(40)] + [5000 + 100 * n for n in range(40)]
    with pytest.raises(
        UserError, match=r"row 42: .*several recordings, .* set back: --repeat N \(1 to 2\) takes one"
    ):
        import_csv(counted(tmp_path, times), Wish(40.0, sort=sort))


def test_halves_of_a_file_that_were_swapped_are_sorted(tmp_path):
    times = [100 * n for n in (*range(20, 40), *range(20))]
    assert import_csv(counted(tmp_path, times), Wish(40.0, sort=True)).recording.duration_s == pytest.approx(3.9)

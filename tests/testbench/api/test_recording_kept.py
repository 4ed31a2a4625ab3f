"""Results are frozen, and so is what they hold."""

from __future__ import annotations

import copy
import pickle
from dataclasses import replace

import numpy as np
import pytest

import gcode
import testbench as tb
from tests.testbench.api.samples import relaxed

REFUSED = pytest.raises((TypeError, ValueError), match=r"not changed in place|read-only")
COPIES = [lambda one: one, copy.copy, copy.deepcopy, lambda one: pickle.loads(pickle.dumps(one)), replace]


@pytest.mark.parametrize("copied", COPIES)
def test_a_recording_stays_as_it_was_checked(copied):
    """A channel that was put in later went past every check; a changed force left the strain as it was."""
    recording = relaxed()
    _ = recording.strain, recording.conductance_S
    again = copied(recording)
    for name in again:
        with REFUSED:
            again.channels[name] = [1.0]
        with REFUSED:
            again[name][0] = 99.0
        assert np.array_equal(again[name], recording[name])
    for values in (again.time_s, again.strain, again.conductance_S):
        with REFUSED:
            values[0] = 99.0
    with REFUSED:
        again.metadata["sensor"] = "another"


def test_a_recording_does_not_follow_the_mapping_it_was_made_of():
    channels = {"displacement_mm": np.arange(3.0), "force_N": np.zeros(3)}
    recording = tb.Recording(np.arange(3.0), channels, 25.0)
    del channels["force_N"]
    assert list(recording) == ["displacement_mm", "force_N"]
    channels["displacement_mm"][0] = 0.5  # the user's own array stays one that may be changed
    assert recording["displacement_mm"].tolist() == [0, 1, 2]  # it followed, past every check


@pytest.mark.parametrize("copied", COPIES)
def test_a_model_stays_as_it_was_checked(copied):
    model = copied(tb.baseline())
    with REFUSED:
        model.effects["slip"] = 3
    assert model == tb.baseline()


def test_a_program_stays_as_it_was_read(tmp_path):
    gcode.generate("paper-1", seed=3, duration_s=20).write(tmp_path)
    program = gcode.read(tmp_path / "program.tap")
    with REFUSED:
        program.header["seed"] = "4"
    for values in (program.position_mm, program.planned().position_mm, gcode.play(program).time_s):
        with REFUSED:
            values[0] = 4.0
    assert program.problems == ()


@pytest.mark.parametrize("copied", COPIES)
def test_what_compare_and_import_hold_stays_as_it_is(copied):
    compared = copied(tb.compare(relaxed(), tb.baseline()).comparison)
    for mapping in (compared.rms, compared.maps, compared.maps["force"]):
        with REFUSED:
            mapping["force"] = 0.0
    given = {"force": "Load"}
    wish = copied(tb.Wish(columns=given, negate={"force"}))
    given["force"] = "none"
    with REFUSED:
        wish.columns["force"] = "none"
    assert wish == tb.Wish(columns={"force": "Load"}, negate=frozenset({"force"}))


@pytest.mark.parametrize("kind", [list, tuple, np.float32])
def test_a_recording_is_made_of_any_numbers(kind):
    time_s, moved, force = ([0, 1, 2], [0, 5, 0], [0, 2, 0])
    of = np.float32 if kind is np.float32 else kind
    recording = tb.Recording(of(time_s), {"displacement_mm": of(moved), "force_N": of(force)}, 25)
    assert recording.strain.tolist() == [0.0, 0.2, 0.0]
    assert recording.time_s.dtype == recording["force_N"].dtype == np.float64


@pytest.mark.parametrize(
    ("channels", "words"),
    [
        ({"force_N": ["a", "b", "c"]}, "recording: force_N must be numbers, could not convert string"),
        (
            {"force_N": [[1, 2], [3, 4], [5, 6]]},
            r"recording: force_N must be one number a sample, got shape \(3, 2\)",
        ),
        ({"force_N": [1, 2, 3j]}, "recording: force_N must be real numbers, got complex128"),
        ([[0, 1, 2]], "recording: channels must be a mapping of names to samples, got list"),
        (None, "recording: channels must be a mapping of names to samples, got NoneType"),
        ({1: [0, 1, 2]}, "recording: a channel's name must be a text such as force_N, got 1"),
    ],
)
def test_a_recording_of_something_else_is_refused_in_a_sentence(channels, words):
    if isinstance(channels, dict):
        channels = {"displacement_mm": [0, 1, 2], **channels}
    with pytest.raises(tb.UserError, match=words):
        tb.Recording([0, 1, 2], channels, 25)


def test_metadata_that_is_none_is_refused_in_a_sentence():
    with pytest.raises(tb.UserError, match="metadata must be a mapping, got NoneType; leave it out"):
        tb.Recording([0, 1], {"displacement_mm": [0, 1]}, 25, "mine", None)  # type: ignore[arg-type]


@pytest.mark.parametrize("call", [lambda r: r.thinned(True), lambda r: r.resampled(True)])
def test_a_truth_is_no_rate(call):
    """``True`` was taken for 1 Hz, and for every sample."""
    with pytest.raises(tb.UserError, match=r"must be a .*number.*got True"):
        call(relaxed())


def test_a_table_of_arrow_or_polars_is_read_as_one_of_pandas_is():
    """It was refused: must be a data frame, got DataFrame."""
    arrow = pytest.importorskip("pyarrow")

    class LikePolars:
        def __init__(self, columns):
            self._columns, self.columns = columns, list(columns)

        def __getitem__(self, name):
            return np.asarray(self._columns[name])

    columns = {"time_s": [0, 1, 2], "displacement_mm": [0, 1, 0], "force_N": [0, 2, 1], "remark": ["a", "b", ""]}
    plain = tb.read(columns, 25)
    for table in (arrow.table(columns), LikePolars(columns)):
        assert tb.read(table, 25).to_dict() == plain.to_dict()
    for nothing in (np.zeros(3), [1, 2], None, b"a.csv", plain):
        with pytest.raises(tb.UserError, match="read: must be a path, a data frame or a mapping of columns, got"):
            tb.read(nothing, 25)

"""Diagnoses are read as they were written, by this version and by the ones before."""

from __future__ import annotations

import pytest

from gcode.support.errors import UserError
from gcode.support.files import write_json
from testbench.results.result_files import read_diagnosis
from tests.testbench.report.samples import diagnosis


@pytest.mark.parametrize("key", ["form", "law"])
def test_the_law_of_a_mechanism_is_read_under_either_name(tmp_path, key):
    written = diagnosis()
    for entry in (*written["ranking"], *written["found"]):
        entry[key] = f"{entry.pop('law')}_power"
    write_json(tmp_path / "d.json", written)
    read = read_diagnosis(tmp_path / "d.json")
    for entry in (*read["ranking"], *read["found"]):
        assert entry["law"] == f"{entry['effect']}_power"
        assert "form" not in entry


def test_an_entry_without_a_law_is_refused_by_its_place(tmp_path):
    written = diagnosis()
    del written["ranking"][1]["law"]
    write_json(tmp_path / "d.json", written)
    with pytest.raises(UserError, match=r"ranking.*law"):
        read_diagnosis(tmp_path / "d.json")


@pytest.mark.parametrize(
    ("changed", "says"),
    [
        ({"found": []}, "nothing is ranked or found"),
        ({"probabilities": {"nothing": 0.5, "unknown": 0.5}}, "there is none of 'stress_relaxation'"),
        ({"bends_like": "swelling"}, "there is none of 'swelling'"),
    ],
)
def test_a_diagnosis_that_no_verdict_can_be_worded_of_is_refused(tmp_path, changed, says):
    write_json(tmp_path / "d.json", diagnosis() | changed)
    with pytest.raises(UserError, match=says):
        read_diagnosis(tmp_path / "d.json")

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

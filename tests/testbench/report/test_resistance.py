"""A report in kΩ: wherever ln G would stand, the resistance does, and the rest is as it was."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import testbench as tb
from testbench.cli import main
from testbench.report.document import Picture, Report, Table
from tests.testbench.builders import record, truth, write_csv


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[str, str]:
    """A recording and a model fitted to it."""
    folder = tmp_path_factory.mktemp("report")
    path = write_csv(record(truth(), 90), folder / "a.csv")
    model = str(folder / "model.json")
    assert main(["fit", path, "--gauge-length-mm", "25", "-o", model]) == 0
    return path, model


def report(made: tuple[str, str], resistance: bool) -> Report:
    path, model = made
    return tb.make_report(path, gauge_length_mm=25.0, model=model, resistance=resistance).report


def words(told: Report) -> str:
    """Every word of its figures and tables."""
    items = [*told.opening, *(item for part in told.sections for item in part.items)]
    layouts = [item.figure["layout"] for item in items if isinstance(item, Picture)]
    tables = [
        (item.head, item.rows) for item in items if isinstance(item, Table) and "Allowed range" not in item.head
    ]
    return json.dumps([layouts, tables], ensure_ascii=False, default=str)


def test_the_resistance_stands_wherever_the_conductance_would(made) -> None:
    text = words(report(made, True))
    assert "kΩ" in text
    assert "ln S" not in text
    assert "ln (G" not in text
    assert "Conductance" not in text


def test_nobody_who_does_not_ask_for_it_gets_it(made) -> None:
    text = words(report(made, False))
    assert "ln S" in text
    assert "kΩ" not in text


def test_the_page_is_written_in_it(made, tmp_path: Path) -> None:
    path, model = made
    argv = ["report", "--recording", path, "--gauge-length-mm", "25", "--model", model, "--resistance"]
    assert main([*argv, "-o", str(tmp_path / "r.html")]) == 0
    assert "Held-out resistance (kΩ)" in (tmp_path / "r.html").read_text()

"""The validation page: what was skipped, failed and found, and how often probabilities were right."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import validation
from validation_data import MATERIALS, all_pairs, recording
from validation_words import page

REAL = Path(__file__).resolve().parents[3] / "../shared/data/real"
FOUND = {
    "verdict": "missing",
    "probabilities": {"stress_relaxation": 0.97, "load_cell_creep": 0.02, "nothing": 0.005},
    "found": [{"effect": "stress_relaxation", "law": "stress_relaxation_power", "probability": 0.97}],
    "tied": [],
    "left": 0.12,
    "error_before": {"force": 0.08},
    "error_after": {"force": 0.02},
    "noise_floor": {"force": 0.01},
    "depends_on": [],
    "samples": 2309,
    "minutes": 30.05,
    "held_out": "relax_2d0",
    "picture": "validation-vhb-relax.png",
    "seconds": 40.0,
}


def rows(**changes):
    return {key: {"skipped": "these recordings are not here"} for key in all_pairs()} | changes


def test_the_page_says_what_was_found_failed_and_skipped():
    text = page(
        MATERIALS,
        rows(**{"vhb-relax": FOUND, "sleeve": {"error": "not ended within 9 s"}}),
        None,
        {},
    )
    assert "1 pairs were diagnosed: 1 as known, 0 otherwise, 0 without a name; 1 failed" in text
    assert "stress relaxation 97 %, load cell creep 2 %" in text
    assert "12 % of the error above the noise is left" in text
    assert "force 0.08, 0.02 (0.01) N" in text
    assert "failed: not ended within 9 s" in text
    assert "these recordings are not here" in text
    assert "(images/validation-vhb-relax.png)" in text
    for material in MATERIALS:
        assert material.source in text
        assert material.licence in text


def test_what_is_not_known_of_the_material_is_counted_against_it():
    wrong = FOUND | {"probabilities": {"clamp_slip": 0.99}}
    text = page(MATERIALS, rows(**{"vhb-relax": wrong}), None, {})
    assert "1 pairs were diagnosed: 0 as known, 1 otherwise" in text
    assert "| clamp slip (99 %) | no |" in text


def test_the_nearest_mechanism_of_an_unknown_is_no_name():
    text = page(MATERIALS, rows(**{"vhb-relax": FOUND | {"verdict": "unknown"}}), None, {})
    assert "0 as known, 0 otherwise, 1 without a name" in text
    assert "| stress relaxation (97 %) | none named |" in text


def test_a_pair_that_takes_too_long_or_fails_is_a_row(tmp_path):
    late = validation.in_a_process("vhb-relax", tmp_path, tmp_path, tmp_path / "p.png", 0.05)
    assert late == {"error": "not ended within 0.05 s"}
    said = validation.last_line("Traceback\n  File x\nUserError: /somewhere/else/file.csv: no such file\n")
    assert said == "UserError: file.csv: no such file"


def test_where_no_recording_is_the_page_stays_as_it_is(tmp_path, capsys):
    out = tmp_path / "validation.md"
    out.write_text("as it was")
    validation.main(["--data", str(tmp_path / "absent"), "-o", str(out), "--results", str(tmp_path / "rows")])
    assert "skipped" in capsys.readouterr().out
    assert out.read_text() == "as it was"


def test_materials_that_are_absent_are_skipped(tmp_path, capsys):
    out = tmp_path / "docs" / "validation.md"
    out.parent.mkdir()
    (tmp_path / MATERIALS[0].folder).mkdir()
    argv = ["--data", str(tmp_path), "-o", str(out), "--results", str(tmp_path / "rows"), "--only", "sleeve"]
    validation.main(argv)
    text = out.read_text()
    assert "0 pairs were diagnosed" in text
    assert str(tmp_path) not in text


def test_the_reliability_diagram_comes_from_the_results_of_the_benchmark(tmp_path):
    path = tmp_path / "r.jsonl"
    lines = [
        {
            "chances": {"clamp_slip": chance, "nothing": 1 - chance},
            "answer": "clamp_slip" if right else "nothing",
            "expected": "missing",
            "hidden": ["clamp_slip"],
            "named": ["clamp_slip"],
            "ranked": ["clamp_slip"],
            "found": ["clamp_slip"],
            "sure": [chance],
            "verdict": "missing",
            "after": 1.1,
            "simulator": "second",
            "strength": 5.0,
            "reached": [5.0],
            "minutes": 6.0,
        }
        for chance, right in [(0.9, True)] * 9 + [(0.9, False)]
    ]
    import json

    path.write_text("".join(json.dumps(line) + "\n" for line in lines))
    told = validation.simulated_of([path], tmp_path / "images")
    assert told["cases"] == 10
    assert "| expected calibration error | 0.000 |" in told["glance"]
    assert (tmp_path / "images" / told["picture"]).is_file()
    text = page(MATERIALS, rows(), told, {})
    assert "10 sensors" in text
    assert validation.simulated_of([tmp_path / "absent.jsonl"], tmp_path) is None


def test_rows_that_hold_no_number_or_go_back_in_time_are_left_out():
    columns = {
        "time_s": np.array([0.0, 1.0, 1.0, 2.0, 3.0]),
        "displacement_mm": np.array([0.0, 1.0, 1.0, np.nan, 3.0]),
        "force_N": np.arange(5.0),
    }
    kept = recording(columns, 20.0, "x")
    assert list(kept.time_s) == [0, 1, 3]


@pytest.mark.real_data
def test_every_recording_can_be_read():
    if not REAL.is_dir():
        pytest.skip("the measured recordings are not here")
    for key, (material, pair) in all_pairs().items():
        every, other = pair.read(REAL / material.folder)
        for one in every:
            assert len(one) > 500, key
            same = other is None or abs(other.gauge_length_mm - one.gauge_length_mm) < 1e-3 * one.gauge_length_mm
            assert same, key

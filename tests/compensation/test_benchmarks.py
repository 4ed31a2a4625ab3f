"""What the benchmarks of compensators print beside the figures themselves: engines, means over materials, options."""

from __future__ import annotations

import argparse
import json
from types import SimpleNamespace

import bench_compensators
import bench_training
import compensator_promises
import compensator_rivals
import numpy as np
import pandas as pd
import pytest
from compensator_cases import Case
from compensator_options import add_kinds, add_specimens, names

from compensation.paper.reproduction import prepared
from compensation.search import search_space
from compensation.series.preprocessing import series_of

SMALL = search_space.spread(search_space.candidates(), 2)[0]


def test_a_candidate_is_trained_by_every_engine(recordings, capsys):
    parts = dict(zip("TAB", (recording.between(0, 30) for recording in recordings), strict=True))
    found = bench_training.compared(prepared(parts, "force"), "force", SMALL)
    assert tuple(found.seconds) == tuple(found.r2) == bench_training.ORDER
    assert found.left_at is None
    bench_training.report([found], 1.0)
    printed = capsys.readouterr().out
    assert "fast beats sklearn" in printed
    assert "to the end in 1 of 1" in printed


def test_pairs_are_averaged_over_materials():
    cases = [Case("others", name, lambda: ([], []), ("force",)) for name in ("silver a", "silver b", "cb c")]
    known = {
        (case.name, "force", "line"): {"r2": 0.1 * number, "raw": 0.5 + 0.1 * number}
        for number, case in enumerate(cases, start=1)
    }
    lines = bench_compensators.tables(known, cases, ["line"])
    means = {line.split(":")[1].split()[0]: line.split()[-2:] for line in lines if line.startswith("mean of")}
    assert means == {"silver,": ["0.650", "0.150"], "cb,": ["0.800", "0.300"], "all": ["0.700", "0.200"]}
    assert lines[-1].startswith("mean of 3")


def test_a_rival_sees_nothing_of_what_is_to_come(recordings):
    """At every sample of 20 Hz, though it runs at 5 Hz: ours does not either."""
    part = series_of(recordings[0].between(0.0, 30.0), "force", 20.0)
    fitted = compensator_rivals.reservoir([part], "force", 0)
    shorter = part.rows(np.arange(len(part) - 7))
    np.testing.assert_allclose(fitted.predict(part)[:-7], fitted.predict(shorter), rtol=1e-9)


def test_a_promise_is_held_against_every_other_recording_of_the_sensor(monkeypatch, tmp_path):
    time_s = np.arange(0, 30, 0.1)
    for name, gain in (("a", 1.0), ("b", 2.0), ("c", 3.0)):
        table = {"time_s": time_s, "force_N": gain * np.sin(time_s), "ohm": 2 + np.sin(time_s)}
        pd.DataFrame(table).to_csv(tmp_path / f"{name}.csv", index=False)

    def perfect(series, target, options):
        promise = {"r2": 0.9, "r2_elsewhere": series[0].truth.max()}
        return SimpleNamespace(recipe={"cross_validated": promise}, predict_series=lambda part: part.truth)

    monkeypatch.setattr(compensator_promises, "ALL_REAL", tmp_path)
    monkeypatch.setattr(compensator_promises, "train_automatically", perfect)
    columns = {"force_N": "force_N", "resistance_ohm": "ohm"}
    monkeypatch.setitem(compensator_promises.SENSORS, "three", ("*.csv", columns))
    rows = compensator_promises.promises("three")
    assert [(first, round(second), came) for first, second, came in rows] == [
        (0.9, own, 1.0) for own in (1, 1, 2, 2, 3, 3)
    ]


def test_what_was_known_when_a_benchmark_was_killed_in_a_line_is_known(tmp_path):
    results, row = tmp_path / "results.jsonl", {"case": "cb", "target": "force", "method": "line", "r2": 0.5}
    row |= dict.fromkeys(bench_compensators.JUDGES, 0.0)
    results.write_text(json.dumps(row) + '\n{"case": "c')
    assert bench_compensators.read(results) == {("cb", "force", "line"): row}
    assert bench_compensators.read(tmp_path / "not there yet") == {}


def test_words_of_an_option_that_nothing_knows_are_refused(capsys):
    parser = argparse.ArgumentParser()
    add_specimens(parser, "--sets", "1,2", "")
    add_kinds(parser, ["pes"], ["pes", "lycra"])
    parser.add_argument("--methods", type=names(["line", "auto"]))
    told = parser.parse_args(["--kinds", "lycra,pes", "--methods", "auto"])
    assert (told.sets, told.kinds, told.methods) == ((1, 2), ("lycra", "pes"), ("auto",))
    assert parser.parse_args([]).kinds == ("pes",)
    for words, match in (
        (["--sets", "1,b"], "--sets: must be whole numbers with commas, such as 871,872; got '1,b'"),
        (["--kinds", "lycra,silk"], "--kinds: must be of pes, lycra, with commas; got 'lycra,silk'"),
        (["--methods", ""], "--methods: must be of line, auto, with commas; got ''"),
    ):
        with pytest.raises(SystemExit):
            parser.parse_args(words)
        assert match in capsys.readouterr().err

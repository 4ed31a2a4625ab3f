"""The benchmark of the diagnosis counts rightly: tried with diagnoses that are made up."""

from __future__ import annotations

import importlib
import json
import sys
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).parents[3] / "benchmarks"


@pytest.fixture(scope="module")
def bench():
    sys.path.insert(0, str(BENCHMARKS))
    yield importlib.import_module("bench_diagnosis")
    sys.path.remove(str(BENCHMARKS))


class Fake:
    """Says always the same."""

    def __init__(self, verdict: str, *ranked: str):
        ranking = [{"effect": name, "gain": 1.0} for name in ranked]
        self.said = {"verdict": verdict, "ranking": ranking, "ceiling_gain": 0.5, "left_unexplained": 0.1}

    def to_dict(self) -> dict:
        errors = {"force": 0.02, "conductance": 0.01}
        model = [{"name": "x", "effect": entry["effect"]} for entry in self.said["ranking"][:1]]
        after = {"model_before": {"effects": []}, "model_after": {"effects": model}}
        return self.said | after | {"error_before": errors, "error_after": errors, "noise_floor": errors}


def _row(bench, effect: str, fake: Fake, **more) -> dict:
    job = bench.Job(effect, 5.0, "matched", 1, minutes=2.0, rate_hz=10.0, **more)
    return bench.run_job(job, lambda *_: fake)


def test_right_first_and_in_the_top_three(bench):
    from diagnosis_score import first, top3

    right = _row(bench, "channel_lag", Fake("missing", "channel_lag", "clamp_slip"))
    third = _row(bench, "channel_lag", Fake("missing", "a", "b", "b", "channel_lag"))
    unsaid = _row(bench, "channel_lag", Fake("unknown", "channel_lag"))
    assert (first(right), top3(right)) == (True, True)
    assert (first(third), top3(third)) == (False, True)
    assert not first(unsaid)


def test_an_effect_left_out_of_the_catalogue_is_gone_in_all_its_forms(bench):
    seen = {}

    def diagnose(calibration, held_out, catalogue, rounds):
        seen["ideas"] = set(catalogue.ideas())
        return Fake("unknown")

    job = bench.Job("channel_lag", 5.0, "matched", 1, left_out=True, minutes=2.0, rate_hz=10.0)
    row = bench.run_job(job, diagnose)
    assert row["expected"] == "unknown"
    assert "channel_lag" not in seen["ideas"]
    assert "clamp_slip" in seen["ideas"]


def test_two_at_once_get_a_round_more_than_there_are(bench):
    asked = []
    job = bench.Job("permanent_set,channel_lag", 5.0, "matched", 1, minutes=2.0, rate_hz=10.0)
    bench.run_job(job, lambda *given: asked.append(given[3]) or Fake("unknown"))
    bench.run_job(
        bench.Job("none", 5.0, "matched", 1, minutes=2.0, rate_hz=10.0),
        lambda *given: asked.append(given[3]) or Fake("unknown"),
    )
    assert asked == [3, 1]


def test_tables_count_false_alarms_and_confusions(bench):
    from diagnosis_score import tables

    rows = [
        _row(bench, "none", Fake("missing", "clamp_slip")),
        _row(bench, "none", Fake("nothing_missing")),
        _row(bench, "unknown", Fake("unknown")),
        _row(bench, "channel_lag", Fake("missing", "clamp_slip", "channel_lag")),
        _row(bench, "permanent_set,channel_lag", Fake("missing", "channel_lag")),
    ]
    text = tables(rows)
    assert "| matched | 50 % of 2 | 0 % of 2 | 100 % of 1 | 50 % of 1 | 0.0 a case |" in text
    assert "| matched | 5x | 0 % of 1 | 0 % of 1 | 100 % of 1 | 100 % of 1 |" in text
    assert "| clamp_slip | 1 |" in text


def test_a_diagnosis_that_raises_is_reported_and_the_rest_goes_on(bench):
    from diagnosis_score import tables

    def diagnose(calibration, held_out, catalogue, rounds):
        raise ValueError("no shape")

    row = bench.run_job(bench.Job("none", 5.0, "matched", 1, minutes=2.0, rate_hz=10.0), diagnose)
    assert row["error"] == "ValueError: no shape"
    assert "no shape" in tables([row])


def test_a_broken_off_run_is_resumed(bench, tmp_path, capsys):
    results = tmp_path / "rows.jsonl"
    jobs = [bench.Job("none", 5.0, "matched", seed, minutes=2.0, rate_hz=10.0) for seed in range(3)]
    bench.run_all(jobs[:2], lambda *_: Fake("nothing_missing"), results, 1)
    results.write_text(results.read_text() + '{"key": "cut sho')
    rows = bench.run_all(jobs, lambda *_: Fake("missing", "clamp_slip"), results, 1)
    assert [row["verdict"] for row in rows] == ["nothing_missing", "nothing_missing", "missing"]
    assert [row["verdict"] for row in bench.read_rows(results)] == ["nothing_missing", "nothing_missing", "missing"]
    assert "1/1 none 5x matched 2" in capsys.readouterr().out


def test_a_row_is_plain_json(bench):
    row = _row(bench, "channel_lag", Fake("missing", "channel_lag"))
    assert json.loads(json.dumps(row, allow_nan=False)) == row


def test_every_effect_strength_world_and_seed_has_its_job(bench):
    jobs = bench.jobs_of(("a", "b", "c"), (2.0, 5.0), ("matched", "mismatched"), (0, 1))
    assert len({job.key for job in jobs}) == len(jobs)
    plain = [job for job in jobs if job.effect in "abc" and not job.left_out]
    assert len(plain) == 3 * 2 * 2 * 2
    assert "none" in {job.effect for job in jobs}
    assert len({job.effect for job in jobs} & set(bench.OUTSIDE)) == 4
    assert sum(job.left_out for job in jobs) == 4

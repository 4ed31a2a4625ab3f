"""The benchmark of the diagnosis counts rightly: tried with diagnoses that are made up."""

from __future__ import annotations

import json

import bench_diagnosis
import pytest


@pytest.fixture
def bench():
    return bench_diagnosis


class Fake:
    """Says always the same."""

    def __init__(self, verdict: str, *ranked: str, sure: float = 0.8):
        names = list(dict.fromkeys(ranked))
        found = [{"effect": name, "probability": sure} for name in names[:1] if verdict == "missing"]
        first = {"missing": names[0] if names else "", "nothing_missing": "nothing", "unknown": "unknown"}[verdict]
        chances = dict.fromkeys(("nothing", "unknown", *names), 0.0) | {first: sure}
        ranking = [{"effect": name, "gain": 1.0} for name in ranked]
        self.said = {"verdict": verdict, "ranking": ranking, "found": found, "probabilities": chances}

    def to_dict(self) -> dict:
        errors = {"force": 0.02, "conductance": 0.01}
        left = {"left_unexplained": 0.1, "error_before": errors, "error_after": errors, "noise_floor": errors}
        return self.said | left


def _row(bench, effect: str, fake: Fake, **more) -> dict:
    job = bench.Job(effect, 5.0, **({"world": "matched", "seed": 1, "minutes": 2.0, "rate_hz": 10.0} | more))
    return bench.run_job(job, lambda *_: fake)


def test_right_first_and_in_the_top_three(bench):
    from diagnosis_score import first, top3

    right = _row(bench, "channel_lag", Fake("missing", "channel_lag", "clamp_slip"))
    third = _row(bench, "channel_lag", Fake("missing", "a", "b", "channel_lag"))
    unsaid = _row(bench, "channel_lag", Fake("unknown", "channel_lag"))
    assert (first(right), top3(right)) == (True, True)
    assert (first(third), top3(third)) == (False, True)
    assert not first(unsaid)


def test_effects_that_cannot_be_as_strong_as_asked_are_counted_beside_those_that_are(bench):
    from diagnosis_score import goals

    found = _row(bench, "channel_lag", Fake("missing", "channel_lag"))
    missed = found | {"named": [], "reached": [0.6 * found["strength"]]}
    told = goals([found, missed])
    assert found["reached"] == [pytest.approx(found["strength"], rel=0.1)]
    assert told["right first and named"] == "50 % of 2"
    assert told["the same, of those as strong as asked"] == "100 % of 1"


def test_an_effect_left_out_of_the_catalogue_is_gone_in_all_its_forms(bench):
    seen = {}

    def diagnose(calibration, held_out, catalogue):
        seen["mechanisms"] = set(catalogue.mechanisms())
        return Fake("unknown")

    job = bench.Job("channel_lag", 5.0, "matched", 1, left_out=True, minutes=2.0, rate_hz=10.0)
    row = bench.run_job(job, diagnose)
    assert row["expected"] == "unknown"
    assert "channel_lag" not in seen["mechanisms"]
    assert "clamp_slip" in seen["mechanisms"]


def test_the_second_simulator_makes_cases_of_its_own(bench):
    row = _row(bench, "thermal_softening", Fake("missing", "temperature_drift"), world="second")
    assert (row["simulator"], row["hidden"]) == ("second", ["temperature_drift"])
    assert row["floor_said"] > 0


@pytest.mark.parametrize("name", ["second", "third", "fourth"])
def test_a_simulator_of_one_world_makes_cases_of_any_kind_it_has(bench, name):
    jobs = bench.kinds_of(40, 0, name)
    effects, motions = bench.EFFECTS[name], bench.MOTIONS[name]
    assert {job.simulator for job in jobs} == {name}
    assert all(job.effect in [*effects, "none"] and job.protocol in motions for job in jobs)
    assert {job.effect for job in bench.jobs_of(effects, [5.0], [name], range(12))} >= {
        *effects,
        *bench.OUTSIDE[name],
    }


def test_a_sensor_clamped_anew_is_diagnosed_as_one(bench):
    seen = []

    def diagnose(calibration, held_out, catalogue, clamp_play_mm=0.0):
        seen.append(clamp_play_mm)
        return Fake("nothing_missing")

    jobs = [bench.Job("none", world=world, seed=3, minutes=2.0, rate_hz=10.0) for world in bench.FREELY_ASKED]
    for job in jobs:
        for again in (False, True):
            row = bench.run_job(bench.replace(job, reclamped=again), diagnose)
            assert (row.get("error"), row["reclamped"]) == (None, again)
    assert [play > 0 for play in seen] == [False, True] * 2


def test_some_recordings_of_any_kind_are_clamped_anew_and_the_others_keep_their_keys(bench):
    jobs = bench.kinds_of(60, 4, "second")
    assert 5 < sum(job.reclamped for job in jobs) < 30
    assert jobs[:20] == bench.kinds_of(20, 4, "second")
    assert not any(job.reclamped for job in bench.kinds_of(20, 4))
    first = bench.replace(jobs[0], reclamped=False)
    assert first.key == "contact_saturation/10.0/second/4000/False/10.0/100.0//staircase/resistance_ohm"
    others = bench.replace(first, reclamped=True), bench.replace(first, laws="drift=none")
    assert len({job.key for job in (first, *others)}) == 3


def test_a_family_of_laws_is_left_out_and_judged_on(bench, capsys, monkeypatch):
    ran = []
    monkeypatch.setattr(bench, "run_all", lambda jobs, *_: ran.extend(jobs) or [])
    for asked, laws in (("elasticity=fung", {"fung"}), ("elasticity!=fung", None)):
        bench.main(["--simulator", "second", "--laws", asked, "--minutes", "1", "--limit", "3"])
        drawn = {job.made().truth["base"]["elasticity"]["law"] for job in ran}
        assert drawn == laws if laws else "fung" not in drawn
        ran.clear()
    for simulator, asked, said in (
        ("third", "elasticity=fung", "laws: elasticity=law,law or elasticity!=law, of gent"),
        ("fourth", "elasticity=fung", "--laws: only for --simulator second or third, not fourth"),
        ("second", "colour=red", "laws: no family 'colour'; there are contact, drift"),
    ):
        with pytest.raises(SystemExit, match="2"):
            bench.main(["--simulator", simulator, "--laws", asked])
        assert said in capsys.readouterr().err


def test_the_third_simulator_makes_cases_of_its_own(bench):
    row = _row(bench, "clamp_slip", Fake("missing", "clamp_slip"), world="third")
    assert (row["simulator"], row["hidden"], row["reached"]) == (
        "third",
        ["clamp_slip"],
        [pytest.approx(5.0, rel=0.1)],
    )


def test_the_fourth_simulator_makes_cases_of_its_own(bench):
    row = _row(bench, "clamp_slip", Fake("missing", "clamp_slip"), world="fourth", rate_hz=40.0, protocol="mixed")
    assert (row["simulator"], row["hidden"]) == ("fourth", ["clamp_slip"])
    assert row["floor_said"] > 0


def test_the_cases_of_a_seed_have_sensors_and_motions_that_their_simulator_has(bench):
    for name in ("matched", "second", "third", "fourth"):
        simulator = bench.Job(world=name).simulator
        jobs = bench.jobs_of(bench.EFFECTS[simulator], [15.0], [name], [5])
        assert len({job.seed for job in jobs}) == len(jobs)
        assert {job.protocol for job in jobs} == {"mixed" if name == "fourth" else "perlin"}


def test_the_brier_score_and_the_calibration_error_are_those_of_the_formulas(bench):
    from diagnosis_score import brier_score, calibration_error, reliability

    def row(sure: float, right: bool) -> dict:
        return {"answer": "a" if right else "b", "chances": {"a": sure, "b": 1 - sure}}

    rows = [row(0.9, True)] * 3 + [row(0.9, False)] + [row(0.75, True)] * 3 + [row(0.75, False)]
    assert brier_score(rows) == pytest.approx((3 * 0.02 + 1.62 + 3 * 0.125 + 1.125) / 8)
    assert calibration_error(rows) == pytest.approx(0.5 * 0.15)
    assert "| 70 to 80 % | 4 | 75 % | 75 % |" in reliability(rows)
    two = {"answer": "", "chances": {"a": 1.0}}
    assert brier_score([*rows, two]) == brier_score(rows)


def test_a_wrong_name_counts_as_surely_wrong_only_where_it_was_sure(bench):
    from diagnosis_score import surely_wrong

    assert surely_wrong(_row(bench, "none", Fake("missing", "clamp_slip", sure=0.95)))
    assert not surely_wrong(_row(bench, "none", Fake("missing", "clamp_slip", sure=0.6)))
    assert not surely_wrong(_row(bench, "clamp_slip", Fake("missing", "clamp_slip", sure=0.95)))
    assert surely_wrong(_row(bench, "clamp_slip", Fake("missing", "clamp_slip", sure=0.95), left_out=True))


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

    def diagnose(calibration, held_out, catalogue):
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
    assert len({job.effect for job in jobs} & set(bench.OUTSIDE["first"])) == 4
    assert sum(job.left_out for job in jobs) == 4

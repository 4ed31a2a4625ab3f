"""How long a job will still take: right within a factor of two, also on a machine that has become slower."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from testbench.commands.diagnose import CANDIDATES_OF_A_ROUND, Refits
from testbench.studio.jobs.job import Job
from testbench.studio.jobs.pace import Pace, Paces, Profile, about_in_words, kind_of
from testbench.studio.parts.job_card import progress_in_words, spark_line

DURATIONS = st.lists(st.floats(0.05, 20), min_size=3, max_size=60)


def played(durations: list[float], slower: float, pace: Pace) -> list[tuple[float, float | None, float]]:
    """Run through a job's steps: elapsed time, what was said to be left, and what was left, after each step."""
    said, now_s, total_s = [], 0.0, slower * sum(durations)
    for number, duration_s in enumerate(durations):
        now_s += slower * duration_s
        pace.hear(f"step {number}", (number + 1) / len(durations), now_s)
        said.append((now_s, pace.left_s(now_s), total_s - now_s))
    return said


@given(durations=DURATIONS, slower=st.floats(0.5, 2.0))
@settings(max_examples=60)
def test_the_time_left_is_right_within_a_factor_of_two(durations: list[float], slower: float) -> None:
    first = Pace()
    played(durations, 1.0, first)
    again = Pace(Profile(sum(durations), dict(first.marks)))
    for now_s, left_s, truly_s in played(durations, slower, again):
        whole_s = slower * sum(durations)
        said_s = now_s + (left_s or 0.0)
        assert whole_s / 2.01 <= said_s <= 2.01 * whole_s
        if now_s > 0.3 * whole_s and truly_s > 0.2 * whole_s:
            assert left_s is not None
            assert truly_s / 2 <= left_s <= 2 * truly_s


def test_a_job_never_seen_before_is_extrapolated_once_it_has_begun() -> None:
    pace = Pace()
    assert pace.left_s(3.0) is None
    pace.hear("one", 0.01, 1.0)
    assert pace.left_s(1.0) is None, "too early to say"
    pace.hear("two", 0.25, 10.0)
    assert pace.left_s(12.0) == pytest.approx(28.0)
    assert pace.left_s(50.0) is None, "it takes longer than was thought"


def test_what_comes_before_the_first_counted_step_is_not_counted_for_every_step() -> None:
    pace = Pace()
    pace.hear("fitting the baseline", None, 30.0)
    pace.hear("refitting with a", 0.125, 32.0, "candidate 3")
    assert pace.total_s() == pytest.approx(30.0 + 2.0 / 0.125)


def test_a_diagnosis_counts_its_candidates(capsys, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("KNITBENCH_PROGRESS", "json")
    tell = Refits(rounds=1)
    job = Job("diagnose:c", "t", ("testbench", "diagnose"))
    said = []
    for number in range(2 * CANDIDATES_OF_A_ROUND):
        if number % CANDIDATES_OF_A_ROUND == 0:
            tell("screening the catalogue")
        tell("refitting with slack")
    for line in capsys.readouterr().err.splitlines():
        job.hear_error(line)
        said.append(job.step)
    assert said[:2] == ["", "candidate 1 of 12"]
    assert said[-1] == "candidate 24 of 24"
    assert list(job.pace.marks)[:2] == ["screening the catalogue", "candidate 1"], "whatever the candidates are"


def test_profiles_are_kept_from_one_studio_to_the_next(tmp_path: Path) -> None:
    path = tmp_path / "running" / "paces.json"
    paces = Paces(path)
    pace = paces.start(["testbench", "fit", "a"])
    pace.hear("iteration 1: cost 5.5", None, 2.0)
    pace.hear("iteration 2: cost 4.5", None, 4.0)
    paces.keep(["testbench", "fit", "a"], pace, 5.0)
    again = Paces(path).start(["testbench", "fit", "b"])
    assert again.profile == Profile(5.0, {"iteration 1": 2.0, "iteration 2": 4.0})
    assert (pace.score_name, pace.scores) == ("misfit", [5.5, 4.5])
    path.write_text("{")
    assert Paces(path).start(["testbench", "fit", "b"]).profile is None


def test_trainings_of_other_methods_take_other_times() -> None:
    train = ["compensation", "train", "x"]
    methods = ([], ["--method", "tuned"], ["--method", "auto"])
    assert len({kind_of([*train, *method]) for method in methods}) == 3
    assert kind_of(train) == kind_of(["compensation", "train", "y", "--hidden", "4,2,2"])


def test_progress_is_told_in_steps_and_time() -> None:
    job = Job("k", "t", ("testbench", "experiment"))
    job.hear_error(json.dumps({"unit": "motion", "done": 7, "total": 13, "note": "imitating on long hold"}))
    words = progress_in_words(job)
    assert words.startswith("motion 7 of 13 · 0 s so far")
    assert words.endswith("imitating on long hold")


@pytest.mark.parametrize(("seconds", "words"), [(4, "a few seconds"), (38, "about 40 s"), (170, "about 3 min")])
def test_times_are_said_roughly(seconds: float, words: str) -> None:
    assert about_in_words(seconds) == words


def test_the_curve_says_where_it_came_from_and_where_it_is() -> None:
    svg = spark_line("misfit", [5.5, 4.5, 4.4])
    assert "misfit 5.50 → 4.40" in svg
    assert svg.count(",") >= 3

"""The loop ends where it should, goes on from wherever it was killed, and makes the same experiment again."""

from __future__ import annotations

import json
import shutil

import numpy as np
import pytest

from gcode.support.errors import UserError
from testbench.campaigns.plan import plan_of
from testbench.investigating import loop
from testbench.investigating.benches import SimulatedBench
from testbench.investigating.state import NAME, load_investigation, run_folder
from testbench.measurements.joining import joined
from testbench.measurements.preparing import prepare
from testbench.recordings.files import read_recording
from testbench.recordings.manifest import problems
from tests.testbench.builders import CATALOGUE
from tests.testbench.investigating.samples import SET, SLIP, asked, hidden, investigated, scripted_belief


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The folder of an investigation that was never cut, how it ended, and what was believed; nobody changes them."""
    folder = tmp_path_factory.mktemp("whole") / "i"
    with pytest.MonkeyPatch.context() as patch:
        return folder, *investigated(folder, patch, [0.6, 0.96])


@pytest.fixture(scope="module")
def _of_one_run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("one") / "i"
    with pytest.MonkeyPatch.context() as patch:
        return folder, investigated(folder, patch, [0.99])[0]


@pytest.fixture
def one_run(tmp_path, _of_one_run):
    """A copy of the folder of an investigation that was sure after one run, and how it ended."""
    folder, ended = _of_one_run
    return shutil.copytree(folder, tmp_path / "i"), ended


def test_it_ends_where_one_hypothesis_is_sure(whole):
    folder, ended, believing = whole
    assert ended.ended == loop.SURE
    assert [run.belief.top for run in ended.runs] == [(SET, 0.6), (SET, 0.96)]
    assert ended.spent_s == pytest.approx(sum(run.seconds for run in ended.runs))
    assert [runs for runs, _ in believing.asked] == [1, 2]
    assert ended.runs[0].expected_nats is None
    assert ended.runs[1].expected_nats >= ended.runs[1].perlin_nats >= 0
    assert load_investigation(folder) == ended
    for number in (1, 2):
        assert problems(run_folder(folder, number)) == []


def test_it_ends_where_the_time_is_spent(tmp_path, monkeypatch):
    ended, _ = investigated(tmp_path / "i", monkeypatch, [0.5, 0.5, 0.5, 0.5], motion="perlin")
    assert ended.ended == loop.SPENT
    assert len(ended.runs) == 3
    assert ended.spent_s <= 360
    assert all(run.expected_nats is None for run in ended.runs)


def test_where_one_model_alone_is_left_a_random_motion_goes_on(tmp_path, monkeypatch):
    believing = scripted_belief(monkeypatch, 0.6, 0.99)

    def of_one_model(*given):
        belief = believing(*given)
        return belief.model_copy(update={"likely": belief.likely[:1]})

    monkeypatch.setattr(loop, "belief_after", of_one_model)
    loop.begin(tmp_path / "i", asked(), "sample")
    ended = loop.proceed(tmp_path / "i", SimulatedBench(hidden()), CATALOGUE)
    assert ended.ended == loop.SURE
    assert [run.expected_nats for run in ended.runs] == [None, None]


def test_an_aged_specimen_remembers_and_a_fresh_one_does_not(tmp_path, monkeypatch, whole):
    folder, aged, seen = whole
    fresh, alone = investigated(tmp_path / "fresh", monkeypatch, [0.5, 0.99], specimen="fresh")
    assert len(plan_of(run_folder(folder, 2)).past) == 1
    assert len(plan_of(run_folder(tmp_path / "fresh", 2)).past) == 0
    assert aged.runs[1].rest_s == 5
    assert fresh.runs[1].rest_s is None
    assert [runs for runs, _ in seen.asked] == [1, 2]
    assert [runs for runs, _ in alone.asked] == [1, 1]
    # Of fresh specimens the evidence multiplies: what the first said counts as well.
    first, second = (run.belief for run in fresh.runs)
    assert second.own[SET] == 0.99
    odds = second.probabilities[SET] / second.probabilities[SLIP]
    assert odds == pytest.approx(first.own[SET] / first.own[SLIP] * second.own[SET] / second.own[SLIP])


def test_the_true_model_leaves_noise_over_all_runs_of_an_aged_specimen(whole):
    folder, _, believing = whole
    joint = believing.asked[-1][1]
    parts = [read_recording(run_folder(folder, k)) for k in (1, 2)]
    assert joint.counts.sum() == sum(prepare(one).counts.sum() for one in parts)
    together = joint.residual(hidden())
    second = prepare(parts[1])
    as_if_new = second.residual(hidden())
    n = len(second.counts)
    late = {c: np.std(values[-n:][second.counts]) for c, values in together.items()}
    wrong = {c: np.std(values[second.counts]) for c, values in as_if_new.items()}
    assert late["force"] < 0.01
    assert late["force"] < 0.3 * wrong["force"]
    assert len(joint.recording) == len(parts[0]) + len(parts[1])


def test_recordings_are_joined_over_their_rests(one_run):
    one = read_recording(run_folder(one_run[0], 1))
    alone, twice = joined([one], []), joined([one, one], [40.0])
    n, gap = len(alone.counts), round(40 / alone.dt_s)
    assert len(twice.counts) == 2 * n + gap
    assert not twice.counts[n : n + gap].any()
    for c in alone.channels:
        assert np.array_equal(twice.measured[c][-n:], alone.measured[c])
    assert np.allclose(np.diff(twice.signals["time_s"]), alone.dt_s)
    start_s = twice.recording.time_s[len(one)] - twice.recording.time_s[0]
    assert start_s == pytest.approx((n + gap) * alone.dt_s, abs=1e-6)


class Killed(Exception):
    """The process died here."""


class Dying(SimulatedBench):
    """Dies before or after the recording of one run."""

    at, when = 2, "before"

    def run(self, order, report, stopped=lambda: False):
        dies = order.folder.name == f"run-{self.at}"
        if dies and self.when == "before":
            raise Killed
        super().run(order, report, stopped)
        if dies:
            raise Killed


@pytest.mark.parametrize("when", ["before", "after"])
def test_killed_around_a_recording_it_goes_on_and_makes_the_same(tmp_path, monkeypatch, whole, when):
    bench = Dying(hidden())
    monkeypatch.setattr(Dying, "when", when)
    with pytest.raises(Killed):
        investigated(tmp_path / "cut", monkeypatch, [0.6], bench)
    left = load_investigation(tmp_path / "cut")
    assert [run.recorded for run in left.runs] == [True, False]
    made = (tmp_path / "cut" / "run-2" / "recording.csv").stat().st_mtime_ns if when == "after" else None
    again, _ = investigated(tmp_path / "cut", monkeypatch, [0.96], resume=True)
    assert same(again) == same(whole[1])
    for name in ("run-1", "run-2"):
        one, other = (folder / name / "recording.csv" for folder in (whole[0], tmp_path / "cut"))
        assert one.read_bytes() == other.read_bytes()
    if made is not None:
        assert (tmp_path / "cut" / "run-2" / "recording.csv").stat().st_mtime_ns == made


def test_killed_in_the_diagnosis_it_goes_on(tmp_path, monkeypatch, whole):

    def dies(*_args, **_kwargs):
        raise Killed

    loop.begin(tmp_path / "cut", asked(), "sample")
    monkeypatch.setattr(loop, "belief_after", dies)
    with pytest.raises(Killed):
        loop.proceed(tmp_path / "cut", SimulatedBench(hidden()), CATALOGUE)
    again, believing = investigated(tmp_path / "cut", monkeypatch, [0.6, 0.96], resume=True)
    assert len(believing.asked) == 2
    assert same(again) == same(whole[1])


def test_killed_in_a_design_it_designs_again(tmp_path, monkeypatch, whole):
    design = loop.best_motion

    def dies(*_args, **_kwargs):
        raise Killed

    monkeypatch.setattr(loop, "best_motion", dies)
    with pytest.raises(Killed):
        investigated(tmp_path / "cut", monkeypatch, [0.6])
    monkeypatch.setattr(loop, "best_motion", design)
    again, _ = investigated(tmp_path / "cut", monkeypatch, [0.96], resume=True)
    assert same(again) == same(whole[1])


def same(state) -> dict:
    """An investigation without the times of the clock."""
    data = state.model_dump(mode="json")
    return {**data, "runs": [{**run, "begun_s": None, "ended_s": None} for run in data["runs"]]}


def test_one_that_has_ended_is_not_run_again(one_run, monkeypatch):
    folder, ended = one_run
    again, believing = investigated(folder, monkeypatch, [], resume=True)
    assert again == ended
    assert believing.asked == []


def test_it_can_be_stopped_between_steps(tmp_path, monkeypatch):
    scripted_belief(monkeypatch, 0.5, 0.99)
    loop.begin(tmp_path / "i", asked(), "sample")
    asked_for = iter([False, False, False, True])
    watcher = loop.Watcher(stopped=lambda: next(asked_for))
    halted = loop.proceed(tmp_path / "i", SimulatedBench(hidden()), CATALOGUE, watcher=watcher)
    assert halted.ended == ""
    assert len(halted.runs) == 1


@pytest.mark.parametrize(
    ("change", "match"),
    [
        (lambda data: data.update(format="else"), "format"),
        (lambda data: data.update(extra=1), "extra"),
        (lambda data: data["settings"].update(sure=1.5), "sure"),
        (lambda data: data["settings"]["bounds"].update(v_max_mm_per_s=-1), "v_max_mm_per_s"),
        (lambda data: data["settings"]["bounds"].update(speed=1), "settings: bounds: allowed are .*; got speed"),
        (lambda data: data["runs"][0]["belief"]["noise"].update(sound=1), "got 'sound'"),
        (lambda data: data["runs"][0]["belief"]["probabilities"].pop("permanent_set"), "'permanent_set' has no prob"),
        (lambda data: data["runs"].insert(0, {"words": "x", "seconds": 1}), "only the last one"),
        (lambda data: data["runs"][0].update(recorded=False), "recorded before it is judged"),
        (lambda data: data["runs"][0]["belief"]["probabilities"].update(permanent_set=7), "permanent_set"),
        (lambda data: data["runs"][0].update(seconds="long"), "seconds"),
    ],
)
def test_a_damaged_state_is_refused_by_name(one_run, change, match):
    path = one_run[0] / NAME
    data = json.loads(path.read_text())
    change(data)
    path.write_text(json.dumps(data))
    with pytest.raises(UserError, match=match) as error:
        load_investigation(one_run[0])
    assert NAME in str(error.value)


def test_a_folder_that_is_taken_is_left_alone(tmp_path, one_run):
    with pytest.raises(UserError, match="`resume`"):
        loop.begin(one_run[0], asked(), "sample")
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "thesis.txt").write_text("mine")
    with pytest.raises(UserError, match="not empty"):
        loop.begin(tmp_path / "other", asked(), "sample")
    assert (tmp_path / "other" / "thesis.txt").read_text() == "mine"


@pytest.mark.parametrize(
    ("changes", "match"),
    [
        ({"budget_s": 60}, "1 min are less than one run of 2 min"),
        ({"budget_s": 1e6}, "are more than 200 runs of 2 min"),
        ({"bounds": {"duration_s": 10}}, "duration_s"),
        ({"bounds": {"duration_s": 120, "speed": 1}}, "bounds: allowed are v_max_mm_per_s, .*; got speed"),
    ],
)
def test_what_no_run_can_be_planned_within_is_refused(changes, match):
    with pytest.raises(UserError, match=match):
        asked(**changes)


class BreaksOff(SimulatedBench):
    """Its second run ends with Ctrl-C when it is asked for first."""

    asked: int = 0

    def run(self, order, report, stopped=lambda: False):
        type(self).asked += 1
        if self.asked == 2:
            raise KeyboardInterrupt
        super().run(order, report, stopped)


def test_the_rest_before_a_run_that_was_broken_off_ends_where_it_was_first_begun(tmp_path, monkeypatch):
    """Two days pass before it goes on: the specimen rested for the 30 s before, and the file can be read again."""
    times_s = iter([0.0, 100.0, 130.0, 2e5, 2e5 + 100])
    monkeypatch.setattr(loop, "now_s", lambda: 1e9 + next(times_s))
    bench = BreaksOff(hidden(), keeps_time=True)
    with pytest.raises(KeyboardInterrupt):
        investigated(tmp_path / "i", monkeypatch, [0.6], bench)
    ended, _ = investigated(tmp_path / "i", monkeypatch, [0.96], bench, resume=True)
    assert [run.rest_s for run in ended.runs] == [None, 30.0]
    assert load_investigation(tmp_path / "i") == ended


def test_an_investigation_goes_on_after_a_week(tmp_path, monkeypatch):
    times_s = iter([0.0, 100.0, 6e5, 6e5 + 100])
    monkeypatch.setattr(loop, "now_s", lambda: 1e9 + next(times_s))
    ended, _ = investigated(tmp_path / "i", monkeypatch, [0.6, 0.96], SimulatedBench(hidden(), keeps_time=True))
    assert ended.runs[1].rest_s == pytest.approx(6e5 - 100)
    assert load_investigation(tmp_path / "i") == ended

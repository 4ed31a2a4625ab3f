"""Data sets: every campaign once, whole, the same on any backend, resumed after a kill."""

from __future__ import annotations

import fcntl
import json
import os
import signal
import threading
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import testbench as tb
from gcode.support.errors import UserError
from testbench import cli
from testbench.campaigns.datasets import dataset
from testbench.campaigns.datasets.dataset import make, one_at_a_time
from testbench.campaigns.datasets.spec import read_spec
from testbench.campaigns.datasets.tasks import tasks_of, varied
from testbench.campaigns.remake import made_again
from testbench.knit.catalogue import baseline, load_catalogue
from testbench.knit.template import write_template
from testbench.recordings.files import read_recording
from testbench.recordings.manifest import problems
from tests.testbench.rig.devices import command, until
from tests.testbench.rig.rigs import program

SPEC = 'sensors = ["knit.json"]\nprograms = ["two_*.tap"]\nseeds = "1-{last}"\n'


def written(folder: Path, last: int = 3, more: str = "") -> Path:
    program(folder)
    (folder / "knit.json").write_text(json.dumps(baseline().to_dict()))
    path = folder / "set.toml"
    path.write_text(SPEC.format(last=last) + more)
    return path


def campaigns(out: Path) -> list[Path]:
    return sorted(path.parent for path in out.glob("*/datapackage.json"))


def tasks(folder: Path, **options):
    path = written(folder, **options)
    return tasks_of(read_spec(path), folder, folder / "out")


def test_a_task_is_made_once_and_again_when_a_byte_is_wrong(tmp_path):
    (task, *_) = tasks(tmp_path)
    (tmp_path / "out").mkdir()
    assert make(task)
    assert not make(task)
    path = task.folder / "recording.csv"
    good = path.read_bytes()
    path.write_bytes(good.replace(b"1", b"2", 1))
    assert make(task)
    assert path.read_bytes() == good


def test_the_command_makes_a_data_set_and_does_nothing_the_second_time(tmp_path, capsys):
    path, out = written(tmp_path), tmp_path / "out"
    words = ["dataset", str(path), "-o", str(out), "--workers", "1"]
    assert cli.main(words) == 0
    assert "3 made, 0 there already" in capsys.readouterr().out
    index = (out / "dataset.json").read_bytes()
    assert cli.main(words) == 0
    assert "0 made, 3 there already" in capsys.readouterr().out
    assert (out / "dataset.json").read_bytes() == index
    assert [entry["seed"] for entry in json.loads(index)["campaigns"]] == [1, 2, 3]
    assert all(problems(folder) == [] for folder in campaigns(out))
    assert cli.main(["verify", str(out)]) == 0
    assert capsys.readouterr().out.count(": intact") == 3
    (campaigns(out)[0] / "program.tap").write_text("M30\n")
    (campaigns(out)[1] / "datapackage.json").write_bytes((campaigns(out)[2] / "datapackage.json").read_bytes())
    campaigns(out)[2].joinpath("datapackage.json").unlink()
    assert cli.main(["verify", str(out)]) == 1
    err = capsys.readouterr().err
    assert "00001/program.tap: 4 bytes, the manifest says" in err
    assert "00002/datapackage.json: not the one that dataset.json lists" in err
    assert "00003: missing; run `testbench dataset` again" in err


def test_a_campaign_that_the_list_has_no_longer_is_named_and_looked_at(tmp_path, capsys):
    out = tmp_path / "out"
    for last in (2, 1):
        assert cli.main(["dataset", str(written(tmp_path, last)), "-o", str(out), "--workers", "1"]) == 0
    (campaigns(out)[1] / "program.tap").write_text("M30\n")
    assert cli.main(["verify", str(out)]) == 1
    err = capsys.readouterr().err
    assert "00002: dataset.json does not list it" in err
    assert "00002/program.tap: 4 bytes, the manifest says" in err


def test_a_folder_that_is_a_campaign_takes_no_data_set_and_is_looked_at_itself(tmp_path, capsys):
    path, out = written(tmp_path, 1), tmp_path / "out"
    assert cli.main(["dataset", str(path), "-o", str(out), "--workers", "1"]) == 0
    before = campaigns(out)[0]
    assert cli.main(["dataset", str(path), "-o", str(before), "--workers", "1"]) == 2
    assert "is a campaign itself" in capsys.readouterr().err
    (before / "dataset.json").write_text('{"format": "knitbench-dataset", "version": 1, "campaigns": []}')
    (before / "recording.csv").write_text("time_s,force_N\n")
    assert cli.main(["verify", str(before)]) == 1
    assert "recording.csv: 15 bytes, the manifest says" in capsys.readouterr().err


def test_a_trajectory_table_plans_its_programs(tmp_path):
    (tmp_path / "knit.json").write_text(json.dumps(baseline().to_dict()))
    path = tmp_path / "set.toml"
    path.write_text(
        'sensors=["knit.json"]\nseeds=[1]\n[trajectory]\npreset="paper-1"\nseeds="52-53"\nduration_s=60\n'
    )
    made = tasks_of(read_spec(path), tmp_path, tmp_path / "out")
    assert [task.program.name for task in made] == ["paper-1-00052.tap", "paper-1-00053.tap"]
    assert made[0].program.read_text() != made[1].program.read_text()


def test_varied_parameters_are_drawn_by_the_seed_and_end_in_the_manifest(tmp_path):
    made = tasks(tmp_path, more='[vary]\n"elasticity.stiffness_N" = [5.0, 9.0]\n')
    drawn = [task.model["effects"][0]["parameters"]["stiffness_N"] for task in made]
    assert len(set(drawn)) == 3
    assert all(5 <= value <= 9 for value in drawn)
    assert (
        varied(baseline(), {"elasticity.stiffness_N": (5, 9)}, made[1].specimen)["elasticity"].stiffness_N == drawn[1]
    )
    (tmp_path / "out").mkdir()
    make(made[0])
    assert read_recording(made[0].folder).metadata["recipe"]["model"] == made[0].model


def test_no_two_campaigns_share_noise_or_sampling_times_or_what_is_drawn(tmp_path):
    """Specimens of the same seed were read at the same times with the same noise, in training as in the test."""
    program(tmp_path)
    path = tmp_path / "set.toml"
    text = 'sensors = ["pes@1", "pes@2"]\nprograms = ["two_*.tap"]\nseeds = [1]\n[vary]\n'
    path.write_text(f'{text}"elasticity.stiffness_N" = [5.0, 9.0]\n')
    one, other = tasks_of(read_spec(path), tmp_path, tmp_path / "out")
    assert one.seed == other.seed
    assert one.model["effects"][0]["parameters"] != other.model["effects"][0]["parameters"]
    (tmp_path / "out").mkdir()
    assert make(one)
    assert make(other)
    first, second = (read_recording(task.folder).time_s[:50] for task in (one, other))
    assert not np.allclose(first, second)


def test_programs_on_the_same_sensor_know_what_came_before(tmp_path):
    path = written(tmp_path, last=1, more="same_sensor = true\nrest_s = 20\n")
    (tmp_path / "two_more.tap").write_text((tmp_path / "two_triangles.tap").read_text())
    first, second = tasks_of(read_spec(path), tmp_path, tmp_path / "out")
    assert first.past == ()
    assert second.past == (first.program,)
    (tmp_path / "out").mkdir()
    assert make(first)
    assert make(second)
    assert not make(second)
    assert made_again(second.folder).differences == ()
    assert (first.folder / "recording.csv").read_bytes() != (second.folder / "recording.csv").read_bytes()


def test_a_data_set_may_use_effects_of_ones_own(tmp_path):
    write_template("mine", tmp_path / "mine.py")
    path = written(tmp_path, last=1, more='effects = "mine.py"\n')
    model = baseline() + load_catalogue(tmp_path / "mine.py")["mine"]()
    (tmp_path / "knit.json").write_text(json.dumps(model.to_dict()))
    path.write_text(path.read_text().replace('["knit.json"]', '["knit.json", "pes"]'))
    with pytest.raises(UserError, match="needs effects of somebody's own"):
        tasks_of(read_spec(path), tmp_path, tmp_path / "out")
    task, without = tasks_of(read_spec(path), tmp_path, tmp_path / "out", tmp_path / "mine.py")
    assert without.effects is None  # a campaign of a sensor that uses none of them had a copy all the same
    (tmp_path / "out").mkdir()
    assert make(task)
    assert not make(task)
    assert made_again(task.folder, task.folder / "effects.py").differences == ()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("seeds = [", "not valid TOML"),
        ('sensors=["pes"]\nseeds="9-1"\nprograms=["*"]', "a range like \"1-500\", got '9-1'"),
        ('sensors=["pes"]\nseeds=[1]', r"give either programs or a table \[trajectory\]"),
        ('sensors=["pes"]\nseeds=[1]\nprograms=["a"]\nsead=2', "sead"),
        ('sensors=["wool"]\nseeds=[1]\nprograms=["two_*.tap"]', "no sensor preset called wool"),
        ('sensors=["pes"]\nseeds=[1]\nprograms=["nothing.tap"]', "no such program"),
        (
            'sensors=["pes"]\nseeds=[1]\nprograms=["two_*.tap"]\nvary={"elasticity.stiffness_N"=[9,5]}',
            r"elasticity.stiffness_N must be \[low, high\], finite and low first, got \[9, 5\]",
        ),
        (
            'sensors=["pes"]\nseeds=[1]\nprograms=["two_*.tap"]\nvary={"elasticity.stiffness_N"=[1e9,1e9]}',
            "vary, pes#1",
        ),
        ('sensors=["pes"]\nseeds=[1]\nprograms=["two_*.tap"]\nrest_s=60', "it needs same_sensor = true"),
        ('sensors=["pes"]\nseeds=[1,2,2]\nprograms=["two_*.tap"]', "2 campaigns would be called .*-00002; name each"),
        ('sensors=["pes"]\nseeds=[true]\nprograms=["two_*.tap"]', r"seeds.*integer"),
        ('sensors=["pes"]\nseeds=[1]\n[trajectory]\npreset="paper-9"\nseeds=[1]', "preset must be one of paper-1"),
    ],
)
def test_a_bad_spec_is_refused_before_anything_runs(tmp_path, text, message):
    path = written(tmp_path)
    path.write_text(text)
    with pytest.raises(UserError, match=message):
        tasks_of(read_spec(path), tmp_path, tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("name", ["_mine", ".mine", "a\nb", "long" * 50])
def test_a_sensor_whose_campaigns_others_would_pass_over_is_refused(tmp_path, name):
    """Pandas left _mine-... out of what it read, without a word; the list of campaigns could not be read again."""
    path = written(tmp_path)
    (tmp_path / "knit.json").rename(tmp_path / f"{name}.json")
    path.write_text(path.read_text().replace('"knit.json"', json.dumps(f"{name}.json")))
    with pytest.raises(UserError, match="which readers of Parquet pass over; rename that file"):
        tasks_of(read_spec(path), tmp_path, tmp_path / "out")


def test_a_data_set_that_fails_before_anything_is_made_leaves_no_folder(tmp_path):
    path, own = written(tmp_path), tmp_path / "mine.py"
    own.write_text("")
    with pytest.raises(UserError, match=r"effects: the spec names none, got .*mine\.py; name the file in the spec"):
        tb.dataset(path, tmp_path / "some" / "out", effects=own)
    assert not (tmp_path / "some").exists()
    (tmp_path / "out").mkdir()
    with pytest.raises(UserError, match="the spec names none"):
        tb.dataset(path, tmp_path / "out", effects=own)
    assert (tmp_path / "out").is_dir()


def test_a_second_command_in_the_same_folder_is_refused(tmp_path):
    with (
        one_at_a_time(tmp_path),
        pytest.raises(UserError, match="another `testbench dataset`"),
        one_at_a_time(tmp_path),
    ):
        pass


def test_drafts_of_killed_workers_are_cleared_away(tmp_path):
    (tmp_path / ".knit-1.abc" / "campaign").mkdir(parents=True)
    (tmp_path / ".knit-2.abc").mkdir()  # killed before its campaign was begun, or after it was moved into its place
    (tmp_path / ".mine.abc" / "notes").mkdir(parents=True)
    with one_at_a_time(tmp_path):
        assert [path.name for path in tmp_path.iterdir() if path.is_dir()] == [".mine.abc"]


def test_a_scheduler_that_is_not_there_is_said_in_a_sentence(tmp_path, capsys, monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr("testbench.campaigns.datasets.dataset.CONNECT_S", 1)
    words = ["dataset", str(written(tmp_path)), "-o", str(tmp_path / "out"), "--scheduler", "tcp://127.0.0.1:9"]
    assert cli.main(words) == 2
    assert "no Dask scheduler answers there" in capsys.readouterr().err


@pytest.mark.slow
def test_a_killed_data_set_is_resumed_and_nothing_is_redone(tmp_path):
    path, out = written(tmp_path, last=100), tmp_path / "out"
    words = ["dataset", str(path), "-o", str(out), "--workers", "2"]
    child = command(*words, start_new_session=True)
    until(lambda: len(campaigns(out)) > 20, child)
    os.killpg(child.pid, signal.SIGKILL)
    child.communicate()
    done = {folder: (folder / "recording.csv").stat().st_mtime_ns for folder in campaigns(out)}
    assert 20 < len(done) < 100
    assert all(problems(folder) == [] for folder in done)
    child = command(*words)
    out_text, err = child.communicate(timeout=600)
    assert f"{len(done)} there already" in out_text, err
    assert {folder: (folder / "recording.csv").stat().st_mtime_ns for folder in done} == done
    assert len(campaigns(out)) == 100
    assert not [path for path in out.iterdir() if path.name.startswith(".")]


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_a_dask_cluster_gives_the_same_bytes_though_a_worker_is_killed(tmp_path):
    distributed = pytest.importorskip("distributed")
    path = written(tmp_path, last=80)
    assert cli.main(["dataset", str(path), "-o", str(tmp_path / "here"), "--workers", "1"]) == 0
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as local:

        def kill_one():
            until(lambda: len(campaigns(tmp_path / "there")) > 20)
            os.kill(next(iter(local.workers.values())).pid, signal.SIGKILL)

        killer = threading.Thread(target=kill_one)
        killer.start()
        words = ["--scheduler", local.scheduler_address]
        assert cli.main(["dataset", str(path), "-o", str(tmp_path / "there"), *words]) == 0
        killer.join()
    for folder in campaigns(tmp_path / "here"):
        for file in folder.iterdir():
            assert file.read_bytes() == (tmp_path / "there" / folder.name / file.name).read_bytes()


@pytest.mark.parametrize("pattern", ["../../**/*.tap", "*/two_a.tap", "**", "/**/*.tap"])
def test_a_spec_cannot_have_the_whole_machine_looked_through(tmp_path, pattern):
    spec = SPEC.format(last=1).replace("knit.json", "pes").replace("two_*.tap", pattern)
    (tmp_path / "knits.toml").write_text(spec)
    with pytest.raises(UserError, match=r"a \* may stand in the name of a program"):
        tasks_of(read_spec(tmp_path / "knits.toml"), tmp_path, tmp_path / "out")


@pytest.mark.parametrize("pattern", ["", ".", "..", "a/" * 2000, "a" * 5000, "\\u0000.tap", "[", "?*"])
def test_a_pattern_that_names_no_program_is_a_sentence(tmp_path, capsys, pattern):
    spec = SPEC.format(last=1).replace("knit.json", "pes").replace("two_*.tap", pattern)
    (tmp_path / "knits.toml").write_text(spec)
    assert cli.main(["dataset", str(tmp_path / "knits.toml"), "-o", str(tmp_path / "out")]) == 2
    assert "testbench dataset: error: " in capsys.readouterr().err


def test_a_lock_that_was_taken_away_while_it_was_opened_holds_nobody_up_and_is_made_anew(tmp_path, monkeypatch):
    locked = []

    def flock(handle, how):
        if not locked:
            (tmp_path / ".lock").unlink()  # by the command before, which ends
        locked.append(handle)
        fcntl.flock(handle, how)

    monkeypatch.setattr(dataset, "fcntl", SimpleNamespace(**{**vars(fcntl), "flock": flock}))
    with (
        one_at_a_time(tmp_path),
        pytest.raises(UserError, match="another `testbench dataset` is at work"),
        one_at_a_time(tmp_path),
    ):
        pass
    assert len(locked) == 3

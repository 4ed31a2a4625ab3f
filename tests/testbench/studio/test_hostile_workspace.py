"""A workspace that a stranger packed: links, loops, pipes, deep and damaged manifests. It is listed, and no more."""

from __future__ import annotations

import asyncio
import os
import re
from pathlib import Path

import pytest

from gcode.support.errors import UserError
from testbench.campaigns.campaign import simulate_campaign
from testbench.campaigns.record import Job as JobOfARecording
from testbench.campaigns.record import begin
from testbench.cli import main
from testbench.rig.acquisition.recorder import Limits
from testbench.studio.jobs.job import Job
from testbench.studio.models import keep_diagnosis, step_diagnosis
from testbench.studio.pages.campaign_card import looked_at
from testbench.studio.parts.unfinished import resume
from testbench.studio.studio import KEY_RECORDING, Studio
from testbench.studio.workspace import Workspace
from tests.fuzz.targets import no_hang
from tests.testbench.rig.rigs import plan, program, triangle

MANIFEST = "datapackage.json"
BROKEN = {
    "deep": "[" * 100_000,
    "numbers": '{"knitbench": {"gauge_length_mm": 1e999, "recipe": {}}}',
    "digits": '{"knitbench": {"gauge_length_mm": ' + "9" * 5000 + ', "recipe": {}}}',
    "null": "null",
    "list": "[]",
    "strange": '{"knitbench": {"gauge_length_mm": {}, "recipe": [], "origin": [], "status": {}}}',
    "zeros": "\0" * 5000,
}


@pytest.fixture
def hostile(tmp_path) -> Path:
    """One good campaign among what is not."""
    root = tmp_path / "workspace"
    root.mkdir()
    simulate_campaign(plan(tmp_path), root / "good", triangle(2.0))
    for name, text in BROKEN.items():
        (root / name).mkdir()
        (root / name / MANIFEST).write_text(text)
    for name in ("pipe", "loop", "folder", "elsewhere", "gone"):
        (root / name).mkdir()
    (root / "gone" / MANIFEST).symlink_to(tmp_path / "nowhere.json")
    os.mkfifo(root / "pipe" / MANIFEST)
    (root / "folder" / MANIFEST).mkdir()
    (root / "loop" / MANIFEST).symlink_to(root / "loop" / MANIFEST)
    (root / "elsewhere" / MANIFEST).symlink_to("/dev/zero")
    (root / "round").symlink_to(root)
    (root / "a\nb\x1b[31m<script>").mkdir()
    (root / "a\nb\x1b[31m<script>" / MANIFEST).write_text("{}")
    return root


def test_everything_is_listed_and_the_good_one_is_good(hostile):
    with no_hang():
        found = {campaign.name: campaign for campaign in Workspace(hostile).campaigns()}
        assert set(BROKEN) | {"good", "pipe", "elsewhere", "gone", "loop", "folder"} <= set(found)
        assert found["good"].gauge_length_mm == 25.0
        assert Workspace(hostile).problems("good") == []


def test_what_is_broken_has_a_sentence(hostile):
    workspace = Workspace(hostile)
    with no_hang():
        for name in (*BROKEN, "a\nb\x1b[31m<script>"):
            assert workspace.problems(name), name
            with pytest.raises(UserError, match=r"not a (campaign manifest|knitbench campaign)|not text"):
                workspace.recording(name)


LINKS = {
    "gone": r"gone/datapackage.json \(a link to .*nowhere.json\): cannot read this campaign manifest: No such file",
    "loop": r"loop/datapackage.json \(a link to .*loop.*\): cannot read .* put the manifest itself there, or what",
    "elsewhere": r"elsewhere/datapackage.json \(a link to /dev/zero\): not a campaign manifest: it is .* a device",
    "folder": r"folder/datapackage.json: not a campaign manifest: it is a folder",
    "pipe": r"pipe/datapackage.json: not a campaign manifest: it is a folder, a pipe",
}


@pytest.mark.parametrize("name", LINKS)
def test_a_manifest_that_is_none_is_one_sentence_in_the_list_and_in_the_terminal(hostile, name, capsys):
    studio = Studio(hostile)
    (card,) = (campaign for campaign in studio.workspace.campaigns() if campaign.name == name)
    with no_hang():
        known = looked_at(studio, card)
        assert not known.good
        assert re.search(LINKS[name], known.why), known.why
        for command in (["verify"], ["fit", "-o", "x.json"], ["report", "-o", "x.html", "--recording"]):
            assert main([*command, str(hostile / name)]) == 2
            assert re.search(LINKS[name], capsys.readouterr().err)
        studio.deleted.add(name)
    assert name not in {campaign.name for campaign in studio.workspace.campaigns()}


def test_a_link_to_the_manifest_of_another_campaign_is_named_where_the_bytes_differ(hostile, capsys):
    (hostile / "borrowed").mkdir()
    (hostile / "borrowed" / "recording.csv").write_text("time_s,displacement_mm\n0,1\n1,2\n")
    (hostile / "borrowed" / MANIFEST).symlink_to(hostile / "good" / MANIFEST)
    told = Workspace(hostile).problems("borrowed")
    assert re.search(r"recording.csv: 31 bytes, the manifest \(a link to .*good/datapackage.json\) says", told[0])
    assert main(["verify", str(hostile / "borrowed")]) == 1
    assert "(a link to" in "".join(capsys.readouterr())


def test_what_may_not_be_read_is_one_sentence(hostile, monkeypatch, capsys):
    """As whoever may not: the tests may run as one who may everything."""
    real = os.open

    def refusing(path, *args, **kwargs):
        if str(path).endswith(MANIFEST):
            raise PermissionError(13, "Permission denied")
        return real(path, *args, **kwargs)

    monkeypatch.setattr("os.open", refusing)
    (told,) = Workspace(hostile).problems("good")
    assert told == f"{hostile / 'good' / MANIFEST}: cannot read this campaign manifest: Permission denied"
    assert main(["verify", str(hostile / "good")]) == 2
    assert told in capsys.readouterr().err


NO_CAMPAIGN = ("pipe", "elsewhere", "loop", "folder", "round", "../workspace", "/etc", "good/../..")


@pytest.mark.parametrize("name", NO_CAMPAIGN)
def test_what_is_no_campaign_cannot_be_opened(hostile, name):
    with no_hang(), pytest.raises((UserError, OSError)) as error:
        Workspace(hostile).recording(name)
    assert isinstance(error.value, UserError), error.value


def test_a_manifest_that_names_a_file_elsewhere_is_refused(hostile):
    secret = hostile.parent / "secret.csv"
    secret.write_text("time_s,displacement_mm\n0,1\n1,2\n")
    (hostile / "good" / "recording.csv").unlink()
    (hostile / "good" / "recording.csv").symlink_to(secret)
    workspace = Workspace(hostile)
    assert workspace.problems("good")
    with pytest.raises(UserError, match="31 bytes, the manifest says"):
        workspace.recording("good")


@pytest.fixture
def outside(tmp_path) -> Path:
    """A folder that is none of the workspace's, with a file that must stay."""
    place = tmp_path / "outside"
    place.mkdir()
    (place / "mine").write_text("mine")
    yield place
    assert {path.name: path.read_text() for path in place.iterdir()} == {"mine": "mine"}


@pytest.mark.parametrize("link", ["results", "results/running", "results/running/record"])
def test_a_studio_whose_results_are_elsewhere_does_not_begin(hostile, outside, link):
    (hostile / link).parent.mkdir(parents=True, exist_ok=True)
    (hostile / link).symlink_to(outside)
    with pytest.raises(UserError, match=r"a link leads to .*outside.*remove the link"):
        Studio(hostile)


@pytest.mark.parametrize("link", ["results/good", "results/deleted"])
def test_results_stay_in_the_workspace(hostile, outside, link):
    studio = Studio(hostile)
    (hostile / "results").mkdir(exist_ok=True)
    (hostile / link).symlink_to(outside)
    with pytest.raises(UserError, match=r"a link leads to .*outside.*remove the link"):
        studio.workspace.results("good") if link.endswith("good") else studio.deleted.add("good")


def linked(place: Path, outside: Path) -> None:
    place.parent.mkdir(parents=True, exist_ok=True)
    place.symlink_to(outside / "mine")


def test_what_was_run_is_not_written_through_a_link(hostile, outside):
    studio = Studio(hostile)
    linked(studio.commands_path("good"), outside)
    with pytest.raises(UserError, match=r"commands.txt: is not a plain file, and nothing is written to it"):
        studio._log(Job("diagnose:good", "a diagnosis", ("testbench", "diagnose", "good")))


def test_a_model_is_not_kept_through_a_link(hostile, outside):
    studio = Studio(hostile)
    linked(step_diagnosis(studio, "good", 1), outside)
    keep_diagnosis(studio, "good", {"verdict": "missing"}, [{"step": "baseline"}], "+ slack")
    assert not step_diagnosis(studio, "good", 1).is_symlink()
    assert '"led_to": "+ slack"' in step_diagnosis(studio, "good", 1).read_text()


@pytest.mark.asyncio
@pytest.mark.parametrize("name", ["alive", "said.jsonl", "errors.txt", "code", "job.json"])
async def test_a_job_that_may_outlive_the_studio_writes_through_no_link(hostile, outside, name):
    linked(hostile / "results" / "running" / "record" / name, outside)
    job = Studio(hostile).jobs.start(KEY_RECORDING, "Recording", ["testbench", "record", "-o", str(hostile / "new")])
    await asyncio.wait_for(job.task, 60)
    if name == "alive":
        assert "alive: is not a plain file, and nothing is written to it" in job.errors[-1]
    else:
        assert "a new recording needs --port and --program" in job.errors[-1]


def test_a_lock_that_is_none_is_no_living_job(hostile):
    running = hostile / "results" / "running"
    (running / "record" / "alive").mkdir(parents=True)
    (running / "rig").mkdir()
    os.mkfifo(running / "rig" / "alive")
    with no_hang():
        assert Studio(hostile).jobs.running() == []


@pytest.mark.parametrize("port", ["/dev/watchdog", "socket://192.0.2.1:80", "spy:///dev/ttyUSB0?file=x"])
def test_a_port_is_not_taken_from_a_stranger(tmp_path, port):
    """What the page shows is what the recorder is given: on the word of a manifest only what that may name."""
    (tmp_path / "workspace").mkdir()
    job = JobOfARecording(port, 115200, program(tmp_path), 25.0, Limits())
    begin(job, tmp_path / "workspace" / "left")
    studio = Studio(tmp_path / "workspace")
    with pytest.raises(UserError, match="left: name the port to record from"):
        resume(studio, studio.workspace.campaign("left"), "", lambda url: None)

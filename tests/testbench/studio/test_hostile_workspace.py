"""A workspace that a stranger packed: links, loops, pipes, deep and damaged manifests. It is listed, and no more."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from gcode.support.errors import UserError
from testbench.campaigns.campaign import simulate_campaign
from testbench.studio.workspace import Workspace
from tests.fuzz.targets import no_hang
from tests.testbench.rig.rigs import plan, triangle

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
    for name in ("pipe", "loop", "folder", "elsewhere"):
        (root / name).mkdir()
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
        assert set(BROKEN) | {"good", "pipe", "elsewhere"} <= set(found)
        assert found["good"].gauge_length_mm == 25.0
        assert Workspace(hostile).problems("good") == []


def test_what_is_broken_has_a_sentence(hostile):
    workspace = Workspace(hostile)
    with no_hang():
        for name in (*BROKEN, "a\nb\x1b[31m<script>"):
            assert workspace.problems(name), name
            with pytest.raises(UserError):
                workspace.recording(name)


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
    with pytest.raises(UserError):
        workspace.recording("good")


def test_results_stay_in_the_workspace(hostile):
    outside = hostile.parent / "outside"
    outside.mkdir()
    (hostile / "results").symlink_to(outside)
    with pytest.raises(UserError, match=r"a link leads to .*outside.*remove the link"):
        Workspace(hostile).results("good")
    assert list(outside.iterdir()) == []

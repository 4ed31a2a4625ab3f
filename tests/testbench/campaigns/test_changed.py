"""A campaign that was changed since it was written is refused by every command that reads one."""

from __future__ import annotations

import logging
import shutil
from pathlib import Path

import pytest

from compensation.cli import main as compensation
from compensation.series.reading import read_samples
from gcode.support.errors import UserError
from testbench.campaigns.campaign import simulate_campaign
from testbench.cli import main as run_testbench
from testbench.knit.catalogue import baseline
from testbench.recordings import doubts
from testbench.recordings.files import check_beside, read_recording
from testbench.results.model_file import ModelFile
from tests.testbench.rig.rigs import plan, triangle

OTHERS = "{good}/recording.csv --gauge-length-mm 25 --held-out"
READERS = {
    "fit": "{bad} -o {out}",
    "fit, held out": f"{OTHERS} {{bad}} -o {{out}}",
    "compare": "{bad} --model {model}",
    "diagnose": "{bad} --quiet",
    "diagnose, held out": f"{OTHERS} {{bad}} --quiet",
    "propose": "{bad} --quiet -o {out}.py",
    "add": "hysteresis --model {model} --fit {bad} -o {out}",
    "report": "--recording {bad} -o {out}",
    "report, held out": "--recording {good} --held-out {bad} -o {out}",
    "align": "{bad} -o {out}",
    "verify": "{bad}",
    "run": "--model {model} --program {good}/program.tap --after {bad} -o {out}",
    "compensation train": "{bad} --target force --hidden 1 --restarts 1 -o {out}",
}
CHANGES = {
    "the gauge length": ("datapackage.json", '"gauge_length_mm": 25.0', '"gauge_length_mm": 35.0'),
    "no checksums asked for": ("datapackage.json", '"status": "complete"', '"status": "recording"'),
    "a sample": ("recording.csv", "\n0.0", "\n0.1"),
}


@pytest.fixture(scope="module")
def good(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("good")
    simulate_campaign(plan(folder), folder / "c", triangle())
    ModelFile(baseline(), 25.0).save(folder / "model.json")
    return folder / "c"


def changed(good: Path, folder: Path, file: str, old: str, new: str) -> Path:
    shutil.copytree(good, folder / "changed")
    path = folder / "changed" / file
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    return folder / "changed"


@pytest.mark.parametrize("change", CHANGES)
@pytest.mark.parametrize("command", READERS)
def test_a_changed_campaign_is_refused(command, change, good, tmp_path, capsys):
    bad = changed(good, tmp_path, *CHANGES[change])
    words = READERS[command].format(bad=bad, good=good, out=tmp_path / "out", model=good.parent / "model.json")
    package, _, rest = command.partition(" ")
    main, name = (compensation, rest) if package == "compensation" else (run_testbench, command.partition(",")[0])
    past = "--after" in words and change == "a sample"  # a past is its program and its sensor, not what was recorded
    assert main([name, *words.split()]) == (0 if past else 1 if name == "verify" else 2)
    shown = capsys.readouterr()
    assert past or "changed since it was written" in shown.err or "checksum differs from the manifest" in shown.err
    assert past or not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    "command",
    ["align {bad} -o {out}", "run --sensor pes --program {bad}/program.tap -o {out}", "run --after {bad} {run}"],
)
def test_a_changed_program_in_a_campaign_is_refused(command, good, tmp_path, capsys):
    text = (good / "program.tap").read_text()
    bad = changed(good, tmp_path, "program.tap", text, text + "(another)\n")
    run = f"--sensor pes --program {good}/program.tap -o {tmp_path / 'out'}"
    assert run_testbench(command.format(bad=bad, out=tmp_path / "out", run=run).split()) == 2
    assert "program.tap" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_the_csv_of_a_campaign_is_held_against_the_manifest_beside_it(good, tmp_path):
    """A path to the file itself is no way round the checksum."""
    bad = changed(good, tmp_path, *CHANGES["a sample"])
    with pytest.raises(UserError, match="checksum differs from the manifest"):
        read_recording(bad / "recording.csv", 25.0)
    for place in (bad, bad / "recording.csv"):
        with pytest.raises(UserError, match="checksum differs from the manifest"):
            read_samples(place)
    assert len(read_recording(good / "recording.csv", 25.0)) > 10


def test_the_csv_of_a_campaign_knows_its_gauge_length(good):
    inside, whole = read_recording(good / "recording.csv"), read_recording(good)
    assert inside.gauge_length_mm == whole.gauge_length_mm
    assert inside.metadata == whole.metadata


@pytest.mark.parametrize("length", [True, "25"])
def test_a_gauge_length_is_a_number(good, tmp_path, length):
    shutil.copyfile(good / "recording.csv", tmp_path / "bare.csv")
    with pytest.raises(UserError, match="the gauge length must be a number of mm"):
        read_recording(tmp_path / "bare.csv", length)


def test_a_file_that_no_manifest_lists_is_read_and_this_is_said(good, tmp_path, caplog, monkeypatch):
    monkeypatch.setattr(doubts, "_SAID", set())
    shutil.copytree(good, tmp_path / "c")
    (tmp_path / "c" / "mine.tap").write_text("mine")
    with caplog.at_level(logging.WARNING):
        check_beside(tmp_path / "c" / "mine.tap")
    assert "mine.tap: the manifest beside it has no checksum of it, so it is read unverified" in caplog.text


def test_a_data_package_of_somebody_else_says_nothing_of_our_files(tmp_path, caplog):
    (tmp_path / "datapackage.json").write_text('{"resources": []}')
    check_beside(tmp_path / "mine.csv")
    assert not caplog.text

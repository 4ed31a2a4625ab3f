"""A folder that came from a stranger: nothing in it writes outside of it, and nothing in it runs unasked."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

from gcode.support.errors import UserError
from testbench import cli
from testbench.api.experiments.investigating import investigate
from testbench.campaigns.campaign import simulate_campaign
from testbench.campaigns.record import Job, begin, check_as_begun, job_of
from testbench.knit.catalogue import baseline
from testbench.recordings.files import read_recording
from testbench.recordings.manifest import problems, read_manifest, sealed
from testbench.rig.acquisition.recorder import Limits
from testbench.rig.connection.ports import stated_port
from testbench.rig.simulation.played import played
from testbench.trust import is_trusted, trust
from tests.testbench.rig.rigs import plan, program

EVIL_EFFECTS = "from pathlib import Path\nPath({mark!r}).write_text('ran')\n"


def changed(folder: Path, **change) -> None:
    """Change entries of the manifest as somebody would who knows how its checksum is made."""
    path = folder / "datapackage.json"
    data = json.loads(path.read_text())
    for name, value in change.items():
        place = data["knitbench"]["recipe"] if name in data["knitbench"]["recipe"] else data["knitbench"]
        place[name] = value
    path.write_text(sealed(data))


@pytest.fixture
def recorded(tmp_path):
    job = Job("/dev/ttyUSB0", 115200, program(tmp_path), 25.0, Limits())
    begin(job, tmp_path / "c")
    return tmp_path / "c"


@pytest.mark.parametrize(
    "port",
    [
        "spy:///dev/null?file={victim}",
        "spy://loop://?file={victim}",
        "alt:///dev/ttyUSB0?class=PosixPollSerial",
        "hwgrep://.*",
        "loop://",
        "socket://192.0.2.1:80",
        "socket://example.org:80",
        "rfc2217://192.0.2.1:80",
        "socket://127.0.0.1:80/?logging=debug",
        "socket://user@127.0.0.1:80",
        "socket://127.0.0.1",
        "socket://[::1",
        "{victim}",
        "../victim.txt",
        "/dev/../{victim}",
        "/dev/watchdog",
        "/dev/ptmx",
        "/dev/mem",
        "/dev/shm/x",
        "/dev/fd/1",
        "/dev/ttyS0\0",
        "",
    ],
)
def test_a_manifest_cannot_name_a_port_that_writes_or_calls_out(recorded, tmp_path, capsys, port):
    victim = tmp_path / "victim.txt"
    victim.write_text("precious")
    changed(recorded, port=port.format(victim=victim))
    assert cli.main(["record", "--resume", "-o", str(recorded)]) == 2
    err = capsys.readouterr().err
    assert "datapackage.json: " in err
    assert any(words in err for words in ("is not opened on the word of a file", "port: ", "a control character"))
    assert victim.read_text() == "precious"


@pytest.mark.parametrize("port", ["/dev/ttyUSB7", "/dev/ttyACM0", "/dev/cu.usb-1410", "/dev/rfcomm0", "/dev/pts/999"])
def test_a_serial_device_may_be_remembered_while_it_is_away(recorded, port):
    changed(recorded, port=port)
    assert job_of(recorded).port == port


@pytest.mark.parametrize("port", ["socket://127.0.0.1:4000", "rfc2217://localhost:4000", "socket://[::1]:4000"])
def test_an_address_of_this_machine_may_be_remembered(recorded, port):
    changed(recorded, port=port)
    assert job_of(recorded).port == port


def test_a_port_on_the_command_line_may_be_anywhere_but_is_still_a_port(recorded):
    assert job_of(recorded, "socket://192.0.2.1:4000").port == "socket://192.0.2.1:4000"
    assert job_of(recorded).port == "/dev/ttyUSB0"
    with pytest.raises(UserError, match=r"this kind of port is not opened; allowed is a device"):
        stated_port("spy:///dev/ttyUSB0?file=/tmp/x")


@pytest.mark.parametrize("name", ["recording.csv", "events.jsonl", "recording.bad"])
@pytest.mark.parametrize("how", [os.symlink, os.link])
def test_a_linked_file_is_not_written_through(recorded, tmp_path, capsys, name, how):
    victim = tmp_path / "victim.txt"
    victim.write_text("precious, without a line feed at its end")
    (recorded / name).unlink(missing_ok=True)
    how(victim, recorded / name)
    # A port that is there: the recorder comes as far as its files.
    master, slave = os.openpty()
    assert cli.main(["record", "--resume", "-o", str(recorded), "--port", os.ttyname(slave)]) == 2
    os.close(master)
    os.close(slave)
    assert "nothing is written to it" in capsys.readouterr().err
    assert victim.read_text() == "precious, without a line feed at its end"


@pytest.mark.parametrize("path", ["../victim.txt", "/etc/hostname", "a/b", "..", ".", "", "a\\b", "a\0b"])
def test_a_manifest_lists_only_files_beside_it(tmp_path, path):
    simulate_campaign(plan(tmp_path), tmp_path / "c", played(program(tmp_path), 25.0)[0])
    data = json.loads((tmp_path / "c" / "datapackage.json").read_text())
    data["resources"][0]["path"] = path
    (tmp_path / "c" / "datapackage.json").write_text(sealed(data))
    with pytest.raises(UserError, match=r"resources\.0\.path|a control character"):
        read_manifest(tmp_path / "c")


def test_a_list_of_campaigns_names_only_folders_beside_it(tmp_path, capsys):
    entry = {"campaign": "../..", "sensor": "", "program": "", "seed": 1, "samples": 1, "manifest_sha256": "0" * 64}
    index = {"format": "knitbench-dataset", "version": 1, "campaigns": [entry]}
    (tmp_path / "dataset.json").write_text(json.dumps(index))
    assert cli.main(["verify", str(tmp_path)]) == 2
    assert "campaigns.0.campaign" in capsys.readouterr().err


@pytest.mark.parametrize("change", [{"gauge_length_mm": 35.0}, {"status": "recording"}, {"origin": "imported"}])
def test_a_manifest_that_was_edited_is_not_used(tmp_path, change):
    simulate_campaign(plan(tmp_path), tmp_path / "c", played(program(tmp_path), 25.0)[0])
    path = tmp_path / "c" / "datapackage.json"
    data = json.loads(path.read_text())
    data["knitbench"] |= change
    path.write_text(json.dumps(data, indent=2) + "\n")
    with pytest.raises(UserError, match=r"datapackage\.json"):
        read_recording(tmp_path / "c")


def test_a_manifest_that_leaves_the_recording_out_does_not_switch_its_checksum_off(tmp_path):
    simulate_campaign(plan(tmp_path), tmp_path / "c", played(program(tmp_path), 25.0)[0])
    data = json.loads((tmp_path / "c" / "datapackage.json").read_text())
    data["resources"] = [entry for entry in data["resources"] if entry["path"] != "recording.csv"]
    (tmp_path / "c" / "datapackage.json").write_text(sealed(data))
    assert any("does not list recording.csv" in line for line in problems(tmp_path / "c"))
    with pytest.raises(UserError, match=r"does not list recording\.csv"):
        read_recording(tmp_path / "c")


def test_an_investigation_writes_through_no_link(tmp_path):
    """A plan that leads elsewhere had its program written there."""
    folder, elsewhere = tmp_path / "i", tmp_path / "elsewhere"
    folder.mkdir()
    elsewhere.mkdir()
    settings = {"bounds": {"duration_s": 120}, "budget_s": 600}
    (folder / "investigation.json").write_text(json.dumps({"settings": settings}))
    (folder / "sensor.json").write_text(json.dumps(baseline().to_dict()))
    (folder / "plan-1").symlink_to(elsewhere)
    with pytest.raises(UserError, match="plan-1: is a link"):
        investigate(folder=folder, resume=True, progress=False)
    assert not list(elsewhere.iterdir())


def test_an_unfinished_recording_says_that_it_is_read_unverified(tmp_path, caplog):
    simulate_campaign(plan(tmp_path), tmp_path / "c", played(program(tmp_path), 25.0)[0])
    changed(tmp_path / "c", status="recording")
    assert len(read_recording(tmp_path / "c")) > 100
    read_recording(tmp_path / "c")
    said = [record.getMessage() for record in caplog.records]
    assert said == [
        f"{tmp_path / 'c'}: this recording is unfinished, so it has no checksum yet and is read unverified"
    ]


def test_a_data_set_does_not_run_the_program_that_it_names(tmp_path, capsys):
    mark = tmp_path / "ran.txt"
    (tmp_path / "fx.py").write_text(EVIL_EFFECTS.format(mark=str(mark)))
    program(tmp_path)
    spec = tmp_path / "set.toml"
    spec.write_text('sensors = ["pes"]\nseeds = [1]\nprograms = ["two_*.tap"]\neffects = "fx.py"\n')
    words = ["dataset", str(spec), "-o", str(tmp_path / "out")]
    assert cli.main(words) == 2
    assert f"if you trust it, give --effects {tmp_path / 'fx.py'}" in capsys.readouterr().err
    other = tmp_path / "other.py"
    other.write_text("pass\n")
    assert cli.main([*words, "--effects", str(other)]) == 2
    assert not mark.exists()
    assert cli.main([*words, "--effects", str(tmp_path / "fx.py")]) == 2  # loaded now: it holds no effect
    assert mark.read_text() == "ran"


def test_planned_programs_are_not_written_through_a_link(tmp_path, capsys):
    elsewhere, out = tmp_path / "elsewhere", tmp_path / "out"
    elsewhere.mkdir()
    out.mkdir()
    (out / "programs").symlink_to(elsewhere)
    spec = tmp_path / "set.toml"
    spec.write_text('sensors=["pes"]\nseeds=[1]\n[trajectory]\npreset="paper-1"\nseeds=[51]\nduration_s=60\n')
    assert cli.main(["dataset", str(spec), "-o", str(out)]) == 2
    assert "nothing is written through it" in capsys.readouterr().err
    assert not any(elsewhere.iterdir())


def test_consent_is_to_the_bytes_and_lives_with_the_user(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    folder = tmp_path / "a stranger's"
    folder.mkdir()
    path = folder / "effects.py"
    path.write_text("x = 1\n")
    assert not is_trusted(path)
    trust(path)
    assert is_trusted(path)
    assert [one.name for one in folder.iterdir()] == ["effects.py"]
    path.write_text("x = 2\n")
    assert not is_trusted(path)
    assert not is_trusted(folder / "missing.py")


@pytest.mark.parametrize("said", [["--max-force-n", "5"], ["--max-strain", "0.2"], ["--baud", "9600"]])
def test_a_limit_that_would_not_hold_is_not_taken_in_silence(recorded, capsys, said):
    assert cli.main(["record", "--resume", "-o", str(recorded), *said]) == 2
    assert "this recording goes on as it began, with" in capsys.readouterr().err


def test_what_is_said_once_more_as_it_was_is_no_contradiction(recorded):
    check_as_begun(recorded, {"baud": 115200, "gauge_length_mm": 25.0}, str(recorded / "program.tap"))
    (recorded / "other.tap").write_text("G90\n")
    with pytest.raises(UserError, match="program: this recording goes on as it began"):
        check_as_begun(recorded, {}, str(recorded / "other.tap"))


def test_a_relative_port_is_remembered_by_a_path_that_holds_in_any_folder(tmp_path, monkeypatch):
    """`--resume` from another folder did not open a link that was named from the folder of the first run."""
    monkeypatch.chdir(tmp_path)
    assert stated_port("lnk") == str(tmp_path / "lnk")

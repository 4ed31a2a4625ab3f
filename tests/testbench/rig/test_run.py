"""``testbench run`` and the clocks that are handed in."""

from __future__ import annotations

import json

import pytest

from gcode.support.errors import UserError
from testbench import cli
from testbench.campaigns.campaign import simulate_campaign, simulate_live
from testbench.campaigns.plan import plan_of
from testbench.knit.catalogue import baseline
from testbench.recordings.files import read_recording
from testbench.recordings.manifest import problems
from testbench.rig.connection.parts import in_memory, paced
from testbench.rig.protocol.wire import decode
from testbench.rig.simulation.played import played
from tests.testbench.rig.rigs import plan, program, rig


class Clock:
    """A clock that moves only when somebody sleeps."""

    now_s = 100.0

    def __call__(self) -> float:
        return self.now_s

    def sleep(self, seconds: float) -> None:
        self.now_s += seconds


@pytest.fixture
def words(tmp_path):
    (tmp_path / "knit.json").write_text(json.dumps(baseline().to_dict()))
    return ["run", "--model", str(tmp_path / "knit.json"), "--program", str(program(tmp_path)), "--seed", "5"]


@pytest.mark.parametrize("speed", [1.0, 20.0])
def test_lines_come_when_their_device_time_has_come(speed):
    clock, lines, came = Clock(), list(rig(duration_s=5.0).lines()), []
    first = decode(lines[0].rstrip()).micros
    for line in paced(lines, speed, clock, clock.sleep):
        came.append(line)
        due_s = (decode(line.rstrip()).micros - first) % 2**32 / 1e6 / speed
        assert clock.now_s - 100.0 == pytest.approx(due_s, abs=1e-9)
    assert came == lines


def test_a_run_in_its_place_gives_the_same_bytes_and_can_be_read_meanwhile(tmp_path):
    wish = plan(tmp_path)
    motion, _ = played(wish.program)
    simulate_campaign(wish, tmp_path / "a", motion)
    seen = []

    def pace(lines):
        for part in in_memory(lines, size=20):
            yield part
            seen.append(len(read_recording(tmp_path / "b")) if (tmp_path / "b" / "recording.csv").exists() else 0)

    simulate_live(wish, tmp_path / "b", motion, pace=pace)
    assert seen == sorted(seen)
    assert 0 < seen[0] < seen[-1]
    for path in (tmp_path / "a").iterdir():
        assert path.read_bytes() == (tmp_path / "b" / path.name).read_bytes()


def test_a_run_is_not_repeated_and_not_overwritten_unasked(words, tmp_path, capsys):
    out = ["-o", str(tmp_path / "c")]
    assert cli.main(words + out) == 0
    assert "seed 5" in capsys.readouterr().out
    assert cli.main(words + out) == 0
    assert "not run again" in capsys.readouterr().out
    assert cli.main([*words, "--divider-ohm", "1000", *out]) == 2
    assert "--overwrite" in capsys.readouterr().err
    assert cli.main([*words, "--divider-ohm", "1000", "--overwrite", *out]) == 0
    recipe = read_recording(tmp_path / "c").metadata["recipe"]
    assert recipe["instruments"]["divider"]["reference_ohm"] == 1000


@pytest.mark.parametrize(("reference_ohm", "told"), [("1", True), ("1e12", True), ("606000", False), ("1e7", False)])
def test_a_divider_that_does_not_suit_the_sensor_is_told(tmp_path, capsys, reference_ohm, told):
    out = ["--program", str(program(tmp_path)), "-o", str(tmp_path / "c"), "--divider-ohm", reference_ohm]
    assert cli.main(["run", "--sensor", "pes", *out]) == 0
    assert ("in steps of" in capsys.readouterr().out) == told


def test_a_thermometer_is_recorded_and_the_knit_feels_the_room(words, tmp_path):
    assert cli.main([*words, "-o", str(tmp_path / "still")]) == 0
    assert cli.main([*words, "--room-swing-c", "3", "-o", str(tmp_path / "room")]) == 0
    still, room = read_recording(tmp_path / "still"), read_recording(tmp_path / "room")
    assert not still.has("temperature_C")
    assert (abs(room["temperature_C"] - 21) <= 3.04).all()
    # The baseline knows no temperature: nothing else may change, noise included.
    assert (room["force_N"] == still["force_N"]).all()


def test_progress_as_json_ends_with_the_outcome(words, tmp_path, capsys):
    assert cli.main([*words, "--progress-json", "-o", str(tmp_path / "c")]) == 0
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert lines[-1]["state"] == "complete"
    assert lines[-1]["samples"] == len(read_recording(tmp_path / "c"))


def test_verify_says_what_differs_and_exits_with_1(words, tmp_path, capsys):
    assert cli.main([*words, "-o", str(tmp_path / "c")]) == 0
    assert cli.main(["verify", "--again", str(tmp_path / "c")]) == 0
    assert "made again byte for byte" in capsys.readouterr().out
    path = tmp_path / "c" / "recording.csv"
    path.write_bytes(path.read_bytes() + b" ")
    assert cli.main(["verify", str(tmp_path / "c")]) == 1
    assert "recording.csv" in capsys.readouterr().err
    assert cli.main(["verify", str(tmp_path)]) == 2


@pytest.mark.parametrize(
    ("text", "message"),
    [("M30\n", "no move"), ("G1 X5\nM30\n", "feed"), ("hello\n", "line 1"), (None, "no such program")],
)
def test_a_program_that_cannot_be_played_is_refused(words, tmp_path, capsys, text, message):
    path = tmp_path / "two_triangles.tap"
    path.unlink() if text is None else path.write_text(text)
    assert cli.main([*words, "-o", str(tmp_path / "c")]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert "two_triangles.tap" in error
    assert not (tmp_path / "c").exists()


def test_a_run_that_ended_early_is_neither_made_again_nor_continued(tmp_path):
    wish = plan(tmp_path)
    motion, _ = played(wish.program)
    simulate_live(wish, tmp_path / "b", motion, stopped=lambda: True)
    assert problems(tmp_path / "b") == []
    with pytest.raises(UserError, match=r"ended early \(interrupted\); only a complete campaign"):
        plan_of(tmp_path / "b")


def test_a_run_that_was_killed_says_to_run_it_again(tmp_path):
    wish = plan(tmp_path)

    def killed(lines):
        yield next(iter(in_memory(lines)))
        raise MemoryError("as good as any crash")

    with pytest.raises(MemoryError):
        simulate_live(wish, tmp_path / "b", played(wish.program)[0], pace=killed)
    assert problems(tmp_path / "b") == [f"{tmp_path / 'b'}: unfinished; run it again, and overwrite it"]
    with pytest.raises(UserError, match="is unfinished; only a complete campaign"):
        plan_of(tmp_path / "b")

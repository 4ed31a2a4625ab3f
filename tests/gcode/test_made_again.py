"""Programs that somebody changed, by accident or with a purpose, are refused; what was made well passes."""

from __future__ import annotations

import re

import numpy as np
import pytest

import gcode
from gcode.cli import main
from gcode.mach4.controller import Machine
from gcode.mach4.header import seal_problem, sealed
from gcode.programs.made_again import check_file
from gcode.programs.make import make
from gcode.trajectories.bounds import Limits
from gcode.trajectories.designed import Hold, Ramp, ReturnToZero
from gcode.trajectories.natural import Noise
from gcode.trajectories.presets import preset
from gcode.trajectories.trajectory import TrajectorySpec

LIMITS = Limits(v_max_mm_per_s=5, a_max_mm_per_s2=20, x_min_mm=-1, x_max_mm=10)


def short_spec(**more) -> TrajectorySpec:
    noise = preset("paper-1").pieces[0].model_copy(update={"duration_s": 60.0, "target": None})
    return preset("paper-1").model_copy(update={"pieces": (noise,), **more})


TEXT = make(short_spec(), 51, 25.0).program
MOVES = [number for number, line in enumerate(TEXT.split("\n")) if line.startswith("G1 ")]


def found(text: str, limits: Limits = LIMITS, **more) -> list[str]:
    return [str(problem) for problem in check_file(text, limits, **more)[0].problems]


def lines_changed(change) -> str:
    lines = TEXT.split("\n")
    change(lines)
    return "\n".join(lines)


def resealed(text: str) -> str:
    """As a forger does it."""
    return sealed("\n".join(line for line in text.split("\n") if not line.startswith("(SHA256: ")))


def test_our_own_program_is_made_again_from_its_recipe():
    result, origin = check_file(TEXT, LIMITS)
    assert result.ok
    assert origin.genuine
    assert seal_problem(TEXT) == ""


def test_line_ends_do_not_count_nor_does_a_lost_seal():
    assert check_file(TEXT.replace("\n", "\r\n"), LIMITS)[1].genuine
    without = "\n".join(line for line in TEXT.split("\n") if not line.startswith("(SHA256: "))
    result, origin = check_file(without, LIMITS)
    assert result.ok
    assert "without a seal" in origin.words


@pytest.mark.parametrize(
    ("case", "why"), [(str, "was changed since it was written"), (str.lower, "its header has no SHA256")]
)
def test_a_program_that_lost_its_recipe_is_held_to_its_seal(case, why):
    lines = TEXT.split("\n")
    off_by_a_millimetre(lines)
    without = case("\n".join(line for line in lines if not line.startswith("(SPEC.")))
    assert why in found(without)[0]


def swap(lines):
    lines[MOVES[40]], lines[MOVES[41]] = lines[MOVES[41]], lines[MOVES[40]]


def delete(lines):
    del lines[MOVES[40]]


def off_by_a_millimetre(lines):
    number = MOVES[40]
    x = float(re.search(r"X([\d.]+)", lines[number])[1])
    lines[number] = re.sub(r"X[\d.]+", f"X{x + 0.01:.4f}", lines[number])


def end_half_way(lines):
    lines[MOVES[40]] = "M30"
    del lines[MOVES[41] :]


def shifted(lines):
    for number in MOVES:
        lines[number] = re.sub(r"X(-?[\d.]+)", lambda found: f"X{float(found[1]) + 1:.4f}", lines[number])


def other_feed_mode(lines):
    lines[lines.index("G94")] = "G93"


def slower(lines):
    lines[MOVES[40]] = re.sub(r"F[\d.]+", "F0.0100", lines[MOVES[40]])


ATTACKS = [swap, delete, off_by_a_millimetre, end_half_way, shifted, other_feed_mode, slower]


@pytest.mark.parametrize("attack", ATTACKS, ids=lambda attack: attack.__name__)
def test_a_changed_program_of_ours_is_refused(attack):
    text = lines_changed(attack)
    assert text != TEXT
    assert "agree with the SHA256" in seal_problem(text)
    assert any("not what the recipe in its header gives" in line or "never" in line for line in found(text))
    # Whoever forges the seal does not get past the recipe.
    assert any("not what the recipe in its header gives" in line for line in found(resealed(text)))


def test_a_recipe_that_was_changed_with_its_program_left_alone_is_refused():
    assert any("not what the recipe" in line for line in found(TEXT.replace("(SEED: 51)", "(SEED: 52)")))
    nonsense = TEXT.replace("(SPEC.RATE_HZ: 20.0)", "(SPEC.RATE_HZ: -1.0)")
    assert any("cannot be made again" in line for line in found(nonsense))
    endless = re.sub(r"DURATION_S: [\d.]+", "DURATION_S: 1e300", TEXT)
    assert any("cannot be made again (program: not a usable recipe" in line for line in found(endless))
    long = re.sub(r"DURATION_S: [\d.]+", "DURATION_S: 172800", TEXT.replace("RATE_HZ: 20.0", "RATE_HZ: 1000.0"))
    assert any("cannot be made again (a trajectory may have 20000000 samples" in line for line in found(long))


def test_a_file_may_not_say_what_the_controller_is():
    """A slow controller smooths what a program asks for; the file's own word for it counts for nothing."""
    brisk = "G90 G21 G94 G64\n" + "".join(f"G1 X{x} F290\n" for x in (3, 0) * 5) + "M30\n"
    assert any("acceleration" in line for line in found(brisk))
    assert found("(MACHINE_ACCELERATION_MM_PER_S2: 2.0)\n(RATE_HZ: 20.0)\n" + brisk) != []
    hint = "the file was written for 2: if yours is set so, give its `acceleration_mm_per_s2`)"
    assert any(hint in line for line in found("(MACHINE_ACCELERATION_MM_PER_S2: 2.0)\n" + brisk))


def test_a_program_for_another_controller_says_how_to_be_judged():
    text = make(short_spec(machine_acceleration_mm_per_s2=20.0), 51, 25.0).program
    assert found(text, machine=Machine(acceleration_mm_per_s2=20.0)) == []


def test_dwells_of_ours_may_be_long_and_those_of_a_stranger_with_our_header_may_not():
    spec = TrajectorySpec.of(
        Ramp(to_percent=10, speed_mm_per_s=1.0) + Hold(duration_s=600) + ReturnToZero(), name="long"
    )
    text = make(spec, 1, 25.0).program
    assert found(text) == []
    strange = "(RATE_HZ: 20.0)\nG90 G21 G94\nG1 X1 F6\nG4 P600.0\nG1 X0 F6\nM30\n"
    assert any("is this milliseconds?" in line for line in found(strange))
    assert found(strange.replace("600.0", "100.0")) == []


START = "G90 G21 G94 G64\n"


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (START + "G1 X1 F0.0000002\nG1 X0 F60\nM30\n", "line 1: not executed, since it would take 9.51 years"),
        (START + "G1 X1 F60\nG4 P100.0\n" + "G1 X0 F0.00005\nM30\n", "not executed, since it would take"),
        (START + "G1 X1 F60\nG55\nG1 X0 F60\nM30\n", "line 3: G55 moves the origin in mid-program"),
        (START + "G1 X1 F60\nG54\nG1 X0 F60\nM30\n", "line 3: G54 moves the origin in mid-program"),
        ("G90 G94\nG1 X1 F60\nG1 X0 F60\nM30\n", "line 2: moves before G20 or G21 is said"),
        ("G21 G94\nG1 X1 F60\nG1 X0 F60\nM30\n", "line 2: moves before G90 or G91 is said"),
        ("G21 G90\nG1 X1 F60\nG1 X0 F60\nM30\n", "line 2: moves before G93 or G94 is said"),
        (START + "G1 X1 F60\nM30\nG1 X0 F60\nM30\n", "line 4: follows the program's end"),
        (START + "G1 X1 F60\n(STEPS 99)\nM2\nX9\n", "line 5: follows the program's end"),
        (START + "G1 X1" + "0" * 200 + " F60\nM30\n", "beyond any machine"),
        (START + "G1 X1 F1" + "0" * 200 + "\nM30\n", "beyond any machine"),
        (START + "G1 X1 F60\nG4 P1" + "0" * 200 + "\nM30\n", "beyond any machine"),
    ],
)
def test_what_a_program_leaves_open_is_refused(text, reason):
    assert any(reason in line for line in found(text)), found(text)


@pytest.mark.parametrize("text", ["G55\n" + START + "G1 X1 F6\nG1 X0 F6\nM30\n%\n(bye)\n\n"])
def test_another_origin_from_the_start_and_a_quiet_end_are_fine(text):
    assert found(text) == []


@pytest.mark.parametrize("option", ["--max-dwell-s", "--rate-hz", "--v-max", "--rapid", "--machine-acceleration"])
@pytest.mark.parametrize("value", ["nan", "-1", "inf"])
def test_no_limit_can_be_switched_off_by_a_number_that_is_none(tmp_path, capsys, option, value):
    path = tmp_path / "p.tap"
    path.write_text(TEXT)
    words = ["check", str(path), "--v-max", "5", "--a-max", "20", "--x-min", "-1", "--x-max", "10"]
    code = main([*words, option, value])
    assert code == 2 or (option, value) == ("--max-dwell-s", "inf")
    assert "Traceback" not in capsys.readouterr().err


def test_the_command_says_where_a_program_comes_from(tmp_path, capsys):
    path = tmp_path / "p.tap"
    words = ["check", str(path), "--v-max", "5", "--a-max", "20", "--x-min", "-1", "--x-max", "10"]
    path.write_text(TEXT)
    assert main(words) == 0
    assert "ok: this program may run (made again from its recipe, line by line the same)" in capsys.readouterr().out
    path.write_text(lines_changed(swap))
    assert main(words) == 1
    assert "refused" in capsys.readouterr().out
    path.write_text(lines_changed(delete))
    main([*words, "--as-foreign"])
    assert "recipe in its header" not in capsys.readouterr().out
    path.write_text("(STEPS 1)\n" + START + "G1 X1 F6\nG1 X0 F6\nM30\n")
    assert main(words) == 0
    assert "nobody's recipe" in capsys.readouterr().out


def test_noise_of_any_preset_is_genuine_in_both_feed_modes():
    spec = TrajectorySpec.of(Noise(duration_s=20) + Hold(duration_s=2) + ReturnToZero(rest_s=1), name="mixed")
    for mode in ("G94", "G93"):
        result, origin = check_file(make(spec, 3, 25.0, mode).program, spec.limits)
        assert (result.ok, origin.genuine) == (True, True), result.problems


@pytest.mark.parametrize("kind", [np.int64, np.uint8])
def test_numbers_of_numpy_are_those_of_python(kind):
    made = gcode.generate("paper-1", seed=kind(3), gauge_length_mm=np.float32(25), duration_s=30)
    assert made.program == gcode.generate("paper-1", seed=3, gauge_length_mm=25.0, duration_s=30).program


@pytest.mark.parametrize("gauge_length_mm", [25, 25.0, np.int64(25), np.float32(25)])
def test_a_whole_number_is_a_gauge_length_like_another(gauge_length_mm):
    """Its header said 25, and 25.0 was due."""
    made = gcode.generate("paper-1", seed=np.int64(3), duration_s=20, gauge_length_mm=gauge_length_mm)
    assert gcode.check(made).ok
    assert made.program == gcode.generate("paper-1", seed=3, duration_s=20, gauge_length_mm=25.0).program

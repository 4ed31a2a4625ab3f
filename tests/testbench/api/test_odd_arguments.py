"""Calls as they are made in a notebook for the first time: what is odd is refused before anything moves."""

from __future__ import annotations

import numpy as np
import pytest

import gcode
import testbench as tb


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    folder = tmp_path_factory.mktemp("program")
    gcode.generate("paper-1", seed=1, duration_s=20).write(folder)
    return folder / "program.tap"


ODD = [
    ({"max_force_N": "5"}, "max_force_N must be a number, got '5'"),
    ({"max_force_N": -5}, "max_force_N must be a positive number, got -5; leave it out where there is no limit"),
    ({"max_strain": float("nan")}, "max_strain must be a positive number, got nan"),
    ({"max_strain": 30}, "max_strain must be at most 10, got 30; 0.3 stands for 30 %"),
    ({"give_up_s": "x"}, "give_up_s must be a number of 0 or more, got 'x'"),
    ({"baud": "x"}, "baud must be a whole number, 1 or more, got 'x'"),
    ({"specimen": 3}, "specimen must be of the class str, got int"),
]


@pytest.mark.parametrize(("odd", "words"), ODD, ids=[str(odd) for odd, _ in ODD])
def test_a_limit_that_watches_nothing_is_refused_before_the_port_is_opened(odd, words, program, tmp_path):
    """A limit of NaN was never passed, and one of ``"5"`` ended the recording in a traceback at the first force."""
    with pytest.raises(tb.UserError, match=f"^{words}"):
        tb.record("/dev/no-such-port", program, tmp_path / "r", **odd)
    assert not (tmp_path / "r").exists()


@pytest.mark.parametrize(
    ("program", "said"),
    [
        (
            gcode.generate("paper-1", seed=1, duration_s=20),
            "program: the gauge length must be a positive number of mm",
        ),
        ("G21 G90 G94\nG2 X1\n", "program: line 2"),
    ],
)
def test_a_program_without_a_file_is_told_as_the_program(program, said):
    """Messages named a file in a folder of the system that was gone already."""
    with pytest.raises(tb.UserError, match=f"^{said}"):
        tb.simulate("pes", program, gauge_length_mm=-1)


def test_an_array_of_one_number_is_no_number():
    with pytest.raises(tb.UserError, match=r"every must be a whole number, 1 or more, got array\(\[1\]\)"):
        tb.example(duration_s=20).thinned(np.array([1]))


@pytest.mark.parametrize("limit", [None, 20, np.float32(20), float("inf")])
def test_a_limit_may_be_left_out_or_be_of_numpy(limit, program, tmp_path):
    with pytest.raises(tb.UserError, match="cannot open this port"):
        tb.record("/dev/no-such-port", program, tmp_path / "r", max_force_N=limit)


@pytest.mark.parametrize("port", [None, 3, ""])
def test_a_port_that_is_no_text_is_refused(port, program, tmp_path):
    with pytest.raises(tb.UserError, match="port: must be a device such as /dev/ttyUSB0"):
        tb.record(port, program, tmp_path / "r")


def test_effects_and_links_are_paths(program, tmp_path):
    model, own = tb.baseline(), tb.effects.StressRelaxation()
    with pytest.raises(tb.UserError, match="got StressRelaxation, not the path of a file with your own effects"):
        tb.run(model, program, tmp_path / "r", effects=own)  # type: ignore[arg-type]
    with pytest.raises(tb.UserError, match="got int, not the path of a link to the port"):
        tb.serve_rig(model, program, link=3)  # type: ignore[arg-type]


@pytest.mark.parametrize("effects", [tb.effects.StressRelaxation(), [tb.effects.StressRelaxation()]])
def test_an_effect_in_the_place_of_its_class_is_named(effects):
    """It was taken for a sequence: got ('fraction', 0.15)."""
    with pytest.raises(tb.UserError, match=r"classes of your own effects, got StressRelaxation\(fraction=0.15"):
        tb.simulate("pes", None, effects=effects)


def test_the_text_of_a_program_is_no_path_of_one(program):
    """The whole text stood in the message."""
    with pytest.raises(gcode.UserError, match="read: takes the path of a program, got its text; check and play"):
        gcode.read(program.read_text())


def test_a_trajectory_that_ends_at_zero_says_so(program):
    assert "Hz, 0 to " in repr(gcode.play(program))


@pytest.mark.parametrize("progress", ["no", 0, np.False_])
def test_progress_that_is_no_truth_is_refused(progress):
    """It showed the line that was to be left out."""
    with pytest.raises(tb.UserError, match="progress must be True, False or a callable that takes a text, got"):
        tb.fit(tb.example(duration_s=20), progress=progress)


@pytest.mark.parametrize("odd", [{"speed": "fast"}, {"budget_minutes": "3"}, {"run_minutes": None}])
def test_an_investigation_that_is_asked_for_words_leaves_no_folder(odd, tmp_path):
    """A speed in words ended in a traceback, and the folder was taken; "3" minutes were 3 sixty times over."""
    (name,) = odd
    with pytest.raises(tb.UserError, match=f"^{name} must be a number, got"):
        tb.investigate("pes", tmp_path / "i", progress=False, **odd)
    assert not (tmp_path / "i").exists()


def test_the_name_of_a_law_is_a_text():
    with pytest.raises(tb.UserError, match="name must be of the class str, got int"):
        tb.propose(tb.example(duration_s=20), name=3)  # type: ignore[arg-type]


@pytest.mark.parametrize("odd", ["3", True])
def test_a_limit_among_the_bounds_is_no_text_either(odd, tmp_path):
    with pytest.raises(tb.UserError, match=f"investigate: bounds.strain_max_percent: must be a number, got {odd!r}"):
        tb.investigate(tb.baseline(), tmp_path / "i", bounds={"strain_max_percent": odd})


@pytest.mark.parametrize("name", ["max_force_N", "rest_s", "seed", "trials", "gauge_length_mm"])
@pytest.mark.parametrize("odd", ["3", True])
def test_an_investigation_makes_no_number_of_a_text_or_of_a_yes(name, odd, tmp_path):
    with pytest.raises(tb.UserError, match=f"investigate: {name}: must be a number, got {odd!r}"):
        tb.investigate(tb.baseline(), tmp_path / "i", **{name: odd})
    assert not (tmp_path / "i").exists()


def test_an_investigation_of_no_sensor_or_of_two_says_which(tmp_path):
    for given, got in (({}, "neither"), ({"sensor": tb.baseline(), "port": "/dev/ttyUSB0"}, "both")):
        with pytest.raises(tb.UserError, match=f"give a SENSOR to simulate, or the port of a real rig; got {got}"):
            tb.investigate(folder=tmp_path / "new", **given)

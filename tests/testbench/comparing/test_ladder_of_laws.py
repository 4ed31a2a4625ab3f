"""A law in the place of another, and the ladder as a table."""

from __future__ import annotations

from dataclasses import replace

import pytest

from testbench.comparing.ladder import fitted_file, undo
from testbench.comparing.tables import ladder_table
from testbench.diagnosis.adding import add_effect
from testbench.knit.mechanics.elasticity import ElasticityTwoSlopes
from testbench.measurements.splitting import split
from tests.testbench.builders import CATALOGUE, record, truth

TWO_SLOPES = ElasticityTwoSlopes(stiffness_N=6.0, more_N=14.0, knee=0.163, width=0.017)


def test_a_law_is_added_in_the_place_of_another_and_taken_back():
    recording = record(truth().plus(TWO_SLOPES), seed=3)
    calibration, held = split(recording, record(truth().plus(TWO_SLOPES), seed=4))
    first = fitted_file(truth(), calibration, held, "baseline")
    second = add_effect(first, "elasticity_two_slopes", calibration, held, CATALOGUE)
    assert list(second.model) == list(first.model)
    law = second.model["elasticity"].model_dump()
    assert law["knee"] == pytest.approx(0.163, abs=0.005)
    errors = [step["errors"]["held_out"]["force"] for step in second.history]
    assert errors[1] < 0.5 * errors[0]
    assert undo(second, CATALOGUE).model["elasticity"].name == "elasticity"


def test_the_ladder_keeps_its_columns_apart_however_long_a_step_is_called():
    recording = record(truth(), seed=3)
    step = "+ shape freedom, elasticity_two_slopes"
    file = fitted_file(truth(), *split(recording, record(truth(), seed=4)), step)
    first, second, third = ladder_table(file).splitlines()
    assert second.startswith(f"{step}  force")
    assert first.index("channel") == second.index("force") == third.index("conductance")


def test_a_fall_from_an_error_of_nearly_nothing_is_written_too():
    recording = record(truth(), seed=3)
    file = fitted_file(truth(), *split(recording, record(truth(), seed=4)), "baseline")
    step = file.history[0]
    tiny = {**step, "errors": {**step["errors"], "held_out": dict.fromkeys(step["errors"]["held_out"], 5e-324)}}
    rows = ladder_table(replace(file, history=(tiny, step))).splitlines()
    assert [row.split()[-2] for row in rows[1:]] == ["0", "0", "-inf", "-inf"]

"""What may be said of the bounds is known in one place, whoever asks."""

from __future__ import annotations

import inspect
import re

import pytest

import testbench as tb
from gcode.support.errors import UserError
from testbench.design.protocols import ALLOWED, MENU, Bounds, bounds_with
from tests.testbench.investigating.samples import asked

STRANGE = "bounds: allowed are v_max_mm_per_s, a_max_mm_per_s2, strain_max_percent, duration_s; got speed"


def test_fields_that_there_are_not_are_refused_alike():
    with pytest.raises(tb.UserError, match=f"^{re.escape(STRANGE)}$"):
        bounds_with({"speed": 1}, 25.0)
    with pytest.raises(ValueError, match=re.escape(STRANGE)):
        asked(bounds={"duration_s": 120, "speed": 1})
    with pytest.raises(tb.UserError, match=re.escape(STRANGE)):
        tb.investigate(tb.baseline(), "never-made", bounds={"speed": 1}, progress=False)


def test_what_is_said_is_what_holds():
    bounds = bounds_with({"v_max_mm_per_s": 3, "gauge_length_mm": 40}, 40.0)
    assert bounds == tb.Bounds(v_max_mm_per_s=3, gauge_length_mm=40)
    assert {*ALLOWED, "gauge_length_mm"} == set(vars(bounds))
    with pytest.raises(tb.UserError, match="the gauge length is 25 mm, got 40; for a sensor of another length give"):
        bounds_with({"gauge_length_mm": 40}, 25.0)
    with pytest.raises(tb.UserError, match="gauge_length_mm: must be a positive number, got nan"):
        bounds_with({}, float("nan"))


@pytest.mark.parametrize("bounds", [{"duration_s": 300}, tb.Bounds(duration_s=300)])
def test_a_duration_beside_run_minutes_is_not_dropped_in_silence(bounds, tmp_path):
    """It was: the runs took three minutes."""
    with pytest.raises(tb.UserError, match=r"bounds: a run takes 180 s \(run_minutes\), got a duration_s of 300"):
        tb.investigate(tb.baseline(), tmp_path / "i", bounds=bounds, progress=False)
    assert not (tmp_path / "i").exists()


def test_the_force_has_one_limit_by_one_name():
    for public in (tb.record, tb.investigate):
        assert "max_force_N" in inspect.signature(public).parameters


def test_a_protocol_that_has_no_room_in_a_short_run_is_left_out():
    """Its random motion would have lasted less than nothing, which ended the whole design in a traceback."""
    with pytest.raises(UserError, match="Noise: duration_s"):
        MENU["mix"](Bounds(duration_s=33))

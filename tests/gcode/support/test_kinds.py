"""Numbers and kinds that Python calls are given."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gcode import Limits
from gcode.support.errors import UserError
from gcode.support.kinds import instance, number, path_of


@pytest.mark.parametrize("value", [1, 1.0, np.float32(1), np.int64(1)])
def test_a_number_of_python_or_numpy_is_one(value):
    assert number("rest_s", value, 0) == 1.0


@pytest.mark.parametrize("value", ["1", None, True, [1], 1j, np.ones(1)])
def test_what_is_no_number_is_refused(value):
    with pytest.raises(UserError, match="rest_s must be a number, got"):
        number("rest_s", value)


@pytest.mark.parametrize("value", [-1e-9, float("nan"), "a"])
def test_a_number_below_the_least_is_refused(value):
    with pytest.raises(UserError, match="rest_s must be a number of 0 or more, got"):
        number("rest_s", value, 0)


def test_a_mapping_is_no_object_of_the_class_that_takes_it():
    limits = Limits(v_max_mm_per_s=5)
    assert instance("limits", limits, Limits) is limits
    with pytest.raises(UserError, match=r"limits must be of the class Limits, got dict; write Limits\(\*\*...\)"):
        instance("limits", {"v_max_mm_per_s": 5}, Limits)
    with pytest.raises(UserError, match=r"limits must be of the class Limits, got str$"):
        instance("limits", "fast", Limits)


def test_an_empty_text_is_no_path():
    """It was the folder one is in, and what a command does with that."""
    with pytest.raises(UserError, match="got an empty text, not the path of a campaign; name it"):
        path_of("", "campaign")
    assert path_of(".") == path_of(Path()) == Path()

"""The presets have the paper's statistics, for any seed, as executed."""

from __future__ import annotations

import numpy as np
import pytest

import gcode
from gcode.programs.make import make
from gcode.support.errors import UserError
from gcode.trajectories.planning import plan
from gcode.trajectories.presets import PRESETS, preset

V_MAX = {"paper-1": 4.142, "paper-2": 4.93, "paper-3": 4.039, "fast": 14.0}


@pytest.mark.parametrize("name", PRESETS)
def test_means_and_sds_of_the_executed_motion_are_within_three_percent(name):
    made = make(preset(name), 51, 25.0)
    assert np.abs(preset(name).pieces[0].target.deviations(made.statistics)).max() < 0.03
    assert made.statistics.v_max_mm_per_s == pytest.approx(V_MAX[name], rel=0.12)
    assert made.statistics.x_max_mm < 0.25 * preset(name).pieces[0].high_percent


@pytest.mark.parametrize("seeds", [range(5), pytest.param(range(5, 25), marks=pytest.mark.slow)], ids=["5", "20"])
@pytest.mark.parametrize("name", PRESETS)
def test_any_seed_gives_them(name, seeds):
    target = preset(name).pieces[0].target
    runs = [plan(preset(name), seed, 25.0).statistics() for seed in seeds]
    off = np.abs([target.deviations(run) for run in runs])
    assert off[:, [0, 2]].max() < 0.02
    assert off[:, [1, 3]].max() < 0.03
    assert max(abs(run.v_max_mm_per_s / V_MAX[name] - 1) for run in runs) < 0.12


def test_an_unknown_limit_is_refused_with_the_names_there_are():
    with pytest.raises(UserError, match=r"there is no limit v_max; limits are .*v_max_mm_per_s"):
        gcode.generate("paper-1", seed=1, v_max=3)


def test_an_unknown_preset_is_refused_with_the_names_there_are():
    with pytest.raises(UserError, match="paper-1, paper-2, paper-3, fast"):
        preset("paper-9")

"""Specimens: they differ as documented, are always the same again, and a command can ask for one."""

from __future__ import annotations

import numpy as np
import pytest

from gcode.support.errors import UserError
from testbench.campaigns.datasets.spec import DatasetSpec
from testbench.knit.model import inputs
from testbench.knit.presets import preset
from testbench.knit.presets.population import SAME, specimen


@pytest.mark.parametrize("name", ["pes", "lycra"])
def test_a_specimen_is_always_the_same_and_unlike_the_others(name):
    assert preset(f"{name}@0") == preset(name)
    assert preset(f"{name}@7") == preset(f"{name}@7") == specimen(preset(name), 7)
    assert preset(f"{name}@7") != preset(f"{name}@8")
    assert list(preset(f"{name}@7")) == list(preset(name))


def test_spread_is_as_documented():
    middle = preset("pes")
    many = [specimen(middle, number) for number in range(1, 301)]
    logs = np.log([one["elasticity"].stiffness_N / middle["elasticity"].stiffness_N for one in many])
    assert logs.mean() == pytest.approx(0.0, abs=0.02)
    assert logs.std() == pytest.approx(0.10, abs=0.015)
    ohms = np.log([one["contact"].contact_resistance_ohm for one in many])
    assert ohms.std() == pytest.approx(0.15, abs=0.02)
    for one in many[:5]:
        for effect in one:
            for key in SAME:
                assert getattr(one[effect], key, 0) == getattr(middle[effect], key, 0)


def test_specimens_simulate_and_differ():
    strain = 0.15 * (1 - np.cos(np.arange(600) / 30))
    given = inputs(np.arange(600) / 20, strain)
    levels = [preset(f"pes@{number}").simulate(given, 0.05)["conductance_S"].mean() for number in range(1, 6)]
    assert np.isfinite(levels).all()
    assert np.std(levels) / np.mean(levels) > 0.03


@pytest.mark.parametrize(("name", "words"), [("pes@x", "a whole number, such as pes@3"), ("pes@9999999", "from 0")])
def test_a_wrong_number_is_named(name, words):
    with pytest.raises(UserError, match=words):
        preset(name)


def test_a_data_set_may_name_specimens(tmp_path):
    from testbench.campaigns.datasets.tasks import tasks_of

    spec = DatasetSpec(
        sensors=("pes", "pes@1"), seeds=(1,), trajectory={"preset": "paper-1", "seeds": (1,), "duration_s": 30.0}
    )
    first, second = tasks_of(spec, tmp_path, tmp_path / "out")
    assert first.folder != second.folder
    assert first.model != second.model

"""A second model beside a campaign's own: what there is to choose from, and what the table says."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from gcode.support.errors import UserError
from testbench.studio import models
from testbench.studio.beside import beside_choices, beside_of, side_by_side
from testbench.studio.studio import Studio


@pytest.fixture
def two_steps(studio: Studio, fitted_model: Path) -> Studio:
    """``sleeve`` with a ladder of two steps, and ``other`` with a model of its own."""
    file = json.loads(fitted_model.read_text())
    first = file["history"][0]
    stiffer = json.loads(json.dumps(first["model"]))
    elasticity = next(one for one in stiffer["effects"] if one["name"] == "elasticity")
    elasticity["parameters"]["stiffness_N"] *= 2
    steps = [first | {"model": stiffer}, first | {"step": "+ stress_relaxation"}]
    studio.make_results("model:sleeve")
    models.model_path(studio, "sleeve").write_text(json.dumps(file | {"history": steps}))
    shutil.copytree(studio.workspace.root / "sleeve", studio.workspace.root / "other")
    shutil.copytree(studio.workspace.root / "sleeve", studio.workspace.root / "not-fitted")
    studio.make_results("model:other")
    models.model_path(studio, "other").write_text(json.dumps(file))
    return studio


def test_earlier_steps_and_fitted_campaigns_are_offered(two_steps: Studio) -> None:
    assert beside_choices(two_steps, "sleeve") == {"other": "that of other", "0": "step 0: baseline"}
    with pytest.raises(UserError, match="no second model 'not-fitted' for sleeve"):
        beside_of(two_steps, "sleeve", "not-fitted")


def test_the_table_puts_both_values_beside_each_other(two_steps: Studio) -> None:
    step, own = beside_of(two_steps, "sleeve", "0"), beside_of(two_steps, "other", "sleeve")
    table = side_by_side((step.label, step.fit, step.model), ("now", own.fit, own.model))
    row = next(cells for cells in table.rows if cells[0] == "elasticity: stiffness")
    now_N = own.model["elasticity"].stiffness_N  # type: ignore[attr-defined]
    assert float(row[1].removesuffix(" N")) == pytest.approx(2 * now_N, rel=0.01), "a step keeps its values alone"
    assert "±" in row[2]
    assert float(row[2].strip("()").partition(" ")[0]) == pytest.approx(now_N, rel=0.01)

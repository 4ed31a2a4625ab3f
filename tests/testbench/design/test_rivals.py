"""What the fits of the rivals leave anyway."""

from __future__ import annotations

import pytest

from testbench.design.rivals import shared_noise, told_apart
from testbench.effects import LoadCellCreep, StressRelaxation
from testbench.results.model_file import ModelFile
from tests.testbench.builders import truth


def file(floor_N: float, left_N: float | None) -> ModelFile:
    """A model with the noise floor of its recording and what its fit left."""
    step = {"step": "baseline", "model": truth().to_dict(), "noise_floor": {"force": floor_N}}
    step["errors"] = {"held_out": {"force": floor_N}, "calibration": {"force": floor_N}}
    return ModelFile(
        truth(), 25.0, "r", "h", {} if left_N is None else {"residual_scale": {"force": left_N}}, (step,)
    )


@pytest.mark.parametrize(
    ("one", "other", "least"),
    [((0.01, 0.03), (0.02, 0.021), 0.021), ((0.01, None), (0.02, 0.05), 0.01), ((0.01, 0.005), (0.01, 0.02), 0.01)],
)
def test_the_noise_is_that_of_the_best_whichever_comes_first(one, other, least) -> None:
    files = file(*one), file(*other)
    assert shared_noise(files) == shared_noise(files[::-1]) == {"force": least}


def test_rivals_are_called_after_what_not_all_of_them_have() -> None:
    base, relaxing = truth(), truth() + StressRelaxation()
    creeping = relaxing + LoadCellCreep()
    assert told_apart({"a": base, "b": relaxing}) == ["without stress_relaxation", "stress_relaxation"]
    nested = told_apart({"a": base, "b": relaxing, "c": creeping})
    lacking = "without stress_relaxation and load_cell_creep"
    assert nested == [lacking, "stress_relaxation", "stress_relaxation + load_cell_creep"]
    assert told_apart({"runs/a.json": base, "runs/b.json": base}) == ["runs/a.json", "runs/b.json"]

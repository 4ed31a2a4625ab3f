"""Several effects, one after the other: also where the first cannot be named alone."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from testbench.discrepancy import repeat
from testbench.discrepancy.diagnosis import Diagnosis
from testbench.discrepancy.evidence import Weighing
from testbench.discrepancy.model_file import ModelFile
from testbench.discrepancy.repeat import diagnose_repeatedly
from testbench.knit.catalogue import baseline
from tests.testbench.discrepancy.samples import CATALOGUE, record, truth

BEFORE = ModelFile(baseline(), 25.0, "a", "b", {}, ({"step": "baseline"},))
WITH_FIRST = replace(BEFORE, model=baseline().plus(CATALOGUE["stress_relaxation"]()), history=({"step": "+ first"},))


def said(verdict: Any, before: float, after: float, attempt: ModelFile | None = None) -> Diagnosis:
    """A diagnosis with these held-out errors, over a noise floor of 1."""
    errors = {"before": {"force": before}, "after": {"force": after}, "floor": {"force": 1.0}}
    nothing = Weighing((), "", 0.0, 0.0, ())
    return Diagnosis(
        verdict, nothing, (), (), (), 0.0, BEFORE, BEFORE, errors["before"], errors["after"], errors["floor"], attempt
    )


@pytest.fixture
def scripted(monkeypatch):
    """Diagnoses to be handed out one after the other, and the models that were asked about."""

    def script(*answers: Diagnosis) -> list:
        asked, left = [], list(answers)

        def diagnose(recording, held_out, model, catalogue, progress):
            asked.append(model)
            return left.pop(0)

        monkeypatch.setattr(repeat, "diagnose", diagnose)
        return asked

    return script


def test_two_that_hide_each_other_are_named_together(scripted):
    asked = scripted(
        said("unknown", 9.0, 9.0, WITH_FIRST), said("missing", 5.0, 1.1), said("nothing_missing", 1.1, 1.1)
    )
    found = diagnose_repeatedly(record(truth(), 30), most=3)
    assert [one.verdict for one in found] == ["missing", "missing", "nothing_missing"]
    assert asked[1] is WITH_FIRST.model
    assert found[0].error_after == {"force": 5.0}


@pytest.mark.parametrize("beside", [said("unknown", 5.0, 1.1), said("missing", 5.0, 4.0)])
def test_neither_is_named_where_both_leave_much(scripted, beside):
    scripted(said("unknown", 9.0, 9.0, WITH_FIRST), beside)
    assert [one.verdict for one in diagnose_repeatedly(record(truth(), 30), most=3)] == ["unknown"]


def test_a_single_diagnosis_does_not_try_a_second(scripted):
    asked = scripted(said("unknown", 9.0, 9.0, WITH_FIRST))
    assert [one.verdict for one in diagnose_repeatedly(record(truth(), 30), most=1)] == ["unknown"]
    assert len(asked) == 1

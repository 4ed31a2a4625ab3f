"""The public functions, their examples and the commands share one diagnosis.

It chooses among one law each of a few mechanisms: what is tried here is how it is asked and told, not how it chooses.
"""

from __future__ import annotations

import inspect
from functools import wraps
from typing import Any

import pytest

from testbench.diagnosis import diagnose
from testbench.diagnosis.result import Diagnosis
from testbench.knit.catalogue import BASELINE, Catalogue
from tests.testbench.asked_once import answered_once

MECHANISMS = ("stress_relaxation", "load_cell_creep", "permanent_set", "mullins_softening", "jamming_stiffening")


@wraps(diagnose)
def among_few(*args: Any, **kwargs: Any) -> Diagnosis:
    """As `diagnose`, of one base and of one law each of a few mechanisms."""
    asked = inspect.signature(diagnose).bind(*args, **kwargs).arguments
    every = asked["catalogue"].effects
    few = {
        name: law
        for name, law in every.items()
        if name in (law.mechanism, *BASELINE) and (law.in_base or name in MECHANISMS)
    }
    return diagnose(**{**asked, "catalogue": Catalogue(few)})


once = answered_once(among_few)


@pytest.fixture(autouse=True)
def _asked_once(monkeypatch):
    monkeypatch.setattr("testbench.diagnosis.diagnose", once)

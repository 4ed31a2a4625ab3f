"""The public functions, their examples and the commands share one diagnosis."""

from __future__ import annotations

import pytest

from testbench.diagnosis import diagnose
from tests.testbench.asked_once import answered_once

once = answered_once(diagnose)


@pytest.fixture(autouse=True)
def _asked_once(monkeypatch):
    monkeypatch.setattr("testbench.diagnosis.diagnose", once)

"""No child process outlives its test, however the test ends."""

from __future__ import annotations

import pytest

from tests.testbench.rig.devices import CHILDREN


@pytest.fixture(autouse=True)
def _no_child_survives():
    yield
    for child in CHILDREN:
        child.kill()
        child.communicate()
    CHILDREN.clear()

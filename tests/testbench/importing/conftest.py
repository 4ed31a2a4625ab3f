"""Every import of these tests is one that a campaign's manifest could keep."""

from __future__ import annotations

import json
from typing import Any

import pytest

from gcode.support.strict import validated
from testbench.importing import from_file
from testbench.recordings.stored import Imported


@pytest.fixture(autouse=True)
def manifest_may_say_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """Hold what is told of each import against what a manifest may say: most tests never write one."""
    details = from_file._details

    def checked(*args: Any) -> dict[str, Any]:
        told = details(*args)
        validated(json.loads(json.dumps(told)), Imported, "the import", "what is told of an import")
        return told

    monkeypatch.setattr(from_file, "_details", checked)

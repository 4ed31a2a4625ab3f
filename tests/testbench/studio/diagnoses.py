"""A workspace in which something was diagnosed already."""

from __future__ import annotations

import json

import tests.testbench.report.samples as samples
from testbench.studio.studio import Studio


def with_diagnosis(studio: Studio, verdict: str = "missing") -> None:
    """A diagnosis with this verdict beside the model of ``sleeve``."""
    history = json.loads((studio.workspace.results("sleeve") / "model.json").read_text())["history"]
    data = samples.diagnosis(verdict) | {"history": history}
    (studio.workspace.results("sleeve") / "diagnosis.json").write_text(json.dumps(data))

"""A workspace in which something was diagnosed already."""

from __future__ import annotations

import json
import os

import tests.testbench.report.samples as samples
from testbench.studio import models
from testbench.studio.jobs.job import Job
from testbench.studio.studio import Studio


def with_diagnosis(studio: Studio, verdict: str = "missing") -> None:
    """A diagnosis with this verdict beside the model of ``sleeve``."""
    history = json.loads((studio.workspace.results("sleeve") / "model.json").read_text())["history"]
    data = samples.diagnosis(verdict) | {"history": history}
    (studio.workspace.results("sleeve") / "diagnosis.json").write_text(json.dumps(data))


def steps_in(studio: Studio, c: str) -> int:
    """How many steps the ladder of a campaign has."""
    return len(json.loads(models.model_path(studio, c).read_text())["history"])


def refit_elsewhere(studio: Studio) -> None:
    """The model of ``sleeve`` fitted anew and judged on other samples, at the very times that its file had."""
    path = models.model_path(studio, "sleeve")
    data, times = json.loads(path.read_text()), path.stat()
    for step in data["history"]:
        step["noise_floor"] = {channel: 1.5 * floor for channel, floor in step["noise_floor"].items()}
    path.write_text(json.dumps(data))
    os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))


def running_job(key: str) -> Job:
    """A job that does not end."""
    return Job(key, "Looking around", ("testbench", "--help"))

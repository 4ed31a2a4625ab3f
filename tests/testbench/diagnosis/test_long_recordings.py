"""Recordings of hours: memory is bounded, and the answer is that of shorter ones."""

from __future__ import annotations

import json
import subprocess
import sys

import numpy as np
import pytest

import testbench as tb
from testbench.fitting import constants
from testbench.fitting.evidence.independent_samples import on_the_grid, telling
from testbench.measurements.preparing import prepare
from tests.testbench.builders import record, truth, write_csv

HOURS = 6
MOST_BYTES = 2e9
DIAGNOSED = """
import resource
from testbench.cli import main
code = main(["diagnose", "a.csv", "--held-out", "b.csv", "--gauge-length-mm", "25", "--json", "d.json"])
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024)
raise SystemExit(code)
"""


def test_a_recording_of_hours_is_compared_on_a_bounded_grid():
    recording = record(truth(), duration_s=3 * 3600, rate_hz=12.5, seed=1)
    whole = prepare(recording)
    grid = telling(on_the_grid(whole))
    assert len(grid.grid_s) <= constants.GRID_POINTS < len(whole.grid_s)
    for channel, values in grid.residual(truth()).items():
        left = values[grid.counts]
        floor = whole.residual(truth())[channel][whole.counts]
        assert np.std(left) < 1.1 * np.std(floor)


@pytest.mark.slow
def test_a_pair_of_six_hours_is_diagnosed_within_two_gigabytes(tmp_path):
    hidden = truth() + tb.effects.StressRelaxation(fraction=0.3)
    for name, seed in (("a", 1), ("b", 2)):
        write_csv(record(hidden, HOURS * 3600, 20.0, seed=seed), tmp_path / f"{name}.csv")
    done = subprocess.run([sys.executable, "-c", DIAGNOSED], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert float(done.stdout.split()[-1]) < MOST_BYTES
    result = json.loads((tmp_path / "d.json").read_text())
    assert result["ranking"][0]["effect"] == "stress_relaxation"
    for channel, error in result["error_after"].items():
        assert error < 1.15 * result["noise_floor"][channel]

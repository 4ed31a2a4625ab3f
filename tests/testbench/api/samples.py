"""Recordings and results that the tests of the public functions share, each made once."""

from __future__ import annotations

from functools import cache

import testbench as tb
from testbench.api.diagnosing import DiagnosisResult
from testbench.api.fitting import FitResult
from testbench.recordings.recording import Recording


@cache
def relaxed(seed: int = 1) -> Recording:
    """A minute and a half of a sensor whose stress relaxes."""
    return tb.example(tb.effects.StressRelaxation(fraction=0.3), seed=seed, duration_s=90)


@cache
def fitted() -> FitResult:
    """The baseline on it."""
    return tb.fit(relaxed(), progress=False)


@cache
def diagnosed() -> DiagnosisResult:
    """What it is missing."""
    return tb.diagnose(relaxed(), most=1, progress=False)

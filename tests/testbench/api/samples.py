"""Recordings and results that the tests of the public functions share, each made once."""

from __future__ import annotations

import doctest
from functools import cache
from typing import Any

import testbench as tb
from gcode.support.lazy import lazy_exports
from testbench.api.missing.diagnosing import DiagnosisResult
from testbench.api.models.fitting import FitResult
from testbench.recordings.recording import Recording


@cache
def after_examples(name: str, told: object) -> dict[str, Any]:
    """Run the examples in the documentation of an object; the names that they leave, empty without examples."""
    runner, left = doctest.DocTestRunner(), {}
    for test in doctest.DocTestFinder(recurse=False).find(told, name, globs={"lazy_exports": lazy_exports}):
        result = runner.run(test, clear_globs=False)
        assert result.failed == 0, f"{name}: {result.failed} examples fail; see the captured output"
        left |= test.globs if result.attempted else {}
    return left


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
    """What it is missing: the example of `diagnose`, which takes as long as all others here."""
    left = after_examples("testbench.diagnose", tb.diagnose)
    assert left["recording"]["force_N"].tobytes() == relaxed()["force_N"].tobytes()
    return left["d"]

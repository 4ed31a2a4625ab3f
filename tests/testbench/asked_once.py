"""The same question to a long search is answered once: tests of what stands around it share its answer.

That a command, a public function and an example put the same question to `diagnose` or to `propose_law` is what
their tests prove; that the same question has the same answer is proved in
``tests/testbench/diagnosis/test_invariance.py``. Commands and public functions look the two up in the packages
``testbench.diagnosis`` and ``testbench.proposing``: set what `answered_once` gives there.
"""

from __future__ import annotations

import inspect
import json
from collections.abc import Callable, Hashable
from functools import wraps
from typing import ParamSpec, TypeVar

from testbench.knit.catalogue import Catalogue
from testbench.knit.model import KnitModel
from testbench.recordings.recording import Recording
from testbench.results.model_file import ModelFile

P = ParamSpec("P")
R = TypeVar("R")


def answered_once(search: Callable[P, R]) -> Callable[P, R]:
    """The search, made only for what was not asked yet; all arguments count but its callback."""
    answers: dict[Hashable, R] = {}

    @wraps(search)
    def once(*args: P.args, **kwargs: P.kwargs) -> R:
        asked = inspect.signature(search).bind(*args, **kwargs)
        asked.apply_defaults()
        question = tuple(_told(value) for name, value in asked.arguments.items() if name != "progress")
        if question not in answers:
            answers[question] = search(*args, **kwargs)
        return answers[question]

    return once


def _told(value: object) -> Hashable:
    """All that there is in an argument, as something to look up by."""
    if isinstance(value, Recording):
        columns = {"time_s": value.time_s, **value.channels}
        return (value.gauge_length_mm, *sorted((name, values.tobytes()) for name, values in columns.items()))
    if isinstance(value, list):
        return tuple(map(_told, value)) if len(value) > 1 else _told(value[0])  # a list of one asks what the one does
    if isinstance(value, KnitModel):
        return json.dumps(value.to_dict())
    if isinstance(value, ModelFile):
        return json.dumps([value.model.to_dict(), value.fit, value.history], default=str)
    if isinstance(value, Catalogue):
        return tuple(value.effects.items())
    assert value is None or isinstance(value, int | float | str), f"asked with {value!r}: say how it is told apart"
    return value

"""Whether what was found was found about the model as it is now: told by content, since file times lie.

A job that began before the model was changed, and ended after, leaves a file that is newer than the model.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

CLOSE = 1e-6  # relative; the same errors, worked out a second time


def made_of(begun: Mapping[str, Any], last: Mapping[str, Any], undone: bool = False) -> bool:
    """Whether the step that a diagnosis or a proposal began with is the `last` one of a model's ladder.

    Noise floors tell the samples that it was judged on. With `undone`, the last step is what is left after one was
    taken back: it has no fit, so whoever asks fits it once more, and only its effects stay the same.
    """
    if not _close(begun["noise_floor"], last["noise_floor"]):
        return False
    if undone:
        return _effects(begun) == _effects(last)
    return begun["model"] == last["model"] and _close(begun["errors"]["held_out"], last["errors"]["held_out"])


def _close(some: Mapping[str, float], others: Mapping[str, float]) -> bool:
    return some.keys() == others.keys() and all(math.isclose(some[key], others[key], rel_tol=CLOSE) for key in some)


def _effects(step: Mapping[str, Any]) -> set[tuple[str, str]]:
    return {(one["name"], one["effect"]) for one in step["model"]["effects"]}

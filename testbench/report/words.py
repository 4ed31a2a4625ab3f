"""What a diagnosis says, in sentences for somebody who knows textiles and not statistics."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from testbench.report.ladder_figures import UNITS


def verdict_in_words(diagnosis: Mapping[str, Any]) -> str:
    """One sentence, or two."""
    verdict, ranking = diagnosis["verdict"], diagnosis["ranking"]
    if verdict == "missing" and ranking:
        return _missing(diagnosis)
    if verdict == "unknown":
        return "Something is missing that no single effect of the catalogue explains." + _depends(diagnosis)
    return "Nothing is missing that these recordings could show."


def _depends(diagnosis: Mapping[str, Any]) -> str:
    most = [f"{entry['channel']} on {spoken(entry['coordinate'])}" for entry in diagnosis.get("depends_on", [])[:2]]
    return f" What is left depends most on this: {'; '.join(most)}." if most else ""


def _missing(diagnosis: Mapping[str, Any]) -> str:
    first = diagnosis["ranking"][0]["effect"]
    tied = [spoken(name) for name in diagnosis.get("tied", []) if name != first]
    sentence = (
        f"The model is missing {spoken(first)}: {error_fall(diagnosis['error_before'], diagnosis['error_after'])}."
    )
    if tied:
        sentence += f" These recordings cannot tell it from {' or '.join(tied)}."
    return sentence


def error_fall(before: Mapping[str, float], after: Mapping[str, float]) -> str:
    """How the held-out error changes, channel by channel."""
    parts = [
        f"{channel} {before[channel]:.3g} to {after[channel]:.3g} {UNITS[channel]}"
        for channel in before
        if channel in after
    ]
    return f"the held-out error goes from {', '.join(parts)}"


def base_in_words(diagnosis: Mapping[str, Any]) -> str:
    """What is wrong with the base laws themselves; empty when nothing is."""
    names = [spoken(name.removesuffix("_shape")) for name in diagnosis.get("base_misfits", [])]
    if not names:
        return ""
    return f"The base law itself misfits: the shape of {' and '.join(names)} is not quite this sensor's."


def spoken(name: str) -> str:
    """A catalogue name as words."""
    return str(name).replace("_", " ")

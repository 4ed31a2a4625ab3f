"""Names of a resistance that is given relative to the one at rest: R/R0, and its change (R - R0)/R0."""

from __future__ import annotations

import re

_REST = r"R_?(?:0|o|i|init|initial|rest|ref)"
_NUMBER = r"(?:[_ #]?\d+)?$"  # of the sensor, behind the formula
_BEFORE = r"(?:^|[\s_.:;#-])"  # what stands before it: the sensor's name
_DELTA_R = r"(?:d|Δ|δ|delta)[ _]?R(?:es(?:istance)?)?"
_CHANGES = (
    re.compile(rf"{_BEFORE}{_DELTA_R}[/_](?:{_REST}|R){_NUMBER}", re.I),
    re.compile(rf"{_BEFORE}R_?t?-{_REST}/{_REST}{_NUMBER}", re.I),
    re.compile(rf"{_BEFORE}R_?t?/{_REST}-1$", re.I),
)
_RATIO = re.compile(rf"{_BEFORE}R_?t?/{_REST}{_NUMBER}", re.I)
_RATE = r"[ _]*[/_ ][ _]*[d∂Δδ]"  # dR/dt
_CHANGE = re.compile(rf"{_BEFORE}(?:{_DELTA_R}(?![^\W\d_]|{_RATE})|R(?:_?t|\(t\))? ?- ?{_REST}{_NUMBER})", re.I)

_RESISTANCE = frozenset(["r", "res", "resistance", "resistor"])
_RESISTANCE_PARTS = ("widerstand", "电阻", "電阻", "抵抗", "저항")
CHANGE_WORDS = ("change", "changes", "variation", "delta", "δ")
CHANGE_PARTS = ("änderung", "aenderung", "变化", "變化", "変化", "변화")
_TO_REST = frozenset(["rel", "relative", "normalized", "normalised", "norm", "fractional"])
_TO_REST_PARTS = ("relativ", "normiert", "相对", "相對", "相対", "상대", "归一", "歸一", "正規化", "정규화")


def ratio_by_formula(name: str) -> str:
    """``relative`` or ``relative_change`` where a name holds the formula of it; else empty."""
    plain = re.sub(r"[\[\](){}<>]", "", name).strip()
    plain = re.sub(r"\s*([/_-])\s*", r"\1", plain)
    if any(formula.search(plain) for formula in _CHANGES):
        return "relative_change"
    return "relative" if _RATIO.search(plain) else ""


def ratio_by_words(name: str, words: list[str]) -> str:
    """``relative`` or ``relative_change`` where the words of a name say so; else empty.

    Parameters
    ----------
    name : str
    words : list of str
        Its words, lower case.
    """
    text, have = name.casefold(), set(words)
    if _CHANGE.search(name):
        return "relative_change"
    if not have & _RESISTANCE and not any(part in text for part in _RESISTANCE_PARTS):
        return ""
    if not have.isdisjoint(CHANGE_WORDS) or any(part in text for part in CHANGE_PARTS):
        return "relative_change"
    return "relative" if have & _TO_REST or any(part in text for part in _TO_REST_PARTS) else ""

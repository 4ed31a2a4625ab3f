"""The parameters of a fitted model as a table for people: what each is, its value and error, what to doubt."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from pydantic.fields import FieldInfo

from testbench.comparing.numbers import allowed, in_words, with_error
from testbench.comparing.words import events_in_words, spoken
from testbench.fitting.parameters import HELD
from testbench.knit.effect import bounds_of
from testbench.knit.model import KnitModel
from testbench.report.document import Table
from testbench.results.model_file import AT_BOUND, doubted

HEAD = ("Parameter", "Value", "Allowed range", "Doubts", "What it is")
HELD_SD = HELD**-0.5  # in the fit's coordinate
NAME = re.compile(r"`(\w+)`")  # of a parameter, within a description
UNIT_TAIL = re.compile(r"_(N|s|S|ohm|mm|C|per_s|per_N|per_C|Hz|N_per_s|ppm)$")


def parameter_table(fit: Mapping[str, Any], model: KnitModel) -> Table | None:
    """Every number of the model that has a meaning of its own; shape weights are counted, not listed.

    `fit` is that of its file; `model` says what each parameter is and how far it may go.
    """
    entries: Mapping[str, Mapping[str, Any]] = fit.get("parameters", {})
    rows = [_row(address, entry, fit, model) for address, entry in entries.items() if "[" not in address]
    events = events_in_words(model, entries)
    for address, told in events.items():
        bounds, meaning = _allowed_and_meant(address, str(entries[f"{address}[0]"]["unit"]), model)
        rows.append((parameter_name(address), told, bounds, "those of this recording alone", meaning))
    if not rows:
        return None
    weights = sum("[" in address and address.partition("[")[0] not in events for address in entries)
    caption = "± is one standard error."
    return Table(HEAD, rows, f"{caption} Another {weights} numbers give shapes their form." if weights else caption)


def _row(address: str, entry: Mapping[str, Any], fit: Mapping[str, Any], model: KnitModel) -> tuple[str, ...]:
    unit, value, error = str(entry["unit"]), float(entry["value"]), float(entry["standard_error"])
    bounds, meaning = _allowed_and_meant(address, unit, model)
    held = is_held(value, error)
    # Where a bound holds a parameter, nothing is known of its error.
    alone = held or doubted(fit).get(address) == AT_BOUND
    told = in_words(value, unit) if alone else with_error(value, error, unit)
    doubt = "; ".join([*doubts(address, fit), *(["held while the rest was fitted"] if held else [])])
    return parameter_name(address), told, bounds, doubt, meaning


def _allowed_and_meant(address: str, unit: str, model: KnitModel) -> tuple[str, str]:
    """The range that a parameter may lie in, and what it is; both empty where the model does not have it."""
    effect, _, key = address.partition(".")
    field = type(model[effect]).model_fields.get(key) if effect in model else None
    if field is None:
        return "", ""
    extra = bounds_of(field)
    return allowed(float(extra["low"]), float(extra["high"]), unit), meaning_of(field)


def meaning_of(field: FieldInfo) -> str:
    """What a parameter is, in words."""
    return NAME.sub(lambda found: name_without_unit(found[1]), field.description or "")


def is_held(value: float, error: float) -> bool:
    """Whether a standard error is that of the prior which holds a parameter, and says nothing about it."""
    return error <= 1.05 * HELD_SD * abs(value) or abs(error / HELD_SD - 1) < 0.05


def parameter_name(address: str) -> str:
    """``stress_relaxation.tau_s`` as words: the unit stands with the value."""
    effect, _, key = address.partition(".")
    return f"{spoken(effect)}: {name_without_unit(key)}"


def name_without_unit(key: str) -> str:
    """``tau_s`` as a word."""
    return spoken(UNIT_TAIL.sub("", key))


def doubts(address: str, fit: Mapping[str, Any]) -> list[str]:
    """Why a value should not be trusted; empty where nothing speaks against it."""
    told = doubted(fit).get(address)
    found = [told] if told else []
    pairs = [pair[:2] for pair in fit.get("correlated", ()) if address in pair[:2]]
    others = [second if first == address else first for first, second in pairs]
    twins = [parameter_name(other) for other in others if "[" not in other]
    if twins:
        found.append(f"hardly told from {' and '.join(twins)}")
    return found

"""One effect of a diagnosis in full: what it says, its formula and source, and the values that were found."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from nicegui import ui

from testbench.comparing.numbers import allowed, in_words
from testbench.knit.card import doc_sections
from testbench.knit.catalogue import Catalogue, model_from_dict
from testbench.knit.effect import Effect, bounds_of
from testbench.report.document import Table
from testbench.report.parameter_table import meaning_of, name_without_unit, parameter_table
from testbench.studio.parts.widgets import subheading, table


def effect_told(diagnosis: Mapping[str, Any], entry: Mapping[str, Any], catalogue: Catalogue) -> None:
    """Lay out what is known of a candidate; `entry` is its row of the ranking."""
    effect = catalogue[entry["law"]]
    told = doc_sections(effect)
    with ui.column().classes("card gap-2"):
        ui.label(told.summary)
        if told.formula:
            ui.label(told.formula.replace("`", "")).classes("formula")
        if told.remarks:
            ui.label(told.remarks.replace("`", ""))
        for name, text in (("Source", told.source), ("Valid", told.valid)):
            if text:
                ui.label(f"{name}: {text.replace('`', '')}").classes("quiet text-sm")
    found = found_parameters(diagnosis, entry, catalogue)
    if found:
        subheading("Its values", "As fitted with it in the model.")
        table(found.head, found.rows, found.caption)
    elif entry["start"]:
        subheading("Its values", "Where a fit would begin; adding the effect fits them to this recording.")
        table(("Parameter", "Value", "Allowed range", "What it is"), start_rows(effect, entry["start"]))


def start_rows(effect: type[Effect], values: Mapping[str, Any]) -> list[tuple[str, str, str, str]]:
    """The numbers of a candidate that was not fitted; they have no errors."""
    rows = []
    for key, field in effect.model_fields.items():
        value = values.get(key)
        if not isinstance(value, int | float) or isinstance(value, bool):
            continue
        extra = bounds_of(field)
        span = allowed(extra["low"], extra["high"], extra["unit"])
        rows.append((name_without_unit(key), in_words(value, extra["unit"]), span, meaning_of(field)))
    return rows


def found_parameters(diagnosis: Mapping[str, Any], entry: Mapping[str, Any], catalogue: Catalogue) -> Table | None:
    """The effect's rows of the parameters that the diagnosis fitted; None where it did not put this one in."""
    fit = diagnosis.get("parameters_after") or {}
    mine = {
        address: value
        for address, value in fit.get("parameters", {}).items()
        if address.partition(".")[0] == entry["law"]
    }
    if not mine or not diagnosis.get("model_after"):
        return None
    return parameter_table(
        {**fit, "parameters": mine}, model_from_dict(diagnosis["model_after"], catalogue, "diagnosis")
    )

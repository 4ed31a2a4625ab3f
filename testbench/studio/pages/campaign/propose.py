"""Propose a law: what no effect of the catalogue explains is written as an effect of its own, and put to use."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape

from nicegui import ui

from testbench.comparing.numbers import in_words, plain, with_error
from testbench.comparing.words import percent, spoken
from testbench.report.formula import formula_svg, lines_of
from testbench.report.words import PANEL_UNITS, odds_in_words
from testbench.results.model_file import about_model
from testbench.studio import models, proposed_law
from testbench.studio.pages.campaign.fit_form import add_fit_form
from testbench.studio.pages.campaign.ladder import report_url
from testbench.studio.parts.address import address
from testbench.studio.parts.fields import check, number_field
from testbench.studio.parts.starting import join_running, run_in_turn
from testbench.studio.parts.widgets import (
    aside,
    button,
    campaign_head,
    facts,
    guarded,
    subheading,
    table,
    trouble,
    working,
)
from testbench.studio.studio import Studio

MOST_ASKED = 4
SHOWN = 4
VERDICTS = {
    "nothing_left": "Nothing is left above the noise, so no law is proposed.",
    "no_law": "No law is proposed: no law of the library explains what is left.",
    "does_not_hold": "No law is proposed: what was found does not hold on the held-out samples.",
}


@guarded
async def page(studio: Studio, c: str = "") -> None:
    """The law that campaign `c` lacks."""
    campaign_head(studio, c, "/missing")
    if not models.has_model(studio, c):
        add_fit_form(studio, c)
        return
    _ask(studio, c)
    kept = await aside(proposed_law.kept_proposal, studio, c)
    if kept is not None:
        await _answer(studio, c, kept)


def _ask(studio: Studio, c: str) -> None:
    key = f"propose:{c}"
    with ui.column().classes("card gap-3"):
        subheading(
            "Propose a law",
            "Looks at what the model leaves, and writes the law that explains it: a formula of at most four numbers, "
            "checked on the held-out samples. It takes about a minute.",
        )
        with ui.row().classes("items-start"):
            name = ui.input("Name of the law", value=proposed_law.free_law_name(studio, c))
            name.props("bottom-slots").style("min-width:220px")
            most = number_field("Laws at most", 1, most=MOST_ASKED)
        button("Look for a law", "auto_awesome", lambda: start())
        holder = ui.column().classes("w-full")

    async def start() -> None:
        if studio.jobs.under_way(key):
            return
        check(most)
        with holder, working("Reading the library of laws"):
            wanted = (name.value or "").strip(), int(most.value)
            command = await aside(proposed_law.propose_command, studio, c, *wanted)
        run_in_turn(studio, key, [command], holder, ui.navigate.reload)

    join_running(studio, key, holder, ui.navigate.reload)


async def _answer(studio: Studio, c: str, kept: proposed_law.Kept) -> None:
    found = kept.found
    with ui.column().classes("card gap-2"):
        proposed = f"Proposed: {'; then '.join(law.words for law in found.laws)}."
        ui.label(VERDICTS.get(found.verdict, proposed)).classes("verdict")
        if found.rejected:
            ui.label(f"Found, but not held: {found.rejected.words}.").classes("quiet")
        for note in found.not_judged:
            ui.label(f"Not judged: {note}.").classes("quiet text-sm")
    facts(_errors(found))
    if not found.laws:
        return
    _adding(studio, c, kept)
    errors = _standard_errors(kept)
    for law in found.laws:
        await _law(law, errors)
    if kept.picture:
        _picture(studio, kept)
    with ui.expansion("The effect file", icon="code").classes("card").style("padding:0"):
        ui.label(kept.code).classes("formula")


def _errors(found: proposed_law.Proposal) -> list[tuple[str, str]]:
    pairs = []
    for channel, before in found.error_before.items():
        after, floor, unit = found.error_after[channel], found.noise_floor[channel], PANEL_UNITS[channel]
        fall = f"{plain(before)} → {plain(after)} {unit}" if found.laws else f"{plain(before)} {unit}"
        pairs.append((f"held-out {channel}, refitted{' without and with it' if found.laws else ''}", fall))
        pairs.append((f"noise floor of the {channel}", f"{plain(floor)} {unit}"))
    return pairs


def _adding(studio: Studio, c: str, kept: proposed_law.Kept) -> None:
    """The button that puts it to use, or why it cannot be."""
    if not kept.fresh:
        trouble("The model has changed since this was proposed.", "Look again to see what is missing now.")
        return
    names = " and ".join(spoken(law.effect) for law in kept.found.laws)

    def add() -> None:
        proposed_law.take(studio, c, kept)
        ui.navigate.to(address("/ladder", c=c))

    with ui.row().classes("items-center"):
        button(f"Add {names}", "add", add, "unelevated color=accent")
        words = (
            f"Writes the class below into {studio.effects.path.name}, so that every fit and diagnosis knows it. "
            "The model has been refitted with it already."
        )
        ui.label(words).classes("quiet text-sm")


def _standard_errors(kept: proposed_law.Kept) -> Mapping[str, float]:
    """By address, from the model that was saved with the proposal."""
    path = kept.folder / proposed_law.MODEL
    fit = about_model(path).get("fit", {}) if path.is_file() else {}
    return {key: one["standard_error"] for key, one in fit.get("parameters", {}).items()}


async def _law(law: proposed_law.FoundLaw, errors: Mapping[str, float]) -> None:
    subheading(spoken(law.effect), f"{law.words}.")
    lines = lines_of(law.latex)
    drawn = [await aside(formula_svg, line) for line in lines]
    with ui.column().classes("card gap-2"):
        for line, svg in zip(lines, drawn, strict=True):
            _formula(line, svg)
        with ui.expansion("LaTeX").props("dense").classes("w-full"):
            ui.label(law.latex).classes("formula")
    rows = [_parameter(law, key, errors.get(f"{law.effect}.{key}")) for key in law.parameters]
    table(("Symbol", "What it is", "Value"), rows, _evidence(law))
    if law.alternatives:
        others = [(other.words, _against(other, law)) for other in law.alternatives[:SHOWN]]
        table(("Instead of it", "Odds against that"), others)


def _formula(line: str, svg: str) -> None:
    from testbench.proposing.laws.formulas import plain as read_aloud

    words = read_aloud(line)
    if svg:
        hidden = svg.replace("<svg", '<svg aria-hidden="true"', 1)  # its parts say nothing; the words say it all
        ui.html(hidden, sanitize=False).classes("typeset").props(f'role=img aria-label="{escape(words)}"')
    else:
        ui.label(words).classes("formula")


def _parameter(law: proposed_law.FoundLaw, key: str, error: float | None) -> tuple[str, str, str]:
    """Symbol, meaning and value of a parameter."""
    symbol, _, meaning = law.meanings.get(key, "").partition(": ")
    value, unit = law.parameters[key], law.units.get(key, "")
    return symbol or spoken(key), meaning, with_error(value, error, unit) if error else in_words(value, unit)


def _evidence(law: proposed_law.FoundLaw) -> str:
    return (
        f"± is one standard error. The recordings speak for it with odds of {odds_in_words(law.log_evidence)} "
        "against the model without it. Where they were resampled, it still gains "
        f"in {percent(law.gains_in)} of the cases and is the best law in {percent(law.best_in)}."
    )


def _against(other: proposed_law.Option, law: proposed_law.FoundLaw) -> str:
    from testbench.proposing.hunt import TIED_NATS

    against = law.log_evidence - other.log_evidence
    return f"{odds_in_words(against)}{', cannot be told from it' if abs(against) < TIED_NATS else ''}"


def _picture(studio: Studio, kept: proposed_law.Kept) -> None:
    """What the channel lacks over the law's own coordinate, and the residual before and after."""
    assert kept.picture is not None
    url = report_url(studio, kept.picture)
    name = "Left over by the model, over the law's own coordinate, and the held-out residual without and with it"
    with ui.element("figure").classes("card").style("margin:0"):
        with ui.link(target=url, new_tab=True).props(f'aria-label="{name}: the picture alone"'):
            ui.image(url).classes("w-full").props(f'alt="{name}" no-transition no-spinner fit=contain')
        with ui.element("figcaption").classes("quiet text-sm"):
            ui.label(f"{name}. A click opens it alone.")

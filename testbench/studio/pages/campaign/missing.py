"""Missing effect: ask, see the candidates with their evidence, look at one's prediction, add it."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

from nicegui import ui

from testbench.comparing.words import spoken
from testbench.diagnosis.verdict import with_probability
from testbench.report.figures import diagnosis_figures as figures
from testbench.report.figures.comparison_figures import contribution_kohm
from testbench.report.words import NOT_REFITTED, base_in_words, error_left, verdict_in_words
from testbench.results.result_files import read_diagnosis
from testbench.studio import models
from testbench.studio.memory import stamp
from testbench.studio.pages.campaign.effect_told import effect_told
from testbench.studio.pages.campaign.fit_form import add_fit_form
from testbench.studio.parts.address import Address, address, span_of
from testbench.studio.parts.picture import Span, ZoomingPlot, plot
from testbench.studio.parts.starting import join_running, run_in_turn
from testbench.studio.parts.widgets import (
    KOHM,
    aside,
    attempt,
    button,
    campaign_head,
    guarded,
    later,
    quantity_toggle,
    subheading,
    trouble,
    way_on,
    working,
)
from testbench.studio.studio import Studio

if TYPE_CHECKING:
    from testbench.api.missing.contributing import ContributionResult

SHOWN = 8


@guarded
async def page(studio: Studio, c: str = "", pick: str = "", show: str = "", start: str = "", end: str = "") -> None:
    """The diagnosis of campaign `c`; `pick` is the candidate that is looked at, from `start` to `end` in seconds."""
    campaign_head(studio, c, "/missing", show)
    if not models.has_model(studio, c):
        add_fit_form(studio, c)
        return
    path = models.diagnosis_path(studio, c)
    _ask(studio, c, known=path.is_file())
    if path.is_file():
        diagnosis = read_diagnosis(path)
        if not models.is_fresh(studio, c, diagnosis):
            trouble("The model has changed since this diagnosis.", "Ask again to see what is missing now.")
        await _answer(studio, diagnosis, Address("/missing", c=c, pick=pick, show=show, start=start, end=end))


def _ask(studio: Studio, c: str, known: bool) -> None:
    key = f"diagnose:{c}"

    def start() -> None:
        argv = ["testbench", "diagnose", str(studio.workspace.campaign(c).folder)]
        argv += [*models.same_arguments(studio, c), "--json", str(models.diagnosis_path(studio, c))]
        argv += ["-o", str(models.diagnosed_path(studio, c))]
        command = (f"Looking for what is missing in {c}", argv)
        run_in_turn(studio, key, [command], holder, ui.navigate.reload)

    if not known:
        under = (
            "The effects of the catalogue are put into the model one after the other, and samples that no fit has "
            "seen decide. It takes a few minutes."
        )
        subheading("What does the model lack?", under)
    button("Ask again" if known else "Find what is missing", "search", start, "outline" if known else "unelevated")
    holder = ui.column().classes("w-full")
    join_running(studio, key, holder, ui.navigate.reload)


async def _answer(studio: Studio, diagnosis: Mapping[str, Any], where: Address) -> None:
    c, pick = where.query["c"], where.query["pick"]
    nothing = diagnosis["verdict"] == "nothing_missing"
    with ui.column().classes("card gap-2"):
        ui.label(verdict_in_words(diagnosis)).classes("verdict")
        base = base_in_words(diagnosis)
        if base:
            ui.label(base).classes("quiet")
        if nothing and diagnosis.get("other_laws"):
            _better_law(studio, c, diagnosis)
    ranking = diagnosis["ranking"][:SHOWN]
    if not nothing:
        with ui.row():
            if len(ranking) > 1:
                # The way out of a tie: an experiment that separates the rivals.
                tied = len(diagnosis.get("tied") or []) > 1
                words = (
                    f"Design {'the experiment that tells them apart' if tied else 'an experiment on the first two'}"
                )
                way_on(words, "science", address("/experiment", c=c), "unelevated" if tied else "flat")
            # The way out where no effect fits: a law of its own.
            look = "unelevated" if diagnosis["verdict"] == "unknown" else "flat"
            way_on("Propose a law", "auto_awesome", address("/propose", c=c), look)
    if not ranking:
        return
    plot(figures.candidates(diagnosis), figures.CANDIDATES_CAPTION)
    chosen = next((entry for entry in ranking if entry["law"] == pick), ranking[0])
    candidates = _Candidates(studio, diagnosis, where)
    candidates.adopting()
    candidates.build(ranking, chosen)


def _better_law(studio: Studio, c: str, diagnosis: Mapping[str, Any]) -> None:
    """Nothing is missing, but another law suits the sensor better than the one of the base."""
    laws = [law for law in diagnosis["other_laws"] if law not in models.laws_in(studio, c)]
    if not laws:
        return
    holder = ui.column().classes("w-full")
    done = partial(ui.navigate.to, address("/ladder", c=c))
    start = partial(models.add_laws, studio, c, laws, diagnosis, holder, done)
    names = " and ".join(spoken(law) for law in laws)
    button(f"Use {names}", "swap_horiz", start)


class _Candidates:
    """The list at the left, the one that is looked at on the right."""

    def __init__(self, studio: Studio, diagnosis: Mapping[str, Any], where: Address) -> None:
        self.studio, self.c, self.diagnosis, self.where = studio, where.query["c"], diagnosis, where
        self.span = span_of(where.query["start"], where.query["end"])
        self.cards: dict[str, ui.element] = {}

    def adopting(self) -> None:
        """Where several effects were found: all of them at once, refitted together as the diagnosis has them."""
        found = [spoken(one["law"]) for one in self.diagnosis["found"]]
        if len(found) > 1 and self._is_fresh():
            title = f"Add all that was found: {', '.join(found)}"
            button(title, "playlist_add", self._adopt, "unelevated color=accent")

    def _adopt(self) -> None:
        models.adopt_diagnosed(self.studio, self.c, self.diagnosis)
        ui.navigate.to(address("/ladder", c=self.c))

    def build(self, ranking: list[Mapping[str, Any]], chosen: Mapping[str, Any]) -> None:
        """Lay out the list and the detail."""
        with ui.element("div").classes("split"):
            with ui.column().classes("gap-2"):
                subheading("Candidates", "Choose one to see what it would add.")
                for number, entry in enumerate(ranking, 1):
                    self._card(number, entry)
            self.detail = ui.column().classes("gap-3 w-full")
        later(partial(self._look, chosen))

    def _card(self, number: int, entry: Mapping[str, Any]) -> None:
        left = error_left(entry)
        card = ui.element("button").classes("candidate").on("click", lambda: self._look(entry))
        self.cards[entry["law"]] = card
        with card:
            with ui.row().classes("items-center justify-between w-full no-wrap"):
                ui.label(f"{number}. {with_probability(self.diagnosis, entry['effect'])}").style("font-weight:600")
                if entry["tied_for_first"]:
                    ui.label("tied").classes("tag bad")
            with ui.element("div").classes("meter"):
                ui.element("div").style(f"width:{100 * entry['probability']:.1f}%")
            ui.label(f"leaves {left} of the held-out error" if left else NOT_REFITTED).classes("quiet text-sm")

    async def _look(self, entry: Mapping[str, Any]) -> None:
        for law, card in self.cards.items():
            card.classes(add="chosen" if law == entry["law"] else "", remove="" if law == entry["law"] else "chosen")
        self.where.note(pick=entry["law"])
        await attempt(lambda: self._show(entry))

    async def _show(self, entry: Mapping[str, Any]) -> None:
        self.detail.clear()
        with self.detail, working("Working out what it would add"):
            shown = await aside(self._predicted, entry)
        if self.where.query["pick"] != entry["law"]:
            return  # another one has been chosen meanwhile
        found = shown.contribution
        if self.where.query["show"] == KOHM and shown.ln_S is not None:
            found = contribution_kohm(found, shown.ln_S)
        self.detail.clear()
        with self.detail:
            with ui.row().classes("items-center justify-between w-full"):
                subheading(spoken(entry["law"]), shown.effect.look)
                if entry["law"] in models.laws_in(self.studio, self.c):
                    ui.label("in the model already").classes("tag made")
                elif self.diagnosis["verdict"] != "nothing_missing":
                    title = f"Add {spoken(entry['law'])}"
                    button(title, "add", lambda: self._add(entry), "unelevated color=accent")
            self.holder = ui.column().classes("w-full")
            if shown.ln_S is not None:
                quantity_toggle(self.where)
            caption = (
                "Held-out samples, without what the base laws could take up: what the model leaves, and what "
                "this effect would add."
            )
            drawn = partial(figures.prediction, found.time_s, found.residual, found.added)
            ZoomingPlot(drawn, caption, found.time_s, self.span, self._zoomed)
            caption = "An effect that is really there predicts its own size: its points lie on the dashed line."
            plot(figures.slope(found.residual, found.added), caption)
            effect_told(self.diagnosis, entry, self.studio.effects.catalogue())

    def _zoomed(self, span: Span) -> None:
        self.span = span  # another candidate is looked at over the same stretch
        self.where.note_span(span)

    def _predicted(self, entry: Mapping[str, Any]) -> ContributionResult:
        """What a candidate looks like in data, and what it would add on the held-out samples."""
        studio, c = self.studio, self.c

        def make() -> ContributionResult:
            from testbench.api.missing.contributing import contribution

            recording, other = studio.workspace.recording(c), models.held_out_recording(studio, c)
            effects = studio.effects.catalogue()
            return contribution(self.diagnosis, entry["law"], recording, other, effects=effects)

        files = stamp(models.diagnosis_path(studio, c), models.model_path(studio, c), studio.effects.file)
        return studio.memory.recall(("predicted", c, entry["law"], files), make)

    def _add(self, entry: Mapping[str, Any]) -> None:
        from testbench.api.models.adding import laws_with

        models.check_is_lacking(self.studio, self.c, [entry["law"]])
        done = partial(ui.navigate.to, address("/ladder", c=self.c))
        found = [one["law"] for one in self.diagnosis["found"]]
        misfits = self.diagnosis.get("other_laws") or self.diagnosis.get("base_misfits")
        # What the diagnosis has refitted already need not be fitted again: all that it found, or the shapes alone.
        if self._is_fresh() and (found == [entry["law"]] or (not found and misfits)):
            models.adopt_diagnosed(self.studio, self.c, self.diagnosis)
            if found:
                done()
                return
        path = models.model_path(self.studio, self.c)
        laws = laws_with(self.diagnosis, entry["law"], path, self.studio.effects.catalogue())
        models.add_laws(self.studio, self.c, laws, self.diagnosis, self.holder, done)

    def _is_fresh(self) -> bool:
        """Whether the diagnosis was made of the model as it is now, and its own model is there."""
        own = models.diagnosed_path(self.studio, self.c)
        return own.is_file() and models.is_fresh(self.studio, self.c, self.diagnosis)

"""Campaigns: what is in the folder, found again by words, tags and state; a thumbnail each."""

from __future__ import annotations

from functools import partial

from nicegui import ui

from gcode.support.errors import UserError
from testbench.recordings.manifest import IN_PROGRESS
from testbench.report.recording_figures import summary, thumbnail
from testbench.studio.finding import ORDERS, STATES, Found, all_tags, narrowed
from testbench.studio.notes import Note, tags_of
from testbench.studio.studio import Studio
from testbench.studio.unfinished import is_under_way, is_unfinished
from testbench.studio.widgets import Address, address, aside, attempt, guarded, heading, invitation
from testbench.studio.workspace import Campaign, results_name

AT_ONCE = 36  # cards; more on demand


@guarded
async def page(studio: Studio, q: str = "", state: str = "", tag: str = "", order: str = "") -> None:
    """Every campaign as a card; thumbnails and checksums follow one after the other."""
    where = Address("/", q=q, state=state, tag=tag, order=order)
    everything = await aside(found_in, studio)
    heading("Campaigns")
    if not everything:
        _empty(studio)
        return
    await _List(studio, where, everything).build()


def found_in(studio: Studio) -> list[Found]:
    """Every campaign with its notes and states."""
    notes, made = studio.notes.all(), studio.workspace.made()
    found = []
    for campaign in studio.workspace.campaigns():
        states = made.get(results_name(campaign.name), frozenset())
        states = states | {"unfinished"} if is_unfinished(campaign) else states
        found.append(Found(campaign, notes.get(campaign.name, Note()), states))
    return found


def _empty(studio: Studio) -> None:
    with invitation("Nothing here yet", "Bring a measured CSV, or plan a motion and run it on the simulated rig."):
        ui.button("Import a CSV", icon="upload_file", on_click=lambda: ui.navigate.to("/import")).props("unelevated")
        ui.button("Plan and run", icon="timeline", on_click=lambda: ui.navigate.to("/plan")).props("outline")
    _deleted(studio)


def _deleted(studio: Studio) -> None:
    """What was deleted can be brought back."""
    gone = studio.workspace.deleted()
    if not gone:
        return

    def restore(place) -> None:
        studio.workspace.restore(place)
        ui.navigate.reload()

    with ui.column().classes("card gap-1").props("role=status"):
        for name, place in gone[:5]:
            with ui.row().classes("items-center gap-3"):
                ui.label(f"{name} was deleted.")
                ui.button("Undo", icon="undo", on_click=partial(attempt, partial(restore, place))).props("flat dense")
        if len(gone) > 5:
            ui.label(f"and {len(gone) - 5} before, in results/deleted").classes("quiet text-sm")


class _List:
    """The fields that narrow the list, and the list."""

    def __init__(self, studio: Studio, where: Address, everything: list[Found]) -> None:
        self.studio, self.where, self.everything = studio, where, everything
        self.shown = AT_ONCE
        self.chosen: list[str] = []
        self.turn = 0  # a list that has been replaced is not filled any further

    async def build(self) -> None:
        """Fields, then cards."""
        query = self.where.query
        with ui.row().classes("items-center w-full gap-2"):
            search = ui.input("Search", value=query["q"]).props("outlined dense clearable type=search debounce=250")
            search.classes("grow").style("min-width:200px")
            search.on_value_change(lambda event: self._narrow(q=event.value or ""))
            self._select("State", {"": "Any state", **{one: one for one in STATES}}, "state")
            tags = all_tags(self.everything)
            if tags:
                self._select("Tag", {"": "Any tag", **{tag: tag for tag in tags}}, "tag")
            self._select("Order", ORDERS, "order", "newest")
        with ui.row().classes("items-center gap-3"):
            self.count = ui.label().classes("quiet").props("role=status")
            self.side = ui.button("Compare side by side", icon="compare", on_click=self._side_by_side)
            self.side.props("outline dense")
            self.side.set_visibility(False)
        _deleted(self.studio)
        self.grid = ui.element("div").classes("campaigns")
        self.more = ui.button("Show more", on_click=self._more).props("outline")
        await self._draw()

    def _select(self, label: str, options: dict[str, str], key: str, usual: str = "") -> None:
        value = self.where.query[key] if self.where.query[key] in options else usual
        field = ui.select(options, value=value, label=label).props("outlined dense").style("width:150px")
        field.on_value_change(lambda event: self._narrow(**{key: "" if event.value == usual else event.value}))

    async def _narrow(self, **chosen: str) -> None:
        self.where.note(**chosen)
        self.shown = AT_ONCE
        await self._draw()

    async def _more(self) -> None:
        self.shown += 3 * AT_ONCE
        await self._draw()

    async def _draw(self) -> None:
        self.turn += 1
        turn, query = self.turn, self.where.query
        fits = narrowed(self.everything, query["q"], query["state"], query["tag"], query["order"])
        number = len(self.everything)
        self.count.set_text(
            f"{number} campaign{'s' if number != 1 else ''}" if len(fits) == number else f"{len(fits)} of {number}"
        )
        self.more.set_visibility(len(fits) > self.shown)
        self.grid.clear()
        with self.grid:
            cards = [(found, _Card(self, found)) for found in fits[: self.shown]]
        for found, card in cards:
            if turn != self.turn:
                return
            await card.fill(self.studio, found.campaign)

    def choose(self, name: str, wanted: bool) -> None:
        """Take a campaign into the side-by-side comparison; the last two count."""
        self.chosen = [one for one in self.chosen if one != name] + ([name] if wanted else [])
        self.side.set_visibility(len(self.chosen) > 1)

    def _side_by_side(self) -> None:
        first, second = self.chosen[-2:]
        ui.navigate.to(address("/side", a=first, b=second))

    async def again(self) -> None:
        """Read the folder and the notes anew."""
        self.everything = await aside(found_in, self.studio)
        await self._draw()


class _Card:
    """One campaign: name and tags at once, picture and checksum when they are known."""

    def __init__(self, parent: _List, found: Found) -> None:
        self.parent, self.found = parent, found
        campaign = found.campaign
        with ui.element("div").classes("campaign-card"):
            with ui.link(target=address("/recording", c=campaign.name)).classes("campaign"):
                with ui.row().classes("items-center justify-between w-full no-wrap"):
                    ui.label(campaign.name).classes("name")
                    self.verdict = ui.label("…").classes("tag")
                self.picture = ui.html("", sanitize=False).classes("w-full").style("min-height:64px;margin:8px 0 4px")
                with ui.row().classes("items-center gap-1"):
                    if campaign.origin:
                        ui.label(campaign.origin).classes("tag")
                    self.state = ui.label().classes("tag bad")
                    self.state.set_visibility(False)
                    for made in sorted(found.states - {"unfinished"}, key=STATES.index):
                        ui.label(made).classes("tag made")
                    for tag in found.note.tags:
                        ui.label(tag).classes("tag own")
                self.facts = ui.label("").classes("quiet text-sm")
                if found.note.text:
                    ui.label(found.note.text).classes("text-sm note")
            self._tools(campaign.name)

    def _tools(self, name: str) -> None:
        with ui.row().classes("tools items-center gap-0 no-wrap"):
            choice = ui.checkbox(on_change=lambda event: self.parent.choose(name, event.value)).props("dense")
            choice.props(f'aria-label="Compare {name} with another"').tooltip("Choose two to see them side by side")
            ui.space()
            for icon, what, action in (
                ("sell", "Tags and note", self._edit),
                ("delete_outline", "Delete", self._delete),
            ):
                button = ui.button(icon=icon, on_click=partial(attempt, action)).props("flat dense round size=sm")
                button.props(f'aria-label="{what} of {name}"' if icon == "sell" else f'aria-label="{what} {name}"')
                button.tooltip(what)

    def _edit(self) -> None:
        name, note = self.found.campaign.name, self.found.note
        with ui.dialog() as dialog, ui.card().classes("gap-3").style("min-width:min(420px, 88vw)"):
            ui.label(name).style("font-weight:620")
            tags = ui.input("Tags, with commas between", value=", ".join(note.tags)).classes("w-full")
            text = ui.textarea("Note", value=note.text).classes("w-full")

            async def save() -> None:
                self.parent.studio.notes.put(name, Note(tags_of(tags.value or ""), (text.value or "").strip()))
                dialog.close()
                await self.parent.again()

            with ui.row():
                ui.button("Save", on_click=save).props("unelevated")
                ui.button("Cancel", on_click=dialog.close).props("flat")
        dialog.open()

    def _delete(self) -> None:
        campaign, studio = self.found.campaign, self.parent.studio
        if is_under_way(studio, campaign):
            raise UserError(f"{campaign.name} is being recorded now; stop the recording first")
        studio.workspace.delete(campaign.name)
        ui.navigate.reload()

    async def fill(self, studio: Studio, campaign: Campaign) -> None:
        """Check and draw; a campaign that cannot be read, or is not what was written, says why."""
        growing = campaign.status == IN_PROGRESS
        self._tell_state(studio, campaign)
        try:
            problems = [] if growing else await aside(studio.workspace.problems, campaign.name)
            if problems:
                self._mark("changed" if campaign.origin else "not ours", "bad", "; ".join(problems))
                return
            picture, facts = await aside(_sketch, studio, campaign)
        except UserError as error:
            self._mark("unreadable", "bad", str(error))
            return
        if growing:
            self.verdict.set_visibility(False)  # there is nothing to hold its bytes against yet
        else:
            self._mark("verified", "good")
        self.picture.set_content(picture)
        self.facts.set_text(facts)

    def _tell_state(self, studio: Studio, campaign: Campaign) -> None:
        if is_under_way(studio, campaign):
            self.state.set_text("recording now")
        elif is_unfinished(campaign):
            self.state.set_text("unfinished")
        elif campaign.status not in ("", "complete"):
            self.state.set_text(campaign.status)
        self.state.set_visibility(bool(self.state.text))

    def _mark(self, text: str, kind: str, why: str = "") -> None:
        self.verdict.set_text(text)
        self.verdict.classes(add=kind)
        if why:
            self.verdict.tooltip(why)
            self.facts.set_text(why[:140])


def _sketch(studio: Studio, campaign: Campaign) -> tuple[str, str]:
    """Thumbnail and a line of facts, drawn once."""
    from testbench.studio.memory import stamp

    def draw() -> tuple[str, str]:
        recording = studio.workspace.recording(campaign.name)
        told = summary(recording)
        return thumbnail(recording), " · ".join(value for _, value in told[:1] + told[3:4])

    return studio.sketches.recall(stamp(campaign.folder / "recording.csv"), draw)

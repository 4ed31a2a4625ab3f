"""Campaigns: what is in the folder, found again by words, tags and state; a thumbnail each."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from nicegui import ui

from gcode.support.errors import UserError
from testbench.studio.finding import ORDERS, STATES, Found, all_tags, narrowed
from testbench.studio.notes import Note
from testbench.studio.pages.campaign_card import Card
from testbench.studio.parts.address import Address, address
from testbench.studio.parts.unfinished import is_unfinished
from testbench.studio.parts.widgets import aside, button, guarded, heading, invitation, way_on
from testbench.studio.studio import Studio
from testbench.studio.workspace import results_name

AT_ONCE = 24  # cards; more on demand


@guarded
async def page(studio: Studio, q: str = "", state: str = "", tag: str = "", order: str = "") -> None:
    """Every campaign as a card; thumbnails and checksums follow one after the other."""
    for name, value, allowed in (("state", state, STATES), ("order", order, ORDERS)):
        if value and value not in allowed:
            raise UserError(f"the {name} must be one of {', '.join(allowed)}, got {value!r}")
    everything = await aside(found_in, studio)
    where = Address("/", q=q, state=state, tag=tag if tag in all_tags(everything) else "", order=order)
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
        way_on("Import a file", "upload_file", "/import")
        way_on("Plan and run", "timeline", "/plan", "outline")
    _deleted(studio)


def _deleted(studio: Studio) -> None:
    """What was deleted can be brought back."""
    gone = studio.deleted.all()
    if not gone:
        return

    def restore(place: Path) -> None:
        studio.deleted.restore(place)
        ui.navigate.reload()

    with ui.column().classes("card gap-1").props("role=status"):
        for name, place in gone[:5]:
            with ui.row().classes("items-center gap-3"):
                whole = (place / "campaign").is_dir()
                ui.label(f"{name} was deleted." if whole else f"Results of {name} from before wait for its new ones.")
                button("Undo", "undo", partial(restore, place), "flat dense")
        if len(gone) > 5:
            ui.label(f"and {len(gone) - 5} before, in results/deleted").classes("quiet text-sm")


class _List:
    """The fields that narrow the list, and the list."""

    def __init__(self, studio: Studio, where: Address, everything: list[Found]) -> None:
        self.studio, self.where, self.everything = studio, where, everything
        self.shown = AT_ONCE
        self.chosen: list[str] = []

    async def build(self) -> None:
        """Fields, then cards."""
        query = self.where.query
        with ui.row().classes("items-center w-full gap-2"):
            search = ui.input("Search", value=query["q"]).props("clearable type=search debounce=250")
            search.classes("grow").style("min-width:200px")
            search.on_value_change(lambda event: self._narrow(q=event.value or ""))
            self._select("State", {"": "Any state", **{one: one for one in STATES}}, "state")
            self.tags = self._select("Tag", _tag_options(self.everything), "tag")
            self.tags.set_visibility(len(self.tags.options) > 1)
            self._select("Order", {key: name for key, (name, _) in ORDERS.items()}, "order", "newest")
        with ui.row().classes("items-center gap-3"):
            self.count = ui.label().classes("quiet").props("role=status")
            self.side = button("Compare side by side", "compare", self._side_by_side, "outline dense")
            self.side.set_visibility(False)
        _deleted(self.studio)
        self.grid = ui.element("div").classes("campaigns")
        self.more = button("Show more", "", self._more, "outline")
        await self._draw()

    def _select(self, label: str, options: dict[str, str], key: str, usual: str = "") -> ui.select:
        value = self.where.query[key] if self.where.query[key] in options else usual
        field = ui.select(options, value=value, label=label).style("width:150px")
        field.on_value_change(lambda event: self._narrow(**{key: "" if event.value == usual else event.value}))
        return field

    async def _narrow(self, **chosen: str) -> None:
        self.where.note(**chosen)
        self.shown = AT_ONCE
        await self._draw()

    async def _more(self) -> None:
        self.shown += 3 * AT_ONCE
        await self._draw()

    async def _draw(self) -> None:
        query = self.where.query
        fits = narrowed(self.everything, query["q"], query["state"], query["tag"], query["order"])
        number = len(self.everything)
        self.count.set_text(
            f"{number} campaign{'s' if number != 1 else ''}" if len(fits) == number else f"{len(fits)} of {number}"
        )
        self.more.set_visibility(len(fits) > self.shown)
        self.grid.clear()
        with self.grid:
            cards = [
                Card(self.studio, found, self._choose, self._again, found.campaign.name in self.chosen)
                for found in fits[: self.shown]
            ]
        for card in cards:
            await card.fill()

    def _choose(self, name: str, wanted: bool) -> None:
        """Take a campaign into the side-by-side comparison; the last two count."""
        self.chosen = [one for one in self.chosen if one != name] + ([name] if wanted else [])
        self.side.set_visibility(len(self.chosen) > 1)

    def _side_by_side(self) -> None:
        first, second = self.chosen[-2:]
        ui.navigate.to(address("/side", a=first, b=second))

    async def _again(self) -> None:
        """Read the folder and the notes anew."""
        self.everything = await aside(found_in, self.studio)
        options = _tag_options(self.everything)
        self.tags.set_options(options, value=self.tags.value if self.tags.value in options else "")
        self.tags.set_visibility(len(options) > 1)
        await self._draw()


def _tag_options(everything: list[Found]) -> dict[str, str]:
    return {"": "Any tag", **{tag: tag for tag in all_tags(everything)}}

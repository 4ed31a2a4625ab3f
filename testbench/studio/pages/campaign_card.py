"""One campaign in the list: name and tags at once, picture and checksum when they are known.

A card is one piece of HTML and three controls. Thousands of parts are what a browser is slow at.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from dataclasses import dataclass, replace
from html import escape

from nicegui import ui

from gcode.support.errors import UserError
from testbench.recordings.manifest import CSV, IN_PROGRESS
from testbench.recordings.recording import Recording
from testbench.report.figures.recording_figures import summary, thumbnail
from testbench.studio.finding import STATES, Found
from testbench.studio.memory import stamp
from testbench.studio.notes import Note, tags_of
from testbench.studio.parts.address import address
from testbench.studio.parts.unfinished import is_under_way, is_unfinished
from testbench.studio.parts.widgets import aside, button
from testbench.studio.studio import Studio, campaign_of
from testbench.studio.workspace import Campaign

MOST_SHOWN = 140  # characters of a trouble on a card; all of them are in its tooltip


@dataclass(frozen=True)
class Known:
    """What is known of a campaign beyond its manifest and notes.

    Attributes
    ----------
    verdict : str
        ``verified``, ``changed``, ...; ``""`` where there is nothing to hold its bytes against.
    good : bool or None
        None while it is being looked at.
    why : str
    state : str
        ``unfinished``, ``recording now``, or how else it ended early.
    picture : str
        SVG.
    facts : str
    """

    verdict: str = "…"
    good: bool | None = None
    why: str = ""
    state: str = ""
    picture: str = ""
    facts: str = ""


def card_html(found: Found, known: Known) -> str:
    """The card's inside; whatever comes from a file is escaped."""
    kind = {True: " good", False: " bad", None: ""}[known.good]
    verdict = f'<span class="tag{kind}" title="{escape(known.why)}">{escape(known.verdict)}</span>'
    note = f'<div class="text-sm note">{escape(found.note.text)}</div>' if found.note.text else ""
    trouble = cut_short(known.why.replace(f"{found.campaign.folder}/", ""))
    return (
        f'<div class="top"><span class="name">{escape(found.campaign.name)}</span>{verdict if known.verdict else ""}'
        f'</div><div class="picture">{known.picture}</div><div class="words">{_tags(found, known)}</div>'
        f'<div class="quiet text-sm">{escape(trouble or known.facts)}</div>{note}'
    )


def cut_short(text: str) -> str:
    """At most `MOST_SHOWN` characters, cut between two words, with dots where something is left out."""
    if len(text) <= MOST_SHOWN:
        return text
    return f"{text[:MOST_SHOWN].rpartition(' ')[0] or text[:MOST_SHOWN]} …"


def _tags(found: Found, known: Known) -> str:
    made = sorted(found.states - {"unfinished"}, key=STATES.index)
    tags = [("tag", found.campaign.origin), ("tag bad", known.state)]
    tags += [("tag made", one) for one in made] + [("tag own", one) for one in found.note.tags]
    return "".join(f'<span class="{kind}">{escape(text)}</span>' for kind, text in tags if text)


class Card:
    """A campaign, and what can be done with it.

    `choose` is called with its name and whether it is to be compared with another (`chosen`: it is already);
    `changed` is awaited when the notes have changed.
    """

    def __init__(
        self,
        studio: Studio,
        found: Found,
        choose: Callable[[str, bool], None],
        changed: Callable[[], Awaitable[None]],
        chosen: bool = False,
    ) -> None:
        self.studio, self.found, self.changed = studio, found, changed
        self.known = Known(state=_state(studio, found.campaign))
        with ui.element("div").classes("campaign-card"):
            with ui.link(target=address("/recording", c=found.campaign.name)).classes("campaign"):
                self.inside = ui.html(card_html(found, self.known), sanitize=False)
            self._tools(found.campaign.name, choose, chosen)

    def _tools(self, name: str, choose: Callable[[str, bool], None], chosen: bool) -> None:
        with ui.element("div").classes("tools"):
            choice = ui.checkbox("Compare", value=chosen, on_change=lambda event: choose(name, event.value))
            _named(choice.props("dense"), f"Compare {name} with another", "Choose two to see them side by side")
            for icon, title, label, action in (
                ("sell", "Tags and note", f"Tags and note of {name}", self._edit),
                ("delete_outline", "Delete", f"Delete {name}", self._delete),
            ):
                _named(button("", icon, action, "flat dense round size=sm"), label, title)

    def _edit(self) -> None:
        name, note = self.found.campaign.name, self.found.note
        with ui.dialog() as dialog, ui.card().classes("gap-3").style("min-width:min(420px, 88vw)"):
            ui.label(name).style("font-weight:620")
            tags = ui.input("Tags, with commas between", value=", ".join(note.tags)).classes("w-full")
            text = ui.textarea("Note", value=note.text).classes("w-full")

            async def save() -> None:
                self.studio.notes.put(name, Note(tags_of(tags.value or ""), (text.value or "").strip()))
                dialog.close()
                await self.changed()

            with ui.row():
                button("Save", "", save)
                button("Cancel", "", dialog.close, "flat")
        dialog.open()

    def _delete(self) -> None:
        campaign = self.found.campaign
        if is_under_way(self.studio, campaign):
            raise UserError(f"{campaign.name} is being recorded now; stop the recording first")
        jobs = [job for job in self.studio.jobs.running() if campaign_of(job.key) == campaign.name]
        if jobs:
            raise UserError(f"{campaign.name} is in use: “{jobs[0].title}” is running; end that first")
        self.studio.deleted.add(campaign.name)
        ui.navigate.reload()

    async def fill(self) -> None:
        """Check and draw, unless another list has taken its place meanwhile."""
        with self.inside:
            found = await aside(looked_at, self.studio, self.found.campaign)
        self.known = replace(found, state=self.known.state)
        self.inside.set_content(card_html(self.found, self.known))


def _named(control: ui.element, name: str, title: str) -> None:
    """A name for screen readers, and words for who points at it."""
    control.props["aria-label"], control.props["title"] = name, title


def _state(studio: Studio, campaign: Campaign) -> str:
    if is_under_way(studio, campaign):
        return "recording now"
    if is_unfinished(campaign):
        return "unfinished"
    return "" if campaign.status == "complete" else campaign.status


def looked_at(studio: Studio, campaign: Campaign) -> Known:
    """A campaign that cannot be read, or is not what was written, says why."""
    growing = campaign.status == IN_PROGRESS
    try:
        problems = [] if growing else studio.workspace.problems(campaign.name)
        if problems:
            return Known("changed" if campaign.origin else "not ours", False, "; ".join(problems))
        mark = stamp(campaign.folder / CSV)
        picture, facts = studio.sketches.recall(mark, lambda: _sketch(studio.workspace.recording(campaign.name)))
    except UserError as error:
        return Known("unreadable", False, str(error))
    if growing:  # there is nothing to hold its bytes against yet
        return Known("", None, picture=picture, facts=facts)
    return Known("verified", True, picture=picture, facts=facts)


def _sketch(recording: Recording) -> tuple[str, str]:
    """Thumbnail and a line of facts."""
    told = summary(recording)
    spans = [f"{name.lower()} {span}" for name, span in told[3:4]]  # of the strain, where there is one
    return thumbnail(recording), " · ".join([told[0][1], *spans])

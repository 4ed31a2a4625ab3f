"""Import: a measured file becomes a campaign; the page shows what it takes for what, and asks what it cannot tell."""

from __future__ import annotations

import asyncio
import os
import re
import tempfile
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nicegui import events, ui
from nicegui.elements.mixins.value_element import ValueElement

from gcode.support.errors import UserError
from testbench.importing.signs import SIGNED, TURNED
from testbench.studio.address import Address, address
from testbench.studio.import_form import NOT_THERE, Choices
from testbench.studio.import_look import (
    DECIMALS,
    ENCODINGS,
    SEPARATORS,
    THOUSANDS,
    column_options,
    described,
    known,
    look_at,
    roles_by_number,
    still_to_say,
    unit_key,
    unit_options,
)
from testbench.studio.import_words import R0, TITLES, page_words
from testbench.studio.job_card import job_card
from testbench.studio.jobs import Job, State
from testbench.studio.raw_lines import raw_table
from testbench.studio.studio import Studio
from testbench.studio.widgets import (
    aside,
    attempt,
    guarded,
    heading,
    later,
    name_in_page,
    subheading,
    trouble,
    working,
)

if TYPE_CHECKING:
    from testbench.importing.choice import Choice
    from testbench.importing.sheet import Sheet

LARGEST_BYTES = 2_000_000_000
KINDS = ".csv,.txt,.tsv,.dat,.asc,.raw,.xlsx,.xlsm,.tdms"


@guarded
def page(studio: Studio, file: str = "", name: str = "", chosen: str = "") -> None:
    """Upload or name a file, look at what was found, import.

    `file` on this machine is read at once, as `chosen` before (see `Choices.told`), to become the campaign `name`.
    """
    under = (
        "CSV and other text, Excel or TDMS, as your tester or logger wrote it. A recording needs a time and a "
        "displacement (or strain), or force and resistance."
    )
    heading("Import a measurement", under)
    with ui.column().classes("card gap-3"):
        with ui.row().classes("w-full items-center"):
            path = ui.input("File on this machine", value=file, placeholder="/data/lab/run-7.csv")
            path.props("outlined dense").classes("grow")
            ui.button("Read the file", on_click=lambda: attempt(lambda: form.read(_typed_path(path.value))))
        upload = ui.upload(label="or drop it here", auto_upload=True, max_files=1, max_file_size=LARGEST_BYTES)
        upload.props(f"flat bordered accept={KINDS}").classes("w-full")
    name_in_page(".q-uploader .q-btn, .q-uploader__input", "Choose a file")
    where = Address("/import", file=file, name=name, chosen=chosen)
    form = _Form(studio, where)
    if file:
        later(lambda: attempt(lambda: form.read(Path(file), chosen)))
    ui.context.client.on_delete(form.forget_upload)
    ui.context.client.sub_pages_router.on_path_changed(lambda _: form.left())

    async def received(event: events.UploadEventArguments) -> None:
        form.forget_upload()
        form.upload = tempfile.TemporaryDirectory(prefix="knitbench-upload-")
        target = Path(form.upload.name) / Path(event.file.name).name
        await event.file.save(target)
        upload.reset()
        await attempt(lambda: form.read(target))

    upload.on_upload(received)


class _Form:
    """One file: its first lines, what is what, and the import; all of it built anew for each file."""

    def __init__(self, studio: Studio, where: Address) -> None:
        self.studio, self.where = studio, where
        self.upload: tempfile.TemporaryDirectory | None = None
        self.holder = ui.column().classes("w-full gap-4")
        self.job: Job | None = None
        self.seen: tuple[Sheet, Choice, dict[str, str]] | None = None
        self.unfolded = False  # what was unfolded stays so when the file is looked at again
        self.looking = asyncio.Lock()  # one look after the other; who imports waits for the last
        self.refused = False  # what stands below the button is why nothing was imported

    def forget_upload(self) -> None:
        """Remove what was uploaded; at the latest, that happens when the studio ends."""
        if self.upload is not None:
            self.upload.cleanup()
            self.upload = None

    def left(self) -> None:
        """The page was left: what was uploaded goes, unless it is being imported."""
        if self.job is None or not self.job.running:
            self.forget_upload()

    async def read(self, path: Path, chosen: str = "") -> None:
        """Show a file, with what was chosen for it before."""
        if not path.is_file():
            raise UserError(f"{path}: no such file; name one on this machine, or drop one")
        if self.upload is not None and path.parent != Path(self.upload.name):
            self.forget_upload()
        self.choices, self.refused = Choices.from_told(path, chosen), False
        if not chosen:
            self.where.note(file="" if self.upload else str(path), name="")
        self.holder.clear()
        with self.holder:
            with ui.column().classes("card gap-3"):
                subheading(path.name)
                self.found = ui.label().classes("quiet")
                self.signs = ui.row()
                self._hints()
                self.lines = ui.html("", sanitize=False).classes("rawbox")
            with ui.column().classes("card gap-3"):
                subheading("What is what", "Found by name and unit; choose where it is empty or wrong.")
                self.roles = ui.column().classes("w-full gap-2")
            with ui.column().classes("card gap-3"):
                self._last(path)
        await self.look()

    def _hints(self) -> None:
        """How the file is written, each to be changed."""
        with ui.row().classes("items-center"):
            for name, label in (("header_row", "Header row"), ("units_row", "Units row")):
                number = self.choices.hints.get(name)
                row = ui.number(label, value=number if isinstance(number, int) else None, min=0, format="%.0f")
                row.props("outlined dense debounce=500 clearable")
                row.style("width:120px").tooltip("counting from 1; 0: there is none; empty: found")
                row.on_value_change(partial(self._hinted, name))
            for name, label, options in (
                ("separator", "Separator", SEPARATORS),
                ("decimal", "Decimal sign", DECIMALS),
                ("thousands", "Thousands", THOUSANDS),
                ("encoding", "Encoding", ENCODINGS),
            ):
                choice = ui.select(options, value=known(options, self.choices.hints.get(name)), label=label)
                choice.props("outlined dense").style("width:150px")
                choice.on_value_change(partial(self._hinted, name))
            if self.choices.path.suffix.lower() in (".xlsx", ".xlsm", ".tdms"):
                sheet = ui.input("Sheet", value=str(self.choices.hints.get("sheet") or ""))
                sheet.props("outlined dense debounce=600").style("width:150px")
                sheet.on_value_change(partial(self._hinted, "sheet"))

    async def _hinted(self, name: str, event: events.ValueChangeEventArguments) -> None:
        value = int(event.value) if name.endswith("_row") and event.value is not None else event.value
        self.choices.hints[name] = None if value == "" else value
        self.choices.columns.clear()
        await self.look()

    def _last(self, path: Path) -> None:
        """Gauge length, name, and the button; what comes of it appears right below."""
        free = self.where.query["name"] or re.sub(r"[^A-Za-z0-9._-]+", "-", path.stem).strip("-.") or "imported"
        with ui.row().classes("items-center"):
            gauge = ui.number("Gauge length / mm", min=0.001, format="%.6g").props("outlined dense")
            gauge.tooltip("length of the sensor between the clamps at rest").bind_value(
                self.choices, "gauge_length_mm"
            )
            self.name = ui.input("Campaign name", value=free).props("outlined dense")
            self.name.on_value_change(self._named)
            boxes = ("Put rows in the order of time", "sort"), ("Leave out rows that cannot be used", "drop_bad")
            fields: list[ValueElement] = [gauge]
            fields += [ui.checkbox(title).bind_value(self.choices, key) for title, key in boxes]
            for field in fields:
                field.on_value_change(self._note)
        ui.button("Import", icon="check", on_click=self._import)
        self.result = ui.column().classes("w-full gap-3").props("aria-live=polite")

    def _note(self) -> None:
        """Keep what was chosen in the address; an upload has none that could be opened again."""
        if self.upload is None:
            self.where.note(chosen=self.choices.told())
        self._ask_again()

    def _named(self) -> None:
        self.where.note(name=self.name.value or "")
        self._ask_again()

    def _ask_again(self) -> None:
        """What was missing may be there now."""
        if self.refused:
            self._import_command()

    async def look(self) -> None:
        """Look at the file once more with what has been chosen, and show it."""
        async with self.looking:
            with self.signs, working("Reading the file"):
                await self._look()
        self._note()

    async def _look(self) -> None:
        try:
            self.seen = await aside(look_at, self.choices)
        except UserError as error:
            self.seen = None
            self.found.set_text("")
            self.roles.clear()
            with self.roles:
                trouble(page_words(str(error)))
            return
        sheet, choice, words = self.seen
        self.found.set_text(described(sheet))
        self.lines.set_content(raw_table(sheet, roles_by_number(choice)))
        self.roles.clear()
        with self.roles:
            self._roles(sheet, choice, words)

    def _roles(self, sheet: Sheet, choice: Choice, words: dict[str, str]) -> None:
        asked = {one.role for one in choice.troubles} | set(choice.taken)
        if not {"displacement", "strain"} & set(choice.taken):
            asked |= {"displacement"}
        shown = [role for role in TITLES if role in asked or role in ("time", "force", "resistance")]
        for role in shown:
            self._role(role, sheet, choice, words)
        if "time" not in choice.taken:
            rate = ui.number("Sampling rate / Hz", value=self.choices.rate_hz, min=0, format="%.6g")
            rate.props("outlined dense debounce=500").on_value_change(partial(self._set, "rate_hz"))
        if {"relative", "relative_change"} & set(choice.taken):
            ohm = ui.number(R0, value=self.choices.r0_ohm, min=0, format="%.6g")
            ohm.props("outlined dense debounce=500").on_value_change(partial(self._set, "r0_ohm"))
        others = ui.expansion("Other quantities, and several clocks").bind_value(self, "unfolded")
        with others.classes("w-full").props("dense"):
            for role in TITLES:
                if role not in shown:
                    self._role(role, sheet, choice, words)
            self._clocks(sheet, choice)
        for note in choice.notes:
            ui.label(page_words(note)).classes("quiet")

    async def _set(self, name: str, event: events.ValueChangeEventArguments) -> None:
        setattr(self.choices, name, event.value or None)
        await self.look()

    def _role(self, role: str, sheet: Sheet, choice: Choice, words: dict[str, str]) -> None:
        """One quantity: its column, its unit, and a value as it is read."""
        taken, title = choice.taken.get(role), TITLES[role]
        with ui.element("div").classes("role"):
            ui.label(title).style("font-weight:550")
            value = str(taken.column.number) if taken else NOT_THERE
            column = ui.select(column_options(sheet), value=value).props("outlined dense")
            column.props(f"aria-label='Column of {title.lower()}'")
            column.on_value_change(partial(self._column_chosen, role))
            unit = ui.select(unit_options(role), value=unit_key(choice, role), label=f"Unit of {title.lower()}")
            unit.props("outlined dense").set_enabled(taken is not None)
            unit.on_value_change(partial(self._unit_chosen, role))
            with ui.row().classes("items-center gap-2"):
                wrong = still_to_say(choice, role)
                ui.label(wrong or words.get(role, "")).classes("wrong" if wrong else "")
                if role in TURNED and taken:
                    self._repairs(role)

    def _repairs(self, role: str) -> None:
        for label, marked in (
            ("Turn the sign", self.choices.negate),
            ("Count from the first sample", self.choices.zero),
        ):
            if marked is self.choices.zero and role not in SIGNED:
                continue

            def mark(event: events.ValueChangeEventArguments, marked: set[str] = marked) -> None:
                (marked.add if event.value else marked.discard)(role)
                self._note()

            box = ui.checkbox(label, value=role in marked, on_change=mark).props("dense")
            box.classes("text-sm").props(f"aria-label='{label} of the {role}'")

    async def _column_chosen(self, role: str, event: events.ValueChangeEventArguments) -> None:
        self.choices.set_column(role, None if event.value == NOT_THERE else event.value)
        await self.look()

    async def _unit_chosen(self, role: str, event: events.ValueChangeEventArguments) -> None:
        self.choices.units[role] = event.value
        await self.look()

    def _clocks(self, sheet: Sheet, choice: Choice) -> None:
        """Where channels have clocks of their own."""
        for role in ("displacement", "strain", "force", "resistance"):
            taken = choice.taken.get(role)
            if taken is None:
                continue
            value = str(taken.clock.number) if taken.clock else NOT_THERE
            options = column_options(sheet) | {NOT_THERE: "(those of time)"}
            clock = ui.select(options, value=value, label=f"Own times of {role}").props("outlined dense")
            clock.style("width:320px").on_value_change(partial(self._clock_chosen, role))

    async def _clock_chosen(self, role: str, event: events.ValueChangeEventArguments) -> None:
        self.choices.clocks.pop(role, None)
        if event.value != NOT_THERE:
            self.choices.clocks[role] = event.value
        await self.look()

    async def _import(self) -> None:
        """Start the import, or say right here what is missing."""
        async with self.looking:  # what was chosen last is still being looked at
            pass
        argv = self._import_command()
        with self.result:
            if argv:
                title = f"Importing {self.choices.path.name}"
                self.job = self.studio.jobs.start(f"import:{self.name.value}", title, argv)
                job_card(self.studio, self.job, self._ended)
        self._show_result()

    def _import_command(self) -> list[str]:
        """The command that imports; empty where something is missing, which is said until it is there."""
        self.result.clear()
        try:
            argv = self._command(self.name.value)
        except UserError as error:
            with self.result:
                trouble(str(error))
            argv = []
        self.refused = not argv
        return argv

    def _command(self, name: str) -> list[str]:
        if self.seen is None:
            raise UserError("the file cannot be read yet: see above")
        choice = self.seen[1]
        if choice.troubles:
            first = choice.troubles[0].role
            raise UserError(f"{TITLES[first]}: {still_to_say(choice, first)}")
        return self.choices.command(self.studio.workspace.free_name(name), set(choice.taken))

    def _ended(self, job: Job) -> None:
        """Go to the recording; stay where there is something to be read first."""
        if job.state is State.FAILED:
            self.result.clear()
            with self.result:
                trouble(page_words(job.problem.replace(f"{self.choices.path}: ", "")))
            self._show_result()
        if job.state is not State.DONE:
            return
        self.forget_upload()
        made = job.latest["recordings"]
        doubts = [f"{Path(one['out']).name}: {doubt}" for one in made for doubt in one["doubts"]]
        if not doubts and len(made) == 1:
            ui.navigate.to(self._address(made[0]))
            return
        self.result.clear()
        with self.result:
            for doubt in doubts:
                trouble(page_words(doubt))
            if doubts:
                ui.label("Import it again under another name with this changed, or leave it as it is.").classes(
                    "quiet"
                )
            with ui.row():
                for one in made:
                    label = f"Open {Path(one['out']).name}"
                    ui.button(label, on_click=partial(ui.navigate.to, self._address(one))).props("outline")

        self._show_result()

    def _show_result(self) -> None:
        """Bring what came of the import to where the eye is."""
        with self.result:
            ui.run_javascript(f"getHtmlElement({self.result.id}).scrollIntoView({{block: 'end'}})")

    def _address(self, made: dict[str, Any]) -> str:
        return address("/recording", c=Path(made["out"]).relative_to(self.studio.workspace.root).as_posix())


def _typed_path(text: str | None) -> Path:
    """What stands in “File on this machine”, as a shell would take it.

    Raises
    ------
    UserError
        If nothing does.
    """
    if not text or not text.strip():
        raise UserError("“File on this machine” is empty: name a file, or drop one")
    return Path(os.path.expanduser(text.strip()))

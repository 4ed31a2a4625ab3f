"""Import: a measured file becomes a campaign; the page shows what it takes for what, and asks what it cannot tell."""

from __future__ import annotations

import asyncio
import re
import tempfile
from functools import partial
from pathlib import Path
from typing import Any

from nicegui import events, ui
from nicegui.elements.mixins.value_element import ValueElement

from gcode.support.errors import UserError
from testbench.studio.importing.import_columns import Columns
from testbench.studio.importing.import_form import Choices
from testbench.studio.importing.import_look import Seen, described, look_at, raw_table, roles_by_number, still_to_say
from testbench.studio.importing.import_words import TITLES, left_out_in_words, page_words
from testbench.studio.jobs.job import Job, State
from testbench.studio.parts.address import Address, address
from testbench.studio.parts.fields import check, number_field, typed_path
from testbench.studio.parts.job_card import JobCard
from testbench.studio.parts.starting import join_newest
from testbench.studio.parts.widgets import (
    aside,
    attempt,
    button,
    guarded,
    heading,
    later,
    name_in_page,
    subheading,
    trouble,
    way_on,
    working,
)
from testbench.studio.studio import Studio

LARGEST_BYTES = 2_000_000_000
REASONS = "(entries) => emit(entries.map(one => [one.failedPropValidation, one.file.name]))"
FILE = 2  # in the command line of an import
KINDS = ".csv,.txt,.tsv,.dat,.asc,.raw,.log,.lvm,.tra,.xlsx,.xlsm,.xls,.tdms,.parquet,.json,.jsonl,.html"


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
            path.classes("grow").on("keydown.enter", lambda: attempt(read_typed))
            button("Read the file", "", lambda: read_typed())
        # Of several files a browser hands on the first and drops the others silently, unless they are allowed.
        upload = ui.upload(
            label="or drop it here", auto_upload=True, multiple=True, max_files=1, max_file_size=LARGEST_BYTES
        )
        upload.props(f"flat bordered accept={KINDS}").classes("w-full")
    name_in_page(".q-uploader .q-btn, .q-uploader__input", "Choose a file")
    where = Address("/import", file=file, name=name, chosen=chosen)
    form = _Form(studio, where)
    if file:
        later(lambda: attempt(lambda: form.read(Path(file), chosen)))
    ui.context.client.on_delete(form.forget_upload)
    ui.context.client.sub_pages_router.on_path_changed(lambda _: form.left())

    async def read_typed() -> None:
        await form.read(typed_path(path.value, "File on this machine", "name a file, or drop one"))

    async def received(event: events.UploadEventArguments) -> None:
        form.forget_upload()
        form.upload = tempfile.TemporaryDirectory(prefix="knitbench-upload-")
        target = Path(form.upload.name) / Path(event.file.name).name
        await event.file.save(target)
        upload.reset()
        await attempt(lambda: form.read(target))

    def refuse(left_out: list[list[str]]) -> None:
        raise UserError(left_out_in_words(left_out, KINDS))

    upload.on_upload(received)
    upload.on("rejected", lambda event: attempt(partial(refuse, event.args)), js_handler=REASONS)


class _Form:
    """One file: its first lines, what is what, and the import; all of it built anew for each file."""

    def __init__(self, studio: Studio, where: Address) -> None:
        self.studio, self.where = studio, where
        self.upload: tempfile.TemporaryDirectory | None = None
        self.before = _result_column()  # what came of an import before this page was read anew
        join_newest(
            self.before, studio, "import", partial(self._ended, self.before), partial(self._show, self.before)
        )
        self.holder = ui.column().classes("w-full gap-4")
        self.job: Job | None = None
        self.seen: Seen | None = None
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
                self.columns = Columns(self.choices, self.look, self._note)
                self.columns.hints()
                self.lines = ui.html("", sanitize=False).classes("rawbox")
            with ui.column().classes("card gap-3"):
                subheading("What is what", "Found by name and unit; choose where it is empty or wrong.")
                self.roles = ui.column().classes("w-full gap-2")
            with ui.column().classes("card gap-3"):
                self._last(path)
        await self.look()

    def _last(self, path: Path) -> None:
        """Gauge length, name, and the button; what comes of it appears right below."""
        free = self.where.query["name"] or re.sub(r"[^\w.-]+", "-", path.stem).strip("-.") or "imported"
        with ui.row().classes("items-start"):
            self.gauge = number_field("Gauge length / mm", None, optional=True)
            self.gauge.tooltip("length of the sensor between the clamps at rest")
            self.gauge.bind_value(self.choices, "gauge_length_mm")
            self.name = ui.input("Campaign name", value=free)
            self.name.on_value_change(self._named)
        with ui.row():
            boxes = ("Put rows in the order of time", "sort"), ("Leave out rows that cannot be used", "drop_bad")
            fields: list[ValueElement] = [self.gauge]
            fields += [ui.checkbox(title).bind_value(self.choices, key) for title, key in boxes]
            for field in fields:
                field.on_value_change(self._note)
        button("Import", "check", self._import)
        self.result = _result_column()

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
            self.columns.roles(sheet, choice, words)

    async def _import(self) -> None:
        """Start the import, or say right here what is missing."""
        async with self.looking:  # what was chosen last is still being looked at
            pass
        argv = self._import_command()
        with self.result:
            if argv:
                title = f"Importing {self.choices.path.name}"
                self.job = self.studio.jobs.start(f"import:{self.name.value}", title, argv)
                JobCard(self.studio, self.job, partial(self._ended, self.result))
        _bring_into_view(self.result)

    def _import_command(self) -> list[str]:
        """The command that imports; empty where something is missing, which is said until it is there."""
        self.result.clear()
        self.before.clear()
        try:
            check(self.gauge, *self.columns.numbers)
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

    def _ended(self, holder: ui.column, job: Job) -> None:
        """Go to the recording; stay where there is something to be read first."""
        if job.state is State.FAILED:
            holder.clear()
            with holder:
                trouble(page_words(job.problem.replace(f"{job.argv[FILE]}: ", "")))
        elif job.state is State.DONE:
            self.forget_upload()
            made = job.latest["recordings"]
            if len(made) == 1 and not made[0]["doubts"]:
                ui.navigate.to(self._address(made[0]))
                return
            holder.clear()
            self._show(holder, job)
        _bring_into_view(holder)

    def _show(self, holder: ui.column, job: Job) -> None:
        """What came of an import: what looks wrong, and the way to each recording."""
        made = job.latest["recordings"]
        doubts = [f"{Path(one['out']).name}: {doubt}" for one in made for doubt in one["doubts"]]
        with holder:
            for doubt in doubts:
                trouble(page_words(doubt))
            if doubts:
                words = "Import it again under another name with this changed, or leave it as it is."
                ui.label(words).classes("quiet")
            with ui.row():
                for one in made:
                    label = f"Open {Path(one['out']).name}"
                    way_on(label, "", self._address(one), "outline")

    def _address(self, made: dict[str, Any]) -> str:
        return address("/recording", c=self.studio.workspace.name_of(Path(made["out"])))


def _result_column() -> ui.column:
    return ui.column().classes("w-full gap-3").props("aria-live=polite")


def _bring_into_view(result: ui.column) -> None:
    """Bring what came of the import to where the eye is."""
    with result:
        ui.run_javascript(f"getHtmlElement({result.id}).scrollIntoView({{block: 'end'}})")

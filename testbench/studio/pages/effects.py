"""Own effects: write one in the browser or in your editor, have it checked, use it like a built-in."""

from __future__ import annotations

import re

from nicegui import ui

from gcode.support.errors import UserError
from gcode.support.files import write_text
from testbench.studio.jobs.job import Job, State
from testbench.studio.memory import stamp
from testbench.studio.parts.fields import typed_path
from testbench.studio.parts.starting import start_in
from testbench.studio.parts.widgets import button, guarded, heading, name_in_page, trouble
from testbench.studio.studio import Studio


@guarded
def page(studio: Studio) -> None:
    """The file of own effects in an editor; errors are shown beside it."""
    under = "One class each, written here or in your own editor. They take part in every fit and diagnosis."
    heading("Own effects", under)
    _Editor(studio)


class _Editor:
    """Name, text, buttons, and what the check says."""

    def __init__(self, studio: Studio) -> None:
        self.studio, self.path = studio, studio.effects.path
        self.mark = stamp(self.path)  # of the file as it stands in the editor
        with ui.column().classes("card gap-3"):
            with ui.row().classes("items-center"):
                self.name = ui.input("Name of a new effect", placeholder="my_effect")
                button("Start from the template", "note_add", self._start, "outline")
                button("Save and check", "check", self._save)
                button("Read the file again", "refresh", self._read, "flat")
            with ui.row().classes("items-center w-full"):
                self.where = ui.input("File in use", value=str(self.path)).classes("grow")
                button("Use this file", "folder_open", self._point, "outline")
            self.text = ui.codemirror("", language="Python", theme="basicLight")
            self.text.classes("w-full").style("height:440px;border:1px solid var(--rule);border-radius:9px")
        name_in_page(".cm-content", "Python file of own effects")
        self.result = ui.column().classes("w-full")
        try:
            self._read()
        except UserError as error:  # the editor stays empty, and another file can be chosen
            trouble(str(error))
        if self.path != self.studio.effects.here and not self.path.is_file():
            trouble(f"{self.path} was pointed to, and is gone.", self._remedy())

    def _remedy(self) -> str:
        return f"Bring it back, or use another file; that of this workspace is {self.studio.effects.here}."

    def _check_place(self) -> None:
        if not self.path.parent.is_dir():
            raise UserError(f"{self.path.parent}: no such folder. {self._remedy()}")

    def _point(self) -> None:
        self.studio.effects.point_to(typed_path(self.where.value, "File in use", "name a .py file on this machine"))
        self.path = self.studio.effects.path
        self.where.set_value(str(self.path))
        self._read()

    def _read(self) -> None:
        self.mark = stamp(self.path)
        self.text.set_value(self.studio.effects.text())

    def _start(self) -> None:
        name = self.name.value or ""
        if not re.fullmatch(r"[a-z][a-z0-9_]*", name):
            raise UserError(f"an effect's name is lower case with underscores, such as my_effect; got {name!r}")
        self._check_place()
        if self.path.exists():
            raise UserError(f"{self.path.name} is there already; write the new class below the others")
        self._run(["testbench", "effects", "--new", name, "-o", str(self.path)], "Writing the template")

    def _save(self) -> None:
        if not self.text.value.strip():
            raise UserError("there is nothing to check; start from the template, or write a class")
        self._check_place()
        if stamp(self.path) != self.mark:
            raise UserError(
                f"{self.path.name} was changed on disk since it was read here; keep a copy of what you have written, "
                "and read the file again"
            )
        write_text(self.path, self.text.value)
        self.mark = stamp(self.path)
        self.studio.effects.agree()  # who saves it here wants it to run
        argv = ["testbench", "effects", "--effects", str(self.path), "--check"]
        self._run(argv, "Trying the rules that every effect keeps")

    def _run(self, argv: list[str], title: str) -> None:
        start_in(self.result, self.studio, "effects", title, argv, self._told)

    def _told(self, job: Job) -> None:
        with self.result:
            for line in job.lines:
                ui.label(line).classes("mono")
        if job.state is State.DONE and "--new" in job.argv:
            self.studio.effects.agree()  # our own template
            self._read()

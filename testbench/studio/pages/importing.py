"""Import: a measured CSV becomes a campaign by saying which column is what."""

from __future__ import annotations

import re
import tempfile
from pathlib import Path

from nicegui import events, ui

from gcode.support.errors import UserError
from testbench.studio.columns import UNITS, column_names, guess, guess_unit
from testbench.studio.jobs import Job, State
from testbench.studio.studio import Studio
from testbench.studio.widgets import address, aside, attempt, guarded, heading, job_card, name_in_page, subheading

NONE = "(not recorded)"
LARGEST_BYTES = 2_000_000_000


@guarded
def page(studio: Studio) -> None:
    """Upload or name a file, choose its columns, import."""
    under = (
        "A recording needs time and displacement (or strain); force and resistance where you have them. Separator, "
        "decimal comma and header line are found by themselves."
    )
    heading("Import a CSV", under)
    with ui.column().classes("card gap-3"):
        with ui.row().classes("w-full items-center"):
            path = ui.input("File on this machine", placeholder="/data/lab/run-7.csv").props("outlined dense")
            path.classes("grow")
            ui.button("Read its columns", on_click=lambda: attempt(lambda: form.read(Path(path.value or ""))))
        upload = ui.upload(label="or drop it here", auto_upload=True, max_files=1, max_file_size=LARGEST_BYTES)
        upload.props("flat bordered accept=.csv,.txt,.tsv,.dat").classes("w-full")
    ui.timer(0.5, lambda: name_in_page(".q-uploader .q-btn, .q-uploader__input", "Choose a CSV"), once=True)
    form = _Form(studio)

    async def received(event: events.UploadEventArguments) -> None:
        folder = Path(tempfile.mkdtemp(prefix="knitbench-upload-"))
        target = folder / Path(event.file.name).name
        await event.file.save(target)
        await attempt(lambda: form.read(target))

    upload.on_upload(received)


class _Form:
    """Which column is what; built anew for each file."""

    def __init__(self, studio: Studio) -> None:
        self.studio = studio
        self.holder = ui.column().classes("w-full gap-4")

    async def read(self, path: Path) -> None:
        """Show the columns of `path`."""
        if not path.is_file():
            raise UserError(f"{path or 'file'}: no such file; name a CSV on this machine or drop one")
        names = await aside(column_names, path)
        if len(names) < 2:
            raise UserError(
                f"{path.name}: only one column ({', '.join(names)}); a recording needs time and displacement"
            )
        self.holder.clear()
        with self.holder:
            self._build(path, names)

    def _build(self, path: Path, names: list[str]) -> None:
        with ui.column().classes("card gap-3"):
            subheading(f"Columns of {path.name}", ", ".join(names))
            columns = {what: self._choice(what, names) for what in UNITS}
            if columns["displacement"][0].value != NONE:
                columns["strain"][0].set_value(NONE)
            with ui.row().classes("items-center"):
                gauge = ui.number("Gauge length / mm", value=25, min=0.001, format="%.6g").props("outlined dense")
                free = re.sub(r"[^A-Za-z0-9._-]+", "-", path.stem).strip("-.") or "imported"
                name = ui.input("Campaign name", value=free).props("outlined dense")
            with ui.row():
                sort = ui.checkbox("Put rows in the order of time")
                drop = ui.checkbox("Leave out rows that cannot be used")

            async def start() -> None:
                argv = self._command(path, columns, gauge.value, name.value, sort.value, drop.value)
                job = self.studio.jobs.start(f"import:{name.value}", f"Importing {path.name}", argv)
                with self.holder:
                    job_card(self.studio, job, self._ended)

            ui.button("Import", icon="check", on_click=lambda: attempt(start))

    def _choice(self, what: str, names: list[str]) -> tuple[ui.select, ui.select]:
        found = guess(names, what)
        with ui.row().classes("items-center no-wrap w-full"):
            ui.label(what.capitalize()).style("width:110px;font-weight:550")
            column = ui.select([NONE, *names], value=found or NONE, label="Column").props("outlined dense")
            column.classes("grow").props(f"aria-label='Column of {what}'")
            unit = ui.select(list(UNITS[what]), value=guess_unit(found, what), label="Unit").props("outlined dense")
            unit.style("width:110px")
        return column, unit

    def _command(
        self, path: Path, columns: dict, gauge: float | None, name: str, sort: bool, drop: bool
    ) -> list[str]:
        """The command line that does it.

        Raises
        ------
        UserError
            If a column or the gauge length is missing.
        """
        chosen = {what: (c.value, u.value) for what, (c, u) in columns.items() if c.value != NONE}
        if "time" not in chosen:
            raise UserError("choose the column of the time")
        if ("displacement" in chosen) == ("strain" in chosen):
            raise UserError("choose the column of the displacement, or that of the strain, and not both")
        if not gauge:
            raise UserError("say the gauge length in mm: the sensor's length between the clamps at rest")
        folder = self.studio.workspace.free_name(name)
        argv = ["testbench", "import", str(path), "--gauge-length-mm", f"{gauge:g}"]
        for what, (column, unit) in chosen.items():
            argv += [f"--{what}", column, f"--{what}-unit", unit]
        argv += ["--sort"] * sort + ["--drop-bad"] * drop
        return [*argv, "-o", str(folder)]

    def _ended(self, job: Job) -> None:
        if job.state is State.DONE:
            name = Path(job.argv[-1]).relative_to(self.studio.workspace.root).as_posix()
            ui.navigate.to(address("/recording", c=name))

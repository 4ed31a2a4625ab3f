"""Align: delay and clock drift between the program that was run and what was recorded of it."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from nicegui import ui

from gcode.support.errors import UserError
from testbench.recordings.channels import DISPLACEMENT
from testbench.recordings.manifest import CSV
from testbench.report.figures.motion_figures import alignment
from testbench.report.words import sentence
from testbench.studio.memory import stamp
from testbench.studio.parts.address import Address, span_of
from testbench.studio.parts.picture import ZoomingPlot
from testbench.studio.parts.starting import open_campaign_of, start_in
from testbench.studio.parts.widgets import aside, button, campaign_head, facts, guarded, subheading, working
from testbench.studio.studio import Studio

if TYPE_CHECKING:
    from testbench.api.bench.aligning import AlignmentResult


@guarded
async def page(studio: Studio, c: str = "", start: str = "", end: str = "") -> None:
    """How the clocks of campaign `c` and of its program relate."""
    campaign_head(studio, c, "/recording")
    subheading(
        "Plan and recording", "Two clocks took part, the machine's and the rig's: they start apart and run apart."
    )
    if not program_of(studio, c).is_file():
        raise UserError(f"{c} has no program in its folder, so there is no plan to compare it with")
    with working("Comparing the recording with its program"):
        result = await aside(_found, studio, c)
    found, on_plan = result.alignment, result.recording
    ui.label(sentence(result.words[0])).classes("verdict")
    facts(
        [
            ("the plan began, on the recorder's clock", f"{round(found.delay_s, 3) + 0.0:+.3f} s"),
            ("the plan's clock against the recorder's", f"{round(found.drift_ppm):+d} ppm"),
            ("recorded where the plan says zero", f"{round(1e3 * found.offset_mm, 1) + 0.0:+.1f} µm"),
            ("left between the two, RMS", f"{1e3 * found.rms_mm:.1f} µm"),
            ("correlation", f"{found.correlation:.5f}"),
        ]
    )
    from testbench.campaigns.alignment import PLANNED

    drawn = partial(alignment, on_plan.time_s, on_plan[DISPLACEMENT] - found.offset_mm, on_plan[PLANNED])
    caption = "Both motions on the plan's clock, and what is left between them. Drag to zoom both rows."
    where = Address("/align", c=c, start=start, end=end)
    ZoomingPlot(drawn, caption, on_plan.time_s, span_of(start, end), where.note_span)
    _keep(studio, c)


def program_of(studio: Studio, c: str) -> Path:
    """The program that a campaign keeps beside its recording."""
    from testbench.campaigns.plan import PROGRAM

    return studio.workspace.campaign(c).folder / PROGRAM


def _found(studio: Studio, c: str) -> AlignmentResult:
    """As `testbench align` does it, remembered."""
    from testbench.api.bench.aligning import align

    program = program_of(studio, c)
    files = stamp(program, program.with_name(CSV))
    return studio.memory.recall(("align", files), lambda: align(studio.workspace.recording(c), program))


def _keep(studio: Studio, c: str) -> None:
    with ui.column().classes("card gap-3"):
        subheading(
            "Keep it on the plan's clock", "A new campaign with the planned displacement as a channel of its own."
        )
        with ui.row().classes("items-center"):
            name = ui.input("Campaign name", value=f"{c}-aligned").style("min-width:300px")
            button("Write it", "save", lambda: start(), "outline")
        holder = ui.column().classes("w-full")

    def start() -> None:
        target = studio.workspace.free_name(name.value)
        argv = ["testbench", "align", str(studio.workspace.campaign(c).folder), "-o", str(target)]
        start_in(holder, studio, f"align:{c}", f"Aligning {c}", argv, partial(open_campaign_of, studio))

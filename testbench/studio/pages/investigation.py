"""Investigations: what was believed after each run, the motions, and where their recordings are."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from nicegui import ui

from gcode.support.errors import UserError
from testbench.studio.parts.address import address
from testbench.studio.parts.picture import plot
from testbench.studio.parts.widgets import aside, guarded, heading, invitation, table
from testbench.studio.studio import Studio
from testbench.studio.workspace import MANIFEST, MAX_DEPTH, holding

if TYPE_CHECKING:
    from testbench.investigating.state import Investigation


@guarded
async def page(studio: Studio, i: str = "") -> None:
    """Investigation `i`, a folder of the workspace; without it, the list of all."""
    root = studio.workspace.root
    heading("Investigations", "Experiments in turn, each designed on what the ones before left open.")
    names = await aside(investigations, root)
    if not names:
        with invitation("No investigation yet", "Start one in this folder, on the simulated rig or a real one:"):
            ui.label("testbench investigate pes@3 -o my-investigation").classes("mono")
        return
    for name in names:
        ui.link(name, address("/investigation", i=name)).classes("way")
    if i or len(names) == 1:
        await _shown(root, i or names[0], names)


def investigations(root: Path) -> list[str]:
    """Folders below `root` that hold one, by name; their runs are campaigns, which lie one folder deeper."""
    from testbench.investigating.state import NAME

    return sorted(Path(folder).relative_to(root).as_posix() for folder, _ in holding(NAME, root, MAX_DEPTH - 1))


async def _shown(root: Path, name: str, names: list[str]) -> None:
    if name not in names:
        raise UserError(f"no investigation {name!r} in {root}; there are {', '.join(names)}")
    from testbench.api.experiments.investigation import motions_of
    from testbench.investigating.state import load_investigation, run_folder
    from testbench.investigating.words import ending_words
    from testbench.report.figures.investigation_figures import investigation as figure_of

    folder = root / name
    state = await aside(load_investigation, folder)
    ui.label(f"{name}: {ending_words(state)}").classes("verdict")
    if state.belief is not None:
        caption = (
            "Above: how probable each hypothesis was after each run; it ends at the dashed line. Below: the motion."
        )
        plot(figure_of(state, await aside(motions_of, folder, state)), caption)
    told = (
        "What a run was expected to tell is the information that was to come of it, in nats: one nat is a factor of "
        "2.7 between the probabilities of two hypotheses. In brackets, that of a random motion."
    )
    table(("Run", "Minutes", "Motion", "Expected to tell / nats", "Believed"), _rows(state), told)
    with ui.row().classes("gap-4"):
        for number in (n for n, run in enumerate(state.runs, 1) if run.recorded):
            campaign = run_folder(Path(name), number)
            if (root / campaign / MANIFEST).is_file():
                where = address("/recording", c=campaign.as_posix())
                ui.link(f"Recording of run {number}", where).classes("way")
            else:
                ui.label(f"The recording of run {number} is gone.").classes("quiet")


def _rows(state: Investigation) -> list[tuple[str, ...]]:
    from testbench.investigating.words import belief_words

    rows: list[tuple[str, ...]] = []
    for number, run in enumerate(state.runs, 1):
        expected = "" if run.expected_nats is None else f"{run.expected_nats:.2f} (random {run.perlin_nats or 0:.2f})"
        believed = "" if run.belief is None else belief_words(run.belief.probabilities)
        rows.append((str(number), f"{run.seconds / 60:.1f}", run.words, expected, believed))
    return rows

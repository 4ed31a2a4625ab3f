"""Where a campaign came from, as its manifest and the log of commands say."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from nicegui import ui

from gcode.support.errors import UserError
from gcode.support.strict import read_text
from testbench.comparing.words import spoken
from testbench.recordings.manifest import read_manifest
from testbench.report.provenance import moment
from testbench.studio.parts.widgets import table
from testbench.studio.studio import Studio


def provenance(studio: Studio, c: str) -> None:
    """Origin, recipe, counts, software, files with their checksums, and what was run."""
    campaign = studio.workspace.campaign(c)
    try:
        made, resources = read_manifest(campaign.folder)
    except UserError:
        return
    rows = [("Origin", made.origin), ("Ended", made.status), ("Manifest written", moment(campaign.made_s))]
    rows += [*_flat("Recipe", made.recipe), *_flat("Counts", made.counts), *_flat("Software", made.versions)]
    files = [(one.path, (one.hash or "").removeprefix("sha256:")) for one in resources]
    with ui.expansion("Where it comes from", icon="history_edu").classes("card").style("padding:0"):
        table(("", ""), rows)
        table(("File", "SHA-256"), files)
        path = studio.commands_path(c)
        if path.is_file():
            ui.label(read_text(path, "list of commands", 1 << 20)).classes("formula")


def _flat(title: str, values: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Plain values of a mapping; what is nested is in the manifest."""
    return [
        (f"{title}: {spoken(name)}", str(value))
        for name, value in values.items()
        if isinstance(value, str | int | float) and value != ""
    ]

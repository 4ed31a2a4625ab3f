"""Compensate: train on this campaign, judge on the others, export for the chip. All of it by `compensation`."""

from __future__ import annotations

import os
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

from nicegui import ui

from gcode.support.errors import UserError
from gcode.support.strict import open_plain
from testbench.recordings.channels import DISPLACEMENT, FORCE, RESISTANCE, TIME
from testbench.recordings.manifest import CSV
from testbench.report.figures import compensator_figures as figures
from testbench.report.provenance import moment
from testbench.report.sections import short_name
from testbench.results.result_files import read_score
from testbench.studio.jobs.job import Job, State
from testbench.studio.models import companions
from testbench.studio.parts.address import address
from testbench.studio.parts.picture import plot
from testbench.studio.parts.starting import join_running, run_in_turn, start_in
from testbench.studio.parts.widgets import button, campaign_head, download_button, facts, guarded, later, subheading
from testbench.studio.studio import Studio
from testbench.studio.workspace import RESULTS

NEEDED = {"force": {RESISTANCE, FORCE}, "displacement": {RESISTANCE, DISPLACEMENT}}
AUTO, TUNED = "auto", "tuned"
# What the slowest filter of a method remembers at most: `compensation score` refuses a recording that ends before.
REMEMBERS_S, TUNED_REMEMBERS_S = 31.0, 77.0
MOST_OF_A_ROW = 1 << 14  # bytes
AT_FIRST = 4  # campaigns of the same specimen that are chosen by themselves
NETWORKS = {
    AUTO: "auto: several, weighted by cross-validation",
    "4,2,2": "4, 2, 2 (the paper)",
    "8,4,4": "8, 4, 4",
    "16,8": "16, 8",
    TUNED: "tuned: eight small networks",
}


@guarded
def page(studio: Studio, c: str = "", target: str = "force") -> None:
    """Training form, and the last score for `target`."""
    campaign_head(studio, c, "/compensate")
    if target not in NEEDED:
        raise UserError(f"the target must be one of {', '.join(NEEDED)}, got {target!r}")
    _form(studio, c, target)
    kept, score = compensator_path(studio, c, target), score_path(studio, c, target)
    if score.is_file():
        told = read_score(score)
        _facts(told)
        _downloads(studio, c, target)
        _show(told, target)
    elif kept.is_file():
        ui.label(f"The compensator of {moment(kept.stat().st_mtime)} has no score; every training ends with one.")
        _downloads(studio, c, target)


def compensator_path(studio: Studio, c: str, target: str) -> Path:
    """Where the compensator of a campaign is kept."""
    return studio.workspace.results(c) / f"{target}.compensator.json"


def compensators(studio: Studio) -> dict[str, str]:
    """Every compensator that was trained here, by path: what of, and which target."""
    found = sorted((studio.workspace.root / RESULTS).glob("*/*.compensator.json"))
    return {str(path): f"{path.parent.name}, {path.name.partition('.')[0]}" for path in found}


def score_path(studio: Studio, c: str, target: str) -> Path:
    """Where its score is kept."""
    return studio.workspace.results(c) / f"{target}.score.json"


def _form(studio: Studio, c: str, target: str) -> None:
    with ui.column().classes("card gap-3"):
        subheading(
            "Train on this campaign", "A bank of exponential smoothers and small networks learn from it alone."
        )
        with ui.row().classes("items-center"):
            aim = ui.select(list(NEEDED), value=target, label="Predict").style("width:150px")
            network = ui.select(NETWORKS, value=AUTO, label="Method").style("width:370px")
            judging = _Judging(studio, c, target)
            network.on_value_change(lambda event: judging.offer(event.value))
        judging.tell_here(str(network.value))
        aim.on_value_change(lambda event: ui.navigate.to(address("/compensate", c=c, target=event.value)))
        key = f"train:{c}:{target}"

        def start() -> None:
            if not studio.jobs.under_way(key):
                score_path(studio, c, target).unlink(missing_ok=True)  # it is of the compensator before
            learnt, *others = (str(studio.workspace.campaign(name).folder) for name in (c, *judging.field.value))
            kept = str(compensator_path(studio, c, target))
            argv = ["compensation", "train", learnt, "--target", target]
            argv += ["--method" if network.value in (AUTO, TUNED) else "--hidden", network.value, "-o", kept]
            scoring = ["compensation", "score", kept, learnt, *others, "-o", str(score_path(studio, c, target))]
            commands = [(f"Training on {c}", argv), ("Scoring", scoring)]
            run_in_turn(studio, key, commands, holder, ui.navigate.reload)

        button("Train", "model_training", start)
        holder = ui.column().classes("w-full")
        join_running(studio, key, holder, ui.navigate.reload)


class _Judging:
    """The campaigns that a compensator is judged on: a field, and what is to be said of those that it leaves out."""

    said: ui.label

    def __init__(self, studio: Studio, c: str, target: str) -> None:
        self.target = target
        self.same, rest = companions(studio, c)
        others = [studio.workspace.campaign(name) for name in (*self.same, *rest)]
        self.lasts_s = {one.name: lasts_s(one.folder / CSV) for one in others if NEEDED[target] <= one.columns}
        self.field = ui.select([], value=[], multiple=True, label="Judged on").props("use-chips")
        self.field.style("min-width:min(280px, 84vw)")

    def tell_here(self, method: str) -> None:
        """What is left out is said here; see `offer`."""
        self.said = ui.label().classes("quiet text-sm")
        self.offer(method)
        self.field.on_value_change(self._tell)

    def offer(self, method: str) -> None:
        """Offer those that last as long as the method remembers; what was chosen stays, at first some of the same."""
        self.least_s = TUNED_REMEMBERS_S if method == TUNED else REMEMBERS_S
        options = [name for name, span_s in self.lasts_s.items() if span_s >= self.least_s]
        chosen = self.field.value if self.field.options else self.same
        kept = [name for name in chosen if name in options]
        self.field.set_options(options, value=kept if self.field.options else kept[:AT_FIRST])
        self._tell()

    def _tell(self) -> None:
        spans_s, said = self.lasts_s.values(), []
        if short := sum(0 < span_s < self.least_s for span_s in spans_s):
            others = "1 campaign is" if short == 1 else f"{short} campaigns are"
            said.append(
                f"{others} shorter than the {self.least_s:.0f} s that this method may remember, and not offered."
            )
        if empty := sum(not span_s for span_s in spans_s):
            said.append(f"Of {empty} campaign{'s' * (empty > 1)} no two samples can be read.")
        none = (
            f"No other campaign of this gauge length has resistance and {self.target}{' for so long' * bool(short)}"
        )
        if not self.field.value:
            alone = "Nothing is chosen to judge on" if self.field.options else none
            said.append(f"{alone}: the score will be that of the training itself.")
        self.said.set_text(" ".join(said))


def lasts_s(path: Path) -> float:
    """From the first sample of a ``recording.csv`` to the last, gaps included; 0 where none can be read.

    Its first and its last row tell it, so that many are asked in no time.
    """
    try:
        with os.fdopen(open_plain(path, "recording"), "rb") as stream:
            names = stream.readline(MOST_OF_A_ROW).decode().strip().split(",")
            first = stream.readline(MOST_OF_A_ROW)
            stream.seek(max(stream.tell() - len(first), os.fstat(stream.fileno()).st_size - MOST_OF_A_ROW))
            whole = stream.read().rpartition(b"\n")[0]  # the last line of a growing file may be half of one
        last = whole.rpartition(b"\n")[2]
        begun_s, ended_s = (float(row.split(b",")[names.index(TIME)]) for row in (first, last))
    except (UserError, OSError, ValueError, IndexError):
        return 0.0
    return ended_s - begun_s


def _downloads(studio: Studio, c: str, target: str) -> None:
    with ui.row():
        path = compensator_path(studio, c, target)
        button("Export for the chip (C header)", "memory", lambda: export(), "outline")
        download_button("Compensator as JSON", path)
    holder = ui.column().classes("w-full")

    def export() -> None:
        header = studio.workspace.results(c) / f"{target}.h"
        argv = ["compensation", "export", str(path), "--format", "c", "-o", str(header)]

        def ended(job: Job) -> None:
            if job.state is State.DONE:
                ui.download(header)

        start_in(holder, studio, f"export:{c}:{target}", "Writing the C header", argv, ended)


def _show(score: Mapping[str, Any], target: str) -> None:
    rows = score["recordings"]
    names = [short_name(row["source"]) for row in rows]
    plot(figures.before_and_after(rows, names, target), figures.BEFORE_AND_AFTER_CAPTION)
    later(partial(_recordings, rows, names, target))


def _facts(score: Mapping[str, Any]) -> None:
    summary = score["summary"]
    number, kind = summary["recordings"], summary["over"]
    judged = f"on the {kind} recording" if number == 1 else f"mean of {number} {kind} recordings"
    facts(
        [
            (f"r² after compensation, {judged}", f"{summary['r2_after']:.3f}"),
            ("r² of the raw conductance", f"{summary['r2_before']:.3f}"),
            ("gained by compensation", f"{summary['gain']:+.3f}"),
            ("parameters of the network", str(score["compensator"]["parameters"])),
        ]
    )


def _recordings(rows: list[dict[str, Any]], names: list[str], target: str) -> None:
    """One recording at a time, the last of them first."""
    with ui.tabs().props("dense align=left no-caps") as tabs:
        for number, (name, row) in enumerate(zip(names, rows, strict=True)):
            ui.tab(str(number), f"{name} ({row['role']})")
    holder = ui.column().classes("w-full gap-4")

    def show(row: dict[str, Any]) -> None:
        holder.clear()
        with holder:
            plot(figures.over_time(row, target), f"The whole recording; below, {figures.ends_in_words(row)}.")
            plot(figures.scatter(row, target), figures.SCATTER_CAPTION)

    tabs.on_value_change(lambda event: show(rows[int(event.value)]))
    tabs.set_value(str(len(rows) - 1))

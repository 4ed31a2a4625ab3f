"""A running job on a page: how far it is, what it says, its end within reach."""

from __future__ import annotations

import inspect
import json
import time
from collections.abc import Awaitable, Callable, Sequence
from html import escape
from pathlib import Path

from nicegui import ui

from gcode.support.colours import BLUE
from testbench.comparing.numbers import plain
from testbench.studio.jobs.job import Job, State
from testbench.studio.jobs.pace import duration_in_words
from testbench.studio.parts.address import address
from testbench.studio.studio import Studio

SHOWN_S = 300.0  # what came of a job is still said for so long


def job_card(studio: Studio, job: Job, on_end: Callable[[Job], Awaitable[None] | None] | None = None) -> None:
    """A job with its progress, its command and a stop; `on_end` is called once in this tab when it has ended."""
    _JobCard(studio, job, on_end)


def start_in(
    holder: ui.column,
    studio: Studio,
    key: str,
    title: str,
    argv: Sequence[str],
    on_end: Callable[[Job], Awaitable[None] | None],
) -> None:
    """Start a command and show its card in `holder`, in place of what is there; see `job_card`."""
    job = studio.jobs.start(key, title, argv)
    holder.clear()
    with holder:
        job_card(studio, job, on_end)


def join_newest(
    holder: ui.column,
    studio: Studio,
    kind: str,
    on_end: Callable[[Job], Awaitable[None] | None],
    done: Callable[[Job], None] | None = None,
    about: Callable[[Job], bool] = lambda _job: True,
) -> None:
    """Show the newest job of a kind where it runs, or what came of it a short while ago: the page was read anew.

    Parameters
    ----------
    holder : ui.column
        Where to show it.
    studio : Studio
    kind : str
        What its key begins with.
    on_end : callable
        As of `job_card`; called at once where it has failed.
    done : callable, optional
        Shows, in `holder`, a job that had ended well before; default: nothing is shown of it.
    about : callable
        Whether a job is one that this page shows.
    """
    jobs = (job for job in reversed(studio.jobs.jobs) if job.key.partition(":")[0] == kind and about(job))
    job = next(jobs, None)
    if job is None or not (job.running or time.monotonic() - (job.ended_s or 0.0) < SHOWN_S):
        return
    with holder:
        if job.state in (State.RUNNING, State.FAILED):
            job_card(studio, job, on_end)
        elif job.state is State.DONE and done is not None:
            done(job)


def offer_campaign_of(studio: Studio, job: Job) -> None:
    """A job that has ended well, and the way to the campaign that it has written."""
    name = studio.workspace.name_of(Path(job.argv[-1]))
    with ui.row().classes("card items-center gap-3").props("role=status"):
        ui.label(f"{job.title}: done after {job.elapsed_s:.1f} s").classes("quiet text-sm")
        ui.button(f"Open {name}", on_click=lambda: open_campaign_of(studio, job)).props("outline")


def open_campaign_of(studio: Studio, job: Job) -> None:
    """Go to the campaign that a job was to write, if it has ended well."""
    if job.state is State.DONE:
        ui.navigate.to(address("/recording", c=studio.workspace.name_of(Path(job.argv[-1]))))


class _JobCard:
    """What is seen of a job in one tab."""

    def __init__(self, studio: Studio, job: Job, on_end: Callable[[Job], Awaitable[None] | None] | None) -> None:
        self.job, self.on_end, self.drawn = job, on_end, 0
        with ui.column().classes("card gap-2").props("role=status"):
            with ui.row().classes("items-center justify-between w-full no-wrap"):
                self.title = ui.label(job.title).style("font-weight:600")
                self.stop = ui.button("Stop", icon="stop", on_click=lambda: studio.jobs.cancel(job))
                self.stop.props("outline color=accent")
            self.bar = ui.linear_progress(show_value=False).props("rounded size=8px instant-feedback")
            self.bar.props(f"aria-label={json.dumps('Progress: ' + job.title)}")
            self.note = ui.label().classes("quiet text-sm")
            self.curve = ui.html("", sanitize=False).classes("curve")
            ui.label(job.command).classes("mono")
            self.problem = ui.label().classes("text-sm").style("color:#9a4300")
            self.timer = ui.timer(0.2, self._look)

    async def _look(self) -> None:
        if self.job.running:
            self._tell()
            return
        self.timer.deactivate()
        for gone in (self.stop, self.bar):
            gone.set_visibility(False)
        self.note.set_text(f"{self.job.state.value} after {self.job.elapsed_s:.1f} s")
        self.problem.set_text(self.job.problem if self.job.state is State.FAILED else "")
        result = self.on_end(self.job) if self.on_end else None
        if inspect.isawaitable(result):
            await result

    def _tell(self) -> None:
        job = self.job
        self.note.set_text(progress_in_words(job))
        share = job.pace.done(job.elapsed_s) if job.pace.marks or job.pace.profile else job.share
        self.bar.props(remove="indeterminate") if share is not None else self.bar.props("indeterminate")
        self.bar.set_value(share or 0.0)
        if len(job.pace.scores) > max(self.drawn, 1):
            self.drawn = len(job.pace.scores)
            self.curve.set_content(spark_line(job.pace.score_name, job.pace.scores))


def progress_in_words(job: Job) -> str:
    """``motion 7 of 13 · 40 s so far, about 35 s left · imitating on long hold``."""
    left_s = job.pace.left_s(job.elapsed_s)
    time = f"{job.elapsed_s:.0f} s so far"
    if left_s is not None:
        time += f", {duration_in_words(left_s)} left"
    return " · ".join(part for part in (job.step, time, job.note) if part)


def spark_line(name: str, values: Sequence[float]) -> str:
    """A small curve of how a fit or a training gets on, as SVG."""
    width, height = 260, 46
    low, high = min(values), max(values)
    step = width / max(len(values) - 1, 1)
    points = " ".join(
        f"{i * step:.1f},{height - 3 - (value - low) / ((high - low) or 1.0) * (height - 6):.1f}"
        for i, value in enumerate(values)
    )
    words = f"{name} {plain(values[0])} → {plain(values[-1])}"
    return (
        f'<svg viewBox="0 0 {width} {height}" width="{width}" height="{height}" role="img" '
        f'aria-label="{escape(words)}">'
        f'<polyline points="{points}" fill="none" stroke="{BLUE}" stroke-width="1.6"/></svg>'
        f'<span class="quiet text-sm">{escape(words)}</span>'
    )

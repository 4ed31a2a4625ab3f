"""A running job on a page: how far it is, what it says, its end within reach."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from html import escape

from nicegui import ui

from gcode.support.colours import BLUE
from testbench.comparing.numbers import plain
from testbench.studio.jobs.job import Job, State
from testbench.studio.jobs.pace import about_in_words
from testbench.studio.studio import Studio

OnEnd = Callable[[Job], None]  # what is done, once in a tab, when a job has ended, well or not


class JobCard:
    """A job in one tab, with its progress, its command and a stop; `on_end` is called once when it has ended."""

    def __init__(self, studio: Studio, job: Job, on_end: OnEnd) -> None:
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

    def _look(self) -> None:
        if self.job.running:
            self._tell()
            return
        self.timer.deactivate()
        for gone in (self.stop, self.bar):
            gone.set_visibility(False)
        self.note.set_text(f"{self.job.state.value} after {self.job.elapsed_s:.1f} s")
        self.problem.set_text(self.job.problem if self.job.state is State.FAILED else "")
        self.on_end(self.job)

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
        time += f", {about_in_words(left_s)} left"
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

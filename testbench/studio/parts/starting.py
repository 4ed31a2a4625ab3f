"""Jobs of a page: begun by a click, found again when the page is read anew, and where they lead to."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from nicegui import ui

from testbench.studio.jobs.job import Commands, Job, State
from testbench.studio.parts.address import address
from testbench.studio.parts.job_card import JobCard, OnEnd
from testbench.studio.parts.widgets import button
from testbench.studio.studio import Studio

SHOWN_S = 300.0  # what came of a job is still said for so long


def start_in(holder: ui.column, studio: Studio, key: str, title: str, argv: Sequence[str], on_end: OnEnd) -> None:
    """Start a command and show its card in `holder`, in place of what is there."""
    _show(studio, studio.jobs.start(key, title, argv), holder, on_end)


def run_in_turn(studio: Studio, key: str, commands: Commands, holder: ui.column, done: Callable[[], None]) -> None:
    """Run commands one after the other, each with its card; `done` when the last has ended well."""
    studio.make_results(key)
    (title, argv), *rest = commands
    _show(studio, studio.jobs.start(key, title, argv, rest), holder, partial(_if_well, done))


def join_running(studio: Studio, key: str, holder: ui.column, done: Callable[[], None]) -> None:
    """Show a job that another tab, or an earlier visit, has started."""
    if running := studio.jobs.under_way(key):
        _show(studio, running, holder, partial(_if_well, done))


def _if_well(done: Callable[[], None], job: Job) -> None:
    if job.state is State.DONE:
        done()


def _show(studio: Studio, job: Job, holder: ui.column, on_end: OnEnd) -> None:
    """A job's card, and the cards of what follows it; `on_end` is called with the last."""

    def ended(finished: Job) -> None:
        if finished.followed_by:
            _show(studio, finished.followed_by, holder, on_end)
        else:
            on_end(finished)

    holder.clear()
    with holder:
        JobCard(studio, job, ended)


def join_newest(
    holder: ui.column,
    studio: Studio,
    kind: str,
    on_end: OnEnd,
    done: Callable[[Job], None] | None = None,
    about: Callable[[Job], bool] = lambda _job: True,
) -> None:
    """Show the newest job of a kind where it runs, or what came of it a short while ago: the page was read anew.

    Parameters
    ----------
    kind : str
        What its key begins with.
    on_end : callable
        As of `JobCard`; called at once where it has failed.
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
            JobCard(studio, job, on_end)
        elif job.state is State.DONE and done is not None:
            done(job)


def offer_campaign_of(studio: Studio, job: Job) -> None:
    """A job that has ended well, and the way to the campaign that it has written."""
    name = studio.workspace.name_of(Path(job.argv[-1]))
    with ui.row().classes("card items-center gap-3").props("role=status"):
        ui.label(f"{job.title}: done after {job.elapsed_s:.1f} s").classes("quiet text-sm")
        button(f"Open {name}", "", lambda: open_campaign_of(studio, job), "outline")


def open_campaign_of(studio: Studio, job: Job) -> None:
    """Go to the campaign that a job was to write, if it has ended well."""
    if job.state is State.DONE:
        ui.navigate.to(address("/recording", c=studio.workspace.name_of(Path(job.argv[-1]))))

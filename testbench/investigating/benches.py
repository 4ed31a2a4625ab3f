"""What an investigation runs on: the simulated rig at once, the same behind its pseudo-terminal, or a real port."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import takewhile
from pathlib import Path
from typing import Protocol

from gcode.support.errors import UserError
from testbench.campaigns.campaign import matches, simulate_campaign
from testbench.campaigns.clearing import vacant
from testbench.campaigns.plan import Plan
from testbench.campaigns.record import Job, begin, job_of, record
from testbench.knit.model import KnitModel
from testbench.recordings import manifest
from testbench.recordings.manifest import read_manifest
from testbench.rig.acquisition.recorder import Limits, Report
from testbench.rig.connection.parts import paced
from testbench.rig.connection.serial_port import BAUD, SerialLink
from testbench.rig.simulation.played import played
from testbench.rig.simulation.pty_port import PtyPort, serve

PATIENCE_S = 5.0  # for the rig to notice that nobody listens any more


@dataclass(frozen=True)
class Order:
    """One run that is wanted.

    Attributes
    ----------
    folder : Path
        Campaign folder to write.
    past : sequence of Path
        Programs that this specimen went through before; empty for a fresh one.
    rest_s : float
        Rest after each of them.
    """

    program: Path
    folder: Path
    gauge_length_mm: float
    past: Sequence[Path] = ()
    rest_s: float = 0.0
    seed: int = 1


class Bench(Protocol):
    """Something that makes recordings."""

    @property
    def keeps_time(self) -> bool:
        """Whether rests take real time, so that they are measured and not stated."""
        ...

    def run(self, order: Order, report: Report, stopped: Callable[[], bool]) -> None:
        """Make the campaign `order.folder`, or finish it where an earlier trial left it unfinished."""
        ...


@dataclass(frozen=True)
class SimulatedBench:
    """The simulated rig, at once.

    Attributes
    ----------
    effects : Path, optional
        File with effects of the user's own that the model uses.
    """

    model: KnitModel
    sensor: str = "model"
    effects: Path | None = None
    keeps_time: bool = False

    def plan(self, order: Order) -> Plan:
        """What the campaign depends on."""
        past, gauge_mm = tuple(order.past), order.gauge_length_mm
        return Plan(
            order.program, self.model, gauge_mm, order.seed, self.sensor,
            past=past, rest_s=order.rest_s, effects=self.effects,
        )  # fmt: skip

    def run(self, order: Order, report: Report, stopped: Callable[[], bool] = lambda: False) -> None:
        plan = self.plan(order)
        if matches(order.folder, plan):
            return
        motion, _ = played(order.program, order.gauge_length_mm)
        simulate_campaign(plan, order.folder, motion, report, overwrite=True)


@dataclass(frozen=True)
class PtyBench:
    """The simulated rig behind a pseudo-terminal, recorded as a real one is.

    Attributes
    ----------
    speed : float
        Times faster than real.
    """

    simulated: SimulatedBench
    speed: float = 1.0
    keeps_time: bool = False

    def run(self, order: Order, report: Report, stopped: Callable[[], bool] = lambda: False) -> None:
        if status_of(order.folder) == "complete":
            return
        if order.folder.exists():  # cut short: it is made again from its start, and so is the rig
            vacant(order.folder, overwrite=True, origin="recorded")
        motion, _ = played(order.program, order.gauge_length_mm)
        lines = self.simulated.plan(order).wire_lines(motion)
        port, heard = PtyPort(), threading.Event()
        wire = takewhile(lambda _line: not heard.is_set(), paced(lines, self.speed))
        worker = threading.Thread(target=lambda: serve(port, wire), daemon=True)
        try:
            worker.start()
            PortBench(port.device).run(order, report, stopped)
        finally:
            heard.set()
            worker.join(timeout=PATIENCE_S)
            port.close()


@dataclass(frozen=True)
class PortBench:
    """A real rig on a serial port; the person starts the machine's program."""

    port: str
    limits: Limits = field(default_factory=Limits)
    specimen: str = ""
    keeps_time: bool = True

    def run(self, order: Order, report: Report, stopped: Callable[[], bool] = lambda: False) -> None:
        if (left := status_of(order.folder)) == "complete":
            return
        if resume := bool(left):
            job = job_of(order.folder, self.port)
        else:
            vacant(order.folder, origin="")
            job = Job(self.port, BAUD, order.program, order.gauge_length_mm, self.limits, self.specimen)
        link = SerialLink(job.port, job.baud, job.give_up_s)
        try:
            if not resume:
                begin(job, order.folder)
            status = record(job, order.folder, link, report, stopped, resume)
        finally:
            link.close()
        if status.state == "interrupted":
            raise KeyboardInterrupt
        if status.state != "complete":
            anew = ": this run is planned anew then, with less strain" if status.state == "alarm" else ""
            raise UserError(
                f"{order.folder}: the recording ended early ({status.state}{': ' if status.message else ''}"
                f"{status.message}); continue the investigation with `resume` when the rig is ready{anew}"
            )


def status_of(folder: Path) -> str:
    """How the campaign in a folder has ended, or that it has not; empty where there is none."""
    return read_manifest(folder)[0].status if (folder / manifest.NAME).is_file() else ""

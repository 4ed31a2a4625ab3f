"""`align`: a recording on the clock of the program that was run."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from gcode.programs.make import Made
from gcode.support.errors import UserError
from gcode.support.figures import outline, panels, picture
from gcode.support.html import card
from gcode.support.kinds import flag, path_of
from testbench.api.arguments import Source, recording_of
from testbench.api.bench.running import program_file
from testbench.campaigns import alignment
from testbench.campaigns.alignment import PLANNED, Alignment
from testbench.campaigns.campaign import write_derived
from testbench.campaigns.plan import PROGRAM
from testbench.recordings.channels import DISPLACEMENT
from testbench.recordings.recording import Recording
from testbench.report import style
from testbench.report.words import clocks_in_words
from testbench.rig.simulation.played import played

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes


@dataclass(frozen=True, eq=False, repr=False)
class AlignmentResult:
    """How the clock of a recording relates to that of its program, and the recording on the program's clock.

    Attributes
    ----------
    alignment : Alignment
        Delay, drift, offset, and how well they fit.
    recording : Recording
        The part during the program, on its clock, with the planned motion in ``displacement_planned_mm``.
    program : Made, its text or its path
    """

    alignment: Alignment
    recording: Recording
    program: Made | str | Path

    @property
    def words(self) -> tuple[str, ...]:
        """How the clocks stand, and how well the motions agree."""
        found = self.alignment
        return (
            clocks_in_words(found.delay_s, found.drift_ppm, self.recording.duration_s),
            f"aligned, correlation {found.correlation:.5f}, difference {found.rms_mm * 1e3:.1f} µm RMS",
        )

    def __repr__(self) -> str:
        return f"<AlignmentResult {'; '.join(self.words)}>"

    def to_dict(self) -> dict[str, float]:
        """JSON-ready form: ``delay_s``, ``drift_ppm``, ``offset_mm``, ``correlation``, ``rms_mm``."""
        return asdict(self.alignment)

    def to_frame(self) -> pd.DataFrame:
        """The aligned samples as a table, see `Recording.to_frame`."""
        return self.recording.to_frame()

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the planned and the recorded displacement, in mm over the plan's time in s; returns the axes."""
        (axis,) = panels(axes, 1)
        time_s, recorded = self.recording.time_s, self.recording[DISPLACEMENT] - self.alignment.offset_mm
        gaps = self.recording.gaps
        axis.plot(*outline(time_s, recorded, 2000, gaps), color=style.MEASURED, linewidth=1.6, label="recorded")
        planned = self.recording[PLANNED]
        axis.plot(*outline(time_s, planned, 2000, gaps), color=style.VERMILION, linewidth=0.9, label="planned")
        axis.set_xlabel("time of the plan (s)")
        axis.set_ylabel("displacement (mm)")
        axis.legend(frameon=False)
        return axis

    def write(self, folder: str | Path, overwrite: bool = False) -> Path:
        """Write the aligned recording as a campaign; `overwrite` replaces an earlier one in `folder`."""
        folder, overwrite = path_of(folder, "folder"), flag("overwrite", overwrite)
        with program_file(self.program) as program:
            write_derived(folder, self.recording, "aligned", self.to_dict(), program, overwrite)
        return folder

    def _repr_html_(self) -> str:
        return card(f"Alignment of {self.recording.source}", self.words, picture(self.plot, 1))


def align(
    recording: Source, program: Made | str | Path | None = None, *, gauge_length_mm: float | None = None
) -> AlignmentResult:
    """Find the delay and the drift between a program and what was recorded of it.

    Parameters
    ----------
    recording : Recording or path
    program : Made, its text or its path, optional
        Default: the one that the campaign keeps in its folder.
    gauge_length_mm : float, optional
        In mm, for the path of a bare CSV.

    Returns
    -------
    AlignmentResult

    Raises
    ------
    UserError
        If there is no such program, or the recorded displacement does not follow it.

    Examples
    --------
    >>> import gcode
    >>> import testbench as tb
    >>> program = gcode.generate("paper-1", seed=3, duration_s=60)
    >>> found = tb.align(tb.simulate(tb.preset("pes"), program), program)
    >>> abs(found.alignment.delay_s) < 0.02, found.recording.has("displacement_planned_mm")
    (True, True)
    """
    given = recording_of(recording, gauge_length_mm)
    if program is None:
        program = _own_program(recording)
    with program_file(program) as path:
        motion, _ = played(path, given.gauge_length_mm)
    found = alignment.align(given, motion)
    return AlignmentResult(found, alignment.applied(given, motion, found), program)


def _own_program(recording: Source) -> Path:
    """The program that a campaign keeps in its folder."""
    if not isinstance(recording, str | Path):
        raise UserError("align: name the program; only a campaign's folder knows its own")
    if not (own := Path(recording) / PROGRAM).is_file():
        raise UserError(f"align: {recording} holds no {PROGRAM}; name the program that was played")
    return own

"""What `investigate` gives: the runs, and what was believed after each."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gcode.support.figures import picture
from gcode.support.html import card, frame_table
from gcode.support.read_only import read_only
from gcode.trajectories.trajectory import read_csv
from testbench.investigating.state import SURE, Investigation, RunState, program_folder
from testbench.investigating.words import ending_words, investigation_words
from testbench.knit.effect import FloatArray
from testbench.report.figures.investigation_figures import investigation as figure_of
from testbench.report.writing.static import draw_on, write_figure

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes


@dataclass(frozen=True, eq=False, repr=False)
class InvestigationResult:
    """An investigation: its runs, and what was believed after each.

    Attributes
    ----------
    state : Investigation
        Everything that is kept in ``investigation.json``.
    folder : Path
    """

    state: Investigation
    folder: Path

    @property
    def hypothesis(self) -> str:
        """The most probable one: ``nothing``, ``unknown`` or a mechanism; empty before the first run was judged."""
        return self.state.belief.top[0] if self.state.belief else ""

    @property
    def probability(self) -> float:
        """Of the most probable hypothesis."""
        return self.state.belief.top[1] if self.state.belief else float("nan")

    @property
    def probabilities(self) -> Mapping[str, float]:
        """After the last run, of every hypothesis; they sum to 1."""
        return read_only(self.state.belief.probabilities if self.state.belief else {})

    @property
    def is_sure(self) -> bool:
        """Whether it ended because one hypothesis was sure."""
        return self.state.ended == SURE

    @property
    def minutes(self) -> float:
        """Time of motion."""
        return self.state.spent_s / 60

    @property
    def words(self) -> str:
        """How it ended, in one sentence."""
        return ending_words(self.state)

    def __repr__(self) -> str:
        return f"<InvestigationResult {self.words}>"

    def __str__(self) -> str:
        return investigation_words(self.state)

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready form, the same as ``testbench investigate --json``: settings, runs, ending."""
        return self.state.model_dump(mode="json")

    def to_frame(self) -> pd.DataFrame:
        """A row a run: run, motion, minutes, expected_nats, perlin_nats, hypothesis, probability, verdict."""
        import pandas as pd

        return pd.DataFrame(_row(number, run) for number, run in enumerate(self.state.runs, 1))

    def beliefs(self) -> pd.DataFrame:
        """Probability of each hypothesis (column) after each run (row) that was judged."""
        import pandas as pd

        judged = {number: run.belief for number, run in enumerate(self.state.runs, 1)}
        rows = {number: belief.probabilities for number, belief in judged.items() if belief is not None}
        return pd.DataFrame.from_dict(rows, orient="index").rename_axis("run")

    def plot(self, axes: Axes | None = None) -> Axes:
        """Draw the belief over the time of motion on `axes` (default: of a new figure); returns them."""
        return draw_on(figure_of(self.state), axes)[0]

    def write_picture(self, path: str | Path) -> None:
        """Draw belief and motions into a PNG, PDF or SVG."""
        write_figure(figure_of(self.state, motions_of(self.folder, self.state)), path)

    def _repr_html_(self) -> str:
        return card(self.words, [], picture(self.plot, 1), frame_table(self.to_frame()))


def motions_of(folder: Path, state: Investigation) -> list[tuple[FloatArray, FloatArray]]:
    """Time in s and strain in percent of each run's motion, as far as its plan is there."""
    found = []
    for number in range(1, len(state.runs) + 1):
        path = program_folder(folder, number) / "trajectory.csv"
        if path.is_file():
            planned = read_csv(path)
            found.append((planned.time_s, 100 * planned.position_mm / state.settings.gauge_length_mm))
    return found


def _row(number: int, run: RunState) -> dict[str, Any]:
    name, chance = run.belief.top if run.belief else ("", float("nan"))
    return {
        "run": number,
        "motion": run.words,
        "minutes": run.seconds / 60,
        "expected_nats": run.expected_nats,
        "perlin_nats": run.perlin_nats,
        "hypothesis": name,
        "probability": chance,
        "verdict": run.belief.verdict if run.belief else "",
    }

"""The ladder: the errors of a model, step by step, down to the noise floor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from gcode.support.errors import UserError
from gcode.support.figures import picture
from gcode.support.html import card, frame_table
from gcode.support.read_only import free_copy
from testbench.api.arguments import AnyModel, Effects, catalogue_of, model_file_of
from testbench.comparing.model_errors import channel_name
from testbench.comparing.tables import ladder_rows, ladder_table
from testbench.measurements.responses import UNIT_OF
from testbench.report.figures.ladder_figures import ladder as figure_of
from testbench.report.overlays import steps_of
from testbench.report.writing.static import draw_on
from testbench.results.model_file import ModelFile

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes


@dataclass(frozen=True, eq=False, repr=False)
class Ladder:
    """Models one effect apart, and what each step did to the errors.

    Attributes
    ----------
    file : ModelFile
        The last model, with the history of all.
    """

    file: ModelFile

    @property
    def steps(self) -> tuple[str, ...]:
        """What each step did, the first one first: ``baseline``, ``+ stress_relaxation``."""
        return tuple(step["step"] for step in self.file.history)

    def __len__(self) -> int:
        return len(self.file.history)

    def __repr__(self) -> str:
        return f"<Ladder {' '.join(self.steps)}>"

    def __str__(self) -> str:
        return ladder_table(self.file)

    def to_dict(self) -> list[dict[str, Any]]:
        """The history, JSON-ready: step, model, errors in N and in ln S, noise floor."""
        return free_copy(list(self.file.history))

    def to_frame(self) -> pd.DataFrame:
        """A row a step and channel: ``step``, ``channel``, ``unit``, three errors and ``fall`` (a share)."""
        import pandas as pd

        frame = pd.DataFrame(ladder_rows(self.file.history))
        frame.insert(2, "unit", frame["channel"].map(UNIT_OF))
        return frame.assign(channel=frame["channel"].map(channel_name))

    def plot(self, axes: Axes | Sequence[Axes] | None = None) -> Any:
        """Draw the held-out error after each step over the noise floor, one panel a channel.

        Returns
        -------
        ndarray of Axes, shape (channels,)
        """
        return draw_on(figure_of(steps_of(self.file.history)), axes)

    def _repr_html_(self) -> str:
        count = len(self.file.history[0]["errors"]["held_out"])
        return card("Ladder", [], frame_table(self.to_frame()), picture(self.plot, count))


def ladder(model: AnyModel, effects: Effects = None) -> Ladder:
    """The ladder of a model: what each step did to its errors.

    Parameters
    ----------
    model : path or result of `fit` or `diagnose`
    effects : path, Catalogue or effect classes, optional
        The user's own effects that it uses.

    Returns
    -------
    Ladder

    Raises
    ------
    UserError
        If the model has no history: it was never fitted to a recording.

    Examples
    --------
    >>> import testbench as tb
    >>> tb.ladder(tb.fit(tb.example(), progress=False))
    <Ladder baseline>
    """
    file = model_file_of(model, catalogue_of(effects))
    if not file.history:
        raise UserError("ladder: this model has no history; fit it to a recording first")
    return Ladder(file)

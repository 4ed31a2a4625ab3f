"""`propose`: a law for what no effect explains, written down as an effect."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gcode.support.errors import UserError
from gcode.support.figures import picture
from gcode.support.files import check_place, write_text
from gcode.support.html import card, frame_table
from gcode.support.kinds import instance, whole
from testbench import proposing as core
from testbench.api.arguments import AnyModel, Effects, Source, catalogue_of, model_file_of, recordings_for
from testbench.api.models.model_result import ModelResult, plot_overlay
from testbench.api.progress import Tell, telling
from testbench.proposing.laws.formulas import in_words
from testbench.proposing.laws_found import Proposed, check_names
from testbench.proposing.proposal import MOST_LAWS
from testbench.proposing.words import as_json, first_line, proposal_text, story
from testbench.proposing.writing import file_text, free_path
from testbench.report.figures.proposal_figures import proposal as figure_of
from testbench.report.writing.static import check_figure, write_figure
from testbench.results.model_file import ModelFile

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes


@dataclass(frozen=True, eq=False, repr=False)
class ProposalResult(ModelResult):
    """A law that was found in what a model leaves, or why none is proposed.

    Attributes
    ----------
    proposed : Proposed
        Everything that was found; see `testbench.proposing.Proposed`.
    """

    proposed: Proposed

    @property
    def verdict(self) -> str:
        """``proposed``, ``nothing_left``, ``no_law`` or ``does_not_hold``."""
        return self.proposed.verdict

    @property
    def is_proposed(self) -> bool:
        """Whether there is a law to write down."""
        return self.verdict == "proposed"

    @property
    def words(self) -> str:
        """The result in one sentence."""
        return first_line(self.proposed)

    @property
    def code(self) -> str:
        """The text of the effect file; empty where no law is proposed."""
        return self._code(f"{self.proposed.name}.py")

    @property
    def file(self) -> ModelFile:
        """The model with the law put in and refitted, as ``model.json`` holds it."""
        return self.proposed.after

    def __repr__(self) -> str:
        return f"<ProposalResult {self.words}>"

    def __str__(self) -> str:
        return proposal_text(self.proposed)

    def write(self, path: str | Path, picture: str | Path | None = None) -> tuple[Path, Path]:
        """Write the effect as a Python file, and its picture.

        Parameters
        ----------
        path : path
            Nothing may be there; ``testbench effects --effects path --check`` tries what was written.
        picture : path, optional
            PNG, PDF or SVG; default: beside the effect.

        Returns
        -------
        tuple of Path
            The effect and the picture.

        Raises
        ------
        UserError
            If no law is proposed, or a file is there already.
        """
        if not self.is_proposed:
            raise UserError(f"propose: there is no effect to write: {self.words}")
        effect, drawn = free_path(path), free_path(picture or Path(path).with_suffix(".png"))
        write_text(effect, self._code(effect.name))
        write_figure(figure_of(self.proposed), drawn)
        return effect, drawn

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready form, the same as ``testbench propose --json``; documented in docs/propose.md."""
        return as_json(self.proposed)

    def to_frame(self) -> pd.DataFrame:
        """A row a law, those that could be in its place below it: effect, law, log_evidence in nats, proposed."""
        import pandas as pd

        rows = [
            (name, in_words(option.law), option.log_evidence, option is step.option)
            for step, (_, name) in zip(self.proposed.steps, self.proposed.laws, strict=True)
            for option in (step.option, *step.alternatives)
        ]
        return pd.DataFrame(rows, columns=["effect", "law", "log_evidence", "proposed"])

    def plot(self, axes: Axes | Sequence[Axes] | None = None) -> Any:
        """Draw the held-out recording and the model without and with the law, one panel a channel.

        Returns
        -------
        ndarray of Axes, shape (channels,)
        """
        models = {"without the law": self.proposed.before.model, "with the law": self.model}
        return plot_overlay(self.proposed.held, models if self.is_proposed else {"modelled": self.model}, axes)

    def _code(self, file: str) -> str:
        found = self.proposed
        return file_text(found.laws, found.grid, story(found), file) if found.laws else ""

    def _repr_html_(self) -> str:
        parts = frame_table(self.to_frame()), picture(self.plot, len(self.proposed.held.channels))
        return card(self.words, self.proposed.notes, *parts)


def propose(
    recording: Source,
    held_out: Source | None = None,
    *,
    model: AnyModel | None = None,
    name: str = "my_effect",
    effects: Effects = None,
    most: int = MOST_LAWS,
    gauge_length_mm: float | None = None,
    progress: Tell | bool | None = None,
) -> ProposalResult:
    """Find a law in what the best model leaves, where no effect of the catalogue explains it.

    Parameters
    ----------
    recording : Recording or path
        To calibrate on; everything is chosen on it.
    held_out : Recording or path, optional
        To take back a law that does not hold; default: the last third of `recording`.
    model : KnitModel, result or path, optional
        The best model so far; default: the baseline.
    name : str
        Of the effect, for instance ``my_effect``.
    effects : path, Catalogue or effect classes, optional
        The user's own effects.
    most : int
        Laws to find at most, one after the other.
    gauge_length_mm : float, optional
        In mm, for paths of bare CSV files; default: the model's.
    progress : callable or bool, optional
        See `testbench.api.progress.telling`.

    Returns
    -------
    ProposalResult

    Raises
    ------
    UserError
        If the name is none for an effect or is taken, or the recordings are too short or still, have a constant
        channel, or do not fit together.

    Examples
    --------
    >>> import testbench as tb
    >>> found = tb.propose(tb.example(), progress=False)
    >>> found.verdict, found.code
    ('nothing_left', '')
    """
    most = whole("most: laws to find", most, 1)
    catalogue = catalogue_of(effects)
    check_names(instance("name", name, str), f"{name}.py", catalogue.effects, most)
    file = None if model is None else model_file_of(model, catalogue)
    first, held, _ = recordings_for(model, file, recording, held_out, gauge_length_mm)
    with telling(progress) as tell:
        return ProposalResult(core.propose_law(first, held, file, name, catalogue, tell, most))


def check_effect_file(
    path: str | Path, picture: str | Path | None = None, effects: Effects = None, most: int = 1
) -> tuple[Path, Path]:
    """Where an effect and its picture can be written; asked before the work whose result would be lost there.

    Parameters
    ----------
    path : path
        Of the effect, whose name becomes the effect's.
    picture : path, optional
        Default: beside the effect.
    effects : path, Catalogue or effect classes, optional
        Effects of the user's own, whose names are taken.
    most : int
        Laws that will be looked for: from the second on their names have a number behind.

    Raises
    ------
    UserError
        If a file is there already or none can be written, the picture is no PNG, PDF or SVG, or the name is none for
        an effect or is taken.
    """
    effect = free_path(path)
    if effect.suffix != ".py":
        raise UserError(f"{effect}: an effect is a Python file; give a name like my_effect.py")
    drawn = free_path(picture or effect.with_suffix(".png"))
    check_place(effect)
    check_figure(drawn)
    check_names(effect.stem, str(effect), catalogue_of(effects).effects, most)
    return effect, drawn

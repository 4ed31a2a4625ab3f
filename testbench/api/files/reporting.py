"""`make_report`: recordings, model, diagnosis and compensator on one self-contained page."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, get_args

from gcode.support.errors import UserError
from gcode.support.html import card
from gcode.support.kinds import flag, path_of
from testbench.api.arguments import AnyModel, Effects, Source, as_recording, catalogue_of, model_file_of
from testbench.api.missing.diagnosing import DiagnosisResult, diagnosis_data
from testbench.recordings.recording import Recording
from testbench.report.build import build_report
from testbench.report.document import Report
from testbench.report.story import Inputs
from testbench.report.writing.write import write_report
from testbench.results.result_files import read_score

Form = Literal["html", "md"]


@dataclass(frozen=True, eq=False, repr=False)
class ReportResult:
    """A report, not written yet.

    Attributes
    ----------
    report : Report
        Its words, tables and figures as data.
    """

    report: Report

    @property
    def verdict(self) -> str:
        """The sentence that a hurried reader takes away."""
        return self.report.verdict

    def write(self, path: str | Path, format: Form = "html", figures: str | Path | None = None) -> list[Path]:
        """Write one self-contained page, or Markdown with its figures beside it.

        Parameters
        ----------
        path : path
        format : {"html", "md"}
        figures : path, optional
            A folder for every figure as PNG and PDF.

        Returns
        -------
        list of Path
            The report, and every figure.
        """
        if format not in get_args(Form):
            raise UserError(f"format must be {' or '.join(get_args(Form))}, got {format!r}")
        folder = None if figures is None else path_of(figures, "folder of figures")
        return write_report(self.report, path_of(path, "report"), format, folder)

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready form: title, verdict, and the titles of the sections."""
        sections = [part.title for part in self.report.sections]
        return {"title": self.report.title, "verdict": self.verdict, "sections": sections}

    def __repr__(self) -> str:
        return f"<ReportResult {self.report.title}: {', '.join(part.title for part in self.report.sections)}>"

    def _repr_html_(self) -> str:
        return card(self.report.title, [self.verdict, *(part.title for part in self.report.sections)])


def make_report(
    recordings: Source | Iterable[Source] = (),
    *,
    held_out: Source | None = None,
    model: AnyModel | None = None,
    diagnoses: DiagnosisResult | str | Path | Iterable[DiagnosisResult | str | Path] = (),
    compensator: str | Path | None = None,
    effects: Effects = None,
    gauge_length_mm: float | None = None,
    commands: str | Path | None = None,
    title: str = "",
    resistance: bool = False,
) -> ReportResult:
    """Put recordings, a model, its diagnoses and a compensator into one report.

    Parameters
    ----------
    recordings : Recording or path, or several
        The first is what the model was fitted on.
    held_out : Recording or path, optional
        What errors are judged on; default: the last third of the first recording.
    model : result or path, optional
        A model with its ladder.
    diagnoses : result or path, or several
        Those that led to each step of the model, the oldest first. Without a model, the last one's own before and
        after are shown.
    compensator : path, optional
        The JSON of ``compensation score``.
    effects : path, Catalogue or effect classes, optional
        The user's own effects that the model uses.
    gauge_length_mm : float, optional
        In mm, for paths of bare CSV files.
    commands : path, optional
        A text file with the command lines that led here, one a line.
    title : str
        Default: the names of the recordings.
    resistance : bool
        Show the resistance in kΩ wherever the conductance would be.

    Returns
    -------
    ReportResult

    Raises
    ------
    UserError
        If there is nothing to report on, a file is missing or damaged, or a recording is of another set-up than the
        model.

    Examples
    --------
    >>> import testbench as tb
    >>> recording = tb.example()
    >>> made = tb.make_report(recording, model=tb.fit(recording, progress=False))
    >>> [part.title for part in made.report.sections][:2]
    ['The error ladder', 'Where the model fails']
    """
    catalogue = catalogue_of(effects)
    recorded, found = _several(recordings), _several(diagnoses)
    given = Inputs(
        recordings=tuple(as_recording(one, gauge_length_mm) for one in recorded),
        held_out=None if held_out is None else as_recording(held_out, gauge_length_mm),
        model=None if model is None else model_file_of(model, catalogue),
        model_name=str(model) if isinstance(model, str | Path) else "model",
        catalogue=catalogue,
        diagnoses=tuple(diagnosis_data(one) for one in found),
        compensator=None if compensator is None else read_score(compensator),
        files=_files((*recorded, held_out, model, effects, *found, compensator)),
        commands=None if commands is None else str(commands),
        title=title,
        resistance=flag("resistance", resistance),
    )
    return ReportResult(build_report(given))


def _several(given: Any) -> list[Any]:
    """One thing, or several of it."""
    if isinstance(given, str | Path | Recording | DiagnosisResult):
        return [given]
    if hasattr(given, "items") or not isinstance(given, Iterable):
        raise UserError(
            f"report: must be a Recording, a diagnosis, the file of one, or several, got {type(given).__name__}; "
            "testbench.read makes a Recording of a data frame"
        )
    return list(given)


def _files(given: Iterable[object]) -> tuple[str, ...]:
    """Those that were named by their files, whose checksums a report can tell."""
    return tuple(str(one) for one in given if isinstance(one, str | Path))

"""From files to a report: reads what the options name, calls the rooms, and puts the sections in order."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gcode.support.console import knitbench_version
from gcode.support.errors import UserError
from gcode.support.files import read_json
from testbench.recording import Recording, read_recording
from testbench.report import ladder_figures, sections
from testbench.report.comparison_figures import busiest_window
from testbench.report.document import Facts, Item, Picture, Report, Section
from testbench.report.ladder_figures import UNITS, Step

if TYPE_CHECKING:
    from testbench.discrepancy.measurement import Measurement
    from testbench.discrepancy.model_file import ModelFile
    from testbench.knit.catalogue import Catalogue

GLANCE_S = 60.0
SCORE_FORMAT = "knitbench-score"


@dataclass(frozen=True)
class Inputs:
    """What a report is made from; each may be missing, but not all.

    Attributes
    ----------
    recordings : tuple of str
        CSVs or campaign folders. The first is what the model was fitted on.
    held_out : str, optional
        The recording that errors are judged on.
    gauge_length_mm : float, optional
        For bare CSVs.
    model, effects : str, optional
        A model.json, and the user's own effects in it.
    compensator : str, optional
        The JSON of ``compensation score``.
    title : str, optional
    """

    recordings: tuple[str, ...] = ()
    held_out: str | None = None
    gauge_length_mm: float | None = None
    model: str | None = None
    effects: str | None = None
    compensator: str | None = None
    title: str = ""


def build_report(given: Inputs) -> Report:
    """Read the inputs and put the report together.

    Raises
    ------
    UserError
        If a file is missing or is not what the option says.
    """
    if not (given.recordings or given.model or given.compensator):
        raise UserError("nothing to report on; name a --recording, a --model or a --compensator")
    recordings = [read_recording(path, given.gauge_length_mm) for path in given.recordings]
    opening: list[Item] = []
    parts: list[Section] = []
    verdict = ""
    if given.model:
        story = _Story(given, recordings)
        verdict, opening = story.verdict(), story.opening()
        parts += story.parts()
    if given.compensator:
        score = read_results(given.compensator, "score", SCORE_FORMAT)
        parts.append(sections.compensator_section(score))
    parts += [
        sections.recording_section(recording, f"Recording {name_of(recording)}", f"recording-{number}")
        for number, recording in enumerate(recordings, 1)
    ]
    title = (
        given.title
        or ", ".join(name_of(recording) for recording in recordings)
        or Path(str(given.model or given.compensator)).stem
    )
    return Report(title, verdict, opening, parts, f"Made by knitbench {knitbench_version()}.")


class _Story:
    """What a model has to tell: what was fitted, how the error fell, where it still fails."""

    def __init__(self, given: Inputs, recordings: Sequence[Recording]) -> None:
        from testbench.discrepancy.model_file import check_same_set_up, load_model_file
        from testbench.knit.catalogue import load_catalogue
        from testbench.report.overlays import steps_of

        assert given.model
        self.catalogue: Catalogue = load_catalogue(given.effects)
        self.file: ModelFile = load_model_file(given.model, self.catalogue)
        self.steps: list[Step] = steps_of(self.file.history)
        self.judged: Measurement | None = None
        self.held_apart = False
        if recordings:
            held = read_recording(given.held_out, given.gauge_length_mm) if given.held_out else None
            for recording in (*recordings, *([held] if held else [])):
                check_same_set_up(self.file, recording, given.model)
            self._judge(recordings[0], held)

    def _judge(self, recording: Recording, held: Recording | None) -> None:
        from testbench.discrepancy.measurement import split

        _, self.judged = split(recording, held)
        self.held_apart = True

    def verdict(self) -> str:
        """The one sentence."""
        if len(self.steps) < 2:
            return "One model, fitted; no effect has been added yet."
        first, last = self.steps[0], self.steps[-1]
        added = ", ".join(step.label.removeprefix("+ ") for step in self.steps[1:])
        falls = " and ".join(
            f"{channel} from {first.errors[channel]:.3g} to {last.errors[channel]:.3g} {UNITS[channel]}"
            for channel in first.errors
        )
        return f"With {added} the held-out error falls: {falls}."

    def opening(self) -> list[Item]:
        """The picture that says it all, and its figures."""
        if not self.steps:
            return []
        items: list[Item] = [Facts(_glance_facts(self.steps))]
        if self.judged:
            from testbench.report.overlays import models_of, overlay_of

            both = overlay_of(self.judged, models_of(self.file, self.catalogue), free_offset=self.held_apart)
            inside = both.within(self.judged.counts)
            figure = ladder_figures.at_a_glance(inside, self.steps, busiest_window(inside, GLANCE_S))
            caption = (
                "Left: a minute of held-out samples, where the first model is worst. "
                "Right: the held-out error after each step, and the noise floor."
            )
            items.append(Picture("at-a-glance", figure, caption))
        return items

    def parts(self) -> list[Section]:
        """Comparison, ladder, parameters."""
        found = []
        if self.judged:
            found.append(self._comparison(self.judged))
        if self.steps:
            found.append(sections.ladder_section(self.steps))
        parameters = sections.parameters_section(self.file.fit)
        return [*found, *([parameters] if parameters else [])]

    def _comparison(self, judged: Measurement) -> Section:
        from testbench.discrepancy.compare import compare
        from testbench.report.overlays import overlay_of

        label = self.steps[-1].label if self.steps else "model"
        both = overlay_of(judged, {label: self.file.model}, self.held_apart).within(judged.counts)
        result = compare(self.file.model, judged, free_offset=self.held_apart)
        return sections.comparison_section(both, result.to_dict())


def _glance_facts(steps: Sequence[Step]) -> list[tuple[str, str]]:
    last = steps[-1]
    pairs = []
    for channel, error in last.errors.items():
        pairs.append((f"held-out error of the {channel}", f"{error:.3g} {UNITS[channel]}"))
        floor = last.noise_floor.get(channel, 0.0)
        if len(steps) > 1 and steps[0].errors[channel] > 0:
            pairs.append(("against the first model", f"{100 * (error / steps[0].errors[channel] - 1):+.0f} %"))
        elif floor > 0:
            pairs.append(("over its noise floor", f"{error / floor:.1f} x"))
    return pairs


def name_of(recording: Recording) -> str:
    """Short name of a recording."""
    return sections.short_name(recording.source)


def read_results(path: str, what: str, form: str) -> Mapping[str, Any]:
    """A JSON object that another command wrote.

    Raises
    ------
    UserError
        If it is missing or is something else.
    """
    data = read_json(path, what)
    if not isinstance(data, dict) or data.get("format") != form:
        raise UserError(f"{path}: not a {what} (its format must be {form!r})")
    return data

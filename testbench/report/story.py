"""The heart of a report: what a model has to tell about samples that it was not fitted on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from testbench.comparing.compare import compare
from testbench.comparing.judged import held_samples
from testbench.comparing.remounting import remounted
from testbench.knit.catalogue import Catalogue, load_catalogue, model_from_dict
from testbench.measurements.measurement import Measurement
from testbench.recordings.doubts import say_if_same
from testbench.recordings.recording import Recording
from testbench.report import sections, words
from testbench.report.document import Facts, Item, Picture, Section
from testbench.report.figures import ladder_figures
from testbench.report.figures.comparison_figures import Overlay, busiest_window
from testbench.report.figures.ladder_figures import Step
from testbench.report.overlays import (
    maps_of,
    models_of,
    overlay_of,
    steps_in_resistance,
    steps_of,
    zero_in_words,
)
from testbench.report.parameter_table import parameter_table
from testbench.report.words import with_unit
from testbench.results.model_file import ModelFile, check_same_set_up


@dataclass(frozen=True)
class Inputs:
    """Recordings, model and results; each may be missing, but not all.

    Attributes
    ----------
    recordings, held_out, diagnoses, compensator, commands, title, resistance
        As `testbench.make_report` takes them, and read.
    model_name : str
        What an error calls the model: its file.
    catalogue : Catalogue
        With the user's own effects.
    files : tuple of str
        Where all of these came from, for their checksums.
    """

    recordings: tuple[Recording, ...] = ()
    held_out: Recording | None = None
    model: ModelFile | None = None
    model_name: str = "model"
    catalogue: Catalogue = field(default_factory=load_catalogue)
    diagnoses: tuple[Mapping[str, Any], ...] = ()
    compensator: Mapping[str, Any] | None = None
    files: tuple[str, ...] = ()
    commands: str | None = None
    title: str = ""
    resistance: bool = False


@dataclass(frozen=True)
class Story:
    """What was fitted, how the error fell, where it still fails.

    Attributes
    ----------
    given : Inputs
    file : ModelFile
        The model that the user keeps, or a diagnosis's own.
    steps : list of Step
    judged : Measurement or None
        The held-out samples, where a recording was given.
    """

    given: Inputs
    file: ModelFile
    steps: list[Step]
    judged: Measurement | None

    @classmethod
    def of(cls, given: Inputs) -> Story:
        """From the model of a report, or from the last diagnosis's own before and after.

        Raises
        ------
        UserError
            If the model was fitted on another set-up.
        """
        file = given.model or _file_of(given.diagnoses[-1], given.catalogue)
        steps, judged = steps_of(file.history), None
        if given.recordings:
            first, other = given.recordings[0], given.held_out
            for recording in (first, *([other] if other else [])):
                check_same_set_up(file, recording, given.model_name if given.model else "diagnosis")
            if other:
                say_if_same(other, first)
            judged = held_samples(file, first, other)
            if given.resistance:
                steps = steps_in_resistance(file, given.catalogue, judged)
        return cls(given, file, steps, judged)

    def verdict(self) -> str:
        """The one sentence, or two: what was gained so far, and what a diagnosis that is still open says."""
        last = self.given.diagnoses[-1] if self.given.diagnoses else None
        asked = words.verdict_in_words(last) if last else ""
        if len(self.steps) < 2 or not self.given.model:
            return asked or "One model, fitted; no effect has been added yet."
        first, now = self.steps[0], self.steps[-1]
        added = words.listed([words.spoken(step.label.removeprefix("+ ")) for step in self.steps[1:]])
        gained = f"With {added} {words.error_fall(first.errors, now.errors)}."
        return f"{gained} {asked}".strip() if last and not self.has_taken(last) else gained

    def has_taken(self, diagnosis: Mapping[str, Any]) -> bool:
        """Whether what a diagnosis found is in the model."""
        found = {row["law"] for row in diagnosis["ranking"][:1]} if diagnosis["verdict"] == "missing" else set()
        return any(name in self.file.model for name in (*found, *diagnosis.get("other_laws", ())))

    def opening(self) -> list[Item]:
        """The first picture of a report, with the numbers that go with it."""
        if not self.steps:
            return []
        items: list[Item] = [Facts(glance_facts(self.steps))]
        if self.judged:
            inside = self._seen(overlay_of(self.judged, models_of(self.file, self.given.catalogue), free_offset=True))
            figure = ladder_figures.at_a_glance(inside, self.steps, busiest_window(inside))
            items.append(Picture("at-a-glance", figure, ladder_figures.GLANCE_CAPTION))
        return items

    def parts(self) -> list[Section]:
        """Diagnoses, ladder, what is still wrong, parameters."""
        found = [self._asked(number, one) for number, one in enumerate(self.given.diagnoses, 1)]
        if self.steps:
            found.append(sections.ladder_section(self.steps, zero_in_words(self.file)))
        if self.judged:
            found.append(self._comparison(self.judged))
        parameters = parameter_table(self.file.fit, self.file.model)
        return [*found, *([Section("The model's parameters", [parameters])] if parameters else [])]

    def _asked(self, number: int, diagnosis: Mapping[str, Any]) -> Section:
        """A diagnosis: an open question, or why a step was taken."""
        if self.given.model and self.has_taken(diagnosis):
            first = diagnosis["ranking"][0]["effect"] if diagnosis["verdict"] == "missing" else "another law"
            title = f"Why {words.spoken(first)} was added"
        else:
            title = "What is missing" if len(self.given.diagnoses) == 1 else "What is missing now"
        return sections.diagnosis_section(diagnosis, title, "" if number == 1 else f"-{number}")

    def _comparison(self, judged: Measurement) -> Section:
        label = self.steps[-1].label if self.steps else "model"
        both = overlay_of(judged, {label: self.file.model}, free_offset=True)
        compared = compare(remounted(self.file.model, judged), judged, free_offset=True)
        maps = maps_of(compared, judged, both, free_offset=True)
        return sections.comparison_section(self._seen(both), compared, maps)

    def _seen(self, both: Overlay) -> Overlay:
        """What is shown of an overlay: the samples that count, as resistance where that is asked for."""
        assert self.judged is not None
        inside = both.within(self.judged.counts)
        return inside.in_resistance() if self.given.resistance else inside


def _file_of(diagnosis: Mapping[str, Any], catalogue: Catalogue) -> ModelFile:
    model = model_from_dict(diagnosis.get("model_after"), catalogue, "diagnosis")
    history = tuple(diagnosis.get("history", ()))
    return ModelFile(model, 0.0, fit=diagnosis.get("parameters_after", {}), history=history)


def glance_facts(steps: Sequence[Step]) -> list[tuple[str, str]]:
    """Held-out errors of the last step, and how far they have come."""
    last = steps[-1]
    pairs = []
    for channel, error in last.errors.items():
        pairs.append((f"held-out error of the {channel}", with_unit(error, channel)))
        floor = last.noise_floor.get(channel, 0.0)
        if len(steps) > 1 and steps[0].errors[channel] > 0:
            fall = f"{100 * (error / steps[0].errors[channel] - 1):+z.0f} %"
            pairs.append((f"the {channel} against the first model", fall))
        elif floor > 0:
            pairs.append((f"error of the {channel} over its noise floor", f"{error / floor:.1f} times"))
    return pairs

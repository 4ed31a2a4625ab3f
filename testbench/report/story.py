"""The heart of a report: what a model has to tell about samples that it was not fitted on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from testbench.discrepancy.compare import compare
from testbench.discrepancy.measurement import Measurement, split
from testbench.discrepancy.model_file import ModelFile, check_same_set_up, load_model_file
from testbench.knit.catalogue import Catalogue, load_catalogue, model_from_dict
from testbench.recording import Recording
from testbench.report import ladder_figures, sections, words
from testbench.report.comparison_figures import busiest_window
from testbench.report.document import Facts, Item, Picture, Section
from testbench.report.ladder_figures import UNITS, Step
from testbench.report.numbers import plain
from testbench.report.overlays import models_of, overlay_of, steps_of

GLANCE_S = 60.0


@dataclass(frozen=True)
class Story:
    """What was fitted, how the error fell, where it still fails.

    Attributes
    ----------
    file : ModelFile
    steps : list of Step
    judged : Measurement or None
        The held-out samples, where a recording was given.
    """

    file: ModelFile
    catalogue: Catalogue
    steps: list[Step]
    judged: Measurement | None

    @classmethod
    def of(
        cls,
        model: str | None,
        diagnosis: Mapping[str, Any] | None,
        effects: str | None,
        recordings: Sequence[Recording],
        held_out: Recording | None,
    ) -> Story:
        """From a model.json, or from a diagnosis's own before and after.

        Raises
        ------
        UserError
            If the model was fitted on another set-up, or a file is damaged.
        """
        catalogue = load_catalogue(effects)
        file = load_model_file(model, catalogue) if model else _file_of(diagnosis or {}, catalogue)
        judged = None
        if recordings:
            for recording in (recordings[0], *([held_out] if held_out else [])):
                check_same_set_up(file, recording, model or "diagnosis")
            _, judged = split(recordings[0], held_out)
        return cls(file, catalogue, steps_of(file.history), judged)

    def verdict(self) -> str:
        """The one sentence."""
        if len(self.steps) < 2:
            return "One model, fitted; no effect has been added yet."
        first, last = self.steps[0], self.steps[-1]
        added = ", ".join(words.spoken(step.label.removeprefix("+ ")) for step in self.steps[1:])
        return f"With {added} {words.error_fall(first.errors, last.errors)}."

    def opening(self) -> list[Item]:
        """The picture that says it all, and its figures."""
        if not self.steps:
            return []
        items: list[Item] = [Facts(glance_facts(self.steps))]
        if self.judged:
            both = overlay_of(self.judged, models_of(self.file, self.catalogue), free_offset=True)
            inside = both.within(self.judged.counts)
            figure = ladder_figures.at_a_glance(inside, self.steps, busiest_window(inside, GLANCE_S))
            caption = (
                "Left: a minute of held-out samples, where the first model is worst. "
                "Right: the held-out error after each step, and the noise floor."
            )
            items.append(Picture("at-a-glance", figure, caption))
        return items

    def parts(self, diagnosis: Mapping[str, Any] | None) -> list[Section]:
        """Diagnosis, ladder, what is still wrong, parameters."""
        found = [sections.diagnosis_section(diagnosis)] if diagnosis else []
        if self.steps:
            found.append(sections.ladder_section(self.steps))
        if self.judged:
            found.append(self._comparison(self.judged))
        parameters = sections.parameters_section(self.file.fit, self.file.model)
        return [*found, *([parameters] if parameters else [])]

    def _comparison(self, judged: Measurement) -> Section:
        label = self.steps[-1].label if self.steps else "model"
        both = overlay_of(judged, {label: self.file.model}, free_offset=True).within(judged.counts)
        result = compare(self.file.model, judged, free_offset=True)
        return sections.comparison_section(both, result.to_dict())


def _file_of(diagnosis: Mapping[str, Any], catalogue: Catalogue) -> ModelFile:
    model = model_from_dict(diagnosis.get("model_after"), catalogue, "diagnosis")
    history = tuple(diagnosis.get("history", ()))
    return ModelFile(model, 0.0, fit=diagnosis.get("parameters_after", {}), history=history)


def glance_facts(steps: Sequence[Step]) -> list[tuple[str, str]]:
    """Held-out errors of the last step, and how far they have come."""
    last = steps[-1]
    pairs = []
    for channel, error in last.errors.items():
        pairs.append((f"held-out error of the {channel}", f"{plain(error)} {UNITS[channel]}"))
        floor = last.noise_floor.get(channel, 0.0)
        if len(steps) > 1 and steps[0].errors[channel] > 0:
            pairs.append(("against the first model", f"{100 * (error / steps[0].errors[channel] - 1):+.0f} %"))
        elif floor > 0:
            pairs.append(("over its noise floor", f"{error / floor:.1f} x"))
    return pairs

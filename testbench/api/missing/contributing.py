"""`contribution`: what one candidate of a diagnosis would add to the model, for a person to look at."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gcode.support.arrays import FloatArray
from gcode.support.errors import UserError
from gcode.support.figures import picture
from gcode.support.html import card
from testbench.api.arguments import Effects, Source, catalogue_of, recordings_for
from testbench.api.missing.diagnosing import DiagnosisResult, diagnosis_data
from testbench.comparing import contribution as core
from testbench.comparing.carried_over import step_before
from testbench.comparing.contribution import Contribution
from testbench.comparing.judged import check_judged_on, held_samples
from testbench.comparing.model_errors import channel_name
from testbench.comparing.words import spoken
from testbench.knit.catalogue import Catalogue, model_from_dict
from testbench.knit.effect import Effect
from testbench.measurements.responses import CONDUCTANCE_CHANNEL, UNIT_OF
from testbench.report.figures.diagnosis_figures import prediction
from testbench.report.writing.static import draw_on
from testbench.results.model_file import ModelFile
from testbench.results.result_files import checked_diagnosis

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes


@dataclass(frozen=True, eq=False, repr=False)
class ContributionResult:
    """What the model leaves of the held-out samples, and what one effect would add there.

    Attributes
    ----------
    effect : Effect
        The law with the parameters that the diagnosis gave it.
    contribution : Contribution
        Residual and what is added, in N and ln S; both without what a refit of the base laws would take up.
    ln_S : ndarray, shape (n,), or None
        The measured ln (G / S) at the same times; None where none was recorded.
    """

    effect: Effect
    contribution: Contribution
    ln_S: FloatArray | None

    def __repr__(self) -> str:
        return f"<ContributionResult {self.effect.name} to {', '.join(map(channel_name, self.contribution.added))}>"

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready form: the effect with its parameters, and the columns of `to_frame`."""
        samples = self.to_frame().to_dict("list")
        return {"effect": self.effect.name, "parameters": self.effect.model_dump(mode="json"), "samples": samples}

    def to_frame(self) -> pd.DataFrame:
        """A row a sample: ``time_s``, ``force_residual_N``, ``force_added_N``, ``conductance_residual_ln_S``, ..."""
        import pandas as pd

        found = self.contribution
        columns = {"time_s": found.time_s}
        for channel in found.added:
            name, unit = channel_name(channel), UNIT_OF[channel].replace(" ", "_")
            columns[f"{name}_residual_{unit}"] = found.residual[channel]
            columns[f"{name}_added_{unit}"] = found.added[channel]
        return pd.DataFrame(columns)

    def plot(self, axes: Axes | Sequence[Axes] | None = None) -> Any:
        """Draw what is left and what the effect would add, one panel a channel.

        Returns
        -------
        ndarray of Axes, shape (channels,)
        """
        found = self.contribution
        figure = prediction(found.time_s, found.residual, found.added, effect=spoken(self.effect.name))
        return draw_on(figure, axes)

    def _repr_html_(self) -> str:
        return card(
            f"What {spoken(self.effect.name)} would add",
            [self.effect.look],
            picture(self.plot, len(self.contribution.added)),
        )


def contribution(
    diagnosis: DiagnosisResult | str | Path | Mapping[str, Any],
    law: str,
    recording: Source,
    held_out: Source | None = None,
    *,
    effects: Effects = None,
    gauge_length_mm: float | None = None,
) -> ContributionResult:
    """Look at what a candidate of a diagnosis would add, on the samples that the diagnosis was judged on.

    Parameters
    ----------
    diagnosis : DiagnosisResult, path of a ``diagnosis.json``, or its content
    law : str
        One of its ranking, by the name of the law or of its effect (mechanism).
    recording, held_out : Recording or path
        As they were diagnosed.
    effects : path, Catalogue or effect classes, optional
        The user's own effects.
    gauge_length_mm : float, optional
        In mm, for paths of bare CSV files.

    Returns
    -------
    ContributionResult

    Raises
    ------
    UserError
        If the diagnosis has no such law, or the catalogue has it no more; if the recordings do not fit together, or
        are not those that were diagnosed.

    Examples
    --------
    >>> import testbench as tb
    >>> recording = tb.example(tb.effects.StressRelaxation(fraction=0.3), duration_s=90)
    >>> d = tb.diagnose(recording, most=1, progress=False)
    >>> tb.contribution(d, "stress_relaxation", recording).effect.mechanism
    'stress_relaxation'
    """
    catalogue = catalogue_of(effects)
    data = checked_diagnosis(diagnosis, "diagnosis") if isinstance(diagnosis, Mapping) else diagnosis_data(diagnosis)
    effect = _candidate(data, law, catalogue)
    if not data.get("history"):
        raise UserError("contribution: the diagnosis keeps no models; diagnose anew")
    before = step_before(data["history"], len(data["found"]))
    without = model_from_dict(before["model"], catalogue, "diagnosis")
    first, second, _ = recordings_for(None, None, recording, held_out, gauge_length_mm)
    held = held_samples(ModelFile(without, 0.0, history=(before,)), first, second)
    check_judged_on(held, before, without)
    ln_S = held.measured[CONDUCTANCE_CHANNEL][held.counts] if CONDUCTANCE_CHANNEL in held.measured else None
    return ContributionResult(effect, core.contribution(without, effect, held), ln_S)


def _candidate(diagnosis: Mapping[str, Any], law: str, catalogue: Catalogue) -> Effect:
    ranking = diagnosis["ranking"]
    of_name = {entry["effect"]: entry for entry in ranking} | {entry["law"]: entry for entry in ranking}
    if not isinstance(law, str) or law not in of_name:
        laws = ", ".join(entry["law"] for entry in ranking) or "none"
        raise UserError(f"contribution: the diagnosis has no law or effect {law!r}; it ranks {laws}")
    return catalogue[of_name[law]["law"]](**of_name[law]["start"])

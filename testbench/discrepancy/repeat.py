"""Several missing effects, found one after the other."""

from __future__ import annotations

from dataclasses import replace

from testbench.discrepancy.diagnosis import Diagnosis, diagnose
from testbench.discrepancy.telling import Progress
from testbench.knit.catalogue import Catalogue
from testbench.knit.model import KnitModel
from testbench.recording import Recording


def diagnose_repeatedly(
    recording: Recording,
    held_out: Recording | None = None,
    model: KnitModel | None = None,
    catalogue: Catalogue | None = None,
    progress: Progress | None = None,
    most: int = 3,
) -> list[Diagnosis]:
    """Put in what was found and diagnose again, until nothing more is named.

    Parameters
    ----------
    recording, held_out, model, catalogue, progress
        As `testbench.discrepancy.diagnosis.diagnose`.
    most : int
        Effects to find at most.

    Returns
    -------
    list of Diagnosis
        One a round; the ladder of each continues the one before. Only the last may name nothing.
    """
    found: list[Diagnosis] = []
    while len(found) < most:
        one = diagnose(recording, held_out, model, catalogue, progress)
        found.append(_continued(found[-1], one) if found else one)
        if one.verdict != "missing":
            break
        model = one.after.model
    return found


def _continued(earlier: Diagnosis, later: Diagnosis) -> Diagnosis:
    """`later` with the steps of `earlier` before its own."""
    history = (*earlier.after.history, *later.after.history[1:])
    return replace(later, after=replace(later.after, history=history))

"""Several missing effects, found one after the other."""

from __future__ import annotations

from dataclasses import replace

from testbench.discrepancy.diagnosis import Diagnosis, diagnose
from testbench.discrepancy.remains import remains
from testbench.discrepancy.telling import Progress
from testbench.knit.catalogue import Catalogue
from testbench.knit.model import KnitModel
from testbench.recording import Recording

LEFT_BY_BOTH = 0.1  # share of the error above the noise that two effects named together may leave


def diagnose_repeatedly(
    recording: Recording,
    held_out: Recording | None = None,
    model: KnitModel | None = None,
    catalogue: Catalogue | None = None,
    progress: Progress | None = None,
    most: int = 3,
) -> list[Diagnosis]:
    """Put in what was found and diagnose again, until nothing more is named.

    Two effects of one size leave each other's part unexplained, so that neither can be named alone. Where the verdict
    is `unknown`, the first idea is tried all the same: if a second one is found beside it, and both together leave
    little, both are named.

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
        new = [diagnose(recording, held_out, model, catalogue, progress)]
        if new[0].attempt is not None and len(found) + 2 <= most:
            beside = diagnose(recording, held_out, new[0].attempt.model, catalogue, progress)
            if _explains(new[0], beside):
                new = [
                    replace(new[0], verdict="missing", after=new[0].attempt, error_after=beside.error_before),
                    beside,
                ]
        for one in new:
            found.append(_continued(found[-1], one) if found else one)
        if new[-1].verdict != "missing":
            break
        model = new[-1].after.model
    return found


def _explains(first: Diagnosis, beside: Diagnosis) -> bool:
    """Whether two effects together leave little of the error above the noise."""
    left = remains(first.error_before, beside.error_after, first.noise_floor).share
    return beside.verdict == "missing" and left < LEFT_BY_BOTH


def _continued(earlier: Diagnosis, later: Diagnosis) -> Diagnosis:
    """`later` with the steps of `earlier` before its own."""
    history = (*earlier.after.history, *later.after.history[1:])
    return replace(later, after=replace(later.after, history=history))

"""A diagnosis as text for the terminal."""

from __future__ import annotations

from testbench.comparing.tables import ladder_table
from testbench.comparing.words import percent, percent_left
from testbench.diagnosis.judging.probabilities import NOTHING, UNKNOWN
from testbench.diagnosis.result import Diagnosis
from testbench.diagnosis.verdict import verdict_clauses

SHOWN = 6


def diagnosis_table(diagnosis: Diagnosis) -> str:
    """What was found and how sure that is, the ranking, and the fall of the error."""
    title = f"{'rank':<6}{'effect':<26}{'law':<34}{'probability':>11}{'log evidence':>14}  held-out error left"
    title += ", mean of the channels (95 %)" if len(diagnosis.error_before) > 1 else " (95 %)"
    lines = [first_line(diagnosis), "", title]
    for place, entry in enumerate(diagnosis.ranking[:SHOWN], 1):
        numbers = (
            f"{percent(entry.probability):>11}{entry.log_evidence:>9.1f} nats  {_error_left(entry.held_out_gain)}"
        )
        tied = "  (tied)" if entry.effect in diagnosis.tied else ""
        lines.append(f"{place:<6}{entry.effect:<26}{entry.law:<34}{numbers}{tied}")
    others = f"nothing is missing: {percent(diagnosis.probabilities[NOTHING])}"
    lines.append(f"{others}; something that no effect explains: {percent(diagnosis.probabilities[UNKNOWN])}")
    if diagnosis.base_misfits:
        lines.append(f"the base laws misfit in themselves; shape freedom used: {', '.join(diagnosis.base_misfits)}")
    if diagnosis.other_laws:
        lines.append(f"a law that suits this sensor better took its place: {', '.join(diagnosis.other_laws)}")
    lines += ["", ladder_table(diagnosis.after)]
    return "\n".join(lines)


def first_line(diagnosis: Diagnosis) -> str:
    """The verdict on one line."""
    return "; ".join(verdict_clauses(diagnosis.findings()))


def _error_left(gains: tuple[float, float, float] | None) -> str:
    """Share of the base's error on samples that no fit has seen; a dash where the mechanism was not refitted."""
    if gains is None:
        return "-"
    value, high, low = map(percent_left, gains)
    return f"{value:.0f} % ({low:.0f} to {high:.0f})"

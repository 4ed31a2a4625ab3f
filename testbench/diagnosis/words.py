"""A diagnosis as text for the terminal."""

from __future__ import annotations

from testbench.comparing.carried_over import CLEARLY, changed, fails_elsewhere
from testbench.comparing.tables import ladder_table
from testbench.comparing.words import listed, percent, percent_left, spoken, still_off
from testbench.diagnosis.judging.probabilities import NOTHING, UNKNOWN
from testbench.diagnosis.judging.weighing import LEFT_AT_MOST
from testbench.diagnosis.result import Diagnosis, Ranked

SHOWN = 6


def diagnosis_table(diagnosis: Diagnosis) -> str:
    """What was found and how sure that is, the ranking, and the fall of the error."""
    title = f"{'rank':<6}{'effect':<26}{'law':<34}{'probability':>11}{'log evidence':>14}  held-out error left"
    title += ", mean of the channels (95 %)" if len(diagnosis.error_before) > 1 else " (95 %)"
    lines = [first_line(diagnosis), "", title]
    for place, entry in enumerate(diagnosis.ranking[:SHOWN], 1):
        numbers = f"{percent(entry.probability):>11}{entry.log_evidence:>9.1f} nats  {_error_left(entry)}"
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
    """All that was found, how sure that is, and what is left."""
    chances = diagnosis.probabilities
    if diagnosis.verdict == "nothing_missing":
        return f"nothing is missing ({percent(chances[NOTHING])}){_bent(diagnosis)}{_held_out(diagnosis)}"
    if diagnosis.verdict == "missing":
        return f"missing: {_found(diagnosis)}; {_left(diagnosis.left)}{_where(diagnosis)}{_held_out(diagnosis)}"
    first = diagnosis.ranking[0]
    if first.probability > chances[UNKNOWN]:
        return f"unknown: {_too_little(first)}{_depends(diagnosis)}"
    said = f"unknown ({percent(chances[UNKNOWN])}): structure remains that no effect of the catalogue explains"
    return said + _depends(diagnosis) + _nearest(first)


def _bent(diagnosis: Diagnosis) -> str:
    """As which effect a law of the base is bent, if it is; that is no news, but it is what the base lacks."""
    mechanism = diagnosis.bends_like
    if not mechanism:
        return ""
    chance = percent(diagnosis.probabilities[mechanism])
    return f", but a law of the base is bent as {spoken(mechanism)} ({chance}) would bend it"


def _too_little(first: Ranked) -> str:
    """What is said of a law that is probable, but explains less than half."""
    probable = f"{spoken(first.effect)} ({percent(first.probability)}) is probable"
    return f"{probable}, but leaves {_share(first.left)}"


def _depends(diagnosis: Diagnosis) -> str:
    if not diagnosis.depends_on:
        return ""
    channel, coordinate, share = diagnosis.depends_on[0]
    return f", depends most on: {channel}: {coordinate} ({percent(share)} of it)"


def _nearest(first: Ranked) -> str:
    """What is said of the most probable law where none is probable: it may be a part of the answer."""
    if first.held_out_gain is None or first.left > CLEARLY:
        return ""
    return f". The nearest is {spoken(first.effect)} ({first.law}), which would leave {_share(first.left)}"


def _held_out(diagnosis: Diagnosis) -> str:
    """What is said where the held-out error is not what the first words promise."""
    off = still_off(diagnosis.error_after, diagnosis.noise_floor)
    fails = fails_elsewhere(diagnosis.after.history, len(diagnosis.found))
    if fails:
        return f" in this recording, but {fails}"
    return f"; but {off}: see `testbench compare`" if off else ""


def _where(diagnosis: Diagnosis) -> str:
    """In which channel most is left, where what was found explains another one."""
    history = diagnosis.after.history
    where = changed(history, len(diagnosis.found))
    others = [c for c in history[-1]["errors"]["calibration"] if c not in where]
    return f", nearly all of it in the {others[0]}" if others and diagnosis.left > LEFT_AT_MOST else ""


def _found(diagnosis: Diagnosis) -> str:
    words = [f"{spoken(one.effect)} ({percent(one.probability)})" for one in diagnosis.found]
    first = diagnosis.found[0].effect
    rivals = [
        f"{spoken(name)} ({percent(diagnosis.probabilities[name])})" for name in diagnosis.tied if name != first
    ]
    if rivals:
        words[0] += f", hardly told from {listed(rivals)}"
    return ", then ".join(words)


def _left(share: float) -> str:
    if share < 0.01:
        return "less than 1 % of the error above the noise is left"
    return f"{_share(share)} is left"


def _share(left: float) -> str:
    return f"{100 * left:.0f} % of the error above the noise"


def _error_left(entry: Ranked) -> str:
    """Share of the base's error on samples that no fit has seen; a dash where the mechanism was not refitted."""
    if entry.held_out_gain is None:
        return "-"
    value, high, low = map(percent_left, entry.held_out_gain)
    return f"{value:.0f} % ({low:.0f} to {high:.0f})"

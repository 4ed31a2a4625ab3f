"""Results as text for the terminal."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from testbench.discrepancy.compare import Comparison
from testbench.discrepancy.diagnosis import Diagnosis
from testbench.discrepancy.errors import channel_name
from testbench.discrepancy.evidence import Evidence
from testbench.discrepancy.measurement import UNIT_OF
from testbench.discrepancy.model_file import ModelFile

STEP_WIDTH = 34  # of the ladder's first column, if no step needs more


def fit_table(file: ModelFile) -> str:
    """Parameters with their standard errors, and plain words on what cannot be trusted."""
    fit = file.fit
    vectors = {address.partition("[")[0] for address in fit["parameters"] if "[" in address}
    rows = []
    for address, entry in fit["parameters"].items():
        if "[" in address:
            continue
        rows.append(f"  {address:<38} {entry['value']:>12.5g} ± {entry['standard_error']:<10.2g} {entry['unit']}")
    rows += [f"  {name:<38} (shape weights)" for name in sorted(vectors)]
    scalar = [name for name in fit["unidentified"] if "[" not in name]
    if fit["at_bound"]:
        rows.append(f"  at a bound (the law may not fit): {', '.join(fit['at_bound'])}")
    if scalar:
        rows.append(f"  this recording cannot tell: {', '.join(scalar)}")
    for first, second, value in fit["correlated"][:3]:
        rows.append(f"  hardly told apart: {first} and {second} (correlation {value:+.2f})")
    return "\n".join(rows)


def errors_line(step: Mapping[str, Any]) -> str:
    """Errors of one step in one line."""
    parts = []
    for channel, held in step["errors"]["held_out"].items():
        calibration, floor = step["errors"]["calibration"][channel], step["noise_floor"][channel]
        unit = UNIT_OF[channel]
        parts.append(
            f"{channel_name(channel)} {calibration:.4g} {unit} (held out {held:.4g}, noise floor {floor:.2g})"
        )
    return f"{step['step']}: RMS error " + "; ".join(parts)


def ladder_table(file: ModelFile) -> str:
    """The errors step by step, down to the noise floor."""
    wide = max(STEP_WIDTH, 2 + max((len(step["step"]) for step in file.history), default=0))
    lines = [f"{'step':<{wide}}{'channel':<13}{'calibration':>14}{'held out':>14}{'noise floor':>14}{'fall':>8}"]
    first: dict[str, float] = {}
    for step in file.history:
        name, errors = step["step"], step["errors"]
        for channel, held in errors["held_out"].items():
            top = first.setdefault(channel, held)
            numbers = (errors["calibration"][channel], held, step["noise_floor"][channel])
            cells = "".join(f"{value:>9.4g} {UNIT_OF[channel]:<4}" for value in numbers)
            lines.append(f"{name:<{wide}}{channel_name(channel):<13}{cells}{100 * (1 - held / top):>6.0f} %")
            name = ""
    return "\n".join(lines)


def comparison_table(result: Comparison) -> str:
    """RMS against the noise floor, and the worst places in words."""
    lines = []
    for channel, rms in result.rms.items():
        floor = result.noise_floor[channel]
        times = rms / max(floor, 1e-300)
        lines.append(
            f"{channel_name(channel)}: RMS error {rms:.4g} {UNIT_OF[channel]}, {times:.1f} times the noise floor "
            f"of {floor:.2g} (estimated from the samples)"
        )
    if result.worst:
        lines.append("where it fails, the worst first:")
        lines += [f"  {n}. {place.words}" for n, place in enumerate(result.worst, 1)]
    else:
        lines.append("no place stands out from the noise")
    return "\n".join(lines)


def diagnosis_table(diagnosis: Diagnosis) -> str:
    """Verdict, ranking and the fall of the error."""
    weighing = diagnosis.weighing
    title = f"{'rank':<6}{'effect':<26}{'form':<34}{'gain':>6}  held-out error left (95 %)"
    lines = [_verdict_line(diagnosis), "", title]
    for place, entry in enumerate(weighing.ranking[:6], 1):
        tied = "  (tied)" if entry.idea in diagnosis.tied else ""
        seen = "  (the readings show it)" if entry.seen else ""
        numbers = f"{entry.gain:>6.2f}  {_error_left(entry)}"
        lines.append(f"{place:<6}{entry.idea:<26}{entry.form:<34}{numbers}{tied}{seen}")
    if diagnosis.verdict == "unknown":
        lines.append("two effects at once can hide each other: --repeat 2 looks for a second beside the first")
        lines.append("what they do not explain depends most on:")
        lines += [f"  {channel}: {coordinate}" for channel, coordinate, _ in weighing.depends_on[:3]]
    if diagnosis.base_misfits:
        lines.append(f"the base laws misfit in themselves; shape freedom used: {', '.join(diagnosis.base_misfits)}")
    if diagnosis.other_laws:
        lines.append(f"a law that suits this sensor better took its place: {', '.join(diagnosis.other_laws)}")
    lines += ["", ladder_table(diagnosis.after)]
    return "\n".join(lines)


def _error_left(entry: Evidence) -> str:
    """Share of the base's error on samples that no fit has seen; a dash where the idea was not worth a refit."""
    if entry.held_out is None:
        return "-"
    value, high, low = (100 * math.exp(-0.5 * gain) for gain in entry.held_out)
    return f"{value:.0f} % ({low:.0f} to {high:.0f})"


def _verdict_line(diagnosis: Diagnosis) -> str:
    first = diagnosis.weighing.ranking[0].idea if diagnosis.weighing.ranking else ""
    if diagnosis.verdict == "missing" and diagnosis.tied:
        return f"missing: {first}, which these recordings cannot tell from {', '.join(diagnosis.tied[1:])}"
    if diagnosis.verdict == "missing":
        return f"missing: {first}"
    if diagnosis.verdict == "unknown":
        return "unknown: structure remains that no effect of the catalogue explains"
    return "nothing missing: no effect gains more than the noise would"

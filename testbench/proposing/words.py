"""A proposed law as text for the terminal, for the head of its file, and as JSON."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from testbench.comparing.model_errors import channel_name
from testbench.comparing.numbers import over_noise
from testbench.comparing.tables import ladder_table
from testbench.comparing.words import percent
from testbench.knit.effect import bounds_of
from testbench.measurements.responses import UNIT_OF
from testbench.proposing.laws.formulas import in_words, latex_of, plain
from testbench.proposing.laws.law import Law
from testbench.proposing.laws_found import Option, Proposed, Step, numbered
from testbench.proposing.trial import TIED_NATS
from testbench.proposing.writing import effect_class, strength_key

SHOWN = 4


def proposal_text(proposed: Proposed) -> str:
    """The whole proposal: the law, what else could be it, the ladder, and what could not be judged."""
    lines = [first_line(proposed), ""]
    for index, step in enumerate(proposed.steps):
        lines += [*_law(proposed, step, index), ""]
    if proposed.rejected:
        law = proposed.rejected.option.law
        lines += [
            f"found, but it does not hold on the held-out recording, {_beyond(proposed.rejected)}: {in_words(law)}",
            "",
        ]
    lines.append(ladder_table(proposed.after))
    if proposed.notes:
        lines += ["", "what this recording could not judge:", *(f"  - {note}" for note in proposed.notes)]
    return "\n".join(lines)


def first_line(proposed: Proposed) -> str:
    """The result in one sentence."""
    if proposed.verdict == "proposed":
        laws = "; then ".join(in_words(law) for law, _ in proposed.laws)
        return f"proposed: {laws}"
    left = ", ".join(
        f"{channel_name(c)} {over_noise(error, proposed.noise_floor[c]):.2f}"
        for c, error in proposed.error_before.items()
    )
    floors = f"(held-out error in noise floors: {left})"
    if proposed.verdict == "nothing_left":
        return f"nothing is left above the noise of the recording that is fitted: no law is proposed {floors}"
    if proposed.verdict == "does_not_hold":
        return f"no law is proposed: what was found does not hold on the held-out recording {floors}"
    return f"no law is proposed: none of the library explains what is left {floors}"


def _law(proposed: Proposed, step: Step, index: int) -> Iterator[str]:
    law, name = step.option.law, numbered(proposed.name, index)
    yield f"{name}: {in_words(law)}"
    yield f"    {plain(law.place.latex)} += a z,   z = {plain(law.term.latex)}"
    yield from (f"    {plain(line)}" for line in law.term.definitions)
    yield f"    LaTeX: {latex_of(law)}"
    option, fields = step.option, effect_class(law, name, proposed.grid).model_fields
    for key, number in numbers(proposed, law, name).items():
        yield f"    {key:<10} = {number} - {fields[key].description}"
    yield (
        f"    log evidence {option.log_evidence:+.1f} nats; it gains in {percent(option.holds)} of the resampled "
        f"recordings and is the best in {percent(option.chosen)}"
    )
    yield f"    judged on the held-out recording, {_beyond(step)}"
    if step.alternatives:
        yield "    instead of it:"
    for other in step.alternatives[:SHOWN]:
        yield f"      {other.log_evidence:+8.1f} nats  {_beside(other, option)}: {in_words(other.law)}"


def _beside(other: Option, option: Option) -> str:
    """How likely another law is beside the one that was chosen."""
    if abs(other.log_evidence - option.log_evidence) < TIED_NATS:
        return "cannot be told from it"
    if other.log_evidence < option.log_evidence:
        return "less likely"
    return f"more likely, but refused: it gains in {percent(other.holds)} of the resampled recordings"


def _beyond(step: Step) -> str:
    return f"{percent(step.beyond)} of which lies beyond what it was fitted on"


def numbers(proposed: Proposed, law: Law, name: str) -> dict[str, str]:
    """The parameters of a law with their standard errors and units, in words."""
    errors, found = proposed.after.fit.get("parameters", {}), {}
    for key, field in effect_class(law, name, proposed.grid).model_fields.items():
        error = errors.get(f"{name}.{key}", {}).get("standard_error")
        around = f" ± {error:.2g}" if error is not None else ""
        unit = bounds_of(field)["unit"]
        found[key] = f"{float(field.default):.4g}{around}{'' if unit == '1' else ' ' + unit}"
    return found


def story(proposed: Proposed) -> str:
    """Where the laws come from, for the head of the file."""
    parts = []
    for c, before in proposed.error_before.items():
        unit, after, floor = UNIT_OF[c], proposed.error_after[c], proposed.noise_floor[c]
        parts.append(f"{channel_name(c)} {before:.3g} -> {after:.3g} {unit} (noise floor {floor:.2g})")
    signals = proposed.calibration.signals
    speed = float(np.quantile(np.abs(np.gradient(signals["strain"], signals["time_s"])), 0.99))
    said = [
        f"Found on {_safe(proposed.calibration.recording.source)} ({signals['time_s'][-1]:.0f} s, strain up to "
        f"{np.max(signals['strain']):.2g}, speed up to {speed:.2g} 1/s)",
        f"judged on {_safe(proposed.held.recording.source)}: held-out error of {', '.join(parts)}",
    ]
    every = "; ".join(
        f"{name}: {', '.join(f'{key} {number}' for key, number in numbers(proposed, law, name).items())}"
        for law, name in proposed.laws
    )
    return f"{', '.join(said)}. Numbers with standard errors: {every}."


def _safe(source: str) -> str:
    """The name of a recording as it may stand in a program: a stranger has chosen it."""
    return re.sub(r"[^\w .()-]", "_", Path(source).name)[:80]


def as_json(proposed: Proposed) -> dict[str, Any]:
    """JSON-ready form; the shape is documented in docs/propose.md."""
    return {
        "verdict": proposed.verdict,
        "laws": [_step_json(s) | {"effect": numbered(proposed.name, k), "tied": s.tied,
                 "alternatives": [_option_json(a) for a in s.alternatives]} for k, s in enumerate(proposed.steps)],
        "rejected": _step_json(proposed.rejected) if proposed.rejected else None,
        "not_judged": list(proposed.notes),
        "error_before": dict(proposed.error_before),
        "error_after": dict(proposed.error_after),
        "noise_floor": dict(proposed.noise_floor),
        "model_after": proposed.after.model.to_dict(),
        "history": [dict(step) for step in proposed.after.history],
    }  # fmt: skip


def _step_json(step: Step) -> dict[str, Any]:
    return _option_json(step.option) | {"held_out_beyond": step.beyond}


def _option_json(option: Option) -> dict[str, Any]:
    law, strength = option.law, strength_key(option.law)
    return {
        "words": in_words(law),
        "latex": latex_of(law),
        "stage": law.place.stage.name,
        "changes": law.place.name,
        "coordinate": law.term.coordinate.name,
        "operators": [one.name for one in law.term.operators],
        "parameters": {strength: law.strength, **law.values},
        "meanings": {
            strength: f"a: change of {plain(law.place.latex)} for each unit of z",
            **{s.key: f"{plain(s.symbol)}: {s.doc}" for s in law.term.slots},
        },
        "units": {strength: str(law.unit), **{s.key: str(law.term.unit_of(s)) for s in law.term.slots}},
        "log_evidence": option.log_evidence,
        "gains_in": option.holds,
        "best_in": option.chosen,
    }

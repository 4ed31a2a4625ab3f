"""Results as text for the terminal."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any, NamedTuple

from testbench.comparing.clamping import Zero
from testbench.comparing.compare import Comparison
from testbench.comparing.model_errors import channel_name
from testbench.comparing.words import events_in_words
from testbench.measurements.responses import UNIT_OF
from testbench.results.model_file import AT_BOUND, UNTOLD, ModelFile, doubted

STEP_WIDTH = 34  # of the ladder's first column, if no step needs more


def fit_table(file: ModelFile) -> str:
    """Parameters with their standard errors, and plain words on what cannot be trusted."""
    fit, doubts = file.fit, doubted(file.fit)
    vectors = {address.partition("[")[0]: "(shape weights)" for address in fit["parameters"] if "[" in address}
    vectors |= events_in_words(file.model, fit["parameters"])
    rows = []
    for address, entry in fit["parameters"].items():
        if "[" in address:
            continue
        # Where a bound holds a parameter, nothing is known of its error.
        error = "" if doubts.get(address) == AT_BOUND else f"± {entry['standard_error']:.2g}"
        rows.append(f"  {address:<38} {entry['value']:>12.5g} {error:<12} {entry['unit']}")
    rows += [f"  {name:<38} {words}" for name, words in sorted(vectors.items())]
    for doubt, remark in ((AT_BOUND, " (the law may not fit)"), (UNTOLD, "")):
        if names := [name for name, told in doubts.items() if told == doubt and "[" not in name]:
            rows.append(f"  {doubt}{remark}: {', '.join(names)}")
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
    zero = step.get("zero")
    anew = f"; held out {Zero(**zero)}" if zero else ""
    return f"{step['step']}: RMS error " + "; ".join(parts) + anew


class LadderRow(NamedTuple):
    """Errors of one channel after one step, in N or ln S; `fall` is the share of the first held-out error."""

    step: str
    channel: str
    calibration: float
    held_out: float
    noise_floor: float
    fall: float


def ladder_rows(history: Iterable[Mapping[str, Any]]) -> Iterator[LadderRow]:
    """A row for each step and channel of a model's history."""
    first: dict[str, float] = {}
    for step in history:
        for channel, held in step["errors"]["held_out"].items():
            top = first.setdefault(channel, held)
            fall = 1 - held / top if top else 0.0
            calibration, floor = step["errors"]["calibration"][channel], step["noise_floor"][channel]
            yield LadderRow(step["step"], channel, calibration, held, floor, fall)


def ladder_table(file: ModelFile) -> str:
    """The errors step by step, down to the noise floor."""
    wide = max(STEP_WIDTH, 2 + max((len(step["step"]) for step in file.history), default=0))
    lines = [f"{'step':<{wide}}{'channel':<13}{'calibration':>16}{'held out':>16}{'noise floor':>16}{'fall':>8}"]
    rows = list(ladder_rows(file.history))
    for row in rows:
        name = row.step if row.channel == rows[0].channel else ""
        numbers = (row.calibration, row.held_out, row.noise_floor)
        cells = "".join(f"{value:>11.4g} {UNIT_OF[row.channel]:<4}" for value in numbers)
        lines.append(f"{name:<{wide}}{channel_name(row.channel):<13}{cells}{100 * row.fall:>z6.0f} %")
    return "\n".join(lines)


def comparison_table(result: Comparison) -> str:
    """RMS against the noise floor, and the worst places in words."""
    lines = [
        f"{channel_name(channel)}: RMS error {result.rms[channel]:.4g} {UNIT_OF[channel]}, {times:.1f} times the "
        f"noise floor of {result.noise_floor[channel]:.2g} (estimated from the samples)"
        for channel, times in result.over_noise.items()
    ]
    if result.worst:
        lines.append("where it fails, the worst first:")
        lines += [f"  {n}. {place.words}" for n, place in enumerate(result.worst, 1)]
    return "\n".join(filter(None, [*lines, result.unplaced]))

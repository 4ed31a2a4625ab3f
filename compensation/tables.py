"""The tables that `compensation table` prints."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from compensation import published, score
from compensation import reproduction as ours
from compensation.paper_campaigns import RUNS, program_of
from testbench.recording import Recording

Recordings = Mapping[str, Mapping[str, Recording]]
TESTS = ("T", "A", "B")


def trajectories(folder: Path) -> str:
    """Speed and acceleration of the trajectories, as executed, at 20 Hz."""
    from gcode.planner import play
    from gcode.reader import read_program, read_text
    from gcode.statistics import motion_statistics

    lines = ["Trajectories: v (mm/s) and a (mm/s2), max / mean / SD at 20 Hz as executed; in brackets the paper's"]
    for name, (preset, _, _) in RUNS.items():
        executed = play(read_program(read_text(program_of(folder, name))), rate_hz=20.0)
        moved = motion_statistics(executed.position_mm, 20.0)
        v = (moved.v_max_mm_per_s, moved.v_mean_mm_per_s, moved.v_sd_mm_per_s)
        a = (moved.a_max_mm_per_s2, moved.a_mean_mm_per_s2, moved.a_sd_mm_per_s2)
        lines.append(f"  {name:7} " + "   ".join(map(_beside, (v, a), published.TRAJECTORIES[preset])))
    return "\n".join(lines) + "\n"


def results(recordings: Recordings, target: str, seeds: int) -> str:
    """r2 raw and compensated on T, A and B."""
    lines = [
        f"{target}: r2 on T (training), A, B (tests); {seeds} seeds",
        f"  {'sensor':6} {'':40} {'T':>14} {'A':>14} {'B':>14} {'mean A, B':>9} {'E':>7} {'param.':>6}",
    ]
    for sensor, runs in recordings.items():
        lines += _sensor_rows(sensor, ours.prepared({name: runs[name] for name in TESTS}, target), target, seeds)
    return "\n".join(lines) + "\n"


def _sensor_rows(sensor: str, series, target: str, seeds: int) -> Iterable[str]:
    parts = list(series.values())
    raw = [score.r2_before(part.truth, part.conductance_S) for part in parts]
    paper = ours.over_seeds(series["T"], parts, target, seeds)
    better = ours.tuned(series["T"], target)
    yield _row(sensor, "raw, the paper's sensor", published.RAW[sensor, target])
    yield _row(sensor, "raw, ours", raw)
    yield _row(
        sensor, "best straight line (rho2), ours", [score.rho_squared(p.truth, p.conductance_S) for p in parts]
    )
    yield _row(sensor, "compensated, the paper", published.COMPENSATED[sensor, target], None, 51)
    label = f"EMA + (4,2,2), all seeds ({paper.dead.sum()} dead)"
    yield _row(sensor, label, paper.r2.mean(axis=0), paper.r2.std(axis=0), 51)
    yield _row(sensor, "EMA + (4,2,2), live seeds", paper.live.mean(axis=0), paper.live.std(axis=0), 51)
    best = paper.best_of(5)
    if len(best):
        yield _row(sensor, "EMA + (4,2,2), best of 5 on training", best.mean(axis=0), best.std(axis=0), 51)
    yield _row(sensor, "tuned", ours.scores_of(better, parts), None, better.parameter_count)
    spans = "".join(f" {f'{low:.3f}..{high:.3f}':>14}" for low, high in ours.intervals_of(better, parts))
    yield f"  {sensor:6} {'  95 % (60 s blocks)':40}{spans}"


def transfer(recordings: Recordings, seeds: int) -> str:
    """Networks trained on 0-30 % used on the fast 0-50 % campaign, and both factors trained there."""
    lines = [f"Force on the fast 0-50 % campaign (test fast-A); live seeds of {seeds}, mean (SD)"]
    for sensor, runs in recordings.items():
        series = ours.prepared(runs, "force")
        tests = [series["fast-A"]]
        raw = score.r2_before(tests[0].truth, tests[0].conductance_S)
        lines.append(f"  {sensor:6} raw {raw:.3f}")
        for label, training, options in (
            ("trained on 0-30 %, a = 2.5", "T", ours.PUBLISHED),
            ("trained on 0-50 %, a = 2.5", "fast-T", ours.PUBLISHED),
            ("trained on 0-50 %, a = 1.75", "fast-T", replace(ours.PUBLISHED, factor=1.75)),
        ):
            found = ours.over_seeds(series[training], tests, "force", seeds, options)
            lines.append(f"  {sensor:6} {label:30} {found.live.mean():.3f} ({found.live.std():.3f})")
    return "\n".join(lines) + "\n"


def others(recordings: Recordings, seeds: int) -> str:
    """Other regressors on the same features, other sampling rates, other scaling: force, mean r2 over A and B."""
    lines = [
        "Force, mean r2 over A and B: other regressors on the same features; the network at other rates (live seeds)"
    ]
    for sensor, runs in recordings.items():
        chosen = {name: runs[name] for name in TESTS}
        series = ours.prepared(chosen, "force")
        for name, scores in ours.baselines(series["T"], [series["A"], series["B"]], "force").items():
            lines.append(f"  {sensor:6} {name:24} {np.mean(scores):.3f}")
        for rate_hz in (10.0, 20.0, 40.0):
            at_rate = ours.prepared(chosen, "force", rate_hz)
            options = replace(ours.PUBLISHED, rate_hz=rate_hz)
            found = ours.over_seeds(at_rate["T"], [at_rate["A"], at_rate["B"]], "force", seeds, options)
            lines.append(f"  {sensor:6} {f'network at {rate_hz:g} Hz':24} {found.live.mean():.3f}")
    return "\n".join(lines) + "\n"


def _row(sensor: str, label: str, means, spreads=None, parameters: int | None = None) -> str:
    shown = [f"{mean:.3f}" for mean in means]
    if spreads is not None:
        shown = [f"{text} ({spread:.3f})" for text, spread in zip(shown, spreads, strict=True)]
    criterion = score.error_of_two(means[1], means[2])
    tail = f" {parameters:6}" if parameters else ""
    return (
        f"  {sensor:6} {label:40}"
        + "".join(f" {text:>14}" for text in shown)
        + f" {np.mean(means[1:]):9.3f} {criterion:7.4f}{tail}"
    )


def _beside(values, reference) -> str:
    return " / ".join(f"{value:.3f} [{other:g}]" for value, other in zip(values, reference, strict=True))

"""The tables that `compensation table` prints."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np

from compensation.paper import published
from compensation.paper import reproduction as ours
from compensation.paper.paper_campaigns import RUNS, TAB, program_of
from compensation.series import score
from compensation.training.tuning import tune
from testbench.recordings.recording import Recording

# Of each kind of sensor, one or more specimens, each with its recordings by name.
Specimens = Mapping[str, Sequence[Mapping[str, Recording]]]
ALL_DEAD = "every seed is dead"
# The paper does not say which it did: docs/decisions/0015-scaler-of-the-paper.md.
SCALERS = {"each by its own scaler": True, "all by T's scaler": False}
TRANSFERS = (
    ("trained on 0-30 %, a = 2.5", "T", 2.5),
    ("trained on 0-50 %, a = 2.5", "fast-T", 2.5),
    ("trained on 0-50 %, a = 1.75", "fast-T", 1.75),
)


def trajectories(folder: Path) -> str:
    """Speed and acceleration of the trajectories, as executed, at 20 Hz."""
    from gcode.mach4.controller import play
    from gcode.mach4.reader import read_program, read_text
    from gcode.motion.statistics import motion_statistics

    lines = ["Trajectories: v (mm/s) and a (mm/s2), max / mean / SD at 20 Hz as executed; in brackets the paper's"]
    for name, (preset, _, _) in RUNS.items():
        executed = play(read_program(read_text(program_of(folder, name))), rate_hz=20.0)
        moved = motion_statistics(executed.position_mm, 20.0)
        v = (moved.v_max_mm_per_s, moved.v_mean_mm_per_s, moved.v_sd_mm_per_s)
        a = (moved.a_max_mm_per_s2, moved.a_mean_mm_per_s2, moved.a_sd_mm_per_s2)
        lines.append(f"  {name:7} " + "   ".join(map(_beside, (v, a), published.TRAJECTORIES[preset])))
    return "\n".join(lines) + "\n"


def results(recordings: Specimens, target: str, seeds: int, engine: str = "exact", tuned: bool = True) -> str:
    """r2 raw and compensated on T, A and B: the paper's and ours, with both scalers, all seeds and live ones."""
    lines = [
        f"{target}: r2 on T (training), A, B (tests); {seeds} seeds; in brackets the SD over sensors, or over seeds",
        f"  {'sensor':6} {'':44} {'T':>14} {'A':>14} {'B':>14} {'mean A, B':>9} {'E':>7} {'param.':>6}",
    ]
    for sensor, several in recordings.items():
        series = [ours.prepared({name: runs[name] for name in TAB}, target) for runs in several]
        lines += _sensor_rows(sensor, series, target, seeds, engine)
        if tuned:
            lines += _tuned_rows(sensor, series[0], target)
    return "\n".join(lines) + "\n"


def _sensor_rows(sensor: str, several, target: str, seeds: int, engine: str) -> Iterable[str]:
    parts = [list(series.values()) for series in several]
    yield _row(sensor, "raw, the paper's sensor", published.RAW[sensor, target])
    raw = [[score.r2_before(part.truth, part.conductance_S) for part in three] for three in parts]
    yield _over_sensors(sensor, f"raw, ours ({len(several)} {'sensor' if len(several) == 1 else 'sensors'})", raw)
    line = [[score.rho_squared(part.truth, part.conductance_S) for part in three] for three in parts]
    yield _over_sensors(sensor, "best straight line (rho2), ours", line)
    yield _row(sensor, "compensated, the paper", published.COMPENSATED[sensor, target], None, 51)
    for label, per_recording in SCALERS.items():
        options = replace(ours.PUBLISHED, per_recording=per_recording, engine=engine)
        found = [ours.over_seeds(three[0], three, target, seeds, options) for three in parts]
        dead = sum(int(one.dead.sum()) for one in found)
        yield _seed_row(sensor, f"{label}: all seeds ({dead}/{seeds * len(found)} dead)", [one.r2 for one in found])
        yield _seed_row(sensor, f"{label}: live seeds", [one.live for one in found])
        best = [one.best_of(5) for one in found]
        if len(best[0]):
            yield _seed_row(sensor, f"{label}: best of 5 on training", best)


def _tuned_rows(sensor: str, series, target: str) -> Iterable[str]:
    parts = list(series.values())
    better = tune([series["T"]], target, ours.PUBLISHED)
    told = [(part.truth, better.predict_series(part)) for part in parts]
    yield _row(sensor, "tuned, first sensor", [score.r2(*both) for both in told], None, better.parameter_count)
    likely = [score.block_interval(*both, part.time_s) for both, part in zip(told, parts, strict=True)]
    spans = "".join(f" {score.interval_text(span):>14}" for span in likely)
    yield f"  {sensor:6} {'  95 % (60 s blocks)':44}{spans}"


def _over_sensors(sensor: str, label: str, rows) -> str:
    values = np.array(rows)
    return _row(sensor, label, values.mean(axis=0), values.std(axis=0) if len(values) > 1 else None)


def _seed_row(sensor: str, label: str, rows: Sequence[np.ndarray]) -> str:
    """Mean over sensors of the mean over seeds; the spread over sensors, or over seeds where there is one sensor."""
    living = [one for one in rows if len(one)]
    if not living:
        return f"  {sensor:6} {label:44} {ALL_DEAD}"
    means = np.array([one.mean(axis=0) for one in living])
    spread = means.std(axis=0) if len(means) > 1 else living[0].std(axis=0)
    return _row(sensor, label, means.mean(axis=0), spread, 51)


def transfer(recordings: Specimens, seeds: int, engine: str = "exact") -> str:
    """Networks trained on 0-30 % used on the fast 0-50 % campaign, and both factors trained there; both scalers."""
    paper = published.TRANSFER
    lines = [
        f"Force on the fast 0-50 % campaign (test fast-A), live seeds of {seeds}: median r2 over sensors (its gain)",
        f"  {'paper':6} raw {paper.raw:.3f}; gains: trained on 0-30 % {paper.gain_trained_slow:+.0%}, "
        f"on 0-50 % {paper.gain_trained_there:+.0%}, with a = 1.75 {paper.gain_trained_there_finer:+.0%}; "
        "one recording from {:.3f} to {:.3f}".format(*paper.extreme),
    ]
    for sensor, several in recordings.items():
        series = [ours.prepared(runs, "force") for runs in several]
        raw = np.array([score.r2_before(one["fast-A"].truth, one["fast-A"].conductance_S) for one in series])
        lines.append(f"  {sensor:6} raw {np.median(raw):.3f}")
        for (scaler, per_recording), (label, training, factor) in product(SCALERS.items(), TRANSFERS):
            options = replace(ours.PUBLISHED, factor=factor, per_recording=per_recording, engine=engine)
            found = [ours.over_seeds(one[training], [one["fast-A"]], "force", seeds, options) for one in series]
            alive = np.array([len(one.live) > 0 for one in found])
            after = np.array([one.live.mean() for one in found if len(one.live)])
            told = ALL_DEAD
            if alive.any():
                told = f"{np.median(after):7.3f} ({np.median(after / raw[alive] - 1):+.0%})"
            lines.append(f"  {sensor:6} {scaler:22} {label:30} {told}")
    return "\n".join(lines) + "\n"


def others(recordings: Specimens, seeds: int) -> str:
    """Other regressors on the same features, other sampling rates, other scaling: force, mean r2 over A and B."""
    lines = [
        "Force, mean r2 over A and B: other regressors on the same features; the network at other rates (live seeds)"
    ]
    for sensor, several in recordings.items():
        runs = several[0]
        chosen = {name: runs[name] for name in TAB}
        series = ours.prepared(chosen, "force")
        for name, scores in ours.baselines(series["T"], [series["A"], series["B"]], "force").items():
            lines.append(f"  {sensor:6} {name:24} {np.mean(scores):.3f}")
        for rate_hz in (10.0, 20.0, 40.0):
            at_rate = ours.prepared(chosen, "force", rate_hz)
            options = replace(ours.PUBLISHED, rate_hz=rate_hz)
            found = ours.over_seeds(at_rate["T"], [at_rate["A"], at_rate["B"]], "force", seeds, options)
            told = f"{found.live.mean():.3f}" if len(found.live) else ALL_DEAD
            lines.append(f"  {sensor:6} {f'network at {rate_hz:g} Hz':24} {told}")
    return "\n".join(lines) + "\n"


def _row(sensor: str, label: str, means, spreads=None, parameters: int | None = None) -> str:
    shown = [f"{mean:.3f}" for mean in means]
    if spreads is not None:
        shown = [f"{text} ({spread:.3f})" for text, spread in zip(shown, spreads, strict=True)]
    criterion = score.error_of_two(means[1], means[2])
    tail = f" {parameters:6}" if parameters else ""
    return (
        f"  {sensor:6} {label:44}"
        + "".join(f" {text:>14}" for text in shown)
        + f" {np.mean(means[1:]):9.3f} {criterion:7.4f}{tail}"
    )


def _beside(values, reference) -> str:
    return " / ".join(f"{value:.3f} [{other:g}]" for value, other in zip(values, reference, strict=True))

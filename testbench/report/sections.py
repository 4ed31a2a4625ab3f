"""Sections of a report, each from plain results: words, tables and figures in the order of reading. No files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from testbench.comparing.cell import Cell
from testbench.comparing.numbers import over_noise, plain
from testbench.comparing.words import percent, spoken
from testbench.recordings.manifest import CSV
from testbench.recordings.recording import Recording
from testbench.report import words
from testbench.report.document import Facts, Item, Picture, Section, Table
from testbench.report.figures import (
    comparison_figures,
    compensator_figures,
    diagnosis_figures,
    ladder_figures,
    recording_figures,
    residual_figures,
)
from testbench.report.figures.comparison_figures import Overlay
from testbench.report.figures.ladder_figures import Step
from testbench.report.words import PANEL_UNITS

if TYPE_CHECKING:
    from testbench.comparing.compare import Comparison


def recording_section(recording: Recording, title: str, key: str, resistance: bool = False) -> Section:
    """What was recorded: the facts, every channel over time, loops, distributions; the resistance where asked for."""
    over_time = recording_figures.time_series(recording, resistance=resistance)
    items: list[Item] = [
        Facts(recording_figures.summary(recording, resistance)),
        Picture(f"{key}-time", over_time, "Every channel over time, as sampled."),
    ]
    loops = recording_figures.hysteresis_loops(recording, resistance)
    if loops:
        items.append(Picture(f"{key}-loops", loops, recording_figures.loops_caption(recording)))
    shares = recording_figures.distributions(recording, resistance)
    if shares:
        items.append(Picture(f"{key}-distributions", shares, recording_figures.distributions_caption(recording)))
    return Section(title, items)


def comparison_section(
    both: Overlay, compared: Comparison, maps: Mapping[str, Mapping[str, Sequence[Cell]]]
) -> Section:
    """Where the model fails: worst places in words, model over measurement, residual maps.

    `both` has one model, and the resistance instead of ln G where that is to be shown; `maps` are those of `maps_of`.
    """
    items: list[Item] = [errors_table(both, compared)]
    if compared.worst:
        rows = [
            (str(n), place.words, f"{100 * place.share_of_error:.0f} %") for n, place in enumerate(compared.worst, 1)
        ]
        items.append(Table(("", "Where it fails, the worst first", "Share of the squared error"), rows))
    if compared.unplaced:
        items.append(words.sentence(compared.unplaced))
    over_time = comparison_figures.overlay(both)
    items.append(Picture("comparison-time", over_time, comparison_figures.OVERLAY_CAPTION))
    loops = comparison_figures.modelled_loops_caption(both)
    items.append(Picture("comparison-loops", comparison_figures.modelled_loops(both), loops))
    items.append(Picture("comparison-map", residual_figures.heat_maps(both), residual_figures.HEAT_MAPS_CAPTION))
    for channel in both.measured:
        figure = residual_figures.profiles(maps[channel], channel)
        items.append(Picture(f"comparison-{channel}", figure, residual_figures.profiles_caption(channel)))
    return Section("Where the model fails", items)


def errors_table(both: Overlay, compared: Comparison) -> Table:
    """RMS error of each channel beside its noise floor."""
    rows = []
    for name in both.measured:
        if name == "resistance":  # ln G was compared
            rms, floor = float(np.std(both.residual(name))), both.noise_floor[name]
        else:
            rms, floor = compared.rms[name], compared.noise_floor[name]
        unit = PANEL_UNITS[name]
        times = f"{over_noise(rms, floor):.1f} times"
        rows.append((name, f"{plain(rms)} {unit}", f"{plain(floor, 2)} {unit}", times))
    return Table(("Channel", "RMS error", "Noise floor", "Error over noise"), rows)


def ladder_section(steps: Sequence[Step], zero: str = "") -> Section:
    """The errors step by step; `zero` says where the held-out recording was clamped anew."""
    channels = list(steps[0].errors)
    head = ("Step", *(f"Held-out {channel} ({PANEL_UNITS[channel]})" for channel in channels), "Fall")
    rows = [
        (step.label, *(plain(step.errors[channel]) for channel in channels), fall_in_words(steps[0], step))
        for step in steps
    ]
    floor = ", ".join(
        f"{channel} {words.with_unit(value, channel, 2)}" for channel, value in steps[-1].noise_floor.items()
    )
    return Section(
        "The error ladder",
        [
            Picture("ladder", ladder_figures.ladder(steps), ladder_figures.LADDER_CAPTION),
            *words.ladder_notes(step.label for step in steps),
            Table(head, rows, f"Noise floor: {floor}."),
            *((zero,) if zero else ()),
        ],
    )


def fall_in_words(first: Step, last: Step) -> str:
    """How far each channel's error has fallen since the first step."""
    if first is last:
        return ""
    falls = [(channel, 1 - last.errors[channel] / error) for channel, error in first.errors.items() if error > 0]
    return ", ".join(f"{channel} {-100 * fall:+z.0f} %" for channel, fall in falls)


_SCORE_HEAD = ("Recording", "", "r² raw", "best line", "r² after", "95 %", "Gain")


def compensator_section(score: Mapping[str, Any]) -> Section:
    """What the compensator makes of the sensor, from the JSON of ``compensation score``."""
    target, rows = score["compensator"]["target"], score["recordings"]
    names = [short_name(row["source"]) for row in rows]
    symbol = compensator_figures.SYMBOLS[target]
    head = (*_SCORE_HEAD, f"RMS error ({score['compensator']['unit']})")
    table = Table(head, [_score_row(name, row) for name, row in zip(names, rows, strict=True)], _score_caption(score))
    shown = next((row for row in rows if row["role"] == "held-out"), rows[0])
    items: list[Item] = [table]
    if len(rows) > 1:
        figure = compensator_figures.before_and_after(rows, names, target)
        items.append(Picture("compensator-scores", figure, compensator_figures.BEFORE_AND_AFTER_CAPTION))
    caption = (
        f"{short_name(shown['source'])} ({shown['role']}): {symbol} as measured, G rescaled to it, and p made from G "
        f"alone; below, {compensator_figures.ends_in_words(shown)}."
    )
    items.append(Picture("compensator-time", compensator_figures.over_time(shown, target), caption))
    scatter = compensator_figures.scatter(shown, target)
    items.append(Picture("compensator-scatter", scatter, compensator_figures.SCATTER_CAPTION))
    return Section("The compensator", items)


def _score_row(name: str, row: Mapping[str, Any]) -> tuple[str, ...]:
    span = row["r2_after_interval"]
    return (
        name,
        row["role"],
        f"{row['r2_before']:.3f}",
        f"{row['rho2_before']:.3f}",
        f"{row['r2_after']:.3f}",
        "too short" if span is None else "{:.3f} to {:.3f}".format(*span),
        f"{row['gain']:+.3f}",
        f"{row['rms_error']:.3g}",
    )


def _score_caption(score: Mapping[str, Any]) -> str:
    summary = score["summary"]
    criterion = f", E = {summary['E']:.4f}" if summary.get("E") is not None else ""
    return f"Mean over {summary['recordings']} {summary['over']}: r² {summary['r2_after']:.3f}{criterion}."


def short_name(source: str) -> str:
    """A campaign's folder, or a file without its suffix."""
    path = Path(source)
    return path.parent.name if path.name == CSV else path.stem


def diagnosis_section(diagnosis: Mapping[str, Any], title: str = "What is missing", tail: str = "") -> Section:
    """What is missing, and the evidence, from the JSON of ``testbench diagnose``.

    `tail` stands behind the names of its pictures, where a report has several diagnoses.
    """
    items: list[Item] = [words.verdict_in_words(diagnosis)]
    base = words.base_in_words(diagnosis)
    items += [base] if base else []
    if diagnosis["ranking"]:
        items.append(candidates_table(diagnosis))
        figure = diagnosis_figures.candidates(diagnosis)
        items.append(Picture(f"candidates{tail}", figure, diagnosis_figures.CANDIDATES_CAPTION))
    depends = diagnosis_figures.dependence(diagnosis)
    if depends:
        caption = "What the residual of the final model still depends on."
        items.append(Picture(f"dependence{tail}", depends, caption))
    return Section(title, items)


def candidates_table(diagnosis: Mapping[str, Any]) -> Table:
    """Every ranked effect with its one number: what a refit with it leaves of the held-out error."""
    rows = []
    for number, entry in enumerate(diagnosis["ranking"][: diagnosis_figures.SHOWN], 1):
        chance = percent(entry["probability"])
        left = words.error_left(entry) or words.NOT_REFITTED
        law = spoken(entry["law"]) if entry["law"] != entry["effect"] else ""
        rows.append((str(number), spoken(entry["effect"]), chance, left, words.error_left_between(entry), law))
    return Table(("", "Effect", "Probability", "Held-out error left", "95 %", "Law"), rows)

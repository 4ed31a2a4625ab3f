"""Sections of a report, each from plain results: words, tables and figures in the order of reading. No files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from testbench.recording import Recording
from testbench.report import (
    comparison_figures,
    compensator_figures,
    diagnosis_figures,
    ladder_figures,
    recording_figures,
    residual_figures,
    words,
)
from testbench.report.comparison_figures import Overlay
from testbench.report.document import Facts, Item, Picture, Section, Table
from testbench.report.ladder_figures import UNITS, Step


def recording_section(recording: Recording, title: str, key: str) -> Section:
    """What was recorded: the facts, every channel over time, loops, distributions."""
    items: list[Item] = [
        Facts(recording_figures.summary(recording)),
        Picture(f"{key}-time", recording_figures.time_series(recording), "Every channel over time, as sampled."),
    ]
    loops = recording_figures.hysteresis_loops(recording)
    if loops:
        caption = "Loops of six half minutes, the first dark, the last light: a shift along the colours is drift."
        items.append(Picture(f"{key}-loops", loops, caption))
    caption = "How often each value occurred; the speed is taken at 20 Hz."
    items.append(Picture(f"{key}-distributions", recording_figures.distributions(recording), caption))
    return Section(title, items)


def comparison_section(both: Overlay, comparison: Mapping[str, Any]) -> Section:
    """Where the model fails: worst places in words, model over measurement, residual maps.

    Parameters
    ----------
    both : Overlay
        One model in `modelled`.
    comparison : mapping
        The JSON of ``testbench compare``.
    """
    items: list[Item] = [errors_table(comparison["channels"])]
    worst = comparison["worst"]
    if worst:
        rows = [
            (str(n), place["words"], f"{100 * place['share_of_error']:.0f} %") for n, place in enumerate(worst, 1)
        ]
        items.append(Table(("", "Where it fails, the worst first", "Share of the squared error"), rows))
    else:
        items.append("No place stands out from the noise.")
    caption = "Measured and modelled, and the residual under each; the grey band is twice the noise floor."
    items.append(Picture("comparison-time", comparison_figures.overlay(both), caption))
    items.append(Picture("comparison-loops", comparison_figures.modelled_loops(both), "The same as loops."))
    caption = "Residual over strain and strain rate: orange where the model is too low, blue where it is too high."
    items.append(Picture("comparison-map", residual_figures.heat_maps(both), caption))
    for channel, entry in comparison["channels"].items():
        caption = f"Mean residual of the {channel} over each coordinate, with two standard errors."
        figure = residual_figures.profiles(entry["maps"], channel)
        items.append(Picture(f"comparison-{channel}", figure, caption))
    return Section("Where the model fails", items)


def errors_table(channels: Mapping[str, Mapping[str, Any]]) -> Table:
    """RMS error of each channel beside its noise floor."""
    rows = [
        (name, f"{entry['rms']:.4g} {entry['unit']}", f"{entry['noise_floor']:.2g} {entry['unit']}",
         f"{entry['over_noise']:.1f} x")
        for name, entry in channels.items()
    ]  # fmt: skip
    return Table(("Channel", "RMS error", "Noise floor", "Error over noise"), rows)


def ladder_section(steps: Sequence[Step]) -> Section:
    """The errors step by step."""
    channels = list(steps[0].errors)
    head = ("Step", *(f"Held-out {channel} / {UNITS[channel]}" for channel in channels), "Fall")
    rows = [
        (step.label, *(f"{step.errors[channel]:.4g}" for channel in channels), fall_in_words(steps[0], step))
        for step in steps
    ]
    floor = ", ".join(f"{channel} {value:.2g} {UNITS[channel]}" for channel, value in steps[-1].noise_floor.items())
    caption = (
        "Held-out error after each step; the dashed line is the noise floor, below which nothing is left to explain."
    )
    return Section(
        "The error ladder",
        [Picture("ladder", ladder_figures.ladder(steps), caption), Table(head, rows, f"Noise floor: {floor}.")],
    )


def fall_in_words(first: Step, last: Step) -> str:
    """How far each channel's error has fallen since the first step."""
    if first is last:
        return ""
    falls = [(channel, 1 - last.errors[channel] / error) for channel, error in first.errors.items() if error > 0]
    return ", ".join(f"{channel} {-100 * fall:+.0f} %" for channel, fall in falls)


def parameters_section(fit: Mapping[str, Any]) -> Section | None:
    """Fitted parameters with standard errors; shape weights are counted, not listed."""
    entries = fit.get("parameters", {})
    rows = [_parameter_row(address, entry, fit) for address, entry in entries.items() if "[" not in address]
    if not rows:
        return None
    weights = sum("[" in address for address in entries)
    caption = f"and {weights} shape weights" if weights else ""
    return Section(
        "The model's parameters", [Table(("Parameter", "Value", "Standard error", "Unit", ""), rows, caption)]
    )


def _parameter_row(address: str, entry: Mapping[str, Any], fit: Mapping[str, Any]) -> tuple[str, ...]:
    unit = "" if entry["unit"] == "1" else entry["unit"]
    return address, f"{entry['value']:.4g}", f"± {entry['standard_error']:.2g}", unit, _doubts(address, fit)


def _doubts(address: str, fit: Mapping[str, Any]) -> str:
    doubts = []
    if address in fit.get("at_bound", ()):
        doubts.append("at its bound")
    if address in fit.get("unidentified", ()):
        doubts.append("this recording cannot tell")
    return ", ".join(doubts)


def compensator_section(score: Mapping[str, Any]) -> Section:
    """What the compensator makes of the sensor.

    Parameters
    ----------
    score : mapping
        The JSON of ``compensation score``.
    """
    target, rows = score["compensator"]["target"], score["recordings"]
    names = [short_name(row["source"]) for row in rows]
    symbol = compensator_figures.SYMBOLS[target]
    head = (
        "Recording",
        "",
        "r² raw",
        "best line",
        "r² after",
        "95 %",
        "Gain",
        f"RMS error / {score['compensator']['unit']}",
    )
    table = Table(head, [_score_row(name, row) for name, row in zip(names, rows, strict=True)], _score_caption(score))
    shown = next((row for row in rows if row["role"] == "held-out"), rows[0])
    items: list[Item] = [table]
    if len(rows) > 1:
        caption = (
            "r² before and after, with the 95 % interval from a bootstrap over blocks of 60 s; dotted: the means "
            "that the paper reports for its two knits."
        )
        figure = compensator_figures.before_and_after(rows, names, target)
        items.append(Picture("compensator-scores", figure, caption))
    caption = (
        f"{short_name(shown['source'])} ({shown['role']}): {symbol} as measured, G rescaled to it, and p made from G "
        "alone; below, the first and the last minute."
    )
    items.append(Picture("compensator-time", compensator_figures.over_time(shown, target), caption))
    items.append(
        Picture("compensator-scatter", compensator_figures.scatter(shown, target), "The same against the truth.")
    )
    return Section("The compensator", items)


def _score_row(name: str, row: Mapping[str, Any]) -> tuple[str, ...]:
    low, high = row["r2_after_interval"]
    return (
        name,
        row["role"],
        f"{row['r2_before']:.3f}",
        f"{row['rho2_before']:.3f}",
        f"{row['r2_after']:.3f}",
        f"{low:.3f} to {high:.3f}",
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
    return path.parent.name if path.name == "recording.csv" else path.stem


def diagnosis_section(diagnosis: Mapping[str, Any]) -> Section:
    """What is missing, and the evidence.

    Parameters
    ----------
    diagnosis : mapping
        The JSON of ``testbench diagnose``.
    """
    items: list[Item] = [words.verdict_in_words(diagnosis)]
    base = words.base_in_words(diagnosis)
    items += [base] if base else []
    if diagnosis["ranking"]:
        caption = (
            "Each effect with the probability that it is what is missing most, its best law speaking for it. Bars: "
            "what it takes off the error of the calibration. Dots: what it takes off the error of held-out samples "
            "(95 % over blocks of 60 s); only the most probable effects are refitted."
        )
        items.append(Picture("candidates", diagnosis_figures.candidates(diagnosis), caption))
    depends = diagnosis_figures.dependence(diagnosis)
    if depends:
        caption = "What the residual of the final model still depends on."
        items.append(Picture("dependence", depends, caption))
    return Section("What is missing", items)

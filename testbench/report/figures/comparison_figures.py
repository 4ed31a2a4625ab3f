"""Figures of a model against a measurement: both over time, the residual under each, loops. No files, no fitting."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from gcode.support.arrays import FloatArray
from testbench.recordings.recording import gaps_in
from testbench.report import style
from testbench.report.downsample import liveliest, window
from testbench.report.figures.recording_figures import at_rows, line, stretches, stretches_in_words, unbroken
from testbench.report.words import PANEL_UNITS

if TYPE_CHECKING:
    from testbench.comparing.contribution import Contribution

LOOPS = 3
OVERLAY_CAPTION = (
    "Measured and modelled; under each the residual, measured minus modelled; grey: twice the noise floor."
)
CHANNEL_TITLES = {"force": "Force (N)", "conductance": "ln (G / S)", "resistance": "Resistance (kΩ)"}
RESIDUALS = {channel: f"{channel.capitalize()}<br>residual ({PANEL_UNITS[channel]})" for channel in CHANNEL_TITLES}
RESIDUAL_TITLES = {channel: f"Residual ({PANEL_UNITS[channel]})" for channel in CHANNEL_TITLES}


@dataclass(frozen=True, eq=False)
class Overlay:
    """Measured and modelled signals on one time grid.

    Attributes
    ----------
    time_s, strain : ndarray, shape (n,)
    measured : mapping of channel to ndarray, shape (n,)
        ``force`` in N, ``conductance`` as ln S.
    modelled : mapping of label to mapping of channel to ndarray, shape (n,)
        One entry a model, in the order of drawing ("baseline", "with stress_relaxation").
    noise_floor : mapping of channel to float
    held_out_from_s : float, optional
        Where the held-out part begins; it is shaded.
    """

    time_s: FloatArray
    strain: FloatArray
    measured: Mapping[str, FloatArray]
    modelled: Mapping[str, Mapping[str, FloatArray]]
    noise_floor: Mapping[str, float]
    held_out_from_s: float | None = None

    @property
    def gaps(self) -> tuple[tuple[float, float], ...]:
        """Where nothing was recorded, or nothing counts; see `gaps_in`."""
        return gaps_in(self.time_s)

    def residual(self, channel: str, label: str | None = None) -> FloatArray:
        """Measured minus modelled of one model (default: the last)."""
        label = label or list(self.modelled)[-1]
        return self.measured[channel] - self.modelled[label][channel]

    def within(self, rows: np.ndarray) -> Overlay:
        """The same over the rows that count, shape (n,) of bool."""
        return replace(
            self,
            time_s=self.time_s[rows],
            strain=self.strain[rows],
            measured={channel: values[rows] for channel, values in self.measured.items()},
            modelled={
                label: {channel: values[rows] for channel, values in signals.items()}
                for label, signals in self.modelled.items()
            },
        )

    def in_resistance(self) -> Overlay:
        """The same with the resistance in kΩ instead of the logarithm of the conductance."""
        if "conductance" not in self.measured:
            return self
        measured = _with_resistance(self.measured)
        floor = self.noise_floor.get("conductance", 0.0) * float(np.sqrt(np.mean(measured["resistance"] ** 2)))
        return replace(
            self,
            measured=measured,
            modelled={label: _with_resistance(signals) for label, signals in self.modelled.items()},
            noise_floor={**self.noise_floor, "resistance": floor},
        )


def resistance_kohm(log_conductance: FloatArray) -> FloatArray:
    """Resistance in kΩ, from ln (G / S)."""
    return 1e-3 * np.exp(-log_conductance)


def _with_resistance(signals: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
    return _instead_of_conductance(signals, resistance_kohm(signals["conductance"]))


def _instead_of_conductance(signals: Mapping[str, FloatArray], kohm: FloatArray) -> dict[str, FloatArray]:
    """Signals by channel with a ``resistance`` in place of the ``conductance``."""
    return {**{name: values for name, values in signals.items() if name != "conductance"}, "resistance": kohm}


def contribution_kohm(found: Contribution, measured_ln_S: FloatArray) -> Contribution:
    """What a model leaves and an effect would add, with the resistance in kΩ instead of ln G."""
    left, added = residuals_kohm(measured_ln_S, found.residual["conductance"], found.added["conductance"])
    residual = _instead_of_conductance(found.residual, left)
    return replace(found, residual=residual, added=_instead_of_conductance(found.added, added))


def residuals_kohm(
    measured_ln_S: FloatArray, left_ln_S: FloatArray, added_ln_S: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """What a model leaves, and what an effect would add to it, as resistance in kΩ, all of shape (n,).

    With R = exp(-ln G), a model that is ``left`` too low in ln G has the resistance R exp(left); what it leaves in R
    is R - R exp(left), and an effect that adds exactly what is left takes exactly that away.
    """
    measured_kohm = resistance_kohm(measured_ln_S)
    modelled_kohm = measured_kohm * np.exp(left_ln_S)
    return measured_kohm - modelled_kohm, modelled_kohm * np.expm1(-added_ln_S)


def model_colour(index: int, count: int) -> str:
    """The last model is drawn in vermilion, those before it fainter."""
    return style.VERMILION if index == count - 1 else style.ORANGE


def overlay(both: Overlay, start_s: float | None = None, end_s: float | None = None) -> style.Figure:
    """Measured and modelled over time with the residual under each, zoom linked in all rows.

    From `start_s` to `end_s` only, at full detail for it, where they are given.
    """
    rows = window(both.time_s, start_s, end_s)
    traces: list[dict[str, Any]] = []
    titles: list[str] = []
    for channel in both.measured:
        traces += signal_traces(both, channel, rows, len(titles))
        for index, label in enumerate(both.modelled):
            colour, left = model_colour(index, len(both.modelled)), both.residual(channel, label)[rows]
            name = f"{label}: residual"
            traces.append(line(both.time_s[rows], left, colour, name, len(titles) + 1, gaps=both.gaps))
        titles += [CHANNEL_TITLES[channel], RESIDUAL_TITLES[channel]]
    heights = [2.0, 1.0] * len(both.measured)  # a residual is half as tall as its signal
    axes = style.stacked_axes(titles, "Time (s)", heights, gap=0.035)
    shapes = [_floor_band(2 * row + 1, both.noise_floor.get(c, 0.0)) for row, c in enumerate(both.measured)]
    shapes += _held_out_shade(both, end_s)
    return style.figure(traces, height=150 * len(titles) + 60, shapes=shapes, **axes)


def signals(both: Overlay) -> style.Figure:
    """Measured and modelled over time, one row a channel."""
    channels = list(both.measured)
    traces = [trace for row, c in enumerate(channels) for trace in signal_traces(both, c, slice(None), row)]
    axes = style.stacked_axes([CHANNEL_TITLES[channel] for channel in channels], "Time (s)")
    return style.figure(traces, height=190 * len(channels) + 70, **axes)


def _model_line(colour: str) -> dict[str, Any]:
    """A model is dashed over the measured line: the two are told apart in greyscale, and where they agree."""
    return {"line": {"color": colour, "width": 1.4, "dash": "dash" if colour == style.VERMILION else "dot"}}


def signal_traces(both: Overlay, channel: str, rows: slice, row: int, **place: str) -> list[dict[str, Any]]:
    """A channel as measured and as each model has it."""
    look: dict[str, Any] = {"gaps": both.gaps, "showlegend": row == 0, **place}
    time_s = both.time_s[rows]
    traces = [line(time_s, both.measured[channel][rows], style.MEASURED, "measured", row, width=2.0, **look)]
    for index, (label, modelled) in enumerate(both.modelled.items()):
        colour = model_colour(index, len(both.modelled))
        traces.append(line(time_s, modelled[channel][rows], colour, label, row, **look, **_model_line(colour)))
    return traces


def _floor_band(row: int, floor: float) -> dict[str, Any]:
    """A band of plus and minus two noise floors: what no model can explain."""
    where = {"xref": "paper", "yref": style.y_ref(row), "x0": 0, "x1": 1, "y0": -2 * floor, "y1": 2 * floor}
    return _area(style.FLOOR, 0.35) | where


def _held_out_shade(both: Overlay, end_s: float | None) -> list[dict[str, Any]]:
    if both.held_out_from_s is None or (end_s is not None and end_s < both.held_out_from_s):
        return []
    across = {"xref": "x", "x0": both.held_out_from_s, "x1": float(both.time_s[-1])}
    return [_area(style.SKY, 0.12) | across | {"yref": "paper", "y0": 0, "y1": 1}]


def _area(colour: str, opacity: float) -> dict[str, Any]:
    """A rectangle below the curves."""
    return {"type": "rect", "fillcolor": colour, "opacity": opacity, "line": {"width": 0}, "layer": "below"}


def modelled_loops_caption(both: Overlay) -> str:
    """What stands under the `modelled_loops`."""
    return f"The same as hysteresis loops: {stretches_in_words(both.time_s, both.strain, LOOPS)}."


def modelled_loops(both: Overlay) -> style.Figure:
    """Hysteresis loops of a few stretches, modelled over measured: force and ln G over strain."""
    names = ["measured", *both.modelled]
    colours = [style.MEASURED, *(model_colour(i, len(both.modelled)) for i in range(len(both.modelled)))]
    whole, windows = np.arange(len(both.time_s)), stretches(both.time_s, both.strain, LOOPS)
    parts = [unbroken(whole[part], both.time_s, both.gaps) for part in windows]
    rows = np.concatenate([np.append(part, -1) for part in parts])[:-1]  # -1 lies between two of them
    strain_percent = at_rows(100 * both.strain, rows)
    traces = []
    for column, channel in enumerate(both.measured):
        signals = [both.measured[channel], *(model[channel] for model in both.modelled.values())]
        shown: dict[str, Any] = {"hovertemplate": "%{y:.4g} at %{x:.2f} %", "showlegend": column == 0}
        for name, colour, values in zip(names, colours, signals, strict=True):
            look = shown if colour == style.MEASURED else shown | _model_line(colour)
            traces.append(style.curve(strain_percent, at_rows(values, rows), colour, column, name=name, **look))
    axes = style.side_by_side_axes([("Strain (%)", CHANNEL_TITLES[channel]) for channel in both.measured])
    return style.figure(traces, height=380, **axes)


def busiest_window(both: Overlay, length_s: float = 60.0) -> tuple[float, float]:
    """The stretch of about `length_s` in which the residuals of the first model are largest: the one to look at."""
    first = next(iter(both.modelled))
    size = sum(
        (both.residual(channel, first) / (float(np.ptp(values)) or 1.0)) ** 2
        for channel, values in both.measured.items()
    )
    return liveliest(both.time_s, np.asarray(size), length_s)

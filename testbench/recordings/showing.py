"""How a recording shows itself: its signals as curves, in a notebook and on Matplotlib axes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from gcode.support.arrays import FloatArray
from gcode.support.figures import outline, panels
from gcode.support.html import card, strips
from testbench.recordings.channels import DISPLACEMENT, RESISTANCE, UNITS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

OHMS = (1e6, "MΩ"), (1e3, "kΩ"), (1.0, "Ω")
Gaps = Sequence[tuple[float, float]]  # last time before, first time after, in s


def titled(channels: Mapping[str, FloatArray], gauge_length_mm: float) -> dict[str, FloatArray]:
    """What is drawn, under the title of its axis: strain in per cent for the displacement, the rest as measured.

    A resistance is in the unit of its size.
    """
    drawn = {}
    for name, values in channels.items():
        if name == DISPLACEMENT and np.isfinite(gauge_length_mm):
            drawn["strain (%)"] = 100 * values / gauge_length_mm
        elif name == RESISTANCE:
            size, unit = next((one for one in OHMS if np.median(values) >= one[0]), OHMS[-1])
            drawn[f"resistance ({unit})"] = values / size
        else:
            unit = UNITS.get(name, "")
            drawn[f"{name.removesuffix(f'_{unit}')} ({unit})" if unit else name] = values
    return drawn


def as_html(
    heading: str, lines: Sequence[str], time_s: FloatArray, drawn: Mapping[str, FloatArray], gaps: Gaps
) -> str:
    """A card with one small curve a signal."""
    thin = {title: outline(time_s, values, 300, gaps) for title, values in drawn.items()}
    curves = "".join(strips(x, {title: y}) for title, (x, y) in thin.items())
    return card(heading, lines, curves)


def plot(time_s: FloatArray, drawn: Mapping[str, FloatArray], axes: Axes | Sequence[Axes] | None, gaps: Gaps) -> Any:
    """One panel a signal, over time, shape (signals,) of Axes."""
    on = panels(axes, len(drawn))
    for axis, (title, values) in zip(on, drawn.items(), strict=True):
        axis.plot(*outline(time_s, values, 2000, gaps), linewidth=0.8)
        axis.set_ylabel(title)
        axis.margins(x=0)
    on[-1].set_xlabel("time (s)")
    return np.array(on)

"""Matplotlib axes in, axes out: the panels that results draw themselves on."""

from __future__ import annotations

import base64
import io
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from gcode.support.errors import UserError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

WIDTH_IN, PANEL_IN, NOTEBOOK_DOTS_PER_INCH = 8.0, 2.3, 90
# Of a file for a journal: letters stay letters (TrueType, not outlines), and the same figure gives the same bytes.
PRINT: Any = {"pdf.fonttype": 42, "ps.fonttype": 42, "svg.fonttype": "none", "svg.hashsalt": "knitbench"}
POINTS = 2000  # nearly twice the pixels of a wide plot: each pixel column keeps its lowest and highest sample


def panels(axes: Axes | Sequence[Axes] | None, count: int) -> list[Axes]:
    """`count` axes to draw on: those given, or those of a new figure, one above the other.

    Raises
    ------
    UserError
        If another number of axes was given.
    """
    if axes is None:
        from matplotlib import pyplot

        size = (WIDTH_IN, PANEL_IN * max(count, 1.4))
        figure, grid = pyplot.subplots(count, 1, squeeze=False, figsize=size, layout="constrained")
        figure.align_ylabels()
        return list(grid[:, 0])
    from matplotlib.axes import Axes

    given = list(np.ravel(np.asarray(axes, dtype=object)))
    if others := [type(one).__name__ for one in given if not isinstance(one, Axes)]:
        raise UserError(f"plot: axes must be Axes of Matplotlib, got {others[0]}")
    if len(given) != count:
        raise UserError(f"plot: needs {count} axes, one a panel, got {len(given)}")
    return given


def picture(draw: Callable[[Any], Any], count: int) -> str:
    """An ``<img>`` of what `draw` makes of `count` axes; no window, no pyplot."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(WIDTH_IN, PANEL_IN * max(count, 1.4)), layout="constrained")
    draw(list(figure.subplots(count, 1, squeeze=False)[:, 0]))
    data = io.BytesIO()
    figure.savefig(data, format="png", dpi=NOTEBOOK_DOTS_PER_INCH, metadata={"Software": None})
    return f'<img alt="" src="data:image/png;base64,{base64.b64encode(data.getvalue()).decode("ascii")}">'


def outline(
    x: np.ndarray, y: np.ndarray, stretches: int = 400, gaps: Sequence[tuple[float, float]] = ()
) -> tuple[np.ndarray, np.ndarray]:
    """Fewer points, the same picture: the lowest and the highest of each stretch, in order of time.

    Parameters
    ----------
    x, y : ndarray, each shape (n,)
        `x` increases.
    stretches : int
    gaps : sequence of (start, end)
        Where nothing was recorded: a NaN stands there, so that no line is drawn over what nobody has seen.
    """
    rows = rows_to_draw(y, 2 * stretches)
    return broken(x[rows], y[rows], gaps)


def rows_to_draw(values: np.ndarray, points: int = POINTS) -> np.ndarray:
    """Rows of the samples that keep the outline of `values`, shape (m,) with m <= about `points`.

    The recording is cut into equal stretches and the lowest and highest sample of each is kept (min-max),
    so no peak is lost however far one is zoomed out.
    """
    from tsdownsample import MinMaxDownsampler

    points = max(4, points - points % 2)
    if len(values) <= points:
        return np.arange(len(values), dtype=np.intp)
    rows = MinMaxDownsampler().downsample(np.ascontiguousarray(values), n_out=points)
    return np.union1d(rows.astype(np.intp), [0, len(values) - 1])


def broken(x: np.ndarray, y: np.ndarray, gaps: Sequence[tuple[float, float]]) -> tuple[np.ndarray, np.ndarray]:
    """A curve with a NaN in the middle of each gap (start, end) that lies within it; see `outline`."""
    middles = [(start + end) / 2 for start, end in gaps if x[0] <= start and end <= x[-1]]
    rows = np.searchsorted(x, middles)
    return np.insert(x, rows, middles), np.insert(y, rows, np.nan)


def histogram_range(values: np.ndarray) -> tuple[float, float]:
    """From where to where the bins of a histogram go; wide enough where all values are alike but for rounding."""
    low, high = (float(np.min(values)), float(np.max(values))) if len(values) else (0.0, 0.0)
    size = max(abs(low), abs(high))
    alike = high - low <= 1e-9 * size
    half = 0.5 * max(size, 1.0) if alike else 0.0
    return low - half, high + half

"""How a result shows itself in a notebook: a title, sentences, a table, a picture; everything quoted is escaped."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from html import escape
from itertools import groupby
from typing import TYPE_CHECKING

import numpy as np

from gcode.support.colours import BLUE

if TYPE_CHECKING:
    import pandas as pd

WIDTH, HEIGHT = 640, 64


def card(title: str, lines: Iterable[str] = (), *parts: str) -> str:
    """A heading, sentences below it, then `parts`, which are HTML already."""
    told = "".join(f"<div>{escape(line)}</div>" for line in lines)
    return f"<div><strong>{escape(title)}</strong>{told}{''.join(parts)}</div>"


def table(headings: Sequence[str], rows: Iterable[Iterable[object]], caption: str = "") -> str:
    """A table of text, with its caption where it has one."""
    head = "".join(f'<th scope="col">{escape(word)}</th>' for word in headings)
    body = "".join(f"<tr>{''.join(f'<td>{escape(str(cell))}</td>' for cell in row)}</tr>" for row in rows)
    above = f"<caption>{escape(caption)}</caption>" if caption else ""
    return f"<table>{above}<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def frame_table(frame: pd.DataFrame) -> str:
    """A data frame as a table, its numbers with four digits; an index that has a name is the first column."""
    whole = frame.reset_index() if frame.index.name else frame
    return table([str(name) for name in whole.columns], (map(_told, row) for row in whole.itertuples(index=False)))


def _told(cell: object) -> str:
    return f"{cell:.4g}" if isinstance(cell, float) else str(cell)


def strips(x: np.ndarray, signals: Mapping[str, np.ndarray]) -> str:
    """Small curves one above the other as SVG, each with its name and range; a NaN interrupts a curve."""
    rows = []
    for title, y in signals.items():
        low, high = float(np.nanmin(y)), float(np.nanmax(y))
        across = WIDTH * (x - x[0]) / max(float(x[-1] - x[0]), 1e-300)
        down = HEIGHT - 4 - (HEIGHT - 8) * (y - low) / max(high - low, 1e-300)
        places = ["" if np.isnan(b) else f"{a:.1f},{b:.1f}" for a, b in zip(across, down, strict=True)]
        lines = (" ".join(part) for seen, part in groupby(places, key=bool) if seen)
        curve = "".join(f'<polyline points="{line}" fill="none" stroke="{BLUE}" stroke-width="1"/>' for line in lines)
        drawn = f'<svg width="{WIDTH}" height="{HEIGHT}" viewBox="0 0 {WIDTH} {HEIGHT}">{curve}</svg>'
        rows.append(f"<div>{escape(title)}: {low:.4g} to {high:.4g}</div>{drawn}")
    return "".join(rows)

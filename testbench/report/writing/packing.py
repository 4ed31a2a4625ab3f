"""Figures on their way to the browser: plotly.js itself, and number arrays in the form that it reads fastest."""

from __future__ import annotations

import base64
import json
from importlib.resources import as_file, files
from pathlib import Path
from typing import Any

import numpy as np

PLOTLY = "plotly/plotly-cartesian.min.js"  # lines, bars, boxes, heat maps: a third of the whole (docs/decisions/0014)
PLOTLY_VERSION = "3.7.0"


def plotly_path() -> Path:
    """plotly.js on disk."""
    with as_file(files("testbench.report").joinpath(PLOTLY)) as path:
        return path


def to_json(figures: Any) -> str:
    """Figures as JSON, their arrays packed."""
    return json.dumps(figures, default=_packed, allow_nan=False, separators=(",", ":"))


def _packed(values: np.ndarray | np.generic) -> Any:
    """Arrays of numbers as base64 float32 (a third of the size), other ones as they are."""
    if isinstance(values, np.generic) or values.dtype.kind not in "fiu":
        return values.tolist()
    if values.ndim > 1:  # heat maps are small; nested lists keep their holes as null
        return [[None if not np.isfinite(entry) else float(f"{entry:.5g}") for entry in row] for row in values]
    return {"dtype": "f4", "bdata": base64.b64encode(values.astype("<f4").tobytes()).decode("ascii")}

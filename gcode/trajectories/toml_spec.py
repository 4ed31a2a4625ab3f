"""TrajectorySpec to TOML and back, so that a spec can be kept, edited and shared."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from gcode.support.strict import read_toml, validated
from gcode.trajectories.trajectory import TrajectorySpec


def read_spec(path: str | Path) -> TrajectorySpec:
    """Read a spec; every fault names the file and the field."""
    return validated(read_toml(path), TrajectorySpec, path, "spec")


def spec_to_toml(spec: TrajectorySpec) -> str:
    """The spec as TOML text; `read_spec` gives an equal spec."""
    data = spec.model_dump(mode="json", exclude_none=True)
    pieces = data.pop("pieces")
    lines = _table(data, "")
    for piece in pieces:
        lines += ["", "[[pieces]]", *_table(piece, "pieces.")]
    return "\n".join(lines) + "\n"


def _table(data: dict[str, Any], prefix: str) -> list[str]:
    plain = {key: value for key, value in data.items() if not isinstance(value, dict)}
    # JSON's numbers, strings and lists of numbers are TOML too.
    lines = [f"{key} = {json.dumps(value)}" for key, value in plain.items()]
    for key, value in data.items():
        if isinstance(value, dict):
            lines += ["", f"[{prefix}{key}]", *_table(value, f"{prefix}{key}.")]
    return lines

"""What a compensator needs on a chip: bytes, and operations a sample."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

from compensation.export.export_c_history import constants_bytes, multiplies, state_bytes
from compensation.model.compensator import TrainedCompensator


@dataclass(frozen=True)
class Cost:
    """What a compensator needs on a chip.

    Attributes
    ----------
    constants_bytes : int
        Weights, biases and filter constants, in flash.
    state_bytes : int
        RAM kept between samples.
    scratch_bytes : int
        Stack used while a sample is worked on (layer values).
    multiplies : int
        Multiplications a sample at the nominal rate.
    """

    constants_bytes: int
    state_bytes: int
    scratch_bytes: int
    multiplies: int


def cost(compensator: TrainedCompensator) -> Cost:
    """Count bytes and multiplications."""
    filters = len(compensator.alphas)
    weights = sum(matrix.size for network in compensator.networks for matrix in network.weights)
    widest = max(max(network.sizes, default=1) for network in compensator.networks)
    return Cost(
        constants_bytes=4 * (compensator.parameter_count + 5 * filters + 2 * compensator.input_count + 4)
        + constants_bytes(compensator.history),
        state_bytes=4 * (4 * filters + 4) + state_bytes(compensator.history),
        scratch_bytes=4 * (compensator.input_count + 2 * widest),
        multiplies=weights + 4 * filters + 1 + multiplies(compensator.history),
    )


def code_bytes(header: str, name: str) -> int | None:
    """Machine code of ``update`` and ``reset`` as this machine's gcc makes it (-Os); None without a compiler."""
    if shutil.which("gcc") is None or shutil.which("size") is None:
        return None
    caller = (
        f'#include "h.h"\nfloat u({name}_state *s, float g, float t) {{ return {name}_update(s, g, t); }}\n'
        f"void r({name}_state *s) {{ {name}_reset(s); }}\n"
    )
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "h.h").write_text(header)
        Path(folder, "u.c").write_text(caller)
        subprocess.run(["gcc", "-Os", "-c", "u.c", "-o", "u.o"], cwd=folder, check=True)
        listing = subprocess.run(["size", "-A", "u.o"], cwd=folder, check=True, capture_output=True, text=True).stdout
    rows = (line.split() for line in listing.splitlines())
    return sum(int(row[1]) for row in rows if row and row[0].startswith(".text"))

"""What a compensator needs on a chip: bytes, and operations a sample."""

from __future__ import annotations

import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from compensation.memories.ema import log_retention
from compensation.model.compensator import TrainedCompensator

# Of the header's exponential: terms of the series, and up to which exponent it is taken.
SERIES, LARGEST_EXPONENT = 6, 0.5


@dataclass(frozen=True)
class Cost:
    """What a compensator needs on a chip."""

    constants_bytes: int  # flash: weights, biases and filter constants
    state_bytes: int  # RAM kept between samples
    scratch_bytes: int  # stack used while a sample is worked on (layer values)
    multiplies: int  # a sample at the nominal step
    # The same at a step that is not nominal to a millionth, as a clock gives: every filter's gain is made anew.
    multiplies_any_step: int


def cost(compensator: TrainedCompensator) -> Cost:
    """Count bytes and multiplications."""
    filters, history = len(compensator.alphas), compensator.history
    motions, plays, remembers = len(history.motion_taus_s), len(history.play_radii), int(history.count > 0)
    weights = sum(matrix.size for network in compensator.networks for matrix in network.weights)
    widest = max(max(network.sizes, default=1) for network in compensator.networks)
    constants = compensator.parameter_count + 5 * filters + 2 * compensator.input_count + 4
    nominal = weights + 4 * filters + 1 + 2 * motions + plays + 2 * remembers
    return Cost(
        constants_bytes=4 * (constants + 4 * motions + 3 * plays + remembers),
        state_bytes=4 * (4 * filters + 4 + history.count + 2 * remembers),
        scratch_bytes=4 * (compensator.input_count + 2 * widest),
        multiplies=nominal,
        multiplies_any_step=nominal + _gains(compensator),
    )


def _gains(compensator: TrainedCompensator) -> int:
    """Multiplications of `NAME_gain` for all filters, 1 % late: the exponent, the series, two for each halving."""
    late, history = 1.01, compensator.history
    taus_s = np.array([history.settle_s, *history.motion_taus_s] if history.count else [])
    exponents = late * np.concatenate([-log_retention(compensator.alphas), 1.0 / (compensator.rate_hz * taus_s)])
    halvings = np.ceil(np.log2(np.maximum(exponents / LARGEST_EXPONENT, 1.0)))
    return int(np.sum(1 + SERIES + 2 * halvings))


def code_bytes(header: str, name: str) -> int | None:
    """Machine code of ``update`` and ``reset`` as this machine's gcc makes it (-Os); None without such a compiler."""
    caller = (
        f'#include "h.h"\nfloat u({name}_state *s, float g, float t) {{ return {name}_update(s, g, t); }}\n'
        f"void r({name}_state *s) {{ {name}_reset(s); }}\n"
    )
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "h.h").write_text(header)
        Path(folder, "u.c").write_text(caller)
        try:
            subprocess.run(["gcc", "-Os", "-c", "u.c", "-o", "u.o"], cwd=folder, check=True, capture_output=True)
            sized = subprocess.run(["size", "-A", "u.o"], cwd=folder, check=True, capture_output=True, text=True)
        except (OSError, subprocess.CalledProcessError):  # no such tools, or others of these names
            return None
    rows = (line.split() for line in sized.stdout.splitlines())
    return sum(int(row[1]) for row in rows if row and row[0].startswith(".text"))

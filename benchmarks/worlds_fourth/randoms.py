"""Random numbers by name: a stream of its own for every part of a case."""

from __future__ import annotations

import zlib

import numpy as np

Rng = np.random.Generator


def stream(*name: object) -> Rng:
    """The stream of this name: drawing more from one never shifts another."""
    return np.random.default_rng([zlib.crc32(str(part).encode()) for part in name])

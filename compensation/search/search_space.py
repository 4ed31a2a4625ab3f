"""The pipelines of the paper's search: 8 sets of smoothing factors x 114 networks = 912 candidates.

The paper (arXiv:2306.12129, its tables of smoothing factors and of hidden layers) multiplies each *base size* with
each *topology*, rounds down, and leaves out repetitions and networks with a layer below 2 neurons: 114 of 8 x 21.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from compensation.memories.ema import smoothing_factors

SMALLEST_LAYER = 2
BASES = (2, 3, 4, 6, 8, 12, 16, 32)
# As printed; the last repeats an earlier one.
TOPOLOGIES: tuple[tuple[float, ...], ...] = (
    (1, 1),
    (1, 0.5),
    (1, 0.25),
    (1, 1, 1),
    (1, 1, 0.5),
    (1, 0.5, 0.5),
    (1, 0.5, 0.25),
    (0.5, 1, 1),
    (0.5, 1, 0.5),
    (0.5, 1, 0.25),
    (1, 1, 1, 1),
    (1, 1, 1, 0.5),
    (1, 1, 0.5, 0.5),
    (1, 0.5, 0.5, 0.5),
    (1, 0.5, 0.5, 0.25),
    (1, 0.5, 0.25, 0.25),
    (1, 0.25, 0.25, 0.25),
    (0.5, 1, 1, 1),
    (0.5, 1, 1, 0.5),
    (0.5, 1, 0.5, 0.5),
    (1, 0.5, 0.5, 0.5),
)
# Set by hand, before any were calculated.
BASELINE = (0.5, 0.1, 0.025, 0.0025)


def calculated(*banks: tuple[float, int]) -> dict[str, tuple[float, ...]]:
    """Smoothing factors ``a^-i``, i = 1..N, of each a and N, by the name of the bank."""
    return {f"{a:g}^{count}": tuple(smoothing_factors(a, count).tolist()) for a, count in banks}


PRESETS = {
    "paper": {"baseline": BASELINE}
    | calculated((2.5, 4), (2.5, 7), (2.5, 10), (5.0, 4), (5.0, 7), (10.0, 3), (10.0, 4)),
    # Finer steps between the factors than the paper tried.
    "fine": calculated((1.5, 7), (1.5, 14), (1.75, 7), (1.75, 10), (2.0, 7), (2.0, 9), (2.5, 5), (2.5, 7)),
}


@dataclass(frozen=True)
class Candidate:
    """A network to try: one smoothing bank, and hidden layers behind it."""

    bank: str  # its name
    alphas: tuple[float, ...]
    sizes: tuple[int, ...]

    @property
    def key(self) -> str:
        """Short name, unique among candidates."""
        return f"{self.bank} {'-'.join(map(str, self.sizes))}"

    def __str__(self) -> str:
        """Smoothing factors, then layers: ``0.1,0.01,0.001;4,2,2``."""
        return ",".join(f"{alpha:.10g}" for alpha in self.alphas) + ";" + ",".join(map(str, self.sizes))


def hidden_layers(bases: Sequence[int] = BASES) -> list[tuple[int, ...]]:
    """Every distinct tuple of layer sizes: 114 with the paper's bases."""
    found = (tuple(math.floor(base * share) for share in shares) for base in bases for shares in TOPOLOGIES)
    return list(dict.fromkeys(sizes for sizes in found if min(sizes) >= SMALLEST_LAYER))


def candidates(preset: str = "paper", bases: Sequence[int] = BASES) -> list[Candidate]:
    """Every network, of these base sizes, behind every bank of a preset: 912 with the paper's."""
    return [Candidate(*bank, sizes) for bank in PRESETS[preset].items() for sizes in hidden_layers(bases)]


def spread(everything: Sequence[Candidate], count: int) -> list[Candidate]:
    """So many of them, spread over banks and networks; a larger count keeps those of a smaller one."""
    size = len(everything)
    # Steps of the golden section, and without a common divisor: no bank and no network is met more often than others.
    stride = next(step for step in range(max(int(size * (5**0.5 - 1) / 2), 1), 0, -1) if math.gcd(step, size) == 1)
    return [everything[index * stride % size] for index in range(min(count, size))]

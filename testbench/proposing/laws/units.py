"""Physical dimensions of what a law is made of: powers of newton, second and kelvin."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Unit:
    """Powers of N, s and K; all zero for a plain number (a strain, ln G)."""

    N: int = 0
    s: int = 0
    K: int = 0

    def __mul__(self, other: Unit) -> Unit:
        return Unit(self.N + other.N, self.s + other.s, self.K + other.K)

    def __truediv__(self, other: Unit) -> Unit:
        return Unit(self.N - other.N, self.s - other.s, self.K - other.K)

    def __str__(self) -> str:
        powers = {"N": self.N, "s": self.s, "K": self.K}
        above = [_raised(name, power) for name, power in powers.items() if power > 0]
        below = [_raised(name, -power) for name, power in powers.items() if power < 0]
        top = " ".join(above) or "1"
        return top if not below else f"{top}/{below[0]}" if len(below) == 1 else f"{top}/({' '.join(below)})"


def _raised(name: str, power: int) -> str:
    return name if power == 1 else f"{name}^{power}"


ONE, NEWTON, SECOND, KELVIN = Unit(), Unit(N=1), Unit(s=1), Unit(K=1)
PER_SECOND = ONE / SECOND

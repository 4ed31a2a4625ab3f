"""Ranking candidates over several seeds, and how sure the ranking is."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

DRAWS = 1000


@dataclass(frozen=True)
class Ranked:
    """One candidate's place, with its 95 % interval and the chance to be first over resampled seeds."""

    key: str
    parameters: int
    seeds: int
    dead: int
    E: float  # mean of the paper's criterion over live seeds
    spread: float  # its standard deviation
    r2_A: float
    r2_B: float
    rank_low: int
    rank_high: int
    chance_first: float


def rank(rows: Sequence[dict[str, Any]]) -> list[Ranked]:
    """Candidates by mean E over live seeds, best first; those with no live seed last.

    The intervals come from a bootstrap over all seeds: what the ranking would be, had other seeds been drawn, dead
    ones among them; a candidate of which every drawn seed is dead is last in that draw.
    """
    groups: dict[str, list[dict[str, Any]]] = defaultdict(list)
    # In the order in which the workers were done, a ranking would depend on how many they were.
    for row in sorted(rows, key=lambda row: (row["key"], row["seed"])):
        groups[row["key"]].append(row)
    rng = np.random.default_rng(0)
    live = {key: [row for row in group if not row["dead"]] or group for key, group in groups.items()}
    draws = np.array([_resampled(group, rng) for group in groups.values()])
    places = draws.argsort(axis=0, kind="stable").argsort(axis=0) + 1
    low, high = np.quantile(places, [0.025, 0.975], axis=1, method="nearest")
    first = (places == 1).mean(axis=1)
    found = [
        Ranked(
            key=key,
            parameters=group[0]["parameters"],
            seeds=len(groups[key]),
            dead=sum(row["dead"] for row in groups[key]),
            **{name: float(np.mean([row[name] for row in group])) for name in ("E", "r2_A", "r2_B")},
            spread=float(np.std([row["E"] for row in group])),
            rank_low=int(low[index]),
            rank_high=int(high[index]),
            chance_first=float(first[index]),
        )
        for index, (key, group) in enumerate(live.items())
    ]
    return sorted(found, key=lambda ranked: (ranked.dead == ranked.seeds, ranked.E))


def split_half_agreement(rows: Sequence[dict[str, Any]]) -> float | None:
    """Rank correlation (Spearman) between the rankings from the even and from the odd seeds; None with one seed."""
    from scipy.stats import spearmanr

    halves: list[dict[str, list[float]]] = [defaultdict(list), defaultdict(list)]
    for row in rows:
        halves[row["seed"] % 2][row["key"]].append(row["E"])
    shared = sorted(halves[0].keys() & halves[1].keys())
    if len(shared) < 3:
        return None
    even, odd = ([np.median(half[key]) for key in shared] for half in halves)
    return float(spearmanr(even, odd).statistic)


def _resampled(group: Sequence[dict[str, Any]], rng: np.random.Generator) -> np.ndarray:
    """Mean E over the live ones of as many seeds, drawn again; infinite where none of them lives."""
    errors, alive = np.array([row["E"] for row in group]), np.array([not row["dead"] for row in group])
    picks = rng.integers(len(group), size=(DRAWS, len(group)))
    count = alive[picks].sum(axis=1)
    mean = np.sum(errors[picks] * alive[picks], axis=1) / np.maximum(count, 1)
    return np.where(count > 0, mean, np.inf)

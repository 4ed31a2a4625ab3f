"""The search for a law: from coordinates with a memory on, the best are given a bend, a factor or another memory."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import minimize

from testbench.diagnosis.searching.side_by_side import SideBySide
from testbench.knit.effect import FloatArray
from testbench.proposing.grids import LATE_S, Grid, rounded, usual_size
from testbench.proposing.laws.grammar import SIGNALS, coordinates_at, fits, price_of
from testbench.proposing.laws.law import Law, Term, namespace
from testbench.proposing.laws.law_coordinates import KINETICS
from testbench.proposing.laws.law_parts import Operator, Slot
from testbench.proposing.laws.operators import OPERATORS
from testbench.proposing.laws.places import Place
from testbench.proposing.screening import Projector

WIDTH, PER_FAMILY = 14, 2  # laws that grow on; of them, with the same place, coordinate and memory
LEVELS, POLISHED = 2, 10  # times that they grow; how many have their numbers optimised each time
EVALUATIONS = 60
CLOUDS, IN_CLOUD, CLOSER = 6, 30, 0.5  # clouds of points around the best, how many in each, and each over the last
TOGETHER = 64  # laws that are weighed at once
Point = tuple[Place, Term, dict[str, float]]  # a law without its strength
STEPS = {"period": 0.02, "share": 0.05}  # e-folds; of all others that have a logarithmic scale, more


@dataclass(frozen=True)
class Found:
    """A law with its best parameters, and its gain in ln Z to first order, less the price of its pieces."""

    law: Law
    gain: float


class Beam:
    """One beam search for a law beside one fitted model.

    Parameters
    ----------
    known : sequence of Law
        What was found before: what one channel follows another may follow as well.
    """

    def __init__(
        self,
        projector: Projector,
        grid: Grid,
        tell: Callable[[str], None],
        pool: SideBySide,
        known: Sequence[Law] = (),
    ) -> None:
        self.projector, self.grid, self.tell, self.pool, self.known = projector, grid, tell, pool, known
        self.chain = projector.chain
        signals = {p.name: self.chain.readable(p) for p in self.chain.places}
        self.readable = {name: set(own) for name, own in signals.items()}
        self.names = {name: namespace(own, grid.dt_s) for name, own in signals.items()}
        self.done: set[tuple[object, ...]] = set()  # laws whose numbers are at their best

    def run(self) -> list[Found]:
        """Search; the best laws, the best first, no two of one structure."""
        self.tell("seeds: every coordinate with every memory")
        found = self.best_of_each(self.scored(self.seeds()))
        for level in range(LEVELS):
            chosen = self.polished(diverse(found, WIDTH, PER_FAMILY))
            self.tell(f"growing the best laws, round {level + 1} of {LEVELS}")
            grown = self.scored([one for parent in chosen for one in self.children(parent.law)])
            found = self.best_of_each([*chosen, *found, *grown])
        return self.polished(diverse(found, WIDTH, PER_FAMILY))

    # --- seeds ---

    def seeds(self) -> Iterator[Point]:
        for place in self.chain.places:
            if place.name == "conductance reading" or place.way != "amount":
                continue  # nearly the trace of another place; which it is, is decided in the end
            coordinates = coordinates_at(place, self.readable[place.name])
            for law in self.known:
                if law.term.coordinate in coordinates and set(law.term.reads) <= self.readable[place.name]:
                    yield place, law.term, dict(law.values)
            for coordinate in coordinates:
                plain = Term(coordinate, (), self.grid.span)
                for values in self.grid.points(coordinate.slots, None):
                    yield from self.from_one(place, plain, values)

    def from_one(self, place: Place, plain: Term, values: dict[str, float]) -> Iterator[Point]:
        """A coordinate alone, and with what leaves no trace in its straight line."""
        name = plain.coordinate.name
        yield place, plain, values
        if name in KINETICS:
            yield from self.grown(place, plain, values, ("factor",))
            return
        yield place, changing(plain), values
        for _, term, more in self.grown(place, plain, values, ("bend",)):
            yield place, term, more
            if name == "time":
                # What ages changes by a share, too: alone it leaves no trace to grow from.
                yield from self.grown(place, term, more, ("factor",))
            if name in SIGNALS and term.operators[0].name == "threshold":
                # What yields flows beyond its threshold alone, of which the memory of the whole is no parent.
                yield from self.grown(place, term, more, ("memory",))
        for _, term, more in self.grown(place, plain, values, ("memory",)):
            yield place, term, more
            yield from self.sized(place, term, more)
            if term.memory == "lag":
                # What is remembered often changes a force by a share, not by an amount.
                yield from self.grown(place, term, more, ("factor",))
            else:
                yield place, changing(term), more

    def sized(self, place: Place, term: Term, values: dict[str, float]) -> Iterator[Point]:
        """The term without its sign (its size, its square), where it has one."""
        if term.coordinate.signed and term.memory != "dead band":
            yield place, with_operator(term, OPERATORS["size"]), values
            yield place, with_operator(term, OPERATORS["square"]), values

    # --- growth ---

    def children(self, law: Law) -> Iterator[Point]:
        """The law with one piece more, or one in the place of another, wherever that makes sense."""
        term = law.term
        for at in range(len(term.operators) + 1):
            yield from self.grown(law.place, term, law.values, at=at)
        for at, one in enumerate(term.operators):
            yield from self.grown(law.place, term.without(at), law.values, at=at, other_than=one.name)

    def grown(
        self,
        place: Place,
        term: Term,
        values: Mapping[str, float],
        kinds: Sequence[str] = ("memory", "bend", "factor"),
        at: int | None = None,
        other_than: str = "",
    ) -> Iterator[Point]:
        """The term with one operator of these kinds put in, at its end or before operator number `at`."""
        at = len(term.operators) if at is None else at
        values = {slot.key: values[slot.key] for slot in term.slots}
        # A factor may come twice: as its square.
        has = {one.name for one in term.operators if one.kind != "factor"} | {other_than}
        x = Term(term.coordinate, term.operators[:at], term.span, term.sizes[:at]).within(
            self.names[place.name], values
        )
        for one in OPERATORS.values():
            makes_sense = one.kind in kinds and one.name not in has and set(one.reads) <= self.readable[place.name]
            if makes_sense and fits(term, one, at, x):
                for more in self.grid.points(one.slots, x, one.name):
                    yield place, with_operator(term, one, x, at), values | more

    # --- scores ---

    def scored(self, points: Iterable[Point]) -> list[Found]:
        """First-order evidence of every point."""
        by_place: dict[str, list[Point]] = {}
        for point in points:
            by_place.setdefault(point[0].name, []).append(point)
        parts = [own[k : k + TOGETHER] for own in by_place.values() for k in range(0, len(own), TOGETHER)]
        # In the order of the parts: which of two equal laws comes first must not depend on the number of cores.
        return [one for scored in self.pool.map(self.of_one_place, parts) for one in scored]

    def of_one_place(self, points: Sequence[Point]) -> list[Found]:
        """Score laws of one place with their parameters, all at once."""
        place = points[0][0]
        z = np.array([term.within(self.names[place.name], values) for _, term, values in points])
        gains, strengths = self.projector.scores(place, z)
        return [
            Found(Law(place, term, values, float(strength)), float(gain) - price_of(term))
            for (_, term, values), gain, strength in zip(points, gains, strengths, strict=True)
        ]

    def at(self, place: Place, term: Term, values: Mapping[str, float]) -> Found:
        """Score one law with these parameters."""
        return self.of_one_place([(place, term, dict(values))])[0]

    @staticmethod
    def best_of_each(found: Sequence[Found]) -> list[Found]:
        """The best point of each structure, the best first."""
        best: dict[str, Found] = {}
        for one in found:
            key = one.law.key
            if np.isfinite(one.gain) and (key not in best or one.gain > best[key].gain):
                best[key] = one
        kept: dict[tuple[str, float], Found] = {}  # two spellings of one z have one gain before their price
        for one in sorted(best.values(), key=lambda one: -one.gain):
            kept.setdefault((one.law.place.name, round(one.gain + price_of(one.law.term), 4)), one)
        return list(kept.values())

    def polished(self, found: Sequence[Found]) -> list[Found]:
        """The same laws, with the parameters of the first `POLISHED` optimised."""
        better = self.pool.map(self.polish, found[:POLISHED])
        self.done |= {_numbers(one.law) for one in better}
        return sorted([*better, *found[POLISHED:]], key=lambda one: -one.gain)

    def polish(self, found: Found) -> Found:
        law = found.law
        slots = law.term.slots
        if not slots or _numbers(law) in self.done:
            return found
        start = np.array([_inward(slot, law.values[slot.key], self.grid) for slot in slots])

        def costs(points: FloatArray) -> FloatArray:
            values = [_outward(slots, point, law.values, self.grid) for point in points]
            return np.array([-one.gain for one in self.of_one_place([(law.place, law.term, v) for v in values])])

        steps = np.array([_step(slot, law.values[slot.key], self.grid) for slot in slots])
        start = _condensed(costs, start, steps)  # the gain of what jumps is a needle: a simplex does not feel it
        simplex = np.vstack([start, start + np.diag(steps)])
        options = {"initial_simplex": simplex, "maxfev": EVALUATIONS * len(slots), "xatol": 1e-3, "fatol": 0.1}
        best = minimize(lambda point: costs(point[None])[0], start, method="Nelder-Mead", options=options)
        then = self.at(law.place, law.term, _outward(slots, best.x, law.values, self.grid))
        return max(found, then, key=lambda one: one.gain)


def diverse(found: Sequence[Found], most: int, of_one_family: int, of_one_place: int = WIDTH) -> list[Found]:
    """The first of these laws, few of one family and place: some are artefacts of the first order.

    A law that is a better one with one more piece, and no more numbers, is left out: the piece does harm.
    """
    kept: list[Found] = []
    for one in found:
        same = [k.law for k in kept if k.law.place == one.law.place]
        alike = [law.term for law in same if law.family == one.law.family]
        idle = any(one.law.term.extends(term) and one.law.term.slots == term.slots for term in alike)
        if len(same) < of_one_place and len(alike) < of_one_family and not idle:
            kept.append(one)
    return kept[:most]


def with_operator(term: Term, one: Operator, x: FloatArray | None = None, at: int | None = None) -> Term:
    """The term with an operator that acts on `x` put in, at the end or before operator number `at`."""
    at = len(term.operators) if at is None else at
    size = rounded(usual_size(x)) if x is not None and "{size}" in one.code else 1.0
    operators = (*term.operators[:at], one, *term.operators[at:])
    return replace(term, operators=operators, sizes=(*term.sizes[:at], size, *term.sizes[at:]))


def changing(term: Term) -> Term:
    """The term times the time: the base has curves and loops of any shape, so that only their growth shows."""
    return with_operator(term, OPERATORS["growing"])


def _numbers(law: Law) -> tuple[object, ...]:
    return law.key, *sorted(law.values.items())


def _condensed(costs: Callable[[FloatArray], FloatArray], start: FloatArray, spread: FloatArray) -> FloatArray:
    """Random search: the best of several clouds of points, each around the best so far and narrower than the last."""
    rng = np.random.default_rng(0)
    best, least = start, costs(start[None])[0]
    for cloud in range(CLOUDS):
        points = best + CLOSER**cloud * spread * rng.standard_normal((IN_CLOUD, len(start)))
        there = costs(points)
        if np.min(there) < least:
            best, least = points[np.argmin(there)], np.min(there)
    return best


def _inward(slot: Slot, value: float, grid: Grid) -> float:
    low, _, log = grid.bounds(slot, value)
    return float(np.log(max(value, low, 1e-12))) if log else value


def _step(slot: Slot, value: float, grid: Grid) -> float:
    if grid.bounds(slot, value)[2]:
        return STEPS.get(slot.key, 0.35)
    if slot.kind == "angle":
        return 0.5
    if slot.kind == "delay":
        return 0.1
    if slot.kind == "skew":
        return LATE_S / grid.duration_s
    return 0.15 * abs(value) + 0.01 * grid.span


def _outward(slots: Sequence[Slot], point: FloatArray, around: Mapping[str, float], grid: Grid) -> dict[str, float]:
    values = {}
    for slot, x in zip(slots, point, strict=True):
        low, high, log = grid.bounds(slot, around[slot.key])
        values[slot.key] = float(np.clip(np.exp(min(x, 60.0)) if log else x, low, high))
    return values

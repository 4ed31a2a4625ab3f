"""The rows of a foreign file as channels: which can be used, in which order, and of which repeat."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gcode.support.errors import UserError
from testbench.importing.choice import ELECTRICAL, FLAGS, Choice
from testbench.importing.clocks import FAR
from testbench.importing.vocabulary.notation import numbers
from testbench.importing.vocabulary.roles import STRETCH
from testbench.importing.wish import Wish
from testbench.recordings.channels import DISPLACEMENT, FORCE, RESISTANCE, TEMPERATURE, TIME
from testbench.recordings.checks import such, within

if TYPE_CHECKING:
    import pandas as pd

REVERSIBLE = frozenset(("resistance", "conductance"))  # negative where the sense leads are the other way round
LONGEST_LABEL = 60  # characters of a repeat's name, which stands in that of its file
MORE = 10  # rows that follow where another recording begins
# Where more of the rows than this are negative, the sign is wrong; where their times repeat, the time is rounded.
MOSTLY = 0.5


def channels_of(scaled: Mapping[str, np.ndarray], wish: Wish) -> dict[str, np.ndarray]:
    """The channels of a recording, made of columns by role that are in our units already."""
    channels = {}
    if "displacement" in scaled:
        channels[DISPLACEMENT] = scaled["displacement"]
    elif "strain" in scaled:
        channels[DISPLACEMENT] = scaled["strain"] * float(wish.gauge_length_mm or 1.0)
    if "force" in scaled:
        channels[FORCE] = scaled["force"]
    resistance = _resistance(scaled, wish.r0_ohm or np.nan)
    if resistance is not None:
        channels[RESISTANCE] = -resistance if wish.negate & REVERSIBLE else resistance
    if "temperature" in scaled:
        channels[TEMPERATURE] = scaled["temperature"]
    return channels


def _resistance(scaled: Mapping[str, np.ndarray], r0_ohm: float) -> np.ndarray | None:
    if "resistance" in scaled:
        return scaled["resistance"]
    if "conductance" in scaled:
        with np.errstate(divide="ignore"):
            return 1.0 / scaled["conductance"]
    if "relative" in scaled:
        return scaled["relative"] * r0_ohm
    if "relative_change" in scaled:
        return (1.0 + scaled["relative_change"]) * r0_ohm
    return None


def check_change(path: Path, rows: np.ndarray, choice: Choice, scaled: Mapping[str, np.ndarray]) -> None:
    """A resistance cannot fall by more than itself: percent were taken for shares."""
    change = scaled.get("relative_change", np.zeros(0))
    below = np.flatnonzero(change <= -1)
    one = choice.taken.get("relative_change")
    if below.size and one is not None and one.unit is not None and one.unit.symbol == "1":
        raise UserError(
            f"{path}: row {rows[below[0]]}: {one.column.label} is {change[below[0]]:g}, and no resistance falls by "
            "more than itself (-1); if the column is in %, say --relative-unit %"
        )


def usable(
    path: Path,
    rows: np.ndarray,
    time_s: np.ndarray,
    channels: Mapping[str, np.ndarray],
    wish: Wish,
    roles: Iterable[str],
) -> np.ndarray:
    """Which rows can be used, as booleans of shape (n,); the channels were made of columns of these `roles`.

    Raises
    ------
    UserError
        If a row cannot be used, and nobody said that such rows are to be left out.
    """
    good = np.ones(len(rows), dtype=bool)
    for name, values in {TIME: time_s, **channels}.items():
        fine = np.isfinite(values)
        if name == RESISTANCE:
            fine &= values > 0
        if wish.drop_bad and name != TIME:  # an overload of a meter is written as 9.9e37
            fine &= within(name, values)
        if not fine.all() and not wish.drop_bad:
            first = int(np.flatnonzero(~fine)[0])
            want = "positive and finite" if name == RESISTANCE else "a finite number"
            remedy, turned = "--drop-bad leaves them out", sorted(REVERSIBLE.intersection(roles))
            if name != TIME and not np.isfinite(values).any():
                alike = {DISPLACEMENT: STRETCH, RESISTANCE: ELECTRICAL}.get(name, (name.partition("_")[0],))
                flags = " or ".join(FLAGS[role] for role in alike if role in roles)
                remedy = f"its column is empty (as where formulas were never computed); {flags} none leaves it out"
            elif name == TEMPERATURE:
                remedy = "--temperature none leaves the temperature out, --drop-bad those rows"
            if name == RESISTANCE and turned and (values < 0).mean() > MOSTLY:
                flag, given = f"--negate {turned[0]}", wish.negate & REVERSIBLE
                remedy = f"leave {flag} out" if given else f"if its leads were the other way round, add {flag}"
            raise UserError(
                f"{path}: row {rows[first]}: {name} must be {want}, got {values[first]:g} "
                f"({such(int((~fine).sum()))}); {remedy}"
            )
        good &= fine
    return good


def in_order(path: Path, rows: np.ndarray, time_s: np.ndarray, sort: bool) -> tuple[np.ndarray, int, int]:
    """Row numbers in the order of time; how many rows were out of order, and how many came at a time already taken.

    Raises
    ------
    UserError
        If the time does not increase, and nobody said that rows are to be sorted.
    """
    steps = np.diff(time_s)
    if (steps > 0).all():
        return np.arange(len(time_s)), 0, 0
    again, at = restarts(time_s), int(np.flatnonzero(steps <= 0)[0]) + 1
    if again or not sort:
        remedy = _for_order(time_s)
        if again:
            at = again[0]
            remedy = (
                "the time starts again there, so the file holds several recordings, or its clock was set back: "
                f"--repeat N (1 to {len(again) + 1}) takes one, or part it into one file each"
                + " (--sort would put the rows of one between those of the other)"
                * sort
            )
        raise UserError(
            f"{path}: row {rows[at]}: time must increase, got {time_s[at]:g} s after {time_s[at - 1]:g} s; {remedy}"
        )
    order = np.argsort(time_s, kind="stable")
    moved = int((order != np.arange(len(order))).sum())
    first = np.concatenate([[True], np.diff(time_s[order]) > 0])
    return order[first], moved, int((~first).sum())


def _for_order(time_s: np.ndarray) -> str:
    """What to do about times that do not increase; those that most rows share with others are no time to sort by.

    Such are whole seconds at a higher rate, and a part of the time that begins anew, as milliseconds do every second.
    """
    steps = np.diff(time_s)
    repeated, onward = int((steps == 0).sum()), steps[steps > 0]
    shared = len(time_s) - len(np.unique(time_s))
    if shared <= MOSTLY * len(time_s) or not onward.size:
        return "--sort puts rows in order and drops repeated times"
    if repeated <= MOSTLY * len(time_s):
        return (
            f"the time falls back {int((steps < 0).sum())} times, and {shared} of {len(time_s)} rows have one that "
            "another row has, too, as where the column is only a part of the time (ms within the second): say --time "
            "COL, a column with the whole time, or --rate-hz F in its place; --sort would drop them"
        )
    rate_hz = len(time_s) / (len(time_s) - repeated) / float(np.median(onward))
    return (
        f"{repeated} of {len(time_s)} rows have the time of the row above, as where it is written in whole seconds: "
        f"say --rate-hz F, the rate that they were sampled at (on average {rate_hz:.3g}), in place of the time "
        "column; --sort would drop them"
    )


def restarts(time_s: np.ndarray) -> list[int]:
    """Where the time falls far back and rises from there among the times before, or far from them all.

    Rows that are but out of order, as they were written late, leave a gap behind them, into which they fit.
    """
    found = []
    falls, far = np.flatnonzero(np.diff(time_s) < 0) + 1, _far(time_s)
    for begin, at, end in zip([0, *falls], falls, [*falls[1:], len(time_s)], strict=False):
        before, behind = time_s[begin:at], time_s[at:end]
        behind = behind[behind <= before[-1]]
        if before[-1] - time_s[at] > far and len(behind) > MORE:
            between = before[(before > behind[0]) & (before < behind[-1])]
            away = np.min([np.abs(before - end_s).min() for end_s in (behind[0], behind[-1])])
            if len(between) or away > far:
                found.append(int(at))
    return found


def _far(time_s: np.ndarray) -> float:
    steps = np.diff(time_s)
    return FAR * float(np.median(steps[steps > 0])) if (steps > 0).any() else np.inf


def runs_of(begins: Sequence[int], time_s: np.ndarray) -> list[tuple[str, np.ndarray]]:
    """Runs by their number, where the names stand again below each and the time begins anew or after a pause.

    Parameters
    ----------
    begins : sequence of int
        Rows that follow on names.
    time_s : ndarray, shape (n,)

    Returns
    -------
    list of (label, rows)
        Empty where the time goes on below all the names, as where they stand on every page.
    """
    there = np.flatnonzero(np.isfinite(time_s))
    steps, far = np.diff(time_s[there]), _far(time_s[there])
    after = np.searchsorted(there, begins)  # the first time at or below the names
    new = [
        begin
        for begin, place in zip(begins, after, strict=True)
        if 0 < place < len(there) and not 0 <= steps[place - 1] <= far
    ]
    parts = np.split(np.arange(len(time_s)), new)
    return [(str(number), rows) for number, rows in enumerate(parts, 1)] if new else []


def mostly_one_gap(time_s: np.ndarray, rows: np.ndarray) -> list[str]:
    """A sentence where more than half of the time lies between two samples, as before a row of results.

    Parameters
    ----------
    time_s, rows : ndarray, each shape (n,)
        Increasing times, and the row of the file that each is from.
    """
    steps = np.diff(time_s)
    at = int(steps.argmax())
    if len(steps) < 2 or 2 * steps[at] <= time_s[-1] - time_s[0]:
        return []
    return [
        f"between row {rows[at]} and row {rows[at + 1]} there is no sample for {steps[at]:.4g} s of the "
        f"{time_s[-1] - time_s[0]:.4g} s: if a row of results or of another test is among the samples, take it out "
        "of the file"
    ]


def zero_set_anew(channels: Mapping[str, np.ndarray], rows: np.ndarray) -> list[str]:
    """A sentence where a displacement that moves on jumps once, as it never does else, and the force does not.

    Parameters
    ----------
    channels : mapping of str to ndarray, each shape (n,)
    rows : ndarray of int, shape (n,)
        Row of the file that each sample is from.
    """
    if not {DISPLACEMENT, FORCE} <= set(channels) or len(rows) < 3:
        return []
    moved, pulled = np.diff(channels[DISPLACEMENT]), np.abs(np.diff(channels[FORCE]))
    at = int(np.abs(moved).argmax())
    others = np.abs(np.delete(moved, at))
    stands = np.median(others) == 0  # a stage that stood still, and took one step
    if stands or abs(moved[at]) <= FAR * others.max() or pulled[at] > 2 * np.delete(pulled, at).max():
        return []
    return [
        f"between row {rows[at]} and row {rows[at + 1]} the displacement jumps by {moved[at]:.4g} mm, and the force "
        "does not: if its zero was set anew there, part the file into one file each"
    ]


def labels_in(cells: pd.Series, decimal: str) -> np.ndarray:
    """What a column calls the repeat of each row, shape (n,): a whole number or a name; empty where neither."""
    counter, _ = numbers(cells, decimal)
    words = cells.astype("string").fillna("").str.strip().str.replace(r"[^\w.]+", "-", regex=True).str[:LONGEST_LABEL]
    whole, named = counter == np.round(counter), np.isnan(counter)
    return np.where(whole, [f"{number:.0f}" for number in counter], np.where(named, words.to_numpy(str), ""))


def repeats_of(labels: np.ndarray, time_s: np.ndarray) -> list[tuple[str, np.ndarray]]:
    """Repeats that a column numbers or names, where the time starts again with each; empty where it does not.

    Parameters
    ----------
    labels, time_s : ndarray, each shape (n,)
        See `labels_in`; and the times.

    Returns
    -------
    list of (label, rows)
        The number or name of the repeat, and which rows are its.
    """
    restarts = np.flatnonzero(np.diff(time_s) < 0)
    changes = np.flatnonzero(labels[1:] != labels[:-1])
    names, counts = np.unique(labels, return_counts=True)
    if not restarts.size or not set(restarts) <= set(changes) or len(names) != len(changes) + 1:
        return []
    if "" in names or counts.min() < 2:  # a number of each sample
        return []
    return [(str(label), np.flatnonzero(labels == label)) for label in dict.fromkeys(labels.tolist())]

"""Zero, sign and gauge length: zero and sign are set on request, and all are said where they look wrong."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

import numpy as np

from gcode.support.errors import UserError
from testbench.importing.choice import Choice
from testbench.importing.columns import Read
from testbench.importing.sheet import Sheet
from testbench.importing.vocabulary.laboratory_units import Unit, conversion, unit_of
from testbench.importing.vocabulary.notation import numbers
from testbench.importing.vocabulary.roles import STRETCH
from testbench.importing.wish import Wish
from testbench.recordings.channels import DISPLACEMENT, FORCE
from testbench.recordings.doubts import AGAINST, correlation

SIGNED = ("displacement", "strain", "force")
TURNED = (*SIGNED, "resistance", "conductance")  # these two are negative where leads are the other way round
FEW = 100_000  # samples that are enough for a correlation
APART = 0.02  # relative; a gauge length is measured with a ruler
ALIKE = 0.999  # correlation of the two; below it, the strain is that of something else
_VALUE = re.compile(r"^\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*([^\s\d.]\S*)?\s*$")


def zero_of(role: str, text: str, unit: Unit) -> tuple[float, str]:
    """A zero that a person gave, in our unit, and in words; without a unit, in that of the file.

    Raises
    ------
    UserError
        If it is no number with a unit of the role.
    """
    found = _VALUE.match(text)
    named = unit_of(found[2], (unit.quantity,)) if found and found[2] else unit
    value = float(found[1]) if found else np.nan
    if named is None or not np.isfinite(value):
        raise UserError(f"--zero {role}= needs a number in {unit.symbol}, or with its unit, got {text!r}")
    return float(named.converted(np.asarray(value))), f"{conversion(value, named)} is the zero of {role}"


def _check_role(flag: str, role: str, allowed: Sequence[str], choice: Choice) -> None:
    """A sign or a zero can only be given to what the file has, and what has one."""
    if role not in allowed or role not in choice.taken:
        have = ", ".join(one for one in allowed if one in choice.taken) or "nothing that has a sign"
        raise UserError(f"{flag} can be said of {have}, got {role}")


def turned(picked: dict[str, np.ndarray], choice: Choice, wish: Wish) -> list[str]:
    """Turn the signs that `wish` says, in place (a resistance was turned as it was read); what was done, in words."""
    for role in wish.negate:
        _check_role("--negate", role, TURNED, choice)
        if role in SIGNED:
            name = DISPLACEMENT if role in STRETCH else FORCE
            picked[name] = 0.0 - picked[name]
    return [f"the sign of {role} was turned" for role in sorted(wish.negate)]


def zeroed(picked: dict[str, np.ndarray], choice: Choice, wish: Wish) -> list[str]:
    """Count displacement and force from where `wish` says, in place; what was done, in words."""
    told = []
    for role, text in wish.zero.items():
        _check_role("--zero", role, SIGNED, choice)
        name = DISPLACEMENT if role in STRETCH else FORCE
        unit = choice.taken[role].unit
        assert unit is not None
        if text is None:
            zero = float(picked[name][0])
            told.append(f"{role} is counted from its first sample, {zero:.6g} {name.rpartition('_')[2]}")
        else:
            zero, words = zero_of(role, text, unit)
            zero *= float(wish.gauge_length_mm or 1.0) if role == "strain" else 1.0
            told.append(words)
        picked[name] = picked[name] - zero
    return told


def doubts(channels: Mapping[str, np.ndarray], negated: frozenset[str]) -> list[str]:
    """What looks wrong about sign and zero, in sentences with the remedy; nothing is changed."""
    if DISPLACEMENT not in channels:
        return []
    every = max(1, len(channels[DISPLACEMENT]) // FEW)
    moved_mm = channels[DISPLACEMENT][::every]
    start, spread = float(moved_mm[0]), float(np.ptp(moved_mm))
    said = _doubts_of_both(moved_mm, channels[FORCE][::every], negated) if FORCE in channels else []
    if not said and _leans_back(moved_mm):
        said.append(
            f"the displacement falls from its first sample, {start:.4g} mm, to {moved_mm.min():.4g} mm: "
            f"if stretch is counted negative there, {_turn('displacement', negated)}"
        )
    if start < -0.05 * spread:
        said.append(
            f"the displacement starts at {start:.4g} mm, a zero of its own, and strain is counted from 0: "
            "add --zero displacement to count from the first sample"
        )
    if start > spread > 0:
        said.append(
            f"the displacement starts at {start:.4g} mm and then moves by {spread:.4g} mm: if it is the distance of "
            "the clamps, or counted from another zero, add --zero displacement to count from the first sample"
        )
    return said


def _doubts_of_both(moved_mm: np.ndarray, force_N: np.ndarray, negated: frozenset[str]) -> list[str]:
    """What only displacement and force together show: that they run against each other, or both backwards."""
    backwards, slackens = _leans_back(moved_mm), _leans_back(force_N)
    related = correlation(moved_mm, force_N)
    if related < AGAINST:
        return [
            f"force rises as the displacement falls (correlation {related:.2f}): one of them runs the wrong way; "
            f"{_turn('displacement' if backwards or not slackens else 'force', negated)}"
        ]
    if backwards and slackens and related > -AGAINST:
        return [
            "displacement and force both fall from their first sample: if this is a stretch and no squeeze, "
            + _turn_both(negated)
        ]
    return []


def _turn(role: str, negated: frozenset[str]) -> str:
    return f"leave --negate {role} out" if role in negated else f"add --negate {role}"


def _turn_both(negated: frozenset[str]) -> str:
    both = ("displacement", "force")
    if len({role in negated for role in both}) == 1:
        return _turn(both[0], negated).replace(both[0], " ".join(both))
    return " and ".join(_turn(role, negated) for role in both)


def _leans_back(values: np.ndarray) -> bool:
    """Whether a signal goes further below its first sample than above it."""
    return bool(values[0] - values.min() > 2 * (values.max() - values[0]))


def gauge_doubts(sheet: Sheet, choice: Choice, read: Read, gauge_length_mm: float | None) -> list[str]:
    """What speaks against the gauge length, a sentence for each column of strain that is of another one.

    A strain without a unit may be a ratio or %.
    """
    if "displacement" not in choice.taken or not gauge_length_mm:
        return []
    doubts = []
    moved_mm = read.values["displacement"]
    for column in choice.unused:
        if "strain" not in dict(column.heading.roles):
            continue
        values, _ = numbers(sheet.body([column.number])[column.number], sheet.decimal)
        unit = column.heading.unit(column.unit_text)
        factors = [unit.factor] if unit and unit.quantity == "ratio" else [1.0, 0.01]
        length_mm = _slope(values[read.rows - sheet.layout.first_row], moved_mm)
        lengths_mm = [length_mm / factor for factor in factors]
        if length_mm and min(abs(one / gauge_length_mm - 1) for one in lengths_mm) > APART:
            said = " or ".join(f"{one:.4g} mm" for one in lengths_mm)
            doubts.append(
                f"{column.label} is that of a gauge length of {said}, and --gauge-length-mm says {gauge_length_mm:g}"
            )
    return doubts


def _slope(strain: np.ndarray, moved_mm: np.ndarray) -> float:
    """Millimetres for a unit of strain; 0 where the two do not move together."""
    good = np.isfinite(strain) & np.isfinite(moved_mm)
    strain, moved_mm = strain[good], moved_mm[good]
    if len(strain) < 3 or correlation(strain, moved_mm) <= ALIKE:
        return 0.0
    return float(np.polyfit(strain, moved_mm, 1)[0])

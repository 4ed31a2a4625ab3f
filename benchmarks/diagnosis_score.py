"""What a diagnosis of a case with a known truth was worth: one row a case, and tables over rows."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from result_rows import Row
from sklearn.calibration import calibration_curve

SURE = 0.9  # a wrong name given with more than this is the worst of errors
BINS = 10  # of the reliability diagram
AS_ASKED = 2 / 3  # of the strength that was asked for: some effects cannot be that strong, in some sensors


def score(truth: Mapping[str, Any], said: Mapping[str, Any], expected: str, mechanisms: Mapping[str, str]) -> Row:
    """One row from the truth and `Diagnosis.to_dict()`.

    Parameters
    ----------
    truth : mapping
        `Case.truth`.
    said : mapping
        ``verdict``, ``ranking``, ``error_after`` and so on.
    expected : str
        The right verdict (another than the truth's where the effect was taken out of the catalogue).
    mechanisms : mapping
        Law of an effect -> the mechanism that it belongs to.
    """
    hidden = _distinct(mechanisms.get(entry["effect"], entry["effect"]) for entry in truth["effects"])
    found = [entry["effect"] for entry in said["found"]]
    return {
        "hidden": hidden,
        "forms": [entry["form"] for entry in truth["effects"]],
        "reached": [entry["strength_reached"] for entry in truth["effects"]],
        "expected": expected,
        "answer": _answer(expected, hidden),
        "verdict": said["verdict"],
        "chances": dict(said["probabilities"]),
        "ranked": [entry["effect"] for entry in said["ranking"]][:5],
        "gains": [entry["gain"] for entry in said["ranking"][:5]],
        "found": found,
        "sure": [entry["probability"] for entry in said["found"]],
        "named": found if said["verdict"] == "missing" else [],
        "left": said["left_unexplained"],
        "tied": list(said.get("tied") or []),
        "base_misfits": list(said.get("base_misfits") or []),
        "before": over_floor(said["error_before"], truth["noise_floor"]),
        "after": over_floor(said["error_after"], truth["noise_floor"]),
        "floor_said": over_floor(said["noise_floor"], truth["noise_floor"]),
    }


def _answer(expected: str, hidden: Sequence[str]) -> str:
    """Which of the probabilities should be 1; empty where two effects are hidden at once."""
    if expected == "missing":
        return hidden[0] if len(hidden) == 1 else ""
    return {"nothing_missing": "nothing", "unknown": "unknown"}[expected]


def over_floor(errors: Mapping[str, float], floors: Mapping[str, float]) -> float:
    """RMS over channels of error / true noise floor (1 is perfect)."""
    ratios = [errors[name] / floors[name] for name in errors if errors[name] is not None and name in floors]
    return float(np.sqrt(np.mean(np.square(ratios)))) if ratios else float("nan")


def _distinct(names: Iterable[str]) -> list[str]:
    return list(dict.fromkeys(names))


# --- what counts as right ---


def is_single(row: Row) -> bool:
    """One effect of the catalogue hidden."""
    return row["expected"] == "missing" and len(row["hidden"]) == 1


def is_as_strong(row: Row) -> bool:
    """The hidden effect is about as strong as was asked for; what shows less is harder to find."""
    return min(row["reached"]) >= AS_ASKED * row["strength"]


def first(row: Row) -> bool:
    """The hidden effect is the first that was found, and the verdict is `missing`."""
    return row["named"][:1] == row["hidden"]


def ranked_first(row: Row) -> bool:
    """The hidden effect is ranked first, whatever the verdict."""
    return row["ranked"][:1] == row["hidden"]


def top3(row: Row) -> bool:
    """The hidden effect is among the first three, whatever the verdict."""
    return row["hidden"][0] in row["ranked"][:3]


def found(row: Row) -> float:
    """Share of the hidden effects that the final model contains."""
    return float(np.mean([name in row["found"] for name in row["hidden"]]))


def surely_wrong(row: Row) -> bool:
    """A name was given with more than 90 %, and nothing like it is hidden."""
    if not row["named"] or row["named"][0] in _findable(row):
        return False
    return max(row["sure"][0], row["chances"].get(row["named"][0], 0.0)) > SURE


def _findable(row: Row) -> list[str]:
    """What may rightly be named: what is hidden, unless it was taken out of the catalogue."""
    return row["hidden"] if row["expected"] == "missing" else []


def said(verdict: str) -> Callable[[Row], bool]:
    """Whether a row has this verdict."""
    return lambda row: row["verdict"] == verdict


def share(rows: Sequence[Row], right: Callable[[Row], float]) -> str:
    """Percentage with the number of cases, or a dash."""
    return f"{100 * np.mean([right(row) for row in rows]):.0f} % of {len(rows)}" if rows else "-"


def median(rows: Sequence[Row], key: str) -> str:
    return f"{np.median([row[key] for row in rows]):.2f}" if rows else "-"


# --- tables ---


def tables(rows: Sequence[Row]) -> str:
    """All tables, as Markdown."""
    good = [row for row in rows if "error" not in row]
    kinds = by_kind(good)
    parts = [at_a_glance(good), reliability(good)] + ([kinds] if kinds else [])
    parts += [by_world_and_strength(good), nothing_unknown_two(good), by_effect(good), confusions(good)]
    failed = [f"{row['key']}: {row['error']}" for row in rows if "error" in row]
    return "\n\n".join(parts + (["Failed:\n" + "\n".join(failed)] if failed else []))


def at_a_glance(rows: Sequence[Row]) -> str:
    """The figures that the diagnosis is judged by, one line each, over all rows."""
    return markdown(["all cases", ""], goals(rows).items())


def goals(rows: Sequence[Row]) -> dict[str, str]:
    """The same by name."""
    single = [row for row in rows if is_single(row)]
    none = [row for row in rows if row["expected"] == "nothing_missing"]
    unknown = [row for row in rows if row["expected"] == "unknown"]
    two = [row for row in rows if row["expected"] == "missing" and len(row["hidden"]) > 1]
    brier, error = brier_score(rows), calibration_error(rows)
    return {
        "right first and named": share(single, first),
        "the same, of those as strong as asked": share([row for row in single if is_as_strong(row)], first),
        "in the top three": share(single, top3),
        "nothing hidden, and nothing said": share(none, said("nothing_missing")),
        "of no catalogue, and unknown said": share(unknown, said("unknown")),
        "a wrong name with more than 90 %": share(rows, surely_wrong),
        "two at once: both found": share(two, lambda row: found(row) == 1.0),
        "error after / noise floor": median(single, "after"),
        "Brier score (0 is perfect)": "-" if brier is None else f"{brier:.3f}",
        "expected calibration error": "-" if error is None else f"{error:.3f}",
    }


# --- calibration: whether what is said with 90 % is right in nine of ten cases ---


def brier_score(rows: Sequence[Row]) -> float | None:
    """Mean over cases of the squared distance between the probabilities and the truth (Brier 1950), from 0 to 2.

    Over nothing, unknown and every mechanism; cases with two hidden effects have no one answer and are left out.
    """
    scores = [
        sum((chance - (name == row["answer"])) ** 2 for name, chance in row["chances"].items())
        + (row["answer"] not in row["chances"])
        for row in rows
        if row["answer"]
    ]
    return float(np.mean(scores)) if scores else None


def confidences(rows: Sequence[Row]) -> tuple[np.ndarray, np.ndarray]:
    """Of each case with one answer: the largest probability, and whether it is that of the truth."""
    best = [(max(row["chances"], key=row["chances"].get), row) for row in rows if row["answer"] and row["chances"]]
    sure = np.clip([row["chances"][name] for name, row in best], 0.0, 1.0)
    return sure, np.array([name == row["answer"] for name, row in best], dtype=bool)


class Bin(NamedTuple):
    """Cases of which the first answer was about as sure."""

    place: int  # from 0 to BINS - 1
    cases: int
    sure: float  # in the mean
    right: float  # share of them


def diagram(rows: Sequence[Row]) -> list[Bin]:
    """The reliability diagram, without its empty bins."""
    sure, right = confidences(rows)
    if not len(sure):
        return []
    often, said_sure = calibration_curve(right, sure, n_bins=BINS)
    count = np.bincount(np.searchsorted(np.linspace(0, 1, BINS + 1)[1:-1], sure))  # as scikit-learn has them
    places = np.flatnonzero(count)
    return [Bin(*one) for one in zip(places, count[places], said_sure, often, strict=True)]


def calibration_error(rows: Sequence[Row]) -> float | None:
    """Mean distance between how sure and how often right, bins weighed by their cases (Naeini et al. 2015)."""
    bins = diagram(rows)
    if not bins:
        return None
    return float(np.average([abs(one.right - one.sure) for one in bins], weights=[one.cases for one in bins]))


def reliability(rows: Sequence[Row]) -> str:
    """The diagram as a table: how sure the first answer was, and how often it was right."""
    lines = []
    for place, cases, sure, right in diagram(rows):
        span = f"{100 * place // BINS} to {100 * (place + 1) // BINS} %"
        lines.append([span, str(cases), f"{100 * sure:.0f} %", f"{100 * right:.0f} %", "#" * round(20 * right)])
    return markdown(["said with", "cases", "mean probability", "right", ""], lines)


def markdown(header: Sequence[str], lines: Iterable[Sequence[str]]) -> str:
    """A table; a bar in a cell would end it."""
    out = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    return "\n".join(out + ["| " + " | ".join(cell.replace("|", "/") for cell in line) + " |" for line in lines])


def _groups(rows: Sequence[Row], *keys: str) -> dict[tuple, list[Row]]:
    groups: dict[tuple, list[Row]] = {}
    for row in sorted(rows, key=lambda row: tuple(row[key] for key in keys)):
        groups.setdefault(tuple(row[key] for key in keys), []).append(row)
    return groups


def by_world_and_strength(rows: Sequence[Row]) -> str:
    lines = []
    for (world, strength), group in _groups([r for r in rows if is_single(r)], "world", "strength").items():
        seconds = f"{np.median([row['seconds'] for row in group]):.0f}"
        lines.append(
            [
                world,
                f"{strength:g}x",
                share(group, first),
                share(group, ranked_first),
                share(group, top3),
                share(group, said("missing")),
                median(group, "before"),
                median(group, "after"),
                seconds,
            ]
        )
    header = ["one hidden", "strength", "right first", "ranked first", "in top 3", "said missing"]
    return markdown([*header, "error before / floor", "after", "seconds"], lines)


KINDS = {
    "minutes": "minutes",
    "rate_hz": "samples a second",
    "protocol": "motion",
    "channels": "channels",
    "reclamped": "clamped anew",
}


def by_kind(rows: Sequence[Row]) -> str:
    """Where recordings are of several kinds: how well each kind does; else empty."""
    lines = []
    for key, words in KINDS.items():
        groups = _groups([row for row in rows if key in row], key)
        if len(groups) < 2:
            continue
        for (value,), group in groups.items():
            single = [row for row in group if is_single(row)]
            none = [row for row in group if row["expected"] == "nothing_missing"]
            shown = f"{value:g}" if isinstance(value, float) else str(value).replace("_", " ").replace(",", ", ")
            alarms = share(none, said("missing"))
            lines.append([words, shown, share(single, first), share(single, top3), median(single, "after"), alarms])
    header = ["recordings by", "", "right first", "in top 3", "error after / floor", "false alarms"]
    return markdown(header, lines) if lines else ""


def nothing_unknown_two(rows: Sequence[Row]) -> str:
    lines = []
    for (world,), group in _groups(rows, "world").items():
        none = [row for row in group if row["expected"] == "nothing_missing"]
        unknown = [row for row in group if row["expected"] == "unknown"]
        two = [row for row in group if row["expected"] == "missing" and len(row["hidden"]) > 1]
        lines.append(
            [
                world,
                share(none, said("missing")),
                share(none, said("unknown")),
                share(unknown, said("unknown")),
                share(two, found),
                f"{np.mean([len(set(row['found']) - set(row['hidden'])) for row in two]):.1f} a case" if two else "-",
            ]
        )
    header = ["world", "false alarms", "unknown of nothing", "unknown rightly said", "of two, found", "false beside"]
    return markdown(header, lines)


def by_effect(rows: Sequence[Row]) -> str:
    lines = []
    for (name,), group in _groups([{**r, "effect": r["hidden"][0]} for r in rows if is_single(r)], "effect").items():
        lines.append([name, share(group, first), share(group, top3), median(group, "after")])
    return markdown(["effect", "right first", "in top 3", "error after / floor"], lines)


def confusions(rows: Sequence[Row]) -> str:
    wrong: Counter = Counter()
    for row in rows:
        if is_single(row) and not first(row):
            said = row["ranked"][0] if row["verdict"] == "missing" and row["ranked"] else row["verdict"]
            wrong[(row["hidden"][0], row["forms"][0], said)] += 1
    lines = [[a, form, b, str(n)] for (a, form, b), n in wrong.most_common(25)]
    return markdown(["hidden", "in the form", "taken for", "times"], lines)

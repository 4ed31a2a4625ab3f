"""What a diagnosis of a case with a known truth was worth: one row a case, and tables over rows."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

Row = dict[str, Any]


def score(truth: Mapping[str, Any], said: Mapping[str, Any], expected: str, ideas: Mapping[str, str]) -> Row:
    """One row from the truth and `Diagnosis.to_dict()`.

    Parameters
    ----------
    truth : mapping
        `Case.truth`.
    said : mapping
        ``verdict``, ``ranking``, ``error_after`` and so on.
    expected : str
        The right verdict (another than the truth's where the effect was taken out of the catalogue).
    ideas : mapping
        Form of an effect -> the idea that it belongs to.
    """
    hidden = [entry["effect"] for entry in truth["effects"]]
    ranked = _distinct(entry["effect"] for entry in said["ranking"])
    added = _distinct(_added(said, ideas))
    return {
        "hidden": hidden,
        "forms": [entry["form"] for entry in truth["effects"]],
        "reached": [entry["strength_reached"] for entry in truth["effects"]],
        "expected": expected,
        "verdict": said["verdict"],
        "ranked": ranked[:5],
        "gains": [entry["gain"] for entry in said["ranking"][:5]],
        "ceiling": said["ceiling_gain"],
        "left": said["left_unexplained"],
        "added": added,
        "tied": list(said.get("tied") or []),
        "base_misfits": list(said.get("base_misfits") or []),
        "before": over_floor(said["error_before"], truth["noise_floor"]),
        "after": over_floor(said["error_after"], truth["noise_floor"]),
        "floor_said": over_floor(said["noise_floor"], truth["noise_floor"]),
    }


def over_floor(errors: Mapping[str, float], floors: Mapping[str, float]) -> float:
    """RMS over channels of error / true noise floor (1 is perfect)."""
    ratios = [errors[name] / floors[name] for name in errors if errors[name] is not None and name in floors]
    return float(np.sqrt(np.mean(np.square(ratios)))) if ratios else float("nan")


def _distinct(names: Iterable[str]) -> list[str]:
    return list(dict.fromkeys(names))


def _added(said: Mapping[str, Any], ideas: Mapping[str, str]) -> list[str]:
    """Ideas in the model after that were not in the one before; bending a base law, or Bouc-Wen loops, is none."""
    before = {entry["name"] for entry in said["model_before"]["effects"]} if "model_before" in said else set()
    after = said["model_after"]["effects"] if "model_after" in said else []
    new = [ideas.get(e["effect"], e["effect"]) for e in after if e["name"] not in before]
    return [name for name in new if not name.endswith("_shape") and name != "hysteresis"]


# --- what counts as right ---


def is_single(row: Row) -> bool:
    """One effect of the catalogue hidden."""
    return row["expected"] == "missing" and len(row["hidden"]) == 1


def first(row: Row) -> bool:
    """The hidden effect is ranked first and the verdict is `missing`."""
    return row["verdict"] == "missing" and row["ranked"][:1] == row["hidden"]


def ranked_first(row: Row) -> bool:
    """The hidden effect is ranked first, whatever the verdict."""
    return row["ranked"][:1] == row["hidden"]


def top3(row: Row) -> bool:
    """The hidden effect is among the first three, whatever the verdict."""
    return row["hidden"][0] in row["ranked"][:3]


def found(row: Row) -> float:
    """Share of the hidden effects that the final model contains."""
    return float(np.mean([name in row["added"] for name in row["hidden"]]))


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
    parts = [kinds] if kinds else []
    parts += [by_world_and_strength(good), nothing_unknown_two(good), by_effect(good), confusions(good)]
    failed = [f"{row['key']}: {row['error']}" for row in rows if "error" in row]
    return "\n\n".join(parts + (["Failed:\n" + "\n".join(failed)] if failed else []))


def _table(header: Sequence[str], lines: Iterable[Sequence[str]]) -> str:
    out = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    return "\n".join(out + ["| " + " | ".join(line) + " |" for line in lines])


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
    return _table([*header, "error before / floor", "after", "seconds"], lines)


KINDS = {"minutes": "minutes", "rate_hz": "samples a second", "protocol": "motion", "channels": "channels"}


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
            shown = f"{value:g}" if isinstance(value, float) else value.replace("_", " ").replace(",", ", ")
            alarms = share(none, said("missing"))
            lines.append([words, shown, share(single, first), share(single, top3), median(single, "after"), alarms])
    header = ["recordings by", "", "right first", "in top 3", "error after / floor", "false alarms"]
    return _table(header, lines) if lines else ""


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
                f"{np.mean([len(set(row['added']) - set(row['hidden'])) for row in two]):.1f} a case" if two else "-",
            ]
        )
    header = ["world", "false alarms", "unknown of nothing", "unknown rightly said", "of two, found", "false beside"]
    return _table(header, lines)


def by_effect(rows: Sequence[Row]) -> str:
    lines = []
    for (name,), group in _groups([{**r, "effect": r["hidden"][0]} for r in rows if is_single(r)], "effect").items():
        lines.append([name, share(group, first), share(group, top3), median(group, "after")])
    return _table(["effect", "right first", "in top 3", "error after / floor"], lines)


def confusions(rows: Sequence[Row]) -> str:
    wrong: Counter = Counter()
    for row in rows:
        if is_single(row) and not first(row):
            said = row["ranked"][0] if row["verdict"] == "missing" and row["ranked"] else row["verdict"]
            wrong[(row["hidden"][0], row["forms"][0], said)] += 1
    lines = [[a, form, b, str(n)] for (a, form, b), n in wrong.most_common(25)]
    return _table(["hidden", "in the form", "taken for", "times"], lines)

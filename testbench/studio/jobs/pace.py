"""How long a job will still take: from its own steps, and from how the steps of the last such job lay in time."""

from __future__ import annotations

import contextlib
import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field

from gcode.support.errors import UserError
from gcode.support.files import make_folder, write_text
from gcode.support.strict import read_json, validated

LIKE_LAST_TIME = 0.03  # so much of the whole is believed to go as fast as it did last time
SHORTEST_S, LONGEST_S = 1e-3, 1e7  # of a job that is believed
EARLY = 0.08  # below this share of its steps a job that was never seen before is not extrapolated
SCORE = re.compile(r"\b(cost|r2|E) (-?[\d.]+(?:e[-+]?\d+)?)")
SCORE_NAMES = {"cost": "misfit", "r2": "r²", "E": "error E"}


@dataclass(frozen=True)
class Profile:
    """When the steps of a job came, the last time that it ran to its end.

    Attributes
    ----------
    total_s : float
    marks : mapping of step to float
        Seconds after the start.
    """

    total_s: Annotated[float, Field(ge=SHORTEST_S, le=LONGEST_S)]
    marks: Mapping[str, Annotated[float, Field(ge=0, le=LONGEST_S)]]


@dataclass
class Pace:
    """The steps of one job so far.

    Attributes
    ----------
    marks : dict of step to float
        Seconds after the start at which each was told.
    share : float or None
        Of the steps, where the job counts them.
    before_s : float
        How long it took until the first step that it counts: reading, starting fits.
    score_name : str
        What the job tells of its success (the misfit of a fit), with its values so far in `scores`.
    """

    profile: Profile | None = None
    marks: dict[str, float] = field(default_factory=dict)
    share: float | None = None
    before_s: float = 0.0
    score_name: str = ""
    scores: list[float] = field(default_factory=list)

    def hear(self, note: str, share: float | None, elapsed_s: float, counted: str = "") -> None:
        """Take in one step; `counted` names it by its number, where the job counts."""
        self.share = share if share is not None else self.share
        self.before_s = self.before_s if self.share else elapsed_s
        stem, repeat = counted or note.partition(":")[0], 1
        mark = stem
        while mark in self.marks:
            repeat += 1
            mark = f"{stem} #{repeat}"
        self.marks[mark] = elapsed_s
        found = SCORE.search(note)
        if found:
            self.score_name = SCORE_NAMES[found[1]]
            self.scores.append(float(found[2]))

    def total_s(self) -> float | None:
        """How long the whole will take; None while nothing can be said."""
        if self.profile:
            known = [
                (at_s, self.profile.marks[mark]) for mark, at_s in self.marks.items() if mark in self.profile.marks
            ]
            at_s, then_s = known[-1] if known else (0.0, 0.0)
            like_s = LIKE_LAST_TIME * self.profile.total_s
            return self.profile.total_s * (at_s + like_s) / (then_s + like_s)
        if self.share and self.share >= EARLY and self.marks:
            return self.before_s + (next(reversed(self.marks.values())) - self.before_s) / self.share
        return None

    def left_s(self, elapsed_s: float) -> float | None:
        """How long it will still take; None while nothing can be said, or where it takes longer than was thought."""
        total_s = self.total_s()
        return total_s - elapsed_s if total_s is not None and total_s > elapsed_s else None

    def done(self, elapsed_s: float) -> float | None:
        """Share of the time that is over, for a bar; None while nothing can be said."""
        total_s = self.total_s()
        if total_s is not None and self.profile:
            return min(elapsed_s / total_s, 0.99)
        return self.share


class Paces:
    """The profiles of the last jobs, kept in a file from one studio to the next; without one, for this studio."""

    def __init__(self, path: Path | None = None) -> None:
        self._path = path
        self._known: dict[str, Profile] = {}
        if path is not None:
            with contextlib.suppress(UserError):
                self._known = validated(read_json(path, "paces", 1 << 20), dict[str, Profile], path, "paces")

    def start(self, argv: Sequence[str]) -> Pace:
        """The pace of a job that begins."""
        return Pace(self._known.get(kind_of(argv)))

    def keep(self, argv: Sequence[str], pace: Pace, total_s: float) -> None:
        """Remember a job that has ended well."""
        self._known[kind_of(argv)] = Profile(max(total_s, SHORTEST_S), dict(pace.marks))
        if self._path is not None:
            make_folder(self._path.parent)
            told: dict[str, Any] = {kind: vars(profile) for kind, profile in self._known.items()}
            write_text(self._path, json.dumps(told, indent=1) + "\n")


def kind_of(argv: Sequence[str]) -> str:
    """Jobs that take about the same steps: the same command, and for a training the same method."""
    method = argv.index("--method") if "--method" in argv else len(argv)
    return " ".join([*argv[:2], *argv[method : method + 2]])


def about_in_words(seconds: float) -> str:
    """``about 40 s``, ``about 3 min``."""
    if seconds < 10:
        return "a few seconds"
    if seconds < 90:
        return f"about {5 * round(seconds / 5)} s"
    return f"about {round(seconds / 60)} min" if seconds < 5400 else f"about {seconds / 3600:.1f} h"

"""Finding campaigns again: words, states and tags that a list is narrowed by, and its order."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from testbench.studio.notes import Note
from testbench.studio.workspace import Campaign


@dataclass(frozen=True)
class Found:
    """A campaign that a search has found.

    Attributes
    ----------
    campaign : Campaign
    note : Note
    states : frozenset of str
        ``fitted``, ``diagnosed``, ``compensated``, ``unfinished``.
    """

    campaign: Campaign
    note: Note
    states: frozenset[str]

    def matches(self, words: Iterable[str]) -> bool:
        """Whether every word is somewhere in its name, origin, specimen, tags, states or note."""
        own = (self.campaign.name, self.campaign.origin, self.campaign.specimen, self.campaign.status)
        text = " ".join((*own, *self.note.tags, *self.states, self.note.text)).lower()
        return all(word.lower() in text for word in words)


STATES = ("fitted", "diagnosed", "compensated", "unfinished")
ORDERS: dict[str, tuple[str, Callable[[Found], tuple]]] = {  # what it is called, and what it sorts by
    "newest": ("Newest first", lambda found: (-found.campaign.made_s, found.campaign.name)),
    "oldest": ("Oldest first", lambda found: (found.campaign.made_s, found.campaign.name)),
    "name": ("By name", lambda found: (found.campaign.name.lower(),)),
    "specimen": ("By specimen", lambda found: (found.campaign.specimen.lower(), -found.campaign.made_s)),
}


def narrowed(
    all_of: Iterable[Found], words: str = "", state: str = "", tag: str = "", order: str = ""
) -> list[Found]:
    """The campaigns that fit, in order; an unknown order is the newest first."""
    kept = [
        found
        for found in all_of
        if (not state or state in found.states)
        and (not tag or tag in found.note.tags)
        and found.matches(words.split())
    ]
    return sorted(kept, key=ORDERS.get(order, ORDERS["newest"])[1])


def all_tags(all_of: Iterable[Found]) -> list[str]:
    """Every tag that is in use."""
    return sorted({tag for found in all_of for tag in found.note.tags}, key=str.lower)

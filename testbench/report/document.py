"""A report as data: sections of words, tables and figures. HTML, Markdown and files are made from the same one."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from testbench.report.style import Figure


@dataclass(frozen=True)
class Picture:
    """One figure with the sentence that says what to see in it.

    Attributes
    ----------
    name : str
        File name without suffix, unique in a report.
    """

    name: str
    figure: Figure
    caption: str


@dataclass(frozen=True)
class Table:
    """Rows of text under a head; numbers come formatted."""

    head: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]
    caption: str = ""


@dataclass(frozen=True)
class Facts:
    """A few values that are read at a glance: pairs of name and value."""

    pairs: Sequence[tuple[str, str]]


Item = str | Picture | Table | Facts


@dataclass(frozen=True)
class Section:
    """A heading and what stands under it, in order; a plain string is a paragraph."""

    title: str
    items: list[Item] = field(default_factory=list)


@dataclass(frozen=True)
class Report:
    """A whole report.

    Attributes
    ----------
    title : str
    verdict : str
        The one sentence a hurried reader takes away.
    opening : list of Item
        The first screen: the few values that matter and the picture that says it all.
    sections : list of Section
    footer : str
        Versions.
    date : str
        When it was made.
    """

    title: str
    verdict: str
    opening: list[Item] = field(default_factory=list)
    sections: list[Section] = field(default_factory=list)
    footer: str = ""
    date: str = ""

    def pictures(self) -> Iterator[Picture]:
        """Every picture, in the order of reading."""
        for items in (self.opening, *(section.items for section in self.sections)):
            yield from (item for item in items if isinstance(item, Picture))

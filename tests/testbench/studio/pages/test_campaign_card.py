"""A card of the list: what it says of a campaign, and that what a stranger's file says stays text."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from testbench.studio.finding import Found
from testbench.studio.notes import Note
from testbench.studio.pages.campaign_card import Known, card_html, looked_at
from testbench.studio.studio import Studio
from testbench.studio.workspace import Campaign

EVIL = "<img src=x onerror=alert(1)>\"'"


def found(**said: str) -> Found:
    campaign = Campaign(said.get("name", "knit"), Path("knit"), said.get("origin", "recorded"), 25.0)
    return Found(campaign, Note((said.get("tag", "wet"),), said.get("note", "first try")), frozenset({"fitted"}))


def test_it_says_what_is_known() -> None:
    text = card_html(found(), Known("verified", True, state="interrupted", picture="<svg/>", facts="4 min"))
    words = (
        "knit",
        '"tag good"',
        "verified",
        "recorded",
        "interrupted",
        "fitted",
        "wet",
        "first try",
        "4 min",
        "<svg/>",
    )
    assert [word for word in words if word not in text] == []


def test_a_trouble_stands_where_the_facts_would() -> None:
    text = card_html(found(), Known("changed", False, "recording.csv: checksum differs", facts="4 min"))
    assert '"tag bad" title="recording.csv: checksum differs">changed' in text
    assert "4 min" not in text


@pytest.mark.parametrize("place", ["name", "origin", "tag", "note"])
def test_what_a_file_says_is_never_code(place: str) -> None:
    assert "<img" not in card_html(found(**{place: EVIL}), Known())


@pytest.mark.parametrize("place", ["verdict", "why", "state", "facts"])
def test_what_was_found_is_never_code(place: str) -> None:
    text = card_html(found(), Known(**{place: EVIL}))
    assert "<img" not in text
    assert EVIL not in text


def test_a_span_says_of_what(studio: Studio) -> None:
    facts = looked_at(studio, studio.workspace.campaign("sleeve")).facts
    assert re.fullmatch(r"2\.5 min · strain 0\.0 to 10\.0 %", facts)


def test_a_long_trouble_ends_at_a_word_and_names_files_within_the_campaign() -> None:
    why = "knit/datapackage.json: not a campaign manifest: " + "surely " * 30
    text = card_html(found(), Known("changed", False, why))
    (shown,) = re.findall(r'"quiet text-sm">([^<]*)<', text)
    assert shown.startswith("datapackage.json: not a campaign manifest: surely")
    assert shown.endswith("surely …")
    assert len(shown) <= 142

"""What is chosen on the import page goes into its address and comes back; nothing else is taken from an address."""

from __future__ import annotations

from pathlib import Path

import pytest

from gcode.support.errors import UserError
from testbench.studio.importing.import_form import Choices

PATH = Path("lab.csv")


def test_choices_come_back_from_an_address() -> None:
    chosen = Choices(
        PATH,
        columns={"time": "1", "force": "none"},
        units={"time": "ms"},
        hints={"header_row": 3, "decimal": ","},
        negate={"force"},
        gauge_length_mm=12.5,
        drop_bad=True,
    )
    assert Choices.from_told(PATH, chosen.told()) == chosen


def test_where_nothing_was_chosen_the_address_says_nothing() -> None:
    assert Choices(PATH).told() == ""
    assert Choices.from_told(PATH, "") == Choices(PATH)


@pytest.mark.parametrize(
    "text",
    [
        "{",
        "[]",
        '{"path":"/etc/passwd"}',
        '{"columns":{"overwrite":"1"}}',
        '{"hints":{"json":1}}',
        '{"negate":["out"]}',
        '{"gauge_length_mm":"long"}',
        '{"columns":7}',
    ],
)
def test_an_address_that_asks_for_something_else_is_refused(text: str) -> None:
    with pytest.raises(UserError, match="the address"):
        Choices.from_told(PATH, text)

"""Fields for numbers: each takes a decimal comma, and says in words what is wrong with what was typed."""

from __future__ import annotations

from pathlib import Path

import testbench.studio


def test_every_field_for_a_number_takes_a_decimal_comma() -> None:
    room = Path(testbench.studio.__file__).parent
    bare = {path.relative_to(room).as_posix() for path in room.rglob("*.py") if "ui.number(" in path.read_text()}
    assert bare == {"parts/fields.py"}, "use its comma_taking_number or number_field instead"

"""Fields for numbers that are checked in place: what is wrong with one stands under it, in its own words."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from functools import partial
from pathlib import Path

from nicegui import ui
from nicegui.elements.mixins.value_element import ValueElement
from nicegui.events import ValueChangeEventArguments

from gcode.support.errors import UserError
from testbench.studio.parts.address import Address

Rules = dict[str, Callable[[float | None], bool]]  # what is said where a value does not keep a rule, and the rule

# Where a browser's language has no decimal comma, it drops the comma of 25,5 without a word.
COMMA_IS_A_POINT = """(e) => {
  if (e.key === ',') { e.preventDefault(); document.execCommand('insertText', false, '.'); }
}"""


def number_field(
    label: str,
    value: float | None,
    positive: bool = True,
    whole: bool = False,
    optional: bool = False,
    most: int | None = None,
) -> ui.number:
    """A field for a number, its unit in the label: ``"Duration / min"``.

    Parameters
    ----------
    positive : bool
        Only numbers above 0.
    whole : bool
        Only whole numbers from 0 on.
    optional : bool
        It may be left empty.
    most : int, optional
        Only whole numbers from 1 to this one.
    """
    name = label.partition(" / ")[0]
    name = name[0].lower() + name[1:]
    rules: Rules = {}
    if not optional:
        rules[f"Give the {name}."] = lambda value: value is not None
    if whole:
        rules[f"The {name} must be a whole number, 0 or more."] = lambda value: (
            value is None or (value >= 0 and value == int(value))
        )
    elif positive:
        rules[f"The {name} must be more than 0."] = lambda value: value is None or value > 0
    if most is not None:
        rules[f"Give a whole number from 1 to {most}."] = lambda value: (
            value is None or (1 <= value <= most and value == int(value))
        )
    field = comma_taking_number(label, value, rules)
    return field.props("bottom-slots").style("width:178px").without_auto_validation()


def comma_taking_number(
    label: str, value: float | None = None, rules: Rules | None = None, look: str | None = None
) -> ui.number:
    """A field for a number as every page has it: a decimal comma becomes a point; `look` is as in ``%.6g``."""
    field = ui.number(label, value=value, validation=rules, format=look)
    return field.on("keydown", js_handler=COMMA_IS_A_POINT)


def asked(where: Address, key: str, otherwise: float | None) -> float | None:
    """The number that an address asks for; `otherwise` where it asks for none.

    Raises
    ------
    UserError
        If it is no number.
    """
    text = where.query.get(key, "")
    if not text:
        return otherwise
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise UserError(f"the address asks for {key}={text!r}, which is no number")
    return int(value) if value == int(value) else value


def keep_in(where: Address, **fields: ValueElement) -> None:
    """Keep what is chosen in `fields` in the address, each under its name, so that a link shows the same choices."""

    def note(key: str, event: ValueChangeEventArguments) -> None:
        value = event.value
        where.note(**{key: "" if value is None else written(value) if isinstance(value, float) else str(value)})

    for key, field in fields.items():
        field.on_value_change(partial(note, key))


def check(*fields: ui.number) -> None:
    """Mark every field that is wrong.

    Raises
    ------
    UserError
        If one is; it repeats what stands under the first.
    """
    wrong = [field for field in fields if not field.validate()]
    if wrong:
        raise UserError(str(wrong[0].error))


def typed(field: ui.number) -> str:
    """The number as it was typed."""
    return written(field.value)


def typed_path(text: str | None, label: str, remedy: str) -> Path:
    """What stands in the field `label` for a file on this machine, as a shell would take it.

    Raises
    ------
    UserError
        If nothing does; it says the `remedy`.
    """
    if not text or not text.strip():
        raise UserError(f"“{label}” is empty: {remedy}")
    return Path(os.path.expanduser(text.strip()))


def written(value: float) -> str:
    """A number with all its digits."""
    return str(int(value)) if value == int(value) else repr(float(value))

"""How a file that is imported is written, and the column and unit of each quantity: found, and to be changed."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from functools import partial

from nicegui import events, ui

from testbench.importing.choice import Choice
from testbench.importing.sheet import Sheet
from testbench.importing.signs import SIGNED, TURNED
from testbench.studio.importing.import_form import NOT_THERE, Choices
from testbench.studio.importing.import_look import (
    DECIMALS,
    ENCODINGS,
    SEPARATORS,
    THOUSANDS,
    column_options,
    still_to_say,
    unit_key,
    unit_options,
)
from testbench.studio.importing.import_words import R0, TITLES, in_a_sentence, page_words
from testbench.studio.parts.fields import number_field


class Columns:
    """Fields that change the choices for one file.

    `look` is awaited where the file must be looked at once more, `note` called where what it holds stays the same.
    """

    def __init__(self, choices: Choices, look: Callable[[], Awaitable[None]], note: Callable[[], None]) -> None:
        self.choices, self.look, self.note = choices, look, note
        self._hint_fields: list[ui.number] = []
        self._role_fields: list[ui.number] = []  # built anew with each look at the file
        self.unfolded = False  # what was unfolded stays so when the file is looked at again

    def hints(self) -> None:
        """How the file is written, each to be changed."""
        with ui.row().classes("items-start gap-2"):
            for name, label in (("header_row", "Header row"), ("units_row", "Units row")):
                number = self.choices.hints.get(name)
                row = number_field(label, number if isinstance(number, int) else None, whole=True, optional=True)
                row.props("debounce=500 clearable")
                row.tooltip("counting from 1; 0: there is none; empty: found")
                row.on_value_change(partial(self._row_hinted, row, name))
                self._hint_fields.append(row)
            for name, label, options in (
                ("separator", "Separator", SEPARATORS),
                ("decimal", "Decimal sign", DECIMALS),
                ("thousands", "Thousands", THOUSANDS),
                ("encoding", "Encoding", ENCODINGS),
            ):
                hint = self.choices.hints.get(name)
                choice = ui.select(options, value=hint if hint in options else "", label=label)
                choice.style("width:140px")
                choice.on_value_change(partial(self._hinted, name))
            if self.choices.path.suffix.lower() in (".xlsx", ".xlsm", ".xls", ".tdms", ".html", ".json"):
                sheet = ui.input("Sheet", value=str(self.choices.hints.get("sheet") or ""))
                sheet.props("debounce=600").style("width:150px")
                sheet.on_value_change(partial(self._hinted, "sheet"))

    async def _row_hinted(self, field: ui.number, name: str, event: events.ValueChangeEventArguments) -> None:
        if field.validate():
            await self._hinted(name, event)

    async def _hinted(self, name: str, event: events.ValueChangeEventArguments) -> None:
        value = int(event.value) if isinstance(event.value, float) else event.value
        self.choices.hints[name] = None if value == "" else value
        self.choices.columns.clear()
        await self.look()

    def roles(self, sheet: Sheet, choice: Choice, words: dict[str, str]) -> None:
        """A row of fields for each quantity that is there or asked for; the others are folded away below."""
        self._role_fields.clear()
        asked = {one.role for one in choice.troubles} | set(choice.taken)
        if not {"displacement", "strain"} & set(choice.taken):
            asked |= {"displacement"}
        shown = [role for role in TITLES if role in asked or role in ("time", "force", "resistance")]
        for role in shown:
            self._role(role, sheet, choice, words)
        if "time" not in choice.taken:
            self._number("Sampling rate / Hz", "rate_hz")
        if {"relative", "relative_change"} & set(choice.taken):
            self._number(R0, "r0_ohm").style("width:230px")
        others = ui.expansion("Other quantities, and several clocks").bind_value(self, "unfolded")
        with others.classes("w-full").props("dense"):
            for role in TITLES:
                if role not in shown:
                    self._role(role, sheet, choice, words)
            self._clocks(sheet, choice)
        for note in choice.notes:
            ui.label(page_words(note)).classes("quiet")

    def _number(self, label: str, name: str) -> ui.number:
        """A field for a number that the file is read with."""
        field = number_field(label, getattr(self.choices, name), optional=True).props("debounce=500")
        field.on_value_change(partial(self._set, field, name))
        self._role_fields.append(field)
        return field

    async def _set(self, field: ui.number, name: str, event: events.ValueChangeEventArguments) -> None:
        if field.validate():
            setattr(self.choices, name, event.value)
            await self.look()

    @property
    def numbers(self) -> list[ui.number]:
        """The fields whose numbers are to be checked before the import."""
        return [*self._hint_fields, *self._role_fields]

    def _role(self, role: str, sheet: Sheet, choice: Choice, words: dict[str, str]) -> None:
        """One quantity: its column, its unit, and a value as it is read."""
        taken, title = choice.taken.get(role), TITLES[role]
        with ui.element("div").classes("role"):
            ui.label(title).style("font-weight:550")
            value = str(taken.column.number) if taken else NOT_THERE
            column = ui.select(column_options(sheet), value=value)
            column.props(f"aria-label='Column of {in_a_sentence(title)}'")
            column.on_value_change(partial(self._column_chosen, role))
            unit = ui.select(
                unit_options(role), value=unit_key(choice, role), label=f"Unit of {in_a_sentence(title)}"
            )
            unit.set_enabled(taken is not None)
            unit.on_value_change(partial(self._unit_chosen, role))
            with ui.row().classes("items-center gap-2"):
                wrong = still_to_say(choice, role)
                ui.label(wrong or words.get(role, "")).classes("wrong" if wrong else "")
                if role in TURNED and taken:
                    self._repairs(role)

    def _repairs(self, role: str) -> None:
        for label, marked in (
            ("Turn the sign", self.choices.negate),
            ("Count from the first sample", self.choices.zero),
        ):
            if marked is self.choices.zero and role not in SIGNED:
                continue

            def mark(event: events.ValueChangeEventArguments, marked: set[str] = marked) -> None:
                (marked.add if event.value else marked.discard)(role)
                self.note()

            box = ui.checkbox(label, value=role in marked, on_change=mark).props("dense")
            box.classes("text-sm").props(f"aria-label='{label} of the {role}'")

    async def _column_chosen(self, role: str, event: events.ValueChangeEventArguments) -> None:
        self.choices.set_column(role, event.value)
        await self.look()

    async def _unit_chosen(self, role: str, event: events.ValueChangeEventArguments) -> None:
        self.choices.units[role] = event.value
        await self.look()

    def _clocks(self, sheet: Sheet, choice: Choice) -> None:
        """Where channels have clocks of their own."""
        for role in ("displacement", "strain", "force", "resistance"):
            taken = choice.taken.get(role)
            if taken is None:
                continue
            value = str(taken.clock.number) if taken.clock else NOT_THERE
            options = column_options(sheet) | {NOT_THERE: "(those of time)"}
            clock = ui.select(options, value=value, label=f"Own times of {role}")
            clock.style("width:320px").on_value_change(partial(self._clock_chosen, role))

    async def _clock_chosen(self, role: str, event: events.ValueChangeEventArguments) -> None:
        self.choices.clocks.pop(role, None)
        if event.value != NOT_THERE:
            self.choices.clocks[role] = event.value
        await self.look()

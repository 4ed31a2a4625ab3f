"""The address of a page: what it shows is written in it, so that it can be kept, sent and gone back to."""

from __future__ import annotations

import math
from urllib.parse import urlencode

from nicegui import ui

from gcode.support.errors import UserError


def address(path: str, **query: str | None) -> str:
    """A deep link."""
    given = {key: value for key, value in query.items() if value}
    return f"{path}?{urlencode(given)}" if given else path


class Address:
    """The address of a page: every choice on it is kept there, so that it can be shared and gone back to."""

    def __init__(self, path: str, **query: str) -> None:
        self.path, self.query, self._page = path, dict(query), ui.context.client

    def note(self, **chosen: str) -> None:
        """Put what was chosen into the address, without leaving the page; the field it was chosen in may be gone."""
        self.query |= chosen
        with self._page:
            ui.navigate.history.replace(self.with_())

    def note_span(self, span: tuple[float | None, float | None]) -> None:
        """Keep the stretch of time that is looked at."""
        self.note(**dict(zip(("start", "end"), ("" if end is None else f"{end:.2f}" for end in span), strict=True)))

    def with_(self, **chosen: str) -> str:
        """The address with something else chosen."""
        return address(self.path, **(self.query | chosen))

    def go(self, **chosen: str) -> None:
        """Open it with something else chosen."""
        with self._page:
            ui.navigate.to(self.with_(**chosen))


def span_of(start: str, end: str) -> tuple[float | None, float | None]:
    """The stretch of time in an address.

    Raises
    ------
    UserError
        If it is no stretch.
    """
    if not start and not end:
        return None, None
    try:
        start_s, end_s = float(start), float(end)
    except ValueError:
        start_s = end_s = math.nan
    if not (math.isfinite(start_s) and math.isfinite(end_s)):
        raise UserError(f"the address asks for times from {start!r} to {end!r}; both must be seconds")
    if not start_s < end_s:
        raise UserError(
            f"the address asks for times from {start_s:g} to {end_s:g} s; the end must come after the start"
        )
    return start_s, end_s

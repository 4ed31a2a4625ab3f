"""What a handler raises is seen by the tests, though the page goes on as if nothing had been."""

from __future__ import annotations

import asyncio
import gc
import logging
import subprocess
import sys

import pytest
from nicegui import Client, ui
from nicegui.testing import User
from nicegui.testing.user_notify import UserNotify

from gcode.support.errors import UserError
from testbench.studio.parts.widgets import aside, attempt
from tests.testbench.studio.conftest import blame_the_handlers
from tests.testbench.studio.served import STDERR, blame_the_server


def test_a_traceback_of_a_server_fails_the_test(capsys: pytest.CaptureFixture[str]) -> None:
    subprocess.run([sys.executable, "-c", "1 / 0"], stderr=STDERR)
    with pytest.raises(AssertionError, match="ZeroDivisionError"):
        blame_the_server()
    assert "ZeroDivisionError" in capsys.readouterr().err
    subprocess.run([sys.executable, "-c", "import sys; sys.stderr.write('a word\\n')"], stderr=STDERR)
    blame_the_server()


@pytest.mark.asyncio
async def test_what_a_handler_raises_fails_the_test(user: User, caplog: pytest.LogCaptureFixture) -> None:
    client = await user.open("/effects")
    with client:
        ui.button("Press me", on_click=lambda: 1 / 0)
    user.find("Press me").click()
    records: list[logging.LogRecord] = caplog.get_records("call")
    with pytest.raises(AssertionError, match="ZeroDivisionError"):
        blame_the_handlers(records)
    caplog.clear()


@pytest.mark.asyncio
async def test_what_a_click_ends_with_is_said_where_its_button_is_gone(
    user: User, monkeypatch: pytest.MonkeyPatch
) -> None:
    said: list[tuple[Client, str]] = []
    # The simulated user's own would not ask, as the real one does, which page it is on.
    monkeypatch.setattr(UserNotify, "__call__", lambda _, text, **__: said.append((ui.context.client, text)))
    client = await user.open("/effects")
    with client:
        holder = ui.column()

    def redraw() -> None:
        holder.clear()
        gc.collect()
        raise UserError("said all the same")

    with holder, ui.row():
        ui.button("Press me", on_click=lambda: attempt(redraw))
    user.find("Press me").click()
    for _ in range(100):
        await asyncio.sleep(0)
    assert said == [(client, "said all the same")]


@pytest.mark.asyncio
async def test_what_a_page_that_was_left_waited_for_is_not_gone_on_with(user: User) -> None:
    with await user.open("/effects"):
        holder = ui.column()
    with holder, pytest.raises(asyncio.CancelledError):
        await aside(holder.delete)

"""Moving along the ladder: what is drawn is the step that was chosen last."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from types import SimpleNamespace

import pytest

from testbench.studio.pages.campaign import ladder

pytestmark = pytest.mark.asyncio


async def test_a_step_that_is_worked_out_slowly_does_not_take_the_place_of_a_later_choice(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    gate, shown, query = asyncio.Event(), [], {}

    async def aside(function: Callable, step: int) -> str:
        await gate.wait() if step == 0 else gate.set()
        return f"step {step}"

    monkeypatch.setattr(ladder, "aside", aside)
    monkeypatch.setattr(ladder.figures, "ladder", lambda steps, step: None)
    page = ladder._Ladder.__new__(ladder._Ladder)
    page.steps, page.where = [None] * 2, SimpleNamespace(query=query)
    page.where.note = lambda **chosen: query.update(chosen)
    page.ladder, page.glance = SimpleNamespace(show=lambda _: None), SimpleNamespace(show=shown.append)
    monkeypatch.setattr(page, "_tell", lambda step: None)
    await asyncio.gather(page._go(0), page._go(1))
    assert shown == ["step 1"]

"""The forms of each hidden effect; the files beside this one register theirs here."""

from __future__ import annotations

from collections.abc import Callable

from testbench.worlds.chain import Change, Form

FORMS: dict[str, dict[str, Form]] = {}
UNKNOWN: set[str] = set()


def form(
    effect: str, name: str, stage: str, most: float, *, unknown: bool = False, **ranges: tuple[float, float] | list
) -> Callable[[Change], Change]:
    """Register a function as one form of `effect` at `stage`; called again under one name, it adds a stage."""

    def register(change: Change) -> Change:
        known = FORMS.setdefault(effect, {})
        before = known.get(name)
        changes = {**(before.changes if before else {}), stage: change}
        known[name] = Form(effect, name, changes, {**(before.ranges if before else {}), **ranges}, most)
        if unknown:
            UNKNOWN.add(effect)
        return change

    return register

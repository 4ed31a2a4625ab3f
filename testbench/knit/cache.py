"""A cache of simulated signals: when a parameter changes, only what depends on it is computed again."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from testbench.knit.additive import AdditiveLaw
from testbench.knit.effect import Effect, FloatArray, Signals


@dataclass(frozen=True, eq=False)
class Change:
    """What a law made of the signals that it looked at; None is a signal that was not there."""

    law: AdditiveLaw
    values: FloatArray
    seen: Mapping[str, FloatArray | None]

    def holds(self, law: AdditiveLaw, state: Signals) -> bool:
        return all(state.get(name) is values for name, values in self.seen.items()) and _same(law, self.law)


class SimulationCache:
    """Signals after each effect of the last run over the same inputs, and what each law added to them."""

    def __init__(self) -> None:
        self._effects: list[Effect] = []
        self._states: list[dict[str, FloatArray]] = []
        self._inputs: Signals | None = None
        self._changes: dict[str, Change] = {}

    def resume(
        self, effects: Mapping[str, Effect], inputs: Signals
    ) -> tuple[dict[str, FloatArray], dict[str, Effect]]:
        """State to start from, and the effects that are still to be applied."""
        items = list(effects.items())
        if inputs is not self._inputs:
            self._inputs, self._effects, self._states = inputs, [], []
        same = 0
        while same < min(len(items), len(self._effects)) and _same(items[same][1], self._effects[same]):
            same += 1
        del self._effects[same:], self._states[same:]
        state = dict(self._states[-1]) if same else dict(inputs)
        return state, dict(items[same:])

    def applied(self, name: str, effect: AdditiveLaw, state: Signals, dt_s: float) -> Signals:
        """What the law writes; its change is made again only where it, or a signal that it looked at, has changed."""
        known = self._changes.get(name)
        if known is None or not known.holds(effect, state):
            watched = _Watched(state)
            known = self._changes[name] = Change(effect, effect.change(watched, dt_s), watched.seen)
        return effect.put(state, known.values)

    def states(self) -> list[Signals]:
        """Signals after each effect of the last run."""
        return list(self._states)

    def changes(self) -> dict[str, Change]:
        """What each additive law of the last run made of the signals that it looked at, by its name in the model."""
        return dict(self._changes)

    def keep(self, effect: Effect, state: dict[str, FloatArray]) -> None:
        """Remember the signals after `effect`."""
        self._effects.append(effect)
        self._states.append(dict(state))


class _Watched(Mapping[str, FloatArray]):
    """Signals that note which of them were looked at."""

    def __init__(self, state: Signals) -> None:
        self.state = state
        self.seen: dict[str, FloatArray | None] = {}

    def __getitem__(self, name: str) -> FloatArray:
        self.seen[name] = self.state.get(name)
        return self.state[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.state)

    def __len__(self) -> int:
        return len(self.state)


def _same(one: Effect, other: Effect) -> bool:
    return one is other or one == other

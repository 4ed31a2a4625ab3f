"""How a small change of a signal anywhere in the chain of a model passes on to its readings.

Most laws have no memory: what they write at a moment depends on what they read at that moment alone, and one more run
of the law gives the slope at every moment. The slopes of one law after the other multiply, from the last law
backwards (reverse accumulation; Griewank & Walther, Evaluating Derivatives (2008), ch. 3). A law that remembers has
no such slope: a change that reaches it must be simulated up to there.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from itertools import islice

import numpy as np

from testbench.knit.additive import AdditiveLaw
from testbench.knit.cache import Change, SimulationCache
from testbench.knit.effect import Effect, FloatArray, Signals
from testbench.knit.filters import log_ratio, shifted
from testbench.knit.model import KnitModel, signals_for
from testbench.knit.readout.reading_age import ReadingAge
from testbench.measurements.measurement import Measurement
from testbench.measurements.responses import SIGNAL_OF

GIVEN = frozenset({"time_s", "strain_nominal", "temperature_C"})  # no law writes these
SMALL = 1e-4  # of the range of a signal: the change that tells a slope


@dataclass(frozen=True, eq=False)
class Answers:
    """How the readings answer to a small change of the signals behind one law.

    Attributes
    ----------
    count : int
        Samples of a signal, n.
    slopes : mapping of channel to (mapping of signal to ndarray, shape (n,))
        Change of the reading over that of each signal, before the instruments read it; conductances in ln S.
    instruments : mapping of channel to callable
        What changes, shape (m, n), are read as; a channel without one is read as it is.
    remembered : mapping of signal to int
        The last law that remembers how this signal was, of those that its change reaches.
    """

    count: int
    slopes: Mapping[str, Mapping[str, FloatArray]]
    instruments: Mapping[str, Callable[[FloatArray], FloatArray]] = field(default_factory=dict)
    remembered: Mapping[str, int] = field(default_factory=dict)

    def to(self, change: Signals) -> dict[str, FloatArray]:
        """Changes of each reading, shape (m, n), for some of the signals: force in N, conductances in ln S."""
        return {channel: self._read(channel, change) for channel in self.slopes}

    def _read(self, channel: str, change: Signals) -> FloatArray:
        slopes = self.slopes[channel]
        whole = [values * slopes[signal] for signal, values in change.items() if signal in slopes]
        if not whole:
            return np.zeros((1, self.count))
        return self.instruments.get(channel, _as_it_is)(sum(whole[1:], whole[0]))


class Chain:
    """The laws of a model in their order, the signals behind each, and how the readings answer to changes of those.

    Parameters
    ----------
    model : KnitModel
    measurement : Measurement
    cache : SimulationCache
        Of the last run, which was of this model over this measurement.
    """

    def __init__(self, model: KnitModel, measurement: Measurement, cache: SimulationCache) -> None:
        self.dt_s, self.added = measurement.dt_s, cache.changes()
        self.laws, self.behind = list(model.effects.items()), cache.states()
        self.before = [
            signals_for(law, state)
            for (_, law), state in zip(self.laws, (measurement.signals, *self.behind), strict=False)
        ]
        self.number = {name: number for number, name in enumerate(model)}
        ones = np.ones(len(measurement.signals["time_s"]))
        ends = {channel: {SIGNAL_OF[channel]: ones} for channel in measurement.channels}
        self._answers = [Answers(len(ones), ends)]  # behind the last law, the one before it, ...

    def answers_behind(self, number: int) -> Answers:
        """How the readings answer to a change of the signals behind this law."""
        while len(self.laws) - len(self._answers) > number:
            self._answers.append(self._before(len(self.laws) - len(self._answers)))
        return self._answers[len(self.laws) - 1 - number]

    def until(self, number: int) -> int:
        """The law up to which a change of this one must be simulated: beyond it nothing remembers what was."""
        remembered = self.answers_behind(number).remembered
        return max([number, *(remembered.get(signal, number) for signal in self.laws[number][1].writes)])

    def terms(self, number: int, parameter: str) -> FloatArray | None:
        """What each weight of a vector adds to what this law writes, shape (k, n), where it is linear in them."""
        law = self.laws[number][1]
        return law.terms(parameter, self.before[number]) if isinstance(law, AdditiveLaw) else None

    def head(self, number: int) -> KnitModel:
        """The model up to this law."""
        return KnitModel(dict(islice(self.laws, number + 1)))

    def _before(self, number: int) -> Answers:
        """How the readings answer to a change of the signals that this law reads."""
        then, (name, law) = self.answers_behind(number), self.laws[number]
        before = self.before[number]
        if isinstance(law, ReadingAge) and _is_last(law, then):
            return self._instrument(law, then, number)
        slopes = {c: {s: x for s, x in own.items() if s not in law.writes} for c, own in then.slopes.items()}
        remembered = {s: last for s, last in then.remembered.items() if s not in law.writes}
        reached = max((then.remembered.get(signal, -1) for signal in law.writes), default=-1)
        passing, remembering = _looks(law, self.added.get(name), before)
        for signal in passing:
            if reached >= 0:
                remembered[signal] = max(remembered.get(signal, -1), reached)
            elif signal not in remembered:  # else its changes are simulated to beyond this law
                self._pass_back(number, signal, then, slopes)
        for signal in remembering:
            remembered[signal] = max(remembered.get(signal, -1), reached, number)
        return _as_one(replace(then, slopes=slopes, remembered=remembered), self._state(number), before)

    def _state(self, number: int) -> Signals:
        """What there is before anything is made ready for this law."""
        return self.behind[number - 1] if number else {}

    def _pass_back(self, number: int, signal: str, then: Answers, slopes: dict[str, dict[str, FloatArray]]) -> None:
        """Add to the slopes before a law what a signal changes through it."""
        name, law = self.laws[number]
        added, (moved, step) = self.added.get(name), _moved(self.before[number], signal)
        if added is not None and signal not in added.seen:
            there = added.law.put(moved, added.values)
        else:
            there = law.apply(moved, self.dt_s)
        for written in law.writes:
            slope = change_of(written, there, self.behind[number]) / step
            for channel, own in then.slopes.items():
                if written in own:
                    slopes[channel][signal] = slopes[channel].get(signal, 0.0) + own[written] * slope

    def _instrument(self, law: ReadingAge, then: Answers, number: int) -> Answers:
        """An instrument reads a change as it reads the whole; what comes behind it follows."""
        (signal,), time_s = law.writes, self.before[number]["time_s"]
        (channel,) = (c for c, own in then.slopes.items() if signal in own)
        later = then.instruments.get(channel, _as_it_is)
        slope = then.slopes[channel][signal]

        def instrument(change: FloatArray) -> FloatArray:
            return later(slope * law.read(change, time_s))

        slopes = {**then.slopes, channel: {signal: np.ones(then.count)}}
        return replace(then, slopes=slopes, instruments={**then.instruments, channel: instrument})


def _as_it_is(change: FloatArray) -> FloatArray:
    return change


def change_of(signal: str, there: Signals, here: Signals) -> FloatArray:
    """Change of a signal from `here` to `there`, shape (n,); of the conductance, in ln S."""
    if signal == "conductance_S":
        return log_ratio(there[signal], here[signal])
    return there[signal] - here[signal]


def _moved(state: Signals, signal: str) -> tuple[Signals, float]:
    """Signals of which one is a little larger everywhere, and by how much; the conductance in ln S."""
    values = state[signal]
    if signal == "conductance_S":
        return {**state, signal: shifted(values, np.full_like(values, SMALL))}, SMALL
    step = SMALL * max(float(np.ptp(values)), 1e-3 * float(np.max(np.abs(values))), 1e-12)
    return {**state, signal: values + step}, step


def _is_last(law: ReadingAge, then: Answers) -> bool:
    """Whether what the instrument reads reaches one channel only, and nothing else does."""
    (signal,) = law.writes
    reached = [own for own in then.slopes.values() if signal in own]
    return len(reached) == 1 and len(reached[0]) == 1 and signal not in then.remembered


def _looks(law: Effect, added: Change | None, before: Signals) -> tuple[set[str], set[str]]:
    """Signals that pass through a law moment by moment, and those that it remembers.

    An additive law looks at less than it reads: to what it writes it only adds.
    """
    read = {*law.reads, *law.optional_reads} if added is None else set(added.seen)
    read = read & set(before) - GIVEN
    only_added = set() if added is None else set(law.writes) - read
    return only_added | (read & set(law.pointwise)), read - set(law.pointwise)


def _as_one(answers: Answers, state: Signals, ready: Signals) -> Answers:
    """Where no law makes a contact force of its own, a change of it is a change of the force."""
    if "contact_force_N" in state or "contact_force_N" not in ready:
        return answers
    slopes, remembered = {}, dict(answers.remembered)
    for channel, own in answers.slopes.items():
        slopes[channel] = dict(own)
        pressing = slopes[channel].pop("contact_force_N", None)
        if pressing is not None:
            slopes[channel]["force_N"] = slopes[channel].get("force_N", 0.0) + pressing
    pressing_until = remembered.pop("contact_force_N", -1)
    if pressing_until >= 0:
        remembered["force_N"] = max(remembered.get("force_N", -1), pressing_until)
    return replace(answers, slopes=slopes, remembered=remembered)

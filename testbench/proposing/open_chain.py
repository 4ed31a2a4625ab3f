"""The chain of a fitted model, opened after each stage: what a law would read there, and what it would change."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from testbench.knit.effect import FloatArray, Signals, Stage
from testbench.knit.model import KnitModel
from testbench.knit.rules import READABLE
from testbench.measurements.measurement import Measurement, channel_of
from testbench.measurements.responses import CONDUCTANCE_CHANNEL, FORCE_CHANNEL, SIGNAL_OF
from testbench.proposing.laws.places import PLACES, Place

STEP = 1e-3  # of the range of a signal, to find how the channels follow it


class OpenChain:
    """Signals after each stage of a model, and the slope of each channel with the signal that a place changes."""

    def __init__(self, model: KnitModel, measurement: Measurement) -> None:
        self.model, self.measurement = model, measurement
        self.after: dict[Stage, dict[str, FloatArray]] = {}
        state = dict(measurement.signals)
        for stage in Stage:
            if stage >= Stage.PRESSURE and "contact_force_N" not in state and "force_N" in state:
                state["contact_force_N"] = state["force_N"]
            part = KnitModel({name: e for name, e in model.effects.items() if e.stage == stage})
            state = part.simulate(state, measurement.dt_s)
            self.after[stage] = dict(state)

    def readable(self, place: Place) -> dict[str, FloatArray]:
        """Signals that a law at this place can read, as they are at the end of its stage."""
        state = self.after[place.stage]
        names = READABLE[place.stage] - {"strain_nominal"} | {"temperature_C"}
        return {name: values for name, values in state.items() if name in names}

    @cached_property
    def places(self) -> tuple[Place, ...]:
        """Places whose signal is there and reaches a channel that was measured."""
        return tuple(p for p in PLACES.values() if p.writes in self.after[p.stage] and self.slopes(p))

    def slopes(self, place: Place) -> dict[str, FloatArray]:
        """Change of each measured channel with what the place changes, by channel, each shape (n,).

        A strain or a force that shifts slowly carries friction with it: the slope is that of a lasting shift.
        """
        measured = self.measurement.channels
        if place.stage >= Stage.CONTACT:
            own = FORCE_CHANNEL if place.writes == SIGNAL_OF[FORCE_CHANNEL] else CONDUCTANCE_CHANNEL
            return {own: self._by_way(place)} if own in measured else {}
        state = self.after[place.stage]
        values = state[place.writes]
        step = STEP * max(float(np.ptp(values)), 1e-9)
        moved = self.downstream(place.stage, {**state, place.writes: values + step})
        still = self.downstream(place.stage, state)
        by = values / step if place.way == "share" else 1 / step
        slopes = {c: (channel_of(moved, c) - channel_of(still, c)) * by for c in measured}
        return {c: slope for c, slope in slopes.items() if np.any(np.abs(slope) > 1e-9)}

    def _by_way(self, place: Place) -> FloatArray:
        """Change of a reading, in N or ln S, with what is changed behind the contacts, shape (n,)."""
        values = self.after[place.stage][place.writes]
        ratio = values / values[0] if place.way != "amount" else np.ones_like(values)
        return 1 / ratio if place.way == "beside" else -ratio if place.way == "in series" else ratio

    def downstream(self, stage: Stage, state: Signals) -> dict[str, FloatArray]:
        """The rest of the chain after a stage."""
        rest = KnitModel({name: e for name, e in self.model.effects.items() if e.stage > stage})
        early = {k: v for k, v in state.items() if k != "contact_force_N" or stage >= Stage.PRESSURE}
        return rest.simulate(early, self.measurement.dt_s)

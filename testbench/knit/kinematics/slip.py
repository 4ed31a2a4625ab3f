"""The knit slips out of its clamps: in jumps, or sliding.

A set of the knit is smooth; what jumps is the clamp.
"""

from __future__ import annotations

import itertools

import numpy as np

from testbench.knit.effect import FloatArray, Points, Signals, Vector, parameter, step_s
from testbench.knit.kinematics.length import Lengthening, overload_s

MOST_SLIPS = 12
NEVER_S = 1e5


class ClampSlipLaw(Lengthening):
    """Base of the laws of slip in the clamps.

    Where the knit was clamped anew it has not slipped yet: what it had is in the new zero of the displacement.
    """

    mechanism = "clamp_slip"
    strength = "amount"
    optional_reads = ("clamping",)

    def slipped(self, signals: Signals, dt_s: float) -> FloatArray:
        """Length slipped so far in one clamping, as strain, shape (n,)."""
        raise NotImplementedError

    def added(self, signals: Signals, dt_s: float) -> FloatArray:
        """Of all clampings in turn, shape (n,)."""
        clamping = signals.get("clamping", np.zeros(len(signals["strain"])))
        begins = np.flatnonzero(np.diff(clamping, prepend=np.nan))
        parts = [slice(begin, end) for begin, end in itertools.pairwise((*begins, len(clamping)))]
        first, *others = [self.slipped({name: signals[name][part] for name in self.reads}, dt_s) for part in parts]
        return np.concatenate([first, *(one - one[0] for one in others)])


class ClampSlip(ClampSlipLaw):
    """The fabric jumps a little out of the clamp whenever the stretch reaches a new level beyond the grip's limit.

    e -= fraction * step * floor((e_max - limit) / step + 1)        for e_max >= limit

    Source: ISO 13934-1:2013 (strip method) warns of slippage in the jaws; the staircase is the simplest law.
    Valid: a few discrete slips; jumps, where `permanent_set` is smooth.
    """

    name = "clamp_slip"
    strength = "fraction"
    jumps = ("limit", "step")
    look = "force drops in a jump at a new largest stretch and stays lower at every strain"

    fraction: float = parameter(0.3, unit="1", low=0, high=0.9, doc="slip per step of strain beyond the limit")
    limit: float = parameter(0.2, unit="1", low=0.01, high=2, scale="log", doc="strain that the grip just holds")
    step: float = parameter(0.04, unit="1", low=0.005, high=0.5, scale="log", doc="strain between two slips")

    def slipped(self, signals: Signals, dt_s: float) -> FloatArray:
        steps = np.floor((np.maximum.accumulate(signals["strain"]) - self.limit) / self.step + 1)
        slips = np.maximum(steps, 0.0)
        return self.fraction * self.step * (slips - slips[0])

    def starts(self, signals: Signals, residual: Signals) -> Points:
        top = float(np.max(signals["strain"]))
        return [
            {"limit": limit * top, "step": step * top}
            for limit, step in itertools.product((0.25, 0.35, 0.45, 0.55, 0.65, 0.75), (0.06, 0.09, 0.13, 0.19, 0.27))
        ]


class ClampSlipRepeated(ClampSlipLaw):
    """Each time the stretch passes the grip's limit, the fabric slips by the same amount.

    e -= amount * (number of times e has risen through `limit`)

    Source: as `clamp_slip`.
    Valid: few passes; a new one counts after the strain has been 0.02 below the limit, or at half a smaller limit.
    """

    name = "clamp_slip_repeated"
    nonlinear = True
    jumps = ("limit",)
    look = "every high stretch costs a little force, in jumps, for ever"

    amount: float = parameter(0.002, unit="1", low=0, high=0.5, doc="slip per pass, as strain")
    limit: float = parameter(0.2, unit="1", low=0.01, high=2, scale="log", doc="strain that the grip just holds")

    def slipped(self, signals: Signals, dt_s: float) -> FloatArray:
        from testbench.knit.kernels import crossings

        return self.amount * crossings(signals["strain"], self.limit, max(self.limit - 0.02, 0.5 * self.limit))

    def starts(self, signals: Signals, residual: Signals) -> Points:
        top = float(np.max(signals["strain"]))
        return [{"limit": share * top} for share in (0.4, 0.6, 0.75, 0.9)]


class ClampSlipOnce(ClampSlipLaw):
    """One slip at one moment.

    e -= amount        from `when_s` on

    Source: as `clamp_slip`.
    Valid: a single event.
    """

    name = "clamp_slip_once"
    nonlinear = True
    jumps = ("when_s",)
    reads = ("time_s", "strain")
    look = "from one moment on everything looks as if the knit were a little longer"

    amount: float = parameter(0.01, unit="1", low=0, high=0.5, doc="slip, as strain")
    when_s: float = parameter(35.0, unit="s", low=0.1, high=1e5, scale="log", doc="moment of the slip")

    def slipped(self, signals: Signals, dt_s: float) -> FloatArray:
        return self.amount * (signals["time_s"] >= self.when_s)

    def starts(self, signals: Signals, residual: Signals) -> Points:
        """The largest slips that the misfit shows, or a few moments of the recording."""
        from testbench.knit.kinematics.jumps import slips

        end_s = float(signals["time_s"][-1])
        found = slips(signals, residual)[:2]
        moments_s = [{"when_s": share * end_s} for share in (0.2, 0.4, 0.6, 0.8)]
        return [{"when_s": when_s, "amount": amount} for when_s, amount in found] or moments_s


class ClampSlipSliding(ClampSlipLaw):
    """Above the grip's limit the fabric slides slowly through the jaws, until it has bedded in.

    e -= amount * (1 - (1 + w / (order work))^-order),   w = integral of (e - limit)+ dt

    A large `order` beds in exponentially, 1 as w / (work + w), a small one hardly ever comes to an end.

    Source: as `clamp_slip`; friction that gives way at a rate that grows with the overload is the simplest law.
    Valid: no return of the fabric.
    """

    name = "clamp_slip_sliding"
    look = "time spent at high stretch costs force at every strain; time spent at low stretch costs nothing"

    amount: float = parameter(0.02, unit="1", low=0, high=0.5, doc="slip in the end, as strain")
    limit: float = parameter(0.2, unit="1", low=0.01, high=2, scale="log", doc="strain that the grip just holds")
    work_s: float = parameter(5.0, unit="s", low=1e-3, high=1e4, scale="log", doc="strain times s that count as one")
    order: float = parameter(20.0, unit="1", low=0.3, high=20, scale="log", doc="how suddenly the sliding ends")

    def slipped(self, signals: Signals, dt_s: float) -> FloatArray:
        slid = overload_s(signals["strain"], self.limit, dt_s)
        return self.amount * (1 - (1 + slid / (self.order * self.work_s)) ** -self.order)

    def starts(self, signals: Signals, residual: Signals) -> Points:
        points = []
        for share in (0.5, 0.65, 0.8):
            limit = max(share * float(np.max(signals["strain"])), 0.01)
            total_s = float(overload_s(signals["strain"], limit, step_s(signals))[-1])
            points += [{"limit": limit, "work_s": part * total_s, "order": 2.0} for part in (0.1, 0.4, 2.0)]
        return points


class ClampSlipEvents(ClampSlipLaw):
    """Slips at moments of their own in every recording.

    e -= sum of amounts_j        over the slips j with time_j <= t

    The moments are looked for in the data: jumps of the misfit within a fraction of a second, while the knit is
    being stretched (`testbench.knit.kinematics.jumps`).

    Source: as `clamp_slip`.
    Valid: at most twelve slips that count.
    """

    name = "clamp_slip_events"
    reads = ("time_s", "strain")
    strength = "amounts"
    jumps = ("slip_times_s",)
    per_recording = ("amounts", "slip_times_s")
    look = "the misfit jumps within a fraction of a second, several times, and stays"

    amounts: Vector = parameter((0.0,) * MOST_SLIPS, unit="1", low=0, high=0.5, doc="slips, as strain")
    slip_times_s: Vector = parameter(
        tuple(3.0 * (k + 1) for k in range(MOST_SLIPS)), unit="s", low=0, high=NEVER_S, doc="their moments"
    )

    def slipped(self, signals: Signals, dt_s: float) -> FloatArray:
        return np.array(self.amounts) @ (signals["time_s"] >= np.array(self.slip_times_s)[:, None])

    def starts(self, signals: Signals, residual: Signals) -> Points:
        from testbench.knit.kinematics.jumps import slips

        found = slips(signals, residual)[:MOST_SLIPS]
        times_s, amounts = zip(*found, *[(NEVER_S, 0.0)] * (MOST_SLIPS - len(found)), strict=True)
        return [{"slip_times_s": times_s, "amounts": amounts}]

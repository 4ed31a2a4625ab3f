"""What a law makes of its coordinate: memories, bends and factors."""

from __future__ import annotations

from functools import partial
from typing import Any

from testbench.proposing.laws.law_parts import DIRECTION, FORCE, LN_G, PRESSING, STRAIN, TIME, Operator, Slot, named
from testbench.proposing.laws.units import NEWTON, ONE, SECOND

_TAU = Slot("tau_s", r"\tau", "time of the memory")
_RELAXES = (r"\tau\,\dot y = {x} - y",)
_DELAY = Slot("delay_s", r"\delta", "delay", "delay")
_REACH = Slot("reach", "r", "reach of the slip element", "size")
_EDGE = Slot("edge_x", "x_1", "threshold", "level")
_BELL = Slot("bell", "b", "width of the bell", "size")


def _operator(kind: str, name: str, code: str, latex: str, words: str, *slots: Slot, **more: Any) -> Operator:
    return Operator(name, code, latex, words, kind, slots, **more)


_memory, _factor = partial(_operator, "memory"), partial(_operator, "factor")
_bend = partial(_operator, "bend", unit=ONE)  # what comes out of most is a plain number

OPERATORS = named(
    _memory("lag", "lowpass(x, self.tau_s, dt_s)", "y", "the memory of {x}", _TAU, definitions=_RELAXES),
    _memory(
        "sudden", "highpass(x, self.tau_s, dt_s)", r"({x} - y)", "what is sudden in {x}", _TAU, definitions=_RELAXES
    ),
    _memory(
        "broad lag",
        "broad_memory(x, self.tau_s, self.decades, dt_s)",
        "y",
        "the memory over decades of time of {x}",
        Slot("tau_s", r"\tau", "middle time of the memory"),
        Slot("decades", "D", "decades over which its times are spread", "number", 0.3, 5.0),
        definitions=(
            r"y = \text{mean of all } y_k",
            r"\tau_k\,\dot y_k = {x} - y_k",
            r"\tau_k \text{ spread over } D \text{ decades around } \tau",
        ),
    ),
    _memory(
        "two-way lag",
        "two_way_lag(x, self.tau_s, self.back_s, dt_s)",
        "y",
        "the memory, with a time of its own for each way, of {x}",
        Slot("tau_s", r"\tau", "time of the memory on the way up"),
        Slot("back_s", r"\tau_b", "time of the memory on the way back"),
        definitions=(
            r"\tau\,\dot y = {x} - y \text{ while } {x} > y",
            r"\tau_b\,\dot y = {x} - y \text{ while } {x} < y",
        ),
    ),
    _memory(
        "slip",
        "stop(x, self.reach)",
        "h",
        "the slip element over {x}",
        _REACH,
        definitions=(r"h = {x} - \text{play}_r({x})",),
    ),
    _memory(
        "relaxing slip",
        "relaxing_stop(x, self.reach, self.tau_s, dt_s)",
        "h",
        "the slip element that relaxes over {x}",
        _REACH,
        _TAU,
        definitions=(r"\dot h = {x}' - \frac{h}{\tau} \text{ within } \pm r",),
    ),
    _memory(
        "loop",
        "heading(x, 50.0 * self.reach)",  # that turns over within a fiftieth of its span
        "h",
        "the rounded loop over {x}",
        Slot("reach", "r", "travel in which it turns over", "size"),
        definitions=(r"\frac{dh}{d{x}} = \frac{1 - \frac{|h| + h\,\mathrm{sgn}\,{x}'}{2}}{r} \text{ (Bouc-Wen)}",),
        unit=ONE,
    ),
    _memory(
        "ring",
        "oscillator(x, self.ring_hz, self.damping, dt_s) - x",
        r"(y - {x})",
        "the ringing of {x}",
        Slot("ring_hz", "f", "frequency of the ringing", "frequency"),
        Slot("damping", r"\zeta", "its damping", "number", 0.005, 0.9),
        definitions=(r"\ddot y + 4\pi\zeta f\,\dot y + (2\pi f)^2 (y - {x}) = 0",),
    ),
    _memory("late", "delayed(x, self.delay_s, dt_s) - x", r"({x}(t - \delta) - {x}(t))", "the delay of {x}", _DELAY),
    _memory("echo", "delayed(x, self.delay_s, dt_s)", r"{x}(t - \delta)", "the echo of {x}", _DELAY),
    _memory(
        "clock",
        "ever_later(x, self.skew) - x",
        r"({x}(t - \kappa\,t) - {x}(t))",
        "the wrong clock of {x}",
        Slot("skew", r"\kappa", "share by which the clock is slow; negative: fast", "skew"),
    ),
    _memory(
        "slow",
        "no_quicker(x, self.quickest, dt_s) - x",
        r"(y - {x})",
        "what lags of {x} where it is too quick",
        Slot("quickest", "v", "rate that is not exceeded", "rate"),
        definitions=(r"\dot y = {x}' \text{ or, until it has caught up, } \pm v",),
    ),
    _memory(
        "dead band",
        "held(x, self.band) - x",
        r"(y - {x})",
        "the dead band of {x}",
        Slot("band", "b", "half width of the dead band", "size", jumps=True),
        definitions=(r"y = {x} \text{ held within} \pm b",),
    ),
    _memory(
        "stick",
        "stuck(x, self.grip)",
        "h",
        "{x} since it last stuck",
        Slot("grip", "g", "how far it sticks", "size", jumps=True),
        definitions=(r"h = {x} \text{ since it last let go, at } g",),
    ),
    _bend("size", "np.abs(x)", r"|{x}|", "the size of {x}", unit=None),
    _bend("square", "x * x", r"({x})^2", "the square of {x}", unit=None, squares=True),
    _bend(
        "power",
        "power_of(x / {size}, self.power)",
        r"\left({x} / x_0\right)^{p}",
        "a power of {x}",
        Slot("power", "p", "exponent", "number", 0.2, 5.0),
    ),
    _bend("log", "np.log(np.maximum(x, 1e-4))", r"\ln {x}", "the logarithm of {x}"),
    _bend("threshold", "over(x, self.edge_x)", r"({x} - x_1)^+", "{x} beyond a threshold", _EDGE, unit=None),
    _bend("below", "over(self.edge_x - x, 0.0)", r"(x_1 - {x})^+", "{x} below a threshold", _EDGE, unit=None),
    _bend(
        "saturation",
        "np.tanh(x / self.scale)",
        r"\tanh\frac{{x}}{x_s}",
        "{x}, which saturates",
        Slot("scale", "x_s", "where it saturates", "size"),
    ),
    _bend(
        "settling",
        "-np.expm1(-np.maximum(x, 0.0) / self.scale)",
        r"\left(1 - e^{-{x}/x_s}\right)",
        "{x}, which settles",
        Slot("scale", "x_s", "in which it settles", "size"),
        only_positive=True,
    ),
    _bend(
        "logarithm",
        "np.log1p(np.maximum(x, 0.0) / self.scale)",
        r"\ln\left(1 + \frac{{x}}{x_s}\right)",
        "the logarithm of {x}",
        Slot("scale", "x_s", "where it sets in", "size"),
        only_positive=True,
    ),
    _bend(
        "bell",
        "bump(x, 0.0, self.bell)",
        r"\exp\left(-\frac{({x})^2}{2 b^2}\right)",
        "a bell around zero of {x}",
        _BELL,
    ),
    _bend(
        "bell at",
        "bump(x, self.centre, self.bell)",
        r"\exp\left(-\frac{({x} - c)^2}{2 b^2}\right)",
        "a bell over {x}",
        Slot("centre", "c", "centre of the bell", "level"),
        _BELL,
    ),
    _bend(
        "switch",
        "relay(x, self.on, self.on - self.gap)",
        r"\sigma({x})",
        "a switch over {x}",
        Slot("on", "x_1", "where it switches on", "level", jumps=True),
        Slot("gap", r"\Delta", "how far below that it switches off", "size", jumps=True),
        definitions=(r"\sigma = 1 \text{ from } x_1 \text{ upwards until } x_1 - \Delta",),
    ),
    _bend(
        "wave",
        "np.sin(2 * np.pi * x / self.period + self.phase)",
        r"\sin\left(\frac{2\pi {x}}{\lambda} + \varphi\right)",
        "a wave over {x}",
        Slot("period", r"\lambda", "period of the wave", "size"),
        Slot("phase", r"\varphi", "its phase", "angle"),
    ),
    _factor("times strain", "x * e", r"{x}\,e", "{x} times the strain", reads=STRAIN),
    _factor("times force", "x * F", r"{x}\,F", "{x} times the force", reads=FORCE, times=NEWTON),
    _factor("times contact force", "x * P", r"{x}\,P", "{x} times the contact force", reads=PRESSING, times=NEWTON),
    _factor("times conductance", "x * ln_g", r"{x}\,\ln\frac{G}{G_0}", "{x} times the change of ln G", reads=LN_G),
    _factor(
        "times direction",
        "x * heading(e, {span})",
        r"{x}\,d",
        "{x}, with the sign of the motion",
        definitions=DIRECTION,
        reads=STRAIN,
    ),
    _factor(
        "times friction",
        "x * heading(e, 50.0 * self.turn)",
        r"{x}\,d",
        "{x}, with the sign of the motion as a friction has it",
        Slot("turn", "l_d", "travel in which the sign turns over", "swing"),
        definitions=(*DIRECTION, r"d \text{ turns over within } l_d"),
        reads=STRAIN,
    ),
    _factor(
        "while stretching",
        "x * 0.5 * (1.0 + heading(e, {span}))",
        r"{x}\,\frac{1 + d}{2}",
        "{x} while stretching",
        definitions=DIRECTION,
        reads=STRAIN,
    ),
    _factor("growing", "x * t", r"{x}\,t", "{x}, which grows with time", reads=TIME, times=SECOND),
    _factor(
        "fading",
        "x * np.exp(-t / self.fade_s)",
        r"{x}\,e^{-t/\tau_f}",
        "{x}, which fades with time",
        Slot("fade_s", r"\tau_f", "time in which it fades"),
        reads=TIME,
    ),
)

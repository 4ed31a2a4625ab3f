"""The library that laws are made of: coordinates, memories and bends, each with its code, its formula and its words.

A law's changing part z is a *coordinate* (what the knit does or has gone through) followed by *operators* (a memory,
a bend, a factor). Every piece is one line of Python that acts on whole signals; the same line is tried in the search,
fitted in the model and written into the effect file, so that what was judged is what comes out.

Names in the code: ``e`` strain, ``F`` force, ``P`` contact force, ``ln_g`` ln of the conductance since the start,
``t`` time, ``T`` temperature since the start, ``x`` what came out of the line before, ``self.KEY`` a parameter;
``{span}`` and ``{size}`` stand for the largest strain of the recording and the usual size of `x`, written as numbers.
"""

from __future__ import annotations

from dataclasses import dataclass

from testbench.proposing.units import KELVIN, NEWTON, ONE, PER_SECOND, SECOND, Unit

TIME_S = (0.02, 1e5)  # time constants that a file may hold


@dataclass(frozen=True)
class Slot:
    """A parameter that a piece needs.

    Attributes
    ----------
    key : str
        Its name in the effect; it ends in its unit where that is not 1.
    symbol, doc : str
    kind : {"time", "level", "size", "number", "angle"}
        Where its values lie: a time constant; a level or a size of the input `x` (its unit is the input's); a number
        between `low` and `high`; an angle.
    """

    key: str
    symbol: str
    doc: str
    kind: str = "time"
    low: float = 0.0
    high: float = 0.0


@dataclass(frozen=True)
class Coordinate:
    """Where a law may depend on: one signal made of what is there.

    Attributes
    ----------
    code : str
        One expression.
    latex, words : str
    reads : tuple of str
        Signals of the chain that it needs.
    """

    name: str
    code: str
    latex: str
    words: str
    unit: Unit
    reads: tuple[str, ...]
    slots: tuple[Slot, ...] = ()
    definitions: tuple[str, ...] = ()
    signed: bool = True


@dataclass(frozen=True)
class Operator:
    """One step from `x` to the next `x`.

    `latex` and `words` hold ``{x}`` where the input stands; `unit` maps the input's unit to the output's.
    """

    name: str
    code: str
    latex: str
    words: str
    kind: str  # "memory", "bend" or "factor"
    slots: tuple[Slot, ...] = ()
    definitions: tuple[str, ...] = ()
    reads: tuple[str, ...] = ()
    unit: Unit | None = None  # of the output; None: as the input
    times: Unit = ONE  # that the input's unit is multiplied by, where `unit` is None
    squares: bool = False
    only_positive: bool = False


STRAIN, FORCE, PRESSING, LN_G = ("strain",), ("force_N",), ("contact_force_N",), ("conductance_S",)
TIME, WARM = ("time_s",), ("temperature_C",)

COORDINATES = {
    c.name: c
    for c in (
        Coordinate("strain", "e", "e", "the strain", ONE, STRAIN),
        Coordinate("strain rate", "rate(e, dt_s)", r"\dot e", "the strain rate", PER_SECOND, STRAIN),
        Coordinate(
            "speed", "np.abs(rate(e, dt_s))", r"|\dot e|", "the speed of the strain", PER_SECOND, STRAIN, signed=False
        ),
        Coordinate(
            "direction",
            "heading(e, {span})",
            "d",
            "the direction of motion",
            ONE,
            STRAIN,
            definitions=(r"d = \pm 1 \text{ while stretching / releasing}",),
        ),
        Coordinate("force", "F", "F", "the force", NEWTON, FORCE),
        Coordinate("force rate", "rate(F, dt_s)", r"\dot F", "the rate of the force", NEWTON / SECOND, FORCE),
        Coordinate("contact force", "P", "P", "the force on the contacts", NEWTON, PRESSING),
        Coordinate("conductance", "ln_g", r"\ln\frac{G}{G_0}", "the change of ln G since the start", ONE, LN_G),
        Coordinate(
            "conductance rate", "rate(ln_g, dt_s)", r"\tfrac{d}{dt}\ln G", "the rate of ln G", PER_SECOND, LN_G
        ),
        Coordinate(
            "heating power",
            "np.expm1(np.clip(ln_g, -30.0, 30.0))",
            r"\tfrac{G}{G_0} - 1",
            "the electrical power in the sensor",
            ONE,
            LN_G,
        ),
        Coordinate(
            "largest strain", "largest(e)", r"e_{\max}", "the largest strain so far", ONE, STRAIN, signed=False
        ),
        Coordinate(
            "below the largest strain",
            "largest(e) - e",
            r"(e_{\max} - e)",
            "how far the strain is below its largest so far",
            ONE,
            STRAIN,
            signed=False,
        ),
        Coordinate(
            "past the last top",
            "e - last_top(e, {span})",
            r"(e - e_{\text{top}})",
            "how far the strain is from where it last turned down",
            ONE,
            STRAIN,
        ),
        Coordinate("path", "path(e, {span})", r"\int |de|", "the path travelled", ONE, STRAIN, signed=False),
        Coordinate(
            "work", "work(F, e)", r"\int |F\,de|", "the work done on the knit", NEWTON, FORCE + STRAIN, signed=False
        ),
        Coordinate(
            "turns",
            "turns_so_far(e, {span})",
            r"N",
            "the number of turns",
            ONE,
            STRAIN,
            signed=False,
            definitions=(r"N = \text{turns so far}",),
        ),
        Coordinate("time", "t", "t", "the time since the start", SECOND, TIME, signed=False),
        Coordinate(
            "time since reversal",
            "since_turn(e, {span}, dt_s)",
            r"t_{\text{rev}}",
            "the time since the last reversal",
            SECOND,
            STRAIN,
            signed=False,
        ),
        Coordinate(
            "time at rest",
            "seconds_near(e, self.width, dt_s)",
            r"t_{\text{rest}}",
            "the time at the present strain",
            SECOND,
            STRAIN,
            (Slot("width", "w", "half width of a strain", "size"),),
            (r"t_{\text{rest}} = \text{time within} \pm w",),
            signed=False,
        ),
        Coordinate("temperature", "T", r"\Delta T", "the change of temperature", KELVIN, WARM),
    )
}

# A share n of something that forms and goes: dn/dt = gain (1 - n) - loss n. What makes it form, and what ends it.
_EDGE = Slot("edge", "e_1", "strain beyond which it forms", "strain")
_FORMS = {
    "with time": (
        r"\frac{1}{\tau_1}",
        "np.full_like(e, 1.0 / self.form_s)",
        (Slot("form_s", r"\tau_1", "time in which it forms"),),
        "forms with time",
    ),
    "under stretch": (
        r"\frac{(e - e_1)^+}{s\,\tau_1}",
        "over(e, self.edge) / ({span} * self.form_s)",
        (_EDGE, Slot("form_s", r"\tau_1", "time in which it forms, a span beyond the edge")),
        "forms beyond a strain",
    ),
    "steeply": (
        r"\frac{((e - e_1)^+)^2}{s^2\,\tau_1}",
        "over(e, self.edge) ** 2 / ({span}**2 * self.form_s)",
        (_EDGE, Slot("form_s", r"\tau_1", "time in which it forms, a span beyond the edge")),
        "forms ever quicker beyond a strain",
    ),
    "with motion": (
        r"\frac{|\dot e|}{l_1}",
        "np.abs(moving(e, dt_s)) / self.reach",
        (Slot("reach", "l_1", "path in which it forms", "path"),),
        "forms with motion",
    ),
    "while stretching": (
        r"\frac{\dot e^+}{l_1}",
        "over(moving(e, dt_s), 0.0) / self.reach",
        (Slot("reach", "l_1", "path in which it forms", "path"),),
        "forms while stretching",
    ),
}
_ENDS = {
    "with time": (
        r"\frac{1}{\tau_2}",
        "np.full_like(e, 1.0 / self.end_s)",
        (Slot("end_s", r"\tau_2", "time in which it goes"),),
        "goes with time",
    ),
    "with motion": (
        r"\frac{|\dot e|}{l_2}",
        "np.abs(moving(e, dt_s)) / self.wipe",
        (Slot("wipe", "l_2", "path that wipes it out", "path"),),
        "is wiped out by motion",
    ),
    "when short": (
        r"\frac{(e_1 - e)^+}{s\,\tau_2}",
        "over(self.edge - e, 0.0) / ({span} * self.end_s)",
        (Slot("end_s", r"\tau_2", "time in which it goes, a span below"),),
        "goes only below it",
    ),
}
_SENSIBLE = (
    ("with time", "with motion"),
    ("under stretch", "with time"),
    ("under stretch", "with motion"),
    ("steeply", "with time"),
    ("while stretching", "with time"),
    ("under stretch", "when short"),
)


def _kinetic(forms: str, ends: str) -> Coordinate:
    gain, gain_code, gain_slots, gain_words = _FORMS[forms]
    loss, loss_code, loss_slots, loss_words = _ENDS[ends]
    return Coordinate(
        f"state that {gain_words} and {loss_words}",
        f"kinetics({gain_code}, {loss_code}, dt_s)",
        "n",
        f"a state that {gain_words} and {loss_words}",
        ONE,
        STRAIN,
        gain_slots + loss_slots,
        (rf"\dot n = {gain}\,(1 - n) - {loss}\,n",),
        signed=False,
    )


KINETICS = {c.name: c for c in (_kinetic(*pair) for pair in _SENSIBLE)}

OPERATORS = {
    o.name: o
    for o in (
        # memories
        Operator(
            "lag",
            "lowpass(x, self.tau_s, dt_s)",
            "y",
            "the memory of {x}",
            "memory",
            (Slot("tau_s", r"\tau", "time of the memory"),),
            (r"\tau\,\dot y = {x} - y",),
        ),
        Operator(
            "sudden",
            "highpass(x, self.tau_s, dt_s)",
            r"({x} - y)",
            "what is sudden in {x}",
            "memory",
            (Slot("tau_s", r"\tau", "time of the memory"),),
            (r"\tau\,\dot y = {x} - y",),
        ),
        Operator(
            "slip",
            "stop(x, self.reach)",
            "h",
            "the slip element over {x}",
            "memory",
            (Slot("reach", "r", "reach of the slip element", "size"),),
            (r"h = {x} - \text{play}_r({x})",),
        ),
        Operator(
            "ring",
            "oscillator(x, self.ring_hz, self.damping, dt_s) - x",
            r"(y - {x})",
            "the ringing of {x}",
            "memory",
            (
                Slot("ring_hz", "f", "frequency of the ringing", "frequency"),
                Slot("damping", r"\zeta", "its damping", "number", 0.005, 0.9),
            ),
            (r"\ddot y + 4\pi\zeta f\,\dot y + (2\pi f)^2 (y - {x}) = 0",),
        ),
        Operator(
            "late",
            "delayed(x, self.delay_s, dt_s) - x",
            r"({x}(t - \delta) - {x}(t))",
            "the delay of {x}",
            "memory",
            (Slot("delay_s", r"\delta", "delay", "delay"),),
        ),
        Operator(
            "dead band",
            "held(x, self.band) - x",
            r"(y - {x})",
            "the dead band of {x}",
            "memory",
            (Slot("band", "b", "half width of the dead band", "size"),),
            (r"y = {x} \text{ held within} \pm b",),
        ),
        Operator(
            "stick",
            "stuck(x, self.grip)",
            "h",
            "{x} since it last stuck",
            "memory",
            (Slot("grip", "g", "how far it sticks", "size"),),
            (r"h = {x} \text{ since it last let go, at } g",),
        ),
        # bends
        Operator("size", "np.abs(x)", r"|{x}|", "the size of {x}", "bend"),
        Operator("square", "x * x", r"({x})^2", "the square of {x}", "bend", squares=True),
        Operator(
            "power",
            "power_of(x / {size}, self.power)",
            r"\left({x} / x_0\right)^{p}",
            "a power of {x}",
            "bend",
            (Slot("power", "p", "exponent", "number", 0.2, 5.0),),
            unit=ONE,
        ),
        Operator("log", "np.log(np.maximum(x, 1e-4))", r"\ln {x}", "the logarithm of {x}", "bend", unit=ONE),
        Operator(
            "threshold",
            "over(x, self.edge_x)",
            r"({x} - x_1)^+",
            "{x} beyond a threshold",
            "bend",
            (Slot("edge_x", "x_1", "threshold", "level"),),
        ),
        Operator(
            "below",
            "over(self.edge_x - x, 0.0)",
            r"(x_1 - {x})^+",
            "{x} below a threshold",
            "bend",
            (Slot("edge_x", "x_1", "threshold", "level"),),
        ),
        Operator(
            "saturation",
            "np.tanh(x / self.scale)",
            r"\tanh\frac{{x}}{x_s}",
            "{x}, which saturates",
            "bend",
            (Slot("scale", "x_s", "where it saturates", "size"),),
            unit=ONE,
        ),
        Operator(
            "settling",
            "-np.expm1(-np.maximum(x, 0.0) / self.scale)",
            r"\left(1 - e^{-{x}/x_s}\right)",
            "{x}, which settles",
            "bend",
            (Slot("scale", "x_s", "in which it settles", "size"),),
            unit=ONE,
            only_positive=True,
        ),
        Operator(
            "logarithm",
            "np.log1p(np.maximum(x, 0.0) / self.scale)",
            r"\ln\left(1 + \frac{{x}}{x_s}\right)",
            "the logarithm of {x}",
            "bend",
            (Slot("scale", "x_s", "where it sets in", "size"),),
            unit=ONE,
            only_positive=True,
        ),
        Operator(
            "bell",
            "bump(x, 0.0, self.bell)",
            r"\exp\left(-\frac{({x})^2}{2 b^2}\right)",
            "a bell around zero of {x}",
            "bend",
            (Slot("bell", "b", "width of the bell", "size"),),
            unit=ONE,
        ),
        Operator(
            "bell at",
            "bump(x, self.centre, self.bell)",
            r"\exp\left(-\frac{({x} - c)^2}{2 b^2}\right)",
            "a bell over {x}",
            "bend",
            (Slot("centre", "c", "centre of the bell", "level"), Slot("bell", "b", "width of the bell", "size")),
            unit=ONE,
        ),
        Operator(
            "switch",
            "relay(x, self.on, self.on - self.gap)",
            r"\sigma({x})",
            "a switch over {x}",
            "bend",
            (
                Slot("on", "x_1", "where it switches on", "level"),
                Slot("gap", r"\Delta", "how far below that it switches off", "size"),
            ),
            (r"\sigma = 1 \text{ from } x_1 \text{ upwards until } x_1 - \Delta",),
            unit=ONE,
        ),
        Operator(
            "wave",
            "np.sin(2 * np.pi * x / self.period + self.phase)",
            r"\sin\left(\frac{2\pi {x}}{\lambda} + \varphi\right)",
            "a wave over {x}",
            "bend",
            (
                Slot("period", r"\lambda", "period of the wave", "size"),
                Slot("phase", r"\varphi", "its phase", "angle"),
            ),
            unit=ONE,
        ),
        # factors
        Operator("times strain", "x * e", r"{x}\,e", "{x} times the strain", "factor", reads=STRAIN),
        Operator("times force", "x * F", r"{x}\,F", "{x} times the force", "factor", reads=FORCE, times=NEWTON),
        Operator(
            "times contact force",
            "x * P",
            r"{x}\,P",
            "{x} times the contact force",
            "factor",
            reads=PRESSING,
            times=NEWTON,
        ),
        Operator(
            "times conductance",
            "x * ln_g",
            r"{x}\,\ln\frac{G}{G_0}",
            "{x} times the change of ln G",
            "factor",
            reads=LN_G,
        ),
        Operator(
            "times direction",
            "x * heading(e, {span})",
            r"{x}\,d",
            "{x}, with the sign of the motion",
            "factor",
            definitions=(r"d = \pm 1 \text{ while stretching / releasing}",),
            reads=STRAIN,
        ),
        Operator(
            "while stretching",
            "x * 0.5 * (1.0 + heading(e, {span}))",
            r"{x}\,\frac{1 + d}{2}",
            "{x} while stretching",
            "factor",
            definitions=(r"d = \pm 1 \text{ while stretching / releasing}",),
            reads=STRAIN,
        ),
        Operator("growing", "x * t", r"{x}\,t", "{x}, which grows with time", "factor", reads=TIME, times=SECOND),
        Operator(
            "fading",
            "x * np.exp(-t / self.fade_s)",
            r"{x}\,e^{-t/\tau_f}",
            "{x}, which fades with time",
            "factor",
            (Slot("fade_s", r"\tau_f", "time in which it fades"),),
            reads=TIME,
        ),
    )
}

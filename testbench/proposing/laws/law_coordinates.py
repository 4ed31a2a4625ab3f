"""What a law may depend on: what the knit does and has gone through, and states that form and go."""

from __future__ import annotations

from testbench.proposing.laws.law_parts import (
    DIRECTION,
    FORCE,
    LN_G,
    PRESSING,
    STRAIN,
    TIME,
    WARM,
    Coordinate,
    Slot,
    named,
)
from testbench.proposing.laws.units import KELVIN, NEWTON, PER_SECOND, SECOND

_SWING = Slot("swing", "w", "how far the strain must come back to have turned", "swing", jumps=True)

COORDINATES = named(
    Coordinate("strain", "e", "e", "the strain"),
    Coordinate("strain rate", "rate(e, dt_s)", r"\dot e", "the strain rate", PER_SECOND),
    Coordinate("speed", "np.abs(rate(e, dt_s))", r"|\dot e|", "the speed of the strain", PER_SECOND, signed=False),
    Coordinate(
        "acceleration",
        "lagging_rate(rate(e, dt_s), dt_s)",
        r"\ddot e",
        "the acceleration of the strain",
        PER_SECOND * PER_SECOND,
    ),
    Coordinate("direction", "heading(e, {span})", "d", "the direction of motion", definitions=DIRECTION),
    Coordinate("force", "F", "F", "the force", NEWTON, FORCE),
    Coordinate("force rate", "rate(F, dt_s)", r"\dot F", "the rate of the force", NEWTON / SECOND, FORCE),
    Coordinate("contact force", "P", "P", "the force on the contacts", NEWTON, PRESSING),
    Coordinate("conductance", "ln_g", r"\ln\frac{G}{G_0}", "the change of ln G since the start", reads=LN_G),
    Coordinate("conductance rate", "rate(ln_g, dt_s)", r"\tfrac{d}{dt}\ln G", "the rate of ln G", PER_SECOND, LN_G),
    Coordinate(
        "heating power",
        "np.expm1(np.clip(ln_g, -30.0, 30.0))",
        r"\tfrac{G}{G_0} - 1",
        "the electrical power in the sensor",
        reads=LN_G,
    ),
    Coordinate("largest strain", "largest(e)", r"e_{\max}", "the largest strain so far", signed=False),
    Coordinate(
        "below the largest strain",
        "largest(e) - e",
        r"(e_{\max} - e)",
        "how far the strain is below its largest so far",
        signed=False,
    ),
    Coordinate(
        "past the last top",
        "e - last_top(e, 0.02 * {span})",
        r"(e - e_{\text{top}})",
        "how far the strain is from where it last turned down",
    ),
    Coordinate(
        "from a share of the last top",
        "e - self.share * last_top(e, self.swing)",
        r"(e - s_t\,e_{\text{top}})",
        "how far the strain is from a share of where it last turned down",
        slots=(Slot("share", "s_t", "share of the last top", "number", 0.5, 1.5), _SWING),
        definitions=(r"e_{\text{top}} = \text{last top of a swing beyond } w",),
    ),
    Coordinate("path", "path(e, {span})", r"\int |de|", "the path travelled", signed=False),
    Coordinate(
        "work", "work(F, e)", r"\int |F\,de|", "the work done on the knit", NEWTON, FORCE + STRAIN, signed=False
    ),
    Coordinate(
        "power",
        "np.abs(F * rate(e, dt_s))",
        r"|F\,\dot e|",
        "the power that pulls the knit",
        NEWTON / SECOND,
        FORCE + STRAIN,
        signed=False,
    ),
    Coordinate(
        "turns",
        "turns_so_far(e, {span})",
        "N",
        "the number of turns",
        definitions=(r"N = \text{turns so far}",),
        signed=False,
    ),
    Coordinate("time", "t", "t", "the time since the start", SECOND, TIME, signed=False),
    Coordinate(
        "time since reversal",
        "since_turn(e, {span}, dt_s)",
        r"t_{\text{rev}}",
        "the time since the last reversal",
        SECOND,
        signed=False,
    ),
    Coordinate(
        "time at rest",
        "seconds_near(e, self.width, dt_s)",
        r"t_{\text{rest}}",
        "the time at the present strain",
        SECOND,
        slots=(Slot("width", "w", "half width of a strain", "size", jumps=True),),
        definitions=(r"t_{\text{rest}} = \text{time within} \pm w",),
        signed=False,
    ),
    Coordinate("temperature", "T", r"\Delta T", "the change of temperature", KELVIN, WARM),
)

# A share n of something that forms and goes: dn/dt = gain (1 - n) - loss n. What makes it form, and what ends it.
_EDGE = Slot("edge", "e_1", "strain beyond which it forms", "strain")
_FORM_BEYOND = Slot("form_s", r"\tau_1", "time in which it forms, a span beyond the edge")
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
        (_EDGE, _FORM_BEYOND),
        "forms beyond a strain",
    ),
    "steeply": (
        r"\frac{((e - e_1)^+)^2}{s^2\,\tau_1}",
        "over(e, self.edge) ** 2 / ({span}**2 * self.form_s)",
        (_EDGE, _FORM_BEYOND),
        "forms ever quicker beyond a strain",
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
        slots=gain_slots + loss_slots,
        definitions=(rf"\dot n = {gain}\,(1 - n) - {loss}\,n",),
        signed=False,
    )


def _store(loss: str, loss_code: str, loss_slots: tuple[Slot, ...], ends: str, *definitions: str) -> Coordinate:
    """What has no limit: it stands in for a state that has hardly filled, and leaves a number for how it goes."""
    words = f"what gathers beyond a strain and {ends}"
    return Coordinate(
        words,
        f"gathered(over(e, self.edge) / {{span}}, {loss_code}, dt_s)",
        "n",
        words,
        SECOND,
        slots=(_EDGE, *loss_slots),
        definitions=(r"\dot n = \frac{(e - e_1)^+}{s}" + (rf" - {loss}\,n" if loss else ""), *definitions),
        signed=False,
    )


_STORES = (
    _store("", "np.zeros_like(e)", (), "stays"),
    _store(
        r"\frac{[e < e_2]}{\tau_2}",
        "(e < self.rest) / self.end_s",
        (
            Slot("rest", "e_2", "strain below which it goes", "strain", jumps=True),
            Slot("end_s", r"\tau_2", "time in which it goes there"),
        ),
        "goes near rest",
    ),
    _store(
        r"\frac{1}{l_2}\sum_k s_k\,\delta(t - t_k)",
        "turning(e, self.swing, dt_s) / self.wipe",
        (_SWING, Slot("wipe", "l_2", "swing that wipes it out, at its end", "path")),
        "is evened out by each turn",
        r"s_k = \text{swing beyond } w",
    ),
)
KINETICS = named(*(_kinetic(*pair) for pair in _SENSIBLE), *_STORES)

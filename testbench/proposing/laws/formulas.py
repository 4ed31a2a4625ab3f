"""A law in words, as a formula in LaTeX, and as one that is read without a typesetter."""

from __future__ import annotations

import re

from testbench.proposing.laws.law import Law

FRACTION = re.compile(r"\\t?frac\{([^{}]*)\}\{([^{}]*)\}")
PLAIN = {
    r"\left": "",
    r"\right": "",
    r"\dot e": "e'",
    r"\ddot e": "e''",
    r"\dot F": "F'",
    r"\dot y": "y'",
    r"\dot n": "n'",
    r"\ddot y": "y''",
    r"\,": " ",
    r"\int": "int ",
    r"\varphi": "phi",
    r"\sigma": "s",
    r"\pm": "+-",
    r"\tanh": "tanh ",
    r"\ln": "ln ",
}
SYMBOLS = {
    "strain": "e is the strain",
    "force_N": "F the force in N",
    "contact_force_N": "P the force on the contacts in N",
    "conductance_S": "G the conductance in S, G_0 at the start",
    "time_s": "t the time in s",
    "temperature_C": "Delta T the change of temperature in K",
}


def in_words(law: Law) -> str:
    """The law in one sentence."""
    way = "rises" if law.strength > 0 else "falls"
    return f"{law.place.words} {way} with {law.term.words}"


def latex_of(law: Law) -> str:
    """The formula in LaTeX."""
    parts = [rf"{law.place.latex} \mathrel{{+}}= a\,z,\quad z = {law.term.latex}", *law.term.definitions]
    return r",\quad ".join(parts)


def plain(latex: str) -> str:
    """A formula that is read without a typesetter."""
    text = latex
    for sign, word in PLAIN.items():
        text = text.replace(sign, word)
    text = re.sub(r"\\(?:text|mathrm)\{([^{}]*)\}", r"\1 ", text)
    text = re.sub(r"_\{\\?([^{}]*)\}", r"_\1", text)
    text = re.sub(r"\^\{([^{}]*)\}", r"^(\1)", text)
    while (simpler := FRACTION.sub(_fraction, text)) != text:
        text = simpler
    text = re.sub(r"\\([a-zA-Z]+)(?=\\)", r"\1 ", text).replace("{", "").replace("}", "").replace("\\", "")
    text = re.sub(r"\s+", " ", text).replace(" ^", "^").replace(" )", ")").strip()
    return re.sub(r"\(\(([^()]*)\)\)", r"(\1)", text).replace("ln (", "ln(").replace("tanh (", "tanh(")


def _fraction(found: re.Match[str]) -> str:
    """A fraction in one line; what is a sum or a product is bracketed."""
    parts = []
    for part in found.groups():
        outside = re.sub(r"\([^()]*\)|\|[^|]*\|", "x", re.sub(r"\([^()]*\)", "x", part))
        parts.append(f"({part})" if re.search(r"\S\s+\S", outside) else part)
    return f"({parts[0]} / {parts[1]})"

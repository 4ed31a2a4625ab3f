"""A law as an effect: the text of its class, with formula, units and bounds, and the class of that text."""

from __future__ import annotations

import copyreg
import re
import textwrap
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

from gcode.support.errors import UserError
from testbench.knit.effect import Effect
from testbench.knit.effect_names import class_name
from testbench.proposing.grids import Grid, rounded
from testbench.proposing.laws.formulas import SYMBOLS, in_words, latex_of, plain
from testbench.proposing.laws.law import NAMES, SINCE_START, STRENGTH, TOOLS, Law

MODULE = "knitbench_proposed"
REACH = 30  # bounds of the strength, over what was found
HEAD = '''"""{title}

{story}

Try it:  testbench effects --effects {file} --check
Use it:  testbench diagnose A --effects {file}
         testbench add {name} --model M --fit A --effects {file} -o M2
"""

'''
CLASS = '''

class {cls}(Effect):
    """{summary}

    {formula}
{definitions}
    {symbols}
    In LaTeX:  {latex}

    Source: proposed by `testbench propose` from what a model left of a recording; no theory stands behind it.
    Valid: where it was found, at strains up to {span:g} and within {duration_s:.0f} s; beyond that nobody has looked.
    """

    name = "{name}"
    stage = Stage.{stage}
    reads, writes = {reads}, {writes}
    strength = "{strength}"
    look = "{look}"
{optional}
{parameters}

    def apply(self, signals, dt_s):
{body}
'''


def strength_key(law: Law) -> str:
    """Name of the strength in the effect, ending in its unit where that is a force."""
    return f"{STRENGTH}_N" if str(law.unit) == "N" else STRENGTH


def effect_class(law: Law, name: str, grid: Grid) -> type[Effect]:
    """The class that the file would hold, made from the same text."""
    return _class_of(file_text([(law, name)], grid, "", f"{name}.py"), name)


@lru_cache(maxsize=1000)
def _class_of(text: str, name: str) -> type[Effect]:
    """One text, one class, whose effects go from one process to another as text and numbers."""
    space: dict[str, Any] = {"__name__": MODULE}
    exec(compile(text, f"<{name}>", "exec"), space)
    found = next(v for v in space.values() if isinstance(v, type) and issubclass(v, Effect) and v is not Effect)
    copyreg.pickle(found, lambda effect: (_made_again, (text, name, effect.model_dump())))
    return found


def _made_again(text: str, name: str, values: dict[str, Any]) -> Effect:
    return _class_of(text, name)(**values)


def file_text(laws: Sequence[tuple[Law, str]], grid: Grid, story: str, file: str) -> str:
    """A whole effect file."""
    classes = "".join(class_text(law, name, grid) for law, name in laws)
    title = _sentence("; ".join(in_words(law) for law, _ in laws))
    head = HEAD.format(title=_folded(title, 0), story=_folded(story or "Proposed.", 0), file=file, name=laws[0][1])
    return head + _imports(classes) + classes


def _imports(code: str) -> str:
    """The import lines of the names that the code uses."""

    def used(names: Sequence[str]) -> list[str]:
        return sorted(name for name in names if re.search(rf"(?<![.\w]){name}\(", code))

    lines = ["import numpy as np\n"] if "np." in code else []
    lines.append("from testbench.knit.effect import Effect, Stage, parameter")
    for module in ("filters", "memories"):
        mine = [n for n, tool in TOOLS.items() if getattr(tool, "__module__", "") == f"testbench.knit.{module}"]
        found = used([*mine, *(["log_conductance"] if module == "filters" else [])])
        if found:
            lines.append(f"from testbench.knit.{module} import {', '.join(found)}")
    return "\n".join(lines) + "\n"


def class_text(law: Law, name: str, grid: Grid) -> str:
    """The text of the class of one law."""
    term, place = law.term, law.place
    reads = tuple(dict.fromkeys([*term.reads, place.writes]))
    definitions = "".join(f"    {plain(line)}\n" for line in term.definitions)
    optional = '    optional_reads = ("temperature_C",)\n' if "temperature_C" in term.reads else ""
    operators = {one.name for one in term.operators}
    optional += "    nonlinear = True\n" if "dead band" in operators else ""
    optional += "    looks_ahead = True\n" if "clock" in operators else ""
    if jumping := [slot.key for slot in term.slots if slot.jumps]:
        optional += f"    jumps = {_tuple(jumping)}\n"
    if term.coordinate.name == "time" and "wave" in operators:
        optional += '    per_recording = ("phase",)\n'  # a hum knows nothing of when a recording began
    return CLASS.format(
        cls=class_name(name),
        summary=_folded(_sentence(in_words(law)), 4),
        formula=f"{plain(place.latex)} += a * z,   z = {plain(term.latex)}",
        definitions=definitions,
        symbols=_folded(f"Here {', '.join(SYMBOLS[name] for name in SYMBOLS if name in reads)}.", 4),
        latex=escaped(latex_of(law)),
        span=grid.span,
        duration_s=grid.duration_s,
        name=name,
        stage=place.stage.name,
        reads=_tuple([name for name in reads if name != "temperature_C"]),
        writes=_tuple((place.writes,)),
        strength=strength_key(law),
        look=_sentence(f"the misfit of {place.words} follows {term.words}")[:160].rstrip("."),
        optional=optional,
        parameters="\n".join(_parameters(law, grid)),
        body=textwrap.indent("\n".join(_body(law)), 8 * " "),
    )


def _body(law: Law) -> list[str]:
    term, place = law.term, law.place
    code = " ".join([*term.lines, place.code])
    lines = []
    for signal, (name, expression) in NAMES.items():
        if not _mentions(code, name):
            continue
        if signal == "temperature_C":
            lines += [
                'if "temperature_C" not in signals:',
                f'    return {{"{place.writes}": signals["{place.writes}"].copy()}}',
            ]
        lines.append(f"{name} = {expression}")
        if signal in SINCE_START:
            lines.append(f"{name} = {name} - {name}[0]")
    lines += [f"x = {line}" for line in term.lines]
    lines.append(f'return {{"{place.writes}": {place.code.replace("{a}", "self." + strength_key(law))}}}')
    return lines


def _mentions(code: str, name: str) -> bool:
    return re.search(rf"(?<![.\w\"]){name}(?![\w(\"])", code) is not None


def _parameters(law: Law, grid: Grid) -> list[str]:
    reach = rounded(REACH * max(abs(law.strength), 1e-12))
    unit = str(law.unit)
    doc = f"a: change of {plain(law.place.latex)} for each unit of z"
    lines = [_parameter(strength_key(law), law.strength, unit, -reach, reach, False, doc)]
    for slot in law.term.slots:
        value = law.values[slot.key]
        unit = "rad" if slot.kind == "angle" else str(law.term.unit_of(slot))
        lines.append(
            _parameter(slot.key, value, unit, *grid.bounds(slot, value), f"{plain(slot.symbol)}: {slot.doc}")
        )
    return lines


def _parameter(key: str, value: float, unit: str, low: float, high: float, log: bool, doc: str) -> str:
    scale = ', scale="log"' if log else ""
    value = min(max(float(f"{value:.6g}"), low), high)
    return (
        f'    {key}: float = parameter({value!r}, unit="{unit}", low={low:g}, high={high:g}{scale},\n'
        f'    {" " * len(key)}                   doc="{doc}")'
    )


def escaped(text: str) -> str:
    """`text` with its backslashes doubled, for a docstring that is no raw string."""
    return text.replace("\\", "\\\\")


def _sentence(text: str) -> str:
    return text[:1].upper() + text[1:] + "."


def _folded(text: str, indent: int) -> str:
    return textwrap.fill(text, 112, subsequent_indent=" " * indent)


def _tuple(names: Sequence[str]) -> str:
    return "(" + ", ".join(f'"{name}"' for name in names) + ("," if len(names) == 1 else "") + ")"


def free_path(path: str | Path) -> Path:
    """The path, if nothing is there.

    Raises
    ------
    UserError
        Somebody's work must not be overwritten.
    """
    if Path(path).exists():
        raise UserError(f"{path} exists already and is not overwritten; choose another place")
    return Path(path)

"""An effect on one card: what it is, what it looks like in data, its parameters, where it comes from."""

from __future__ import annotations

import inspect
import textwrap
from dataclasses import dataclass
from typing import Any

from testbench.knit.catalogue import Catalogue
from testbench.knit.effect import Effect, Stage, bounds_of


@dataclass(frozen=True)
class DocSections:
    """The parts of an effect's docstring."""

    summary: str
    formula: str
    remarks: str
    source: str
    valid: str


def doc_sections(effect: type[Effect]) -> DocSections:
    """Split the docstring: a paragraph that sums up, the formula, remarks; ``Source:``, ``Valid:``."""
    text = inspect.cleandoc(effect.__doc__ or "")
    body, _, tail = text.partition("Source:")
    source, _, valid = tail.partition("Valid:")
    summary, _, rest = body.strip().partition("\n\n")
    formula, _, remarks = rest.partition("\n\n")
    return DocSections(
        " ".join(summary.split()), formula.strip(), *(" ".join(text.split()) for text in (remarks, source, valid))
    )


def parameter_rows(effect: type[Effect]) -> list[dict[str, str]]:
    """One row a parameter: name, default, unit, bounds, meaning."""
    return [
        {
            "name": key,
            "default": _shown(field.default),
            "unit": "" if extra["unit"] == "1" else extra["unit"],
            "bounds": f"{extra['low']:g} to {extra['high']:g}{', log' if extra['scale'] == 'log' else ''}",
            "meaning": (field.description or "") + ("; 0: no effect" if key == effect.strength else ""),
        }
        for key, field in effect.model_fields.items()
        for extra in [bounds_of(field)]
    ]


def _shown(value: Any) -> str:
    return f"({value[0]:g}, ...) x {len(value)}" if isinstance(value, tuple) else f"{value:g}"


def other_laws(effect: type[Effect], catalogue: Catalogue) -> list[str]:
    """Names of the other laws of the same mechanism."""
    return [law.name for law in catalogue.mechanisms().get(effect.mechanism, []) if law.name != effect.name]


def card_text(effect: type[Effect], catalogue: Catalogue) -> str:
    """The card as plain text, at most about 110 columns wide."""
    doc = doc_sections(effect)
    read = ", ".join(effect.reads + effect.optional_reads)
    chain = f"{effect.stage.name.lower()}: {read} -> {', '.join(effect.writes)}"
    lines = [f"{effect.name}   ({chain})", doc.summary, "", textwrap.indent(doc.formula, "    "), ""]
    lines += [f"in data    {effect.look}", "", *_table(parameter_rows(effect)), ""]
    told = {"remarks": doc.remarks, "source": doc.source, "valid": doc.valid}
    lines += [_wrapped(label, text) for label, text in told.items() if text]
    laws = other_laws(effect, catalogue)
    return "\n".join([*lines, _wrapped("other laws", ", ".join(laws))] if laws else lines)


def _wrapped(label: str, text: str) -> str:
    return textwrap.fill(text, 110, initial_indent=f"{label:11s}", subsequent_indent=" " * 11)


def _table(rows: list[dict[str, str]]) -> list[str]:
    if not rows:
        return ["parameters none"]
    cells = [[row["name"], f"{row['default']} {row['unit']}".strip(), row["bounds"], row["meaning"]] for row in rows]
    widths = [max(len(row[column]) for row in cells) for column in range(3)]
    return [
        "  ".join([text.ljust(width) for text, width in zip(row, widths, strict=False)] + [row[3]]) for row in cells
    ]


def catalogue_text(catalogue: Catalogue) -> str:
    """All effects by stage; further laws of a mechanism indented below the first of them there."""
    lines = []
    for stage in Stage:
        lines.append(stage.name.lower())
        for laws in catalogue.mechanisms().values():
            here = [law for law in laws if law.stage is stage]
            lines += [f"  {'' if law is here[0] else '  '}{law.name}".ljust(38) + f" {law.look}" for law in here]
        lines.append("")
    lines += [f"broken: {name}: {reason}" for name, reason in catalogue.broken.items()]
    count = len(catalogue.mechanisms())
    lines.append(f"{len(catalogue.effects)} effects of {count} mechanisms. Card: testbench effects NAME")
    return "\n".join(lines)


def catalogue_markdown(catalogue: Catalogue) -> str:
    """The table of docs/effects.md."""
    lines = ["| effect | stage | in data |", "|---|---|---|"]
    for laws in catalogue.mechanisms().values():
        for law in laws:
            name = f"`{law.name}`" if law is laws[0] else f"&nbsp;&nbsp;`{law.name}`"
            lines.append(f"| {name} | {law.stage.name.lower()} | {law.look} |")
    return "\n".join(lines)

"""A report as Markdown; its pictures are files beside it."""

from __future__ import annotations

from urllib.parse import quote

from testbench.report.document import Facts, Item, Picture, Report, Table


def to_markdown(report: Report, figures: str) -> str:
    """The report as Markdown; `figures` is the folder of the PNG files, as the document should name it."""
    parts = [f"# {report.title}", report.date, report.verdict]
    parts += [_item(item, figures) for item in report.opening]
    for section in report.sections:
        parts.append(f"## {section.title}")
        parts += [_item(item, figures) for item in section.items]
    parts.append(report.footer)
    return "\n\n".join(part for part in parts if part) + "\n"


def _item(item: Item, figures: str) -> str:
    if isinstance(item, Picture):
        place = quote(f"{figures}/{item.name}.png")  # a blank would end the link
        return f"![{item.caption}]({place})\n\n*{item.caption}*"
    if isinstance(item, Table):
        return _table(item)
    if isinstance(item, Facts):
        return "\n".join(f"- **{name}**: {value}" for name, value in item.pairs)
    return item


def _table(table: Table) -> str:
    lines = [table.head, tuple("---" for _ in table.head), *table.rows]
    text = "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines)
    return f"{text}\n\n{table.caption}" if table.caption else text

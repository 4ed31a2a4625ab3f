"""Writing a report and its figures to disk, as one page or as Markdown with its pictures beside it."""

from __future__ import annotations

import os
from pathlib import Path
from urllib.parse import quote

from gcode.support.errors import UserError
from gcode.support.files import make_folder, write_text
from testbench.report.document import Facts, Item, Picture, Report, Table
from testbench.report.writing.page import to_html
from testbench.report.writing.static import write_figure

ENDINGS = {"html": (".html", ".htm"), "md": (".md", ".markdown")}


def write_report(
    report: Report, output: str | Path, form: str = "html", figures: str | Path | None = None
) -> list[Path]:
    """Write the report, and its figures as PNG and PDF where a folder is given.

    Markdown needs its pictures as files, so it gets them beside itself when no folder is named.

    Returns
    -------
    list of Path
        The report, and every figure.

    Raises
    ------
    UserError
        If the name of the file ends as that of another kind of file does.
    """
    output = Path(output)
    _check_ending(output, form)
    if form == "md" and figures is None:
        figures = output.with_name(f"{output.stem}-figures")
    written = [] if figures is None else _write_figures(report, Path(figures))
    if form == "md":
        assert figures is not None
        text = _to_markdown(report, Path(os.path.relpath(figures, output.parent)).as_posix())
    else:
        text = to_html(report)
    write_text(output, text)
    return [output, *written]


def _check_ending(output: Path, form: str) -> None:
    """Refuse a name that promises another kind of file: ``report.pdf`` would hold HTML."""
    if output.suffix and output.suffix.lower() not in ENDINGS[form]:
        other = next((one for one, endings in ENDINGS.items() if output.suffix.lower() in endings), "")
        remedy = f"write it as {other}, or give another name" if other else "give another name"
        raise UserError(f"{output}: a report as {form} ends in {' or '.join(ENDINGS[form])}; {remedy}")


def _write_figures(report: Report, folder: Path) -> list[Path]:
    make_folder(folder)
    pictures = [(picture, suffix) for picture in report.pictures() for suffix in ("png", "pdf")]
    places = [folder / f"{picture.name}.{suffix}" for picture, suffix in pictures]
    for (picture, _), place in zip(pictures, places, strict=True):
        write_figure(picture.figure, place)
    return places


def _to_markdown(report: Report, figures: str) -> str:
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

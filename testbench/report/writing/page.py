"""A report as one HTML file that opens anywhere: no server, no network, plotly.js inlined once."""

from __future__ import annotations

from html import escape
from importlib.resources import files
from typing import Any

from gcode.support import html
from testbench.report import style
from testbench.report.document import Facts, Item, Picture, Report, Section, Table
from testbench.report.writing.packing import plotly_path, to_json

CONTENT_POLICY = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:"


def to_html(report: Report) -> str:
    """The whole page.

    Notes
    -----
    A content security policy in the page forbids every fetch, so nothing can be loaded from outside even by mistake.
    """
    own = files("testbench.report")
    figures: dict[str, Any] = {picture.name: picture.figure for picture in report.pictures()}
    figures["config"] = style.CONFIG
    # "</script>" inside a string would end the element, so the slash is escaped (the same JSON string).
    packed = to_json(figures).replace("</", "<\\/")
    body = "".join(_section(number, section) for number, section in enumerate(report.sections))
    links = "".join(
        f'<a href="#part-{number}">{escape(section.title)}</a>' for number, section in enumerate(report.sections)
    )
    return f"""<!doctype html>
<html lang="en"><head><meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="{CONTENT_POLICY}">
<title>{escape(report.title)}</title>
<style>{own.joinpath("page.css").read_text("utf-8")}</style></head>
<body><header class="hero">
<p class="kicker">knitbench report{escape(f" · {report.date}" if report.date else "")}</p>
<h1>{escape(report.title)}</h1><p class="verdict">{escape(report.verdict)}</p>
{"".join(_item(item) for item in report.opening)}
<nav class="contents" aria-label="Contents">{links}</nav></header>
<main>{body}<footer>{escape(report.footer)}</footer></main>
<script>{plotly_path().read_text("utf-8")}</script>
<script type="application/json" id="figures">{packed}</script>
<script>{own.joinpath("narrow.js").read_text("utf-8")}</script>
<script>{own.joinpath("page.js").read_text("utf-8")}</script>
</body></html>
"""


def _section(number: int, section: Section) -> str:
    items = "".join(_item(item) for item in section.items)
    return f'<section id="part-{number}"><h2>{escape(section.title)}</h2>{items}</section>'


def _item(item: Item) -> str:
    if isinstance(item, Picture):
        height = item.figure["layout"]["height"]
        return (
            f'<figure><div class="plot" id="{escape(item.name)}" style="height:{height}px" role="img" '
            f'aria-label="{escape(item.caption)}"></div><figcaption>{escape(item.caption)}</figcaption></figure>'
        )
    if isinstance(item, Table):
        return f'<div class="scroll">{html.table(item.head, item.rows, item.caption)}</div>'
    if isinstance(item, Facts):
        tiles = "".join(
            f'<div class="tile"><b>{escape(value)}</b><span>{escape(name)}</span></div>' for name, value in item.pairs
        )
        return f'<div class="tiles">{tiles}</div>'
    return f"<p>{escape(item)}</p>"

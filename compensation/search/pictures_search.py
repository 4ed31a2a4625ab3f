"""The picture of a search: E over the number of parameters, one colour a bank."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from compensation.search.ranking import Ranked
from gcode.support.colours import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, VERMILION
from gcode.support.figures import PRINT
from gcode.support.files import atomic_path

COLOURS = (BLUE, VERMILION, GREEN, ORANGE, SKY, PURPLE, BLACK, GREY)
PUBLISHED = "2.5^7 4-2-2"
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "*")


def draw_search(ranking: Sequence[Ranked], path: str | Path) -> None:
    """Write a scatter of mean E over live seeds (bars: standard deviation) against the number of parameters.

    Candidates that no seed brought to life are counted in the title and not drawn: their E is 1.
    """
    from matplotlib import rc_context
    from matplotlib.figure import Figure
    from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

    figure = Figure(figsize=(10.5, 5), layout="constrained")
    axis = figure.subplots()
    alive = [row for row in ranking if row.dead < row.seeds] or list(ranking)
    banks = sorted({row.key.split()[0] for row in alive}, key=_numbers)
    for bank, colour, marker in zip(banks, COLOURS, MARKERS, strict=False):
        rows = [row for row in alive if row.key.split()[0] == bank]
        axis.errorbar(
            [row.parameters for row in rows],
            [row.E for row in rows],
            [row.spread for row in rows],
            fmt=marker,
            ms=4,
            lw=0.6,
            color=colour,
            label=_named(bank),
        )
    axis.set(xscale="log", yscale="log", xlabel="weights and biases", ylabel="E (smaller is better)")
    _point_out(axis, alive[0], "best", (-40, -18))
    for row in alive:
        if row.key == PUBLISHED:
            _point_out(axis, row, "the paper's (4,2,2)", (-95, -42))
    for scale in (axis.xaxis, axis.yaxis):
        scale.set_major_locator(LogLocator(subs=(1, 2, 5)))
        scale.set_minor_locator(NullLocator())
        scale.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    never = len(ranking) - len(alive)
    title = f"{len(ranking)} candidates, {ranking[0].seeds} seeds; best {ranking[0].key}: E = {ranking[0].E:.4f}"
    axis.set_title(title + (f"; {never} dead from every seed" if never else ""), loc="left", fontsize=11)
    axis.legend(fontsize=8, title="smoothing bank", title_fontsize=8, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    axis.grid(alpha=0.3, which="both", lw=0.4)
    with rc_context(PRINT), atomic_path(path) as temporary:
        figure.savefig(temporary, dpi=110)


def _numbers(bank: str) -> tuple[float, int]:
    if "^" not in bank:
        return 0.0, 0
    a, n = bank.split("^")
    return float(a), int(n)


def _named(bank: str) -> str:
    """A candidate's name as the paper's table writes it."""
    return "a = {}, N = {}".format(*bank.split("^")) if "^" in bank else f"{bank} (set by hand)"


def _point_out(axis, row: Ranked, text: str, offset: tuple[int, int]) -> None:
    arrow = {"arrowstyle": "->", "lw": 0.8}
    axis.annotate(
        text, (row.parameters, row.E), xytext=offset, textcoords="offset points", fontsize=9, arrowprops=arrow
    )

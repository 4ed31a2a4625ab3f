"""The picture of a search: E over the number of parameters, one colour a bank."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from compensation.ranking import Ranked
from gcode.support.files import atomic_path

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#E69F00", "#56B4E9", "#CC79A7", "#000000", "#999999")
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "*")


def draw_search(ranking: Sequence[Ranked], path: str | Path) -> None:
    """Write a scatter of mean E over live seeds (bars: standard deviation) against the number of parameters."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9, 5), layout="constrained")
    axis = figure.subplots()
    banks = sorted({row.key.split()[0] for row in ranking})
    for bank, colour, marker in zip(banks, COLOURS, MARKERS, strict=False):
        rows = [row for row in ranking if row.key.split()[0] == bank]
        a, n = bank.split("^")
        axis.errorbar(
            [row.parameters for row in rows],
            [row.E for row in rows],
            [row.spread for row in rows],
            fmt=marker,
            ms=4,
            lw=0.6,
            color=colour,
            label=f"a = {a}, N = {n}",
        )
    axis.set(xscale="log", yscale="log", xlabel="weights and biases", ylabel="E (smaller is better)")
    best = ranking[0]
    axis.set_title(f"{len(ranking)} candidates; best {best.key}: E = {best.E:.4f}", loc="left", fontsize=11)
    axis.legend(fontsize=8, ncols=2, title="smoothing bank", title_fontsize=8)
    axis.grid(alpha=0.3, which="both", lw=0.4)
    with atomic_path(path) as temporary:
        figure.savefig(temporary, dpi=120)

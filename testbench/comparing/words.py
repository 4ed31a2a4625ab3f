"""Findings in the words of somebody who knows textiles and not statistics."""

from __future__ import annotations

import math

from testbench.comparing.cell import Cell

PERCENT = {"strain", "largest_strain"}


def place_in_words(channel: str, coordinate: str, cell: Cell, size: float) -> str:
    """One sentence: what the model does wrong, by how much, and where."""
    # measured minus modelled is negative where the model is too high
    way = "too high" if cell.mean < 0 else "too low"
    amount = abs(math.expm1(cell.mean)) if channel == "conductance" else abs(cell.mean) / size
    of = " of its range" if channel == "force" else ""
    return f"modelled {channel} is {100 * amount:.1f} %{of} {way} {_where(coordinate, cell)}"


def _where(coordinate: str, cell: Cell) -> str:
    low, high = (_number(coordinate, cell.low), _number(coordinate, cell.high))
    moving = {1: " while stretching", -1: " while releasing", 0: ""}[cell.direction]
    if coordinate == "strain":
        return f"between {low} and {high} strain{moving}"
    if coordinate == "largest_strain":
        return f"when the knit has seen at most {low} to {high} strain{moving}"
    if coordinate == "strain_rate":
        doing = "stretching" if cell.low + cell.high > 0 else "releasing"
        return f"at strain rates from {low} to {high} per second ({doing})"
    if coordinate == "elapsed_s":
        return f"from {low} to {high} s after the start"
    if coordinate == "since_reversal_s":
        return f"{low} to {high} s after a reversal{moving}"
    if coordinate == "since_hold_s":
        return f"{low} to {high} s into a hold"
    if coordinate == "cycle":
        return f"in cycles {low} to {high}"
    return f"between {low} and {high} °C"


def _number(coordinate: str, value: float) -> str:
    if coordinate in PERCENT:
        return f"{100 * value:.1f} %"
    return f"{value:.3g}"


def percent(share: float) -> str:
    """A probability or a share of something, never as 0 or 100 %."""
    if share < 0.01:
        return "< 1 %"
    return "> 99 %" if share > 0.99 else f"{100 * share:.0f} %"

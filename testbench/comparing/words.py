"""Findings in the words of somebody who knows textiles and not statistics."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from testbench.comparing.cell import HOLD_RATE, Cell
from testbench.comparing.numbers import over_noise, plain, span, with_error

if TYPE_CHECKING:
    from testbench.knit.model import KnitModel

DOING = {1: " while stretching", -1: " while releasing", 0: ""}
NOISE_REACHED = 1.1  # an error of at most this many noise floors is noise: nothing is left to be pointed at
FAR = 3.0  # noise floors: an error that is told even where nothing more is missing
MANY = math.log(1e6)  # log odds beyond this are "more than a million to one"


def spoken(name: str) -> str:
    """A catalogue name as words."""
    return str(name).replace("_", " ")


def place_in_words(channel: str, coordinate: str, cell: Cell) -> str:
    """One sentence: what the model does wrong, by how much, and where."""
    # The mean is measured minus modelled; of ln G, that is ln(measured / modelled).
    way = "too high" if cell.mean < 0 else "too low"
    relative = 100 * abs(math.expm1(-cell.mean))
    amount = f"{relative:.1f} %" if channel == "conductance" else f"{plain(abs(cell.mean), 2)} N"
    return f"modelled {channel} is {amount} {way} {where_in_words(coordinate, cell)}"


def no_place_in_words(over_noise: Mapping[str, float], quick: Mapping[str, float]) -> str:
    """What is said where no worst place is named, of the error of each channel over its noise floor.

    `quick` is the part of it that comes and goes between the points of the grid, where no effect is looked for.
    """
    above = [channel for channel, times in over_noise.items() if times > NOISE_REACHED]
    if not above:
        return "no place stands out from the noise"
    of = f"the error of the {' and the '.join(above)}"
    if all(quick[channel] > max(NOISE_REACHED, over_noise[channel] / math.sqrt(2)) for channel in above):
        return f"{of} comes and goes too quickly for any effect: a hum, or coloured noise"
    return f"{of} is spread out or in a few peaks: no single place can be named"


def still_off(errors: Mapping[str, float], floors: Mapping[str, float]) -> str:
    """Where nothing more is missing: that an error is far above its noise floor all the same; empty if none is."""
    times = {channel: over_noise(error, floors[channel]) for channel, error in errors.items()}
    worst = max(times, key=lambda channel: times[channel])
    return f"the error of the {worst} is {times[worst]:.0f} times its noise floor" if times[worst] > FAR else ""


def where_in_words(coordinate: str, cell: Cell) -> str:
    """A stretch of a coordinate; strains in % and rates in %/s."""
    low, high, doing = cell.low, cell.high, DOING[cell.direction]
    if coordinate == "strain":
        return f"between {span(100 * low, 100 * high, between='and')} % strain{doing}"
    if coordinate == "largest_strain":
        if 100 * (high - low) < 0.05:
            return f"once the knit has seen {100 * high:.1f} % strain{doing}"
        return f"when the knit has seen at most {span(100 * low, 100 * high)} % strain{doing}"
    if coordinate == "strain_rate":
        return f"at strain rates of {span(100 * low, 100 * high)} %/s{_moving(low, high)}"
    return _when(coordinate, low, high, doing)


def _moving(low: float, high: float) -> str:
    """What the knit does at strain rates (1/s) from `low` to `high`; empty where that is more than one thing."""
    if low >= HOLD_RATE or high <= -HOLD_RATE:
        return " (stretching)" if low > 0 else " (releasing)"
    return " (holding)" if low >= -HOLD_RATE and high <= HOLD_RATE else ""


def _when(coordinate: str, low: float, high: float, doing: str) -> str:
    if coordinate == "elapsed_s":
        return f"from {span(low, high, 's')} after the start"
    if coordinate == "since_reversal_s":
        return f"{span(low, high, 's')} after a reversal{doing}"
    if coordinate == "since_hold_s":
        return f"{span(low, high, 's')} into a hold"
    if coordinate == "cycle":
        return f"in cycles {low:.0f} to {high:.0f}"
    return f"between {span(low, high, '°C', between='and')}"


def percent_left(gain: float) -> float:
    """What is left of an RMS error, in %, where the logarithm of the squared error falls by `gain`."""
    return 100 * math.exp(-0.5 * gain)


def listed(names: Sequence[str]) -> str:
    """Names with commas, and an ``and`` before the last."""
    return ", ".join(names[:-1]) + (" and " if len(names) > 1 else "") + names[-1] if names else ""


def percent(share: float) -> str:
    """A probability or a share of something, never as 0 or 100 %."""
    if share < 0.01:
        return "< 1 %"
    return "> 99 %" if share > 0.99 else f"{100 * share:.0f} %"


def events_in_words(model: KnitModel, fitted: Mapping[str, Mapping[str, Any]]) -> dict[str, str]:
    """What effects do at moments of their own, such as slips: how much, and when; by the address of its sizes.

    Those that their errors do not tell from none are left out.

    Parameters
    ----------
    model : KnitModel
    fitted : mapping of address to mapping
        ``parameters`` of its fit.
    """
    found = {}
    for name, effect in model.effects.items():
        address = f"{name}.{effect.strength}"
        moments_s = [getattr(effect, key) for key in effect.jumps if isinstance(getattr(effect, key), tuple)]
        if moments_s and f"{address}[0]" in fitted:
            sizes = [fitted[f"{address}[{n}]"] for n in range(len(moments_s[0]))]
            told = [
                f"{with_error(size['value'], size['standard_error'], size['unit'])} at {plain(when_s, 4)} s"
                for when_s, size in sorted(zip(moments_s[0], sizes, strict=True), key=lambda one: one[0])
                if size["value"] > 2 * size["standard_error"]
            ]
            found[address] = "; ".join(told) or "none"
    return found

"""A proposed experiment as text for the terminal."""

from __future__ import annotations

import math
from collections.abc import Sequence

from testbench.comparing.model_errors import channel_name
from testbench.comparing.words import MANY
from testbench.design.experiment import Option
from testbench.design.imitation import Rival
from testbench.design.protocols import NOISE


def odds(log_odds: float) -> str:
    """``150 : 1``, at most a million."""
    if log_odds > MANY:
        return "> 1e6 : 1"
    return f"{math.exp(log_odds):.3g} : 1"


def experiment_table(rivals: Sequence[Rival], options: Sequence[Option]) -> str:
    """Every protocol with what it would show, the best first, and a sentence on the winner."""
    lines = [
        f"rivals: {' against '.join(rival.name for rival in rivals)}",
        "",
        f"{'protocol':<20}{'minutes':>8}{'left over':>11}{'log odds':>11}{'x noise':>9}   {'it will':<14}seen in",
    ]
    reference = max(_noise(options).hardest.log_odds, 1e-6)
    for option in options:
        shown = option.hardest
        numbers = f"{shown.noise_units:>9.2f} n{shown.log_odds:>11.3g}{shown.log_odds / reference:>9.3g}"
        minutes = option.made.trajectory.duration_s / 60
        words = f"{option.grade:<14}{channel_name(shown.channel)}"
        lines.append(f"{option.name:<20}{minutes:>8.1f}{numbers}   {words}")
    lines += [
        "",
        "left over: RMS that the wrong model cannot imitate, over what a fit leaves anyway (n)",
        verdict(options),
    ]
    return "\n".join(lines)


def _noise(options: Sequence[Option]) -> Option:
    """Random motion; where that cannot be driven, the last protocol."""
    return next((option for option in options if option.name == NOISE), options[-1])


def verdict(options: Sequence[Option]) -> str:
    """One sentence on the winner, and on what it gains over plain noise."""
    best = options[0]
    noise = _noise(options)
    if best.grade == "cannot tell":
        return (
            "none of these protocols can tell the rivals apart; try longer, faster or larger strains, "
            "or lower the noise"
        )
    sentence = f"propose {best.name}: {best.grade}, expected odds {odds(best.hardest.log_odds)}"
    if best is noise or noise.hardest.log_odds <= 0:
        return sentence
    ratio = best.hardest.log_odds / noise.hardest.log_odds
    return f"{sentence}; its evidence is {ratio:.3g} times that of plain noise"

"""An effect: what it does at which stages of the chain, for a size that is 0 where it is not there.

Stages: ``displacement`` in mm, ``strain``, ``force`` in N, ``driver`` of the contacts, ``conductance`` (ln G),
``force_reading`` in N, ``resistance_reading`` (ln R).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from worlds_fourth.randoms import Rng
from worlds_fourth.signals import Hooks
from worlds_fourth.specimen import Specimen

READINGS = ("force_reading", "resistance_reading")
OF_RESISTANCE = ("driver", "conductance", "resistance_reading")  # stages that the force does not show


@dataclass(frozen=True)
class Effect:
    """A law with its numbers.

    Attributes
    ----------
    text : str
        What it does, with its numbers; a is the size.
    largest : float
        The largest size that makes sense.
    hooks : mapping
        Stage -> what it does there.
    clips : str
        The reading whose noise it clips too, if any.
    """

    text: str
    largest: float
    hooks: Hooks
    clips: str = ""


Draw = Callable[[Rng, Specimen], Effect]


@dataclass(frozen=True)
class Form:
    """One law of a mechanism; `draw` draws its numbers for a specimen."""

    mechanism: str
    name: str
    draw: Draw


def form_of(forms: list[Form], mechanism: str) -> Callable[[Draw], Draw]:
    """Decorator: add a function to `forms`, under its own name. Their order counts: a law is drawn by its place."""

    def add(draw: Any) -> Draw:
        forms.append(Form(mechanism, draw.__name__, draw))
        return draw

    return add

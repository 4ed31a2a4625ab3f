"""A base, or a base with one effect put in, refitted and scored."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from testbench.discrepancy.baseline import SHAPES
from testbench.discrepancy.candidates import Candidate, is_vector
from testbench.discrepancy.evidence import Evidence
from testbench.discrepancy.fit import Fit

SHAPES_MUST_PAY = 0.02  # in ln(RMS), for the flexible base to be kept


@dataclass(frozen=True)
class Bases:
    """The base fitted stiff, and with its shape freedom."""

    stiff: Fit
    flexible: Fit


@dataclass(frozen=True)
class Entrant:
    """A refitted model and its errors.

    Attributes
    ----------
    name : str
        Catalogue effect that was put in; empty for the base alone.
    idea : str
    fit : Fit
    score : float
        Mean of ln(RMS) over channels and over both recordings; lower is better.
    held : dict of channel to float
        Held-out RMS.
    """

    name: str
    idea: str
    fit: Fit
    score: float
    held: Mapping[str, float]

    @property
    def candidate(self) -> Candidate:
        """The effect as it was fitted."""
        effect = self.fit.model[self.name]
        return Candidate(self.idea, effect, getattr(effect, effect.strength), from_data=True)


def has_events(entrant: Entrant) -> bool:
    """Whether its effect consists of events at moments of their own."""
    effect = entrant.fit.model[entrant.name]
    return is_vector(type(effect), effect.strength)


def bends(entrant: Entrant) -> bool:
    """Whether its base has shape freedom."""
    return any(name in SHAPES for name in entrant.fit.model)


def spoken_for_by(entry: Evidence, entrant: Entrant) -> Evidence:
    """The evidence with the entrant's form to speak for the idea."""
    if entrant.name == entry.form:
        return entry
    return replace(entry, form=entrant.name, candidate=entrant.candidate, coefficient=1.0)

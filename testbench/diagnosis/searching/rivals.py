"""Finds the rivals of a law: laws of other mechanisms that could explain what it explains."""

from __future__ import annotations

from dataclasses import replace

from testbench.diagnosis.judging.entries import Entry, Proposal
from testbench.diagnosis.searching.fits import Fits
from testbench.diagnosis.searching.proposals import Screen, laws_of
from testbench.fitting.evidence.laplace import fitted


def rivals_of(e: Entry, fits: Fits) -> list[Proposal]:
    """What laws of other mechanisms promise where nothing is to be explained but what a law does, the best first.

    What a model with the law says stands for the measurement: there is no noise in it, and nothing else is missing.
    Of what a measurement leaves, another effect may be the larger part, and hides which laws are alike.
    """
    said = fits.measurement.modelled(e.hypothesis.model)
    likelihood = replace(fits.compared, measurement=replace(fits.measurement, measured=said))
    without = fitted(e.base, likelihood, fits.reference, e.hypothesis, iterations=0)
    left = e.hypothesis.evidence.sigma  # counts as the noise
    evidence, normal = replace(without.evidence, sigma=left), replace(without.normal, least=left)
    without = replace(without, evidence=evidence, normal=normal)
    found = Screen(without, likelihood).proposals(laws_of(without, fits.compared, fits.catalogue))
    return [p for p in found if p.mechanism != e.mechanism]

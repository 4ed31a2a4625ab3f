"""Residuals of the logarithm of the conductance, as differences of the resistance in kΩ."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from gcode.support.arrays import FloatArray
from testbench.report.figures.comparison_figures import instead_of_conductance, resistance_kohm

if TYPE_CHECKING:
    from testbench.comparing.contribution import Contribution


def residuals_kohm(
    measured_ln_S: FloatArray, left_ln_S: FloatArray, added_ln_S: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """What a model leaves, and what an effect would add to it, as resistance.

    With R = exp(-ln G), a model that is ``left`` too low in ln G has the resistance R exp(left); what it leaves in R
    is R - R exp(left), and an effect that adds exactly what is left takes exactly that away.

    Parameters
    ----------
    measured_ln_S, left_ln_S, added_ln_S : ndarray, shape (n,)
        ln (G / S) as measured, measured minus modelled, and modelled with minus modelled without the effect.

    Returns
    -------
    tuple of ndarray, shape (n,)
        The latter two in kΩ.
    """
    measured_kohm = resistance_kohm(measured_ln_S)
    modelled_kohm = measured_kohm * np.exp(left_ln_S)
    return measured_kohm - modelled_kohm, modelled_kohm * np.expm1(-added_ln_S)


def contribution_kohm(found: Contribution, measured_ln_S: FloatArray) -> Contribution:
    """What a model leaves and an effect would add, with the resistance in kΩ instead of ln G."""
    left, added = residuals_kohm(measured_ln_S, found.residual["conductance"], found.added["conductance"])
    return replace(
        found,
        residual=instead_of_conductance(found.residual, left),
        added=instead_of_conductance(found.added, added),
    )

"""Elastic laws: how force follows strain, without history."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from testbench.knit.effect import Effect, FloatArray, Points, Signals, Stage, bounds_of, parameter

LEVELS = 50  # of the strain that count alike where a law is drawn to data
NEAREST = 0.98  # to the end of its chains, where a law that locks is still looked at


class ElasticLaw(Effect):
    """Base of elastic laws: a few curves over strain, each times a coefficient.

    A subclass says which parameters are the coefficients (`linear`), where to look for the others (`bends`), and
    draws the curves.
    """

    stage = Stage.MECHANICS
    mechanism = "elasticity"
    in_base = True
    reads, writes = ("strain",), ("force_N",)
    linear: ClassVar[tuple[str, ...]]
    bends: ClassVar[tuple[Mapping[str, float], ...]] = ({},)

    def curves(self, e: FloatArray) -> tuple[FloatArray, ...]:
        """The curve of each coefficient over the strain, each shape (n,)."""
        raise NotImplementedError

    def apply(self, signals: Signals, dt_s: float) -> dict[str, FloatArray]:
        curves = self.curves(signals["strain"])
        return {"force_N": sum(getattr(self, key) * curve for key, curve in zip(self.linear, curves, strict=True))}

    def starts(self, signals: Signals, residual: Signals) -> Points:
        """Where the law follows the measured force best, its loops averaged, each strain alike.

        A hold of half an hour says nothing of the other strains.
        """
        if "force_N" not in signals:
            return []
        strain, force_N = signals["strain"], signals["force_N"] + residual.get("force", 0.0)
        return [self.drawn_to(strain, force_N, 1 / _times_seen(strain)).model_dump()]

    def drawn_to(self, e: FloatArray, force_N: FloatArray, weight: FloatArray) -> ElasticLaw:
        """The law that is nearest to a force over strain: least squares at each of its `bends`, the best of them.

        Parameters
        ----------
        e, force_N, weight : ndarray, shape (n,)
        """
        bounds = [bounds_of(type(self).model_fields[key]) for key in self.linear]
        low, high = (np.array([one[side] for one in bounds]) for side in ("low", "high"))
        best, least = self, np.inf
        for bend in self.bends:
            law: Any = self.near(**bend)
            columns = np.stack(law.curves(e), axis=1)
            weighted, wanted = columns * np.sqrt(weight)[:, None], force_N * np.sqrt(weight)
            size = np.maximum(np.linalg.norm(weighted, axis=0), 1e-300)
            found = np.linalg.lstsq(weighted / size, wanted, rcond=1e-12)[0] / size
            if np.any((found < low) | (found > high)):  # where one coefficient has to stop, the others make up for it
                from scipy.optimize import lsq_linear

                found = lsq_linear(weighted / size, wanted, (low * size, high * size), method="bvls").x / size
            misfit = float(np.average((force_N - columns @ found) ** 2, weights=weight))
            if misfit < least:
                coefficients = zip(self.linear, found, strict=True)
                best, least = law.near(**{key: float(value) for key, value in coefficients}), misfit
        return best


def _times_seen(strain: FloatArray) -> FloatArray:
    """Samples that lie within the same `LEVELS`th of the range, shape (n,)."""
    low, high = float(np.min(strain)), float(np.max(strain))
    level = np.minimum((LEVELS * (strain - low) / max(high - low, 1e-12)).astype(int), LEVELS - 1)
    return np.bincount(level, minlength=LEVELS)[level].astype(float)


class Elasticity(ElasticLaw):
    """J-curve of a knit: loops straighten at low strain, yarn stretches at high strain.

    F(e) = offset + stiffness * (exp(curvature e) - 1) / curvature

    `stiffness` is the slope at zero strain [N per unit strain]; `curvature` = 0 is a straight line.

    Source: Fung, Am. J. Physiol. 213 (1967) 1532, Eq. 6 (exponential law of soft fibrous tissue).
    Valid: monotonic loading below yarn damage, about 0 <= e <= 0.6.
    """

    name = "elasticity"
    look = "force rises with strain, the steeper the further the knit is stretched"
    linear = ("offset_N", "stiffness_N")
    bends = tuple({"curvature": curvature} for curvature in (-4.0, -2.0, -0.5, 0.5, 1.5, 3.0, 5.0, 8.0, 12.0))

    stiffness_N: float = parameter(8.0, unit="N", low=1e-3, high=1e4, scale="log", doc="slope at zero strain")
    curvature: float = parameter(3.0, unit="1", low=-10, high=30, doc="how fast the slope grows with strain")
    offset_N: float = parameter(0.0, unit="N", low=-100, high=100, doc="force at zero strain (not tared)")

    def curves(self, e: FloatArray) -> tuple[FloatArray, ...]:
        c = self.curvature
        return np.ones_like(e), np.expm1(c * e) / c if abs(c) > 1e-6 else e


class ElasticityCubic(ElasticLaw):
    """A cubic: steep, soft and steep again, as a knit is whose friction holds its loops at first.

    F(e) = offset + stiffness e + square e^2 + cube e^3

    Source: Mooney, J. Appl. Phys. 11 (1940) 582, expanded in strain.
    Valid: between the strains of the fit.
    """

    name = "elasticity_cubic"
    look = "force rises with strain, steeply at first, less steeply, and steeply again"
    linear = ("offset_N", "stiffness_N", "square_N", "cube_N")

    stiffness_N: float = parameter(8.0, unit="N", low=-1e4, high=1e4, doc="slope at zero strain")
    square_N: float = parameter(10.0, unit="N", low=-1e5, high=1e5, doc="force of the square at strain 1")
    cube_N: float = parameter(20.0, unit="N", low=-1e6, high=1e6, doc="force of the cube at strain 1")
    offset_N: float = parameter(0.0, unit="N", low=-100, high=100, doc="force at zero strain (not tared)")

    def curves(self, e: FloatArray) -> tuple[FloatArray, ...]:
        return np.ones_like(e), e, e**2, e**3


class ElasticityOgden(ElasticLaw):
    """Rubber with a textile around it: one term of Ogden's law for uniaxial stretch, and a straight line.

    F(e) = offset + modulus * (l^(power - 1) - l^(-power / 2 - 1)) + linear e,   l = 1 + e

    Source: Ogden, Proc. R. Soc. A 326 (1972) 565, Eq. 28 (incompressible, uniaxial).
    Valid: e > -0.5.
    """

    name = "elasticity_ogden"
    look = "force rises with strain as that of a rubber band: hardly bent, then ever more steeply"
    linear = ("offset_N", "modulus_N", "linear_N")
    bends = tuple({"power": power} for power in (1.5, 2.5, 4.0, 6.0, 8.0, 10.0, 12.0, 14.0, 17.0, 20.0, 25.0))

    modulus_N: float = parameter(1.0, unit="N", low=0, high=1e4, doc="force of the rubber's term")
    power: float = parameter(8.0, unit="1", low=1.1, high=30, scale="log", doc="how suddenly it stiffens")
    linear_N: float = parameter(3.0, unit="N", low=-1e4, high=1e4, doc="slope of the straight line")
    offset_N: float = parameter(0.0, unit="N", low=-100, high=100, doc="force at zero strain (not tared)")

    def curves(self, e: FloatArray) -> tuple[FloatArray, ...]:
        stretch = 1 + np.maximum(e, -0.5)
        return np.ones_like(e), stretch ** (self.power - 1) - stretch ** (-0.5 * self.power - 1), e


class ElasticityTwoSlopes(ElasticLaw):
    """Two stiffnesses with a knee between them: first the loops unfold, then the yarn stretches.

    F(e) = offset + stiffness e + more * width * ln(1 + exp((e - knee) / width))

    Source: toe and linear region of fibrous materials, Fung, Biomechanics (1993), ch. 7; the knee is the usual smooth
    ramp.
    Valid: also for one that softens (`more` < 0).
    """

    name = "elasticity_two_slopes"
    look = "force over strain is two straight lines with a bend between them"
    linear = ("offset_N", "stiffness_N", "more_N")
    bends = tuple(
        {"knee": knee, "width": width}
        for knee in (0.03, 0.06, 0.09, 0.12, 0.15, 0.18, 0.21, 0.25, 0.3, 0.36, 0.42)
        for width in (0.005, 0.02, 0.06)
    )

    stiffness_N: float = parameter(8.0, unit="N", low=-1e4, high=1e4, doc="slope below the knee")
    more_N: float = parameter(10.0, unit="N", low=-1e4, high=1e4, doc="slope above the knee less that below it")
    knee: float = parameter(0.15, unit="1", low=0.005, high=2, scale="log", doc="strain at the knee")
    width: float = parameter(0.02, unit="1", low=1e-3, high=0.5, scale="log", doc="strain over which it bends")
    offset_N: float = parameter(0.0, unit="N", low=-100, high=100, doc="force at zero strain (not tared)")

    def curves(self, e: FloatArray) -> tuple[FloatArray, ...]:
        return np.ones_like(e), e, self.width * np.logaddexp(0.0, (e - self.knee) / self.width)


class ElasticityGent(ElasticLaw):
    """Rubber or loops that lock: Gent's law of chains that come to their end, and a straight line.

    F(e) = offset + linear e + modulus (l - 1 / l^2) / (1 - J / J_m),   l = 1 + e,   J = l^2 + 2 / l - 3

    J_m is J at the strain `locking`, where the force would be infinite.

    Source: Gent, Rubber Chem. Technol. 69 (1996) 59 (incompressible, uniaxial).
    Valid: -0.5 < e < `locking`; where e < 0 nothing locks, and J counts as 0.
    """

    name = "elasticity_gent"
    look = "force rises with strain ever more steeply, towards a strain that it cannot pass"
    linear = ("offset_N", "modulus_N", "linear_N")
    bends = tuple({"locking": float(locking)} for locking in np.geomspace(0.02, 4.0, 24))

    modulus_N: float = parameter(1.0, unit="N", low=0, high=1e4, doc="force of the chains")
    locking: float = parameter(0.5, unit="1", low=0.01, high=10, scale="log", doc="strain where it locks")
    linear_N: float = parameter(3.0, unit="N", low=-1e4, high=1e4, doc="slope of the straight line")
    offset_N: float = parameter(0.0, unit="N", low=-100, high=100, doc="force at zero strain (not tared)")

    def curves(self, e: FloatArray) -> tuple[FloatArray, ...]:
        stretch = 1 + np.maximum(e, -0.5)
        share = _invariant(stretch) / _invariant(1 + self.locking)
        chains = (stretch - stretch**-2) / (1 - np.minimum(np.where(e > 0, share, 0.0), NEAREST))
        return np.ones_like(e), chains, e


def _invariant(stretch: Any) -> Any:
    """First invariant of the stretch, less that at rest."""
    return stretch**2 + 2 / stretch - 3

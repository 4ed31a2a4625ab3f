"""Softening that stays: the Mullins effect, and fatigue."""

from __future__ import annotations

import numpy as np

from testbench.knit.additive import ForceFactor
from testbench.knit.effect import FloatArray, Points, Signals, Vector, parameter, zeros
from testbench.knit.filters import DEAD_BAND_STRAIN, factor_of
from testbench.knit.shapes.curves import LAW_TERMS, curve


class MullinsLaw(ForceFactor):
    """Base of the laws of Mullins softening: a knit softer than a virgin one."""

    mechanism = "mullins_softening"
    strength = "softening"


def lost_below(strain: FloatArray, top: FloatArray, span: float, power: float, growth: float = 1.0) -> FloatArray:
    """Force lost below the stretch `top`, over that lost at rest after a stretch to `span`, shape (n,)."""
    return np.minimum((top / span) ** growth, 1 / 0.9) * (1 - np.clip(strain / top, 0.0, 1.0) ** power)


class MullinsSoftening(MullinsLaw):
    """Below the largest stretch so far the knit is softer than a virgin one (pseudo-elastic).

    F *= 1 - softening * erf((w_max - w) / (width + w_max / 2)),   w = e^2 / 2

    w stands for the strain energy, w_max for its largest value so far; on the virgin curve w = w_max and nothing
    happens.

    Source: Ogden & Roxburgh, Proc. R. Soc. A 455 (1999) 2861, doi:10.1098/rspa.1999.0431, with the energy
    of a linear spring.
    Valid: the first few stretches; no healing.
    """

    name = "mullins_softening"
    look = "the first stretch to a new length needs more force than all later ones"

    softening: float = parameter(0.2, unit="1", low=0, high=0.9, doc="largest share of the force that is lost")
    width: float = parameter(0.01, unit="1", low=1e-5, high=1, scale="log", doc="drop of e^2/2 over which it sets in")

    def change(self, signals: Signals, dt_s: float) -> FloatArray:
        from scipy.special import erf

        energy = 0.5 * signals["strain"] ** 2
        top = np.maximum.accumulate(energy)
        return 1 - self.softening * erf((top - energy) / (self.width + 0.5 * top))


class MullinsSofteningPower(MullinsLaw):
    """Below the largest stretch so far the knit is softer, as a power of how far below it is.

    F *= 1 - softening * min((e_max / span)^growth, 1 / 0.9) * (1 - (e / e_max)^power)

    Source: pseudo-elasticity as `mullins_softening`; powers of the relative strain in place of its error function.
    Valid: the first few stretches; no healing; `span` is the largest strain of the recording.
    """

    name = "mullins_softening_power"
    look = "after a stretch, shorter ones need less force, until the old largest stretch is reached again"

    softening: float = parameter(0.2, unit="1", low=0, high=0.9, doc="share of the force lost at zero strain")
    growth: float = parameter(1.0, unit="1", low=0, high=4, doc="how the loss grows with the largest stretch")
    power: float = parameter(1.5, unit="1", low=0.3, high=8, scale="log", doc="how late the force comes back")
    span: float = parameter(0.3, unit="1", low=1e-3, high=5, doc="strain at which the loss is counted")

    def change(self, signals: Signals, dt_s: float) -> FloatArray:
        strain, top = signals["strain"], np.maximum.accumulate(signals["strain"])
        lost = lost_below(strain, np.maximum(top, 1e-6), self.span, self.power, self.growth)
        lost[strain >= top] = 0.0  # never stretched farther, however little that is
        return 1 - self.softening * lost


class MullinsSofteningDamage(MullinsLaw):
    """Each new largest stretch breaks bonds for good: one damage variable for all strains.

    F *= 1 - softening * (d(e_max) - d(e_0)),   d(e) = 1 - exp(-e / scale)

    Source: Simo, Comput. Methods Appl. Mech. Eng. 60 (1987) 153, doi:10.1016/0045-7825(87)90107-1.
    Valid: no healing; counted from the first sample.
    """

    name = "mullins_softening_damage"
    look = "after each new largest stretch the knit stays softer at every strain"

    softening: float = parameter(0.2, unit="1", low=0, high=0.9, doc="share of the force lost in the end")
    scale: float = parameter(0.2, unit="1", low=0.005, high=3, scale="log", doc="strain at which 63 % is lost")

    def change(self, signals: Signals, dt_s: float) -> FloatArray:
        top = np.maximum(np.maximum.accumulate(signals["strain"]), 0.0)
        damage = -np.expm1(-(top - top[0]) / self.scale) * np.exp(-top[0] / self.scale)
        return 1 - self.softening * damage


class MullinsSofteningCurve(MullinsLaw):
    """Below the largest stretch so far the knit is softer, along a smooth curve of any form.

    F *= exp( e_max / span * (curve(1 - e / e_max) - curve(0)) )

    Source: pseudo-elasticity as `mullins_softening`; the curve as in `elasticity_shape`.
    Valid: the first few stretches; no healing; `span` is the largest strain of the recording.
    """

    name = "mullins_softening_curve"
    strength = "weights"
    look = "after a stretch, shorter ones need less force, however much at each length"

    weights: Vector = zeros(LAW_TERMS, unit="1", most=3, doc="weights of the curve")
    span: float = parameter(0.3, unit="1", low=1e-3, high=5, doc="strain at which the loss is counted")

    def change(self, signals: Signals, dt_s: float) -> FloatArray:
        top = np.maximum(np.maximum.accumulate(signals["strain"]), 1e-6)
        below = 1 - np.clip(signals["strain"] / top, 0.0, 1.0)
        softer = curve(below, 0.0, 1.0, self.weights) - curve(np.zeros(1), 0.0, 1.0, self.weights)
        return factor_of(top / self.span * softer)


class MullinsSofteningHealing(MullinsLaw):
    """Below the largest stretch that it still remembers the knit is softer, and it forgets: with time it heals.

    F *= 1 - softening * min(top / span, 1 / 0.9) * (1 - (e / top)^power)
    top follows e at once where that is higher, else  d top / dt = -(top - e) / heal

    Source: softening as `mullins_softening_power`; recovery with time as reviewed by Diani, Fayolle & Gilormini, Eur.
    Polym. J. 45 (2009) 601.
    Valid: one time of recovery; `span` is the largest strain of the recording.
    """

    name = "mullins_softening_healing"
    look = "after a stretch, shorter ones need less force, for a while"

    softening: float = parameter(0.2, unit="1", low=0, high=0.9, doc="share of the force lost at zero strain")
    heal_s: float = parameter(100.0, unit="s", low=2, high=1e5, scale="log", doc="time constant of the recovery")
    power: float = parameter(1.5, unit="1", low=0.3, high=8, scale="log", doc="how late the force comes back")
    span: float = parameter(0.3, unit="1", low=1e-3, high=5, doc="strain at which the loss is counted")

    def change(self, signals: Signals, dt_s: float) -> FloatArray:
        from testbench.knit.memories import two_way_lag

        strain = np.ascontiguousarray(signals["strain"])
        top = np.maximum(np.maximum(two_way_lag(strain, 0.0, self.heal_s, dt_s), strain), 1e-6)
        return 1 - self.softening * lost_below(strain, top, self.span, self.power)


def cycled_strain(signals: Signals) -> FloatArray:
    """Strain path travelled so far, noise left out."""
    from testbench.knit.kernels import travelled

    return travelled(signals["strain"], DEAD_BAND_STRAIN)


def weibull(x: FloatArray, scale: float, shape: float) -> FloatArray:
    """Share 1 - exp(-(x / scale)^shape) of parts that differ in their lives, shape (n,)."""
    return -np.expm1(-((np.maximum(x, 0.0) / scale) ** shape))


def weibull_points(path: FloatArray) -> Points:
    """Scales and shapes of `weibull` where a fit may start on a path, shape (n,)."""
    whole = max(float(path[-1]), 1e-3)
    return [{"scale": share * whole, "shape": shape} for share in (0.2, 1.0, 5.0) for shape in (0.4, 0.7, 1.5, 3.0)]


class LevellingOff(ForceFactor):
    """Base of the laws of a loss that ends: F *= 1 - loss * tired, with `tired` from 0 to 1."""

    mechanism = "cyclic_fatigue"
    strength = "loss"

    loss: float = parameter(0.1, unit="1", low=0, high=0.9, doc="share of the force lost in the end")

    def tired(self, signals: Signals) -> FloatArray:
        """Share of the loss that has come so far, shape (n,)."""
        raise NotImplementedError

    def change(self, signals: Signals, dt_s: float) -> FloatArray:
        return 1 - self.loss * self.tired(signals)


class CyclicFatigue(LevellingOff):
    """The knit loses force with every cycle and levels off.

    F *= 1 - loss * (1 - exp(-path / scale)),   path = integral of |de|, 0.004 less at each turn

    Source: Chaboche, Int. J. Plasticity 5 (1989) 247 (cyclic softening over the accumulated strain).
    Valid: conditioning and fatigue before rupture. Path counts from the first sample.
    """

    name = "cyclic_fatigue"
    look = "the peaks of the force sink from cycle to cycle, not in a hold"

    scale: float = parameter(5.0, unit="1", low=0.1, high=1e5, scale="log", doc="strain path for 63 % of it")

    def tired(self, signals: Signals) -> FloatArray:
        return -np.expm1(-cycled_strain(signals) / self.scale)


class CyclicFatigueLog(ForceFactor):
    """The knit loses the same share of force in every tenfold number of cycles.

    F *= max(1 - per_decade * log10(1 + path / scale), 0),   path = integral of |de|, 0.004 less at each turn

    Source: engineering use, after the straight lines that cyclic softening shows over the logarithm of cycles.
    Valid: before rupture.
    """

    name = "cyclic_fatigue_log"
    mechanism = "cyclic_fatigue"
    strength = "per_decade"
    look = "the peaks of the force sink with the logarithm of the cycle number"

    per_decade: float = parameter(0.05, unit="1", low=0, high=0.3, doc="share of force lost per decade of path")
    scale: float = parameter(1.0, unit="1", low=0.01, high=1e3, scale="log", doc="strain path where it sets in")

    def change(self, signals: Signals, dt_s: float) -> FloatArray:
        decades = np.log1p(cycled_strain(signals) / self.scale) / np.log(10)
        return np.maximum(1 - self.per_decade * decades, 0.0)


class CyclicFatigueWeibull(CyclicFatigue):
    """The knit loses force with the strain path: at once and ever more slowly, or late and then quickly.

    F *= 1 - loss * (1 - exp(-(path / scale)^shape)),   path = integral of |de|, 0.004 less at each turn

    `shape` below 1: the weak parts go first, nearly with a power of the path; above 1: after an incubation.

    Source: Weibull, J. Appl. Mech. 18 (1951) 293 (lives of parts that differ).
    Valid: before rupture. Path counts from the first sample.
    """

    name = "cyclic_fatigue_weibull"
    look = "the peaks of the force sink from cycle to cycle, early or late, not in a hold"

    shape: float = parameter(0.6, unit="1", low=0.2, high=4, scale="log", doc="below 1: early; above 1: late")

    def starts(self, signals: Signals, residual: Signals) -> Points:
        return weibull_points(cycled_strain(signals))

    def tired(self, signals: Signals) -> FloatArray:
        return weibull(cycled_strain(signals), self.scale, self.shape)


class CyclicFatigueSwings(LevellingOff):
    """Large swings tire a knit more than many small ones of the same path.

    F *= 1 - loss * (1 - exp(-n / scale)),   n = integral of (r / span)^power |de|

    r is how far the strain has gone since it last turned; each swing adds its size to the power of `power` + 1.

    Source: Basquin, Proc. ASTM 10 (1910) 625 (lives fall with a power of the amplitude), and Miner, J. Appl. Mech. 12
    (1945) A159 (damage adds up), as in rainflow counting without nested cycles.
    Valid: before rupture; `span` is the largest strain of the recording.
    """

    name = "cyclic_fatigue_swings"
    look = "the peaks of the force sink after each large cycle, hardly with many small ones"

    scale: float = parameter(2.0, unit="1", low=0.01, high=1e5, scale="log", doc="weighted path for 63 % of it")
    power: float = parameter(2.0, unit="1", low=0.3, high=8, scale="log", doc="how much more large swings count")
    span: float = parameter(0.3, unit="1", low=1e-3, high=5, doc="strain at which the path counts once")

    def starts(self, signals: Signals, residual: Signals) -> Points:
        whole = {power: max(float(self._damage(signals, power)[-1]), 1e-3) for power in (1.0, 3.0)}
        return [{"power": power, "scale": share * n} for power, n in whole.items() for share in (0.2, 1.0, 5.0)]

    def tired(self, signals: Signals) -> FloatArray:
        return -np.expm1(-self._damage(signals, self.power) / self.scale)

    def _damage(self, signals: Signals, power: float) -> FloatArray:
        from testbench.knit.kernels import last_turn

        strain = signals["strain"]
        turned = strain[last_turn(strain, DEAD_BAND_STRAIN)]
        ends = np.abs(np.stack((np.r_[strain[0], strain[:-1]], strain)) - turned) / self.span
        near, far = ends.min(axis=0), ends.max(axis=0)
        # The mean of the power over a step, exactly, but where that is a difference of equal numbers.
        short = far - near < 1e-6 * far + 1e-12
        mean = (far ** (power + 1) - near ** (power + 1)) / ((power + 1) * np.where(short, 1.0, far - near))
        return np.cumsum(np.diff(cycled_strain(signals), prepend=0.0) * np.where(short, far**power, mean))

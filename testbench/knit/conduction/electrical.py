"""Changes of the conductance after the contacts: drift, wear and cracks of the coating, a memory of the direction."""

from __future__ import annotations

import numpy as np

from testbench.knit.additive import ConductanceLaw
from testbench.knit.effect import FloatArray, Points, Signals, parameter
from testbench.knit.mechanics.damage import cycled_strain, weibull, weibull_points
from testbench.knit.mechanics.hysteresis import mean_slip


class DriftLaw(ConductanceLaw):
    """Base of the laws of drift: ln G depends on the time elapsed."""

    mechanism = "drift"
    in_base = True
    reads = ("time_s", "conductance_S")


class Drift(DriftLaw):
    """Logarithmic drift of the conductance as contacts settle.

    ln G += ln(10) * per_decade * log10(1 + t / tau)

    Source: Greenwood & Williamson, Proc. R. Soc. A 295 (1966) 300 (creep of asperities grows like log time).
    Valid: times from a fraction of tau to days.
    """

    name = "drift"
    strength = "per_decade"
    look = "conductance creeps in one direction, quickly at first, ever more slowly"

    per_decade: float = parameter(0.03, unit="1", low=-1, high=1, doc="log10 change of G per decade of time")
    tau_s: float = parameter(10.0, unit="s", low=0.1, high=1e5, scale="log", doc="when the drift sets in")

    def log_change(self, signals: Signals, dt_s: float) -> FloatArray:
        return self.per_decade * np.log1p(signals["time_s"] / self.tau_s)


class DriftExponential(DriftLaw):
    """Drift of the conductance that comes to an end.

    ln G += amount * (1 - exp(-t / tau))

    Source: first-order approach to a new equilibrium (moisture, relaxation of a mounting).
    Valid: one dominating process.
    """

    name = "drift_exponential"
    strength = "amount"
    look = "conductance creeps in one direction and stops"

    amount: float = parameter(0.1, unit="1", low=-3, high=3, doc="change of ln G in the end")
    tau_s: float = parameter(300.0, unit="s", low=1, high=1e5, scale="log", doc="time in which 63 % of it is done")

    def log_change(self, signals: Signals, dt_s: float) -> FloatArray:
        return -self.amount * np.expm1(-signals["time_s"] / self.tau_s)


class DriftPower(DriftLaw):
    """Drift of the conductance with a power of time: straight for 1, diffusive for 1/2.

    ln G += per_hour * (t / 1 h)^exponent

    Source: Crank, The Mathematics of Diffusion (1975), ch. 4 (exponent 1/2: uptake of moisture at short times).
    Valid: far from the end of the process.
    """

    name = "drift_power"
    strength = "per_hour"
    look = "conductance creeps on and on in one direction"

    per_hour: float = parameter(0.1, unit="1", low=-5, high=5, doc="change of ln G in the first hour")
    exponent: float = parameter(1.0, unit="1", low=0.2, high=1.5, doc="1: linear; 0.5: diffusion")

    def log_change(self, signals: Signals, dt_s: float) -> FloatArray:
        return self.per_hour * (signals["time_s"] / 3600) ** self.exponent


class WearLaw(ConductanceLaw):
    """Base of the laws of wear: conductance lost with the path that the yarns rub."""

    mechanism = "coating_wear"
    strength = "loss"


class CoatingWear(WearLaw):
    """Rubbing yarns wear their conductive coating off: conductance falls with the path they rub.

    ln G -= loss * path / 100,   path = integral of |de|, 0.004 less at each turn

    Source: Archard, J. Appl. Phys. 24 (1953) 981 (wear volume in proportion to the sliding path).
    Valid: thick coating, constant load.
    """

    name = "coating_wear"
    look = "conductance falls with every cycle, not in a rest"

    loss: float = parameter(0.05, unit="1", low=0, high=20, doc="fall of ln G in 100 units of strain path")

    def log_change(self, signals: Signals, dt_s: float) -> FloatArray:
        return -self.loss * cycled_strain(signals) / 100


class CoatingWearThrough(WearLaw):
    """The coating gets thinner by the same amount on every path, until it is worn through.

    ln G += ln(1 - loss * path / 100),   path = integral of |de|, 0.004 less at each turn

    Source: Archard, J. Appl. Phys. 24 (1953) 981; the conductance of a film is in proportion to its thickness.
    Valid: constant load; at least 1 % of the coating is left.
    """

    name = "coating_wear_through"
    look = "conductance falls with every cycle, ever faster, not in a rest"

    loss: float = parameter(0.05, unit="1", low=0, high=20, doc="share of coating lost in 100 units of strain path")

    def log_change(self, signals: Signals, dt_s: float) -> FloatArray:
        return np.log(np.maximum(1 - self.loss * cycled_strain(signals) / 100, 0.01))


class CoatingWearRunningIn(WearLaw):
    """The coating wears most at first: what stands out is rubbed off, the rest is pressed flat.

    ln G -= loss * ln(1 + path / running_in),   path = integral of |de|, 0.004 less at each turn

    Source: running-in after Archard, J. Appl. Phys. 24 (1953) 981, with a wear rate that falls with the path; Blau,
    Tribol. Int. 38 (2005) 1007. Valid: constant load.
    """

    name = "coating_wear_running_in"
    look = "conductance falls with the first cycles, ever less with each, not in a rest"

    loss: float = parameter(0.05, unit="1", low=0, high=20, doc="fall of ln G in each e-fold of the path")
    running_in: float = parameter(5.0, unit="1", low=0.1, high=1000, scale="log", doc="strain path of the running-in")

    def log_change(self, signals: Signals, dt_s: float) -> FloatArray:
        return -self.loss * np.log1p(cycled_strain(signals) / self.running_in)


class CoatingWearLoad(WearLaw):
    """Rubbing under load wears the coating: wear is load times path.

    ln G -= loss * integral (P / 1 N)^exponent |de| / 100        (0.004 less of |de| at each turn)

    Source: Archard, J. Appl. Phys. 24 (1953) 981. Valid: thick coating.
    """

    name = "coating_wear_load"
    reads = ("strain", "conductance_S", "contact_force_N")
    look = "conductance falls with every cycle, the more the higher it goes, not in a rest"

    loss: float = parameter(0.05, unit="1", low=0, high=20, doc="fall of ln G in 100 units of strain path at 1 N")
    exponent: float = parameter(1.0, unit="1", low=0.5, high=3, doc="growth of the wear with the load")

    def log_change(self, signals: Signals, dt_s: float) -> FloatArray:
        path, load_N = np.diff(cycled_strain(signals), prepend=0.0), np.maximum(signals["contact_force_N"], 0.0)
        mean_N = 0.5 * (load_N + np.r_[load_N[0], load_N[:-1]])
        return -self.loss * np.cumsum(path * mean_N**self.exponent) / 100


class CoatingWearWeibull(WearLaw):
    """The coating goes with the path: at once and ever more slowly, or late and then quickly.

    ln G -= loss * (1 - exp(-(path / scale)^shape)),   path = integral of |de|, 0.004 less at each turn

    Source: Weibull, J. Appl. Mech. 18 (1951) 293 (lives of parts that differ), for patches of the coating.
    Valid: constant load.
    """

    name = "coating_wear_weibull"
    look = "conductance falls with every cycle, early or late, not in a rest"

    loss: float = parameter(0.05, unit="1", low=0, high=20, doc="fall of ln G in the end")
    scale: float = parameter(5.0, unit="1", low=0.1, high=1e5, scale="log", doc="strain path for 63 % of it")
    shape: float = parameter(0.6, unit="1", low=0.2, high=4, scale="log", doc="below 1: early; above 1: late")

    def starts(self, signals: Signals, residual: Signals) -> Points:
        return weibull_points(cycled_strain(signals))

    def log_change(self, signals: Signals, dt_s: float) -> FloatArray:
        return -self.loss * weibull(cycled_strain(signals), self.scale, self.shape)


class CoatingCracks(ConductanceLaw):
    """Each new largest stretch cracks the coating further; the cracks stay.

    ln G -= loss * (m - m(0)),   m = largest strain so far

    Source: irreversible channel cracks of brittle films on stretched substrates (Leterrier, Prog. Mater. Sci. 48
    (2003) 1); proportionality is the simplest law.
    Valid: first stretches.
    """

    name = "coating_cracks"
    strength = "loss"
    look = "conductance falls for good at each new largest stretch, force does not"

    loss: float = parameter(0.5, unit="1", low=0, high=20, doc="fall of ln G per unit of largest strain")

    def log_change(self, signals: Signals, dt_s: float) -> FloatArray:
        top = np.maximum.accumulate(signals["strain"])
        return -self.loss * (top - top[0])


class CoatingCracksWeibull(CoatingCracks):
    """Patches of the coating crack at stretches of their own, once and for all.

    ln G -= loss * (c(m) - c(m(0))),   c(m) = 1 - exp(-(m / scale)^shape),   m = largest strain so far

    Source: Weibull, J. Appl. Mech. 18 (1951) 293 (strengths of parts that differ); for brittle films Leterrier, Prog.
    Mater. Sci. 48 (2003) 1.
    Valid: first stretches.
    """

    name = "coating_cracks_weibull"
    look = "conductance falls for good at each new largest stretch, most around one stretch"

    loss: float = parameter(0.3, unit="1", low=0, high=20, doc="fall of ln G when all have cracked")
    scale: float = parameter(0.2, unit="1", low=5e-3, high=10, scale="log", doc="strain at which 63 % have")
    shape: float = parameter(2.0, unit="1", low=0.3, high=12, scale="log", doc="how alike they are")

    def log_change(self, signals: Signals, dt_s: float) -> FloatArray:
        cracked = weibull(np.maximum.accumulate(signals["strain"]), self.scale, self.shape)
        return -self.loss * (cracked - cracked[0])

    def starts(self, signals: Signals, residual: Signals) -> Points:
        top = float(np.max(signals["strain"]))
        return [{"scale": share * top, "shape": shape} for share in (0.4, 0.7, 1.0, 2.0) for shape in (0.7, 2.0, 6.0)]


class ElectricalHysteresis(ConductanceLaw):
    """The conductance remembers the direction: friction of the contacts that the force does not show.

    ln G += gain * mean_k( stop_k(e) / r_k ),   r_k = threshold * spread_k

    Source: Kuhnen, Eur. J. Control 9 (2003) 407, Eqs. 4-9.
    Valid: rate-independent; driven by strain, where `contact_hysteresis` is driven by force.
    """

    name = "electrical_hysteresis"
    mechanism = "contact_hysteresis"
    in_base = True  # the loops of `contact_loops_shape` are of any kind
    look = "conductance over strain is a loop, at any speed, wider (or narrower) than the force's"

    gain: float = parameter(0.05, unit="1", low=-3, high=3, doc="shift of ln G when every element slips")
    threshold: float = parameter(0.02, unit="1", low=5e-4, high=0.5, scale="log", doc="strain from a turn to slip")

    def log_change(self, signals: Signals, dt_s: float) -> FloatArray:
        return self.gain * mean_slip(signals["strain"], self.threshold)

"""Hidden effects on force: what the yarn and the loops do beyond elasticity and friction.

Relaxation as in generalised Maxwell solids, linear and not; dashpots beside the knit; softening below the largest
strain so far (Mullins) and with every cycle; loops that lock.
"""

from __future__ import annotations

import numpy as np
from scipy.special import erf

from testbench.worlds.chain import Scene, Shape
from testbench.worlds.effects.registry import form
from testbench.worlds.kernels import last_turning_point, lowpass


@form("stress_relaxation", "one_time", "mechanics", 0.8, tau=(4, 80))
def relax_one(s: Scene, a: float, p: Shape) -> None:
    s.force = s.force - a * lowpass(s.t, s.force, p["tau"])


@form("stress_relaxation", "log_spectrum", "mechanics", 0.8, shortest=(0.5, 2), decades=(2, 3))
def relax_spectrum(s: Scene, a: float, p: Shape) -> None:
    times = p["shortest"] * 10 ** np.linspace(0, p["decades"], 5)
    s.force = s.force - a * np.mean([lowpass(s.t, s.force, tau) for tau in times], axis=0)


@form("stress_relaxation", "grows_with_force", "mechanics", 1.5, tau=(5, 60), power=(1.3, 2))
def relax_nonlinear(s: Scene, a: float, p: Shape) -> None:
    drive = s.top_N * (np.abs(s.force) / s.top_N) ** p["power"]
    s.force = s.force - a * lowpass(s.t, drive, p["tau"])


@form("viscous_rate_stiffening", "linear_dashpot", "mechanics", 20.0)
def dashpot(s: Scene, a: float, p: Shape) -> None:
    s.force = s.force + a * s.top_N * s.rate()


@form("viscous_rate_stiffening", "eyring", "mechanics", 0.5, onset=(0.003, 0.03))
def eyring(s: Scene, a: float, p: Shape) -> None:
    s.force = s.force + a * s.top_N * np.arcsinh(s.rate() / p["onset"])


@form("viscous_rate_stiffening", "stiffer_when_fast", "mechanics", 1.0, onset=(0.01, 0.05), power=(0.5, 1.2))
def cowper_symonds(s: Scene, a: float, p: Shape) -> None:
    rate = s.rate()
    s.force = s.force * (1 + a * np.sign(rate) * (np.abs(rate) / p["onset"]) ** p["power"] / 3)


@form("mullins_softening", "ogden_roxburgh", "mechanics", 0.9, width=(0.1, 0.5))
def ogden_roxburgh(s: Scene, a: float, p: Shape) -> None:
    energy = np.maximum(s.e, 0) ** 2 / 0.3**2
    worst = np.maximum.accumulate(energy)
    s.force = s.force * (1 - a * erf((worst - energy) / (p["width"] + 0.3 * worst)))


@form("mullins_softening", "continuum_damage", "mechanics", 0.9, reach=(0.05, 0.3))
def continuum_damage(s: Scene, a: float, p: Shape) -> None:
    worst = np.maximum.accumulate(np.maximum(s.e, 0))
    s.force = s.force * (1 - a * -np.expm1(-worst / p["reach"]))


@form("mullins_softening", "recovers_at_old_maximum", "mechanics", 0.9, power=(1, 3))
def softened_below_maximum(s: Scene, a: float, p: Shape) -> None:
    worst = np.maximum(np.maximum.accumulate(s.e), 1e-3)
    share = np.clip(s.e / worst, 0, 1) ** p["power"]
    s.force = s.force * (1 - a * worst / 0.3 * (1 - share))


@form("cyclic_fatigue", "work_done", "mechanics", 0.8, share=(0.2, 1.5))
def fatigue_by_work(s: Scene, a: float, p: Shape) -> None:
    done = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(s.e) * s.force[1:]))])
    s.force = s.force * (1 - a * -np.expm1(-done / max(p["share"] * done[-1], 1e-12)))


@form("cyclic_fatigue", "power_of_cycles", "mechanics", 0.6)
def fatigue_by_cycles(s: Scene, a: float, p: Shape) -> None:
    turns = np.cumsum(np.diff(last_turning_point(s.e, 0.02), prepend=0.0) != 0)
    # a cycle takes its toll little by little, not in one step
    cycles = lowpass(s.t, turns / 2.0, 3.0)
    s.force = s.force * (1 + cycles) ** -a


@form("cyclic_fatigue", "by_travel", "mechanics", 0.8, travel=(10, 60))
def fatigue_by_travel(s: Scene, a: float, p: Shape) -> None:
    s.force = s.force * (1 - a * -np.expm1(-s.path() / p["travel"]))


@form("jamming_stiffening", "quadratic_beyond", "mechanics", 5.0, onset=(0.15, 0.25))
def jam_quadratic(s: Scene, a: float, p: Shape) -> None:
    over = np.maximum(s.e - p["onset"], 0) / 0.1
    s.force = s.force + a * s.top_N * over**2


@form("jamming_stiffening", "exponential_beyond", "mechanics", 3.0, onset=(0.15, 0.24), sharp=(20, 50))
def jam_exponential(s: Scene, a: float, p: Shape) -> None:
    over = np.clip(s.e - p["onset"], 0, 0.25)
    s.force = s.force + 0.1 * a * s.top_N * np.expm1(p["sharp"] * over)


@form("jamming_stiffening", "locking_limit", "mechanics", 3.0, limit=(0.36, 0.45))
def jam_limit(s: Scene, a: float, p: Shape) -> None:
    near = np.clip(s.e / p["limit"], 0, 0.95)
    s.force = s.force + 0.05 * a * s.top_N * (near / (1 - near)) ** 2

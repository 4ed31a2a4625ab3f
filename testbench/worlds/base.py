"""Base worlds: what a sensor does before anything is hidden in it.

A world is four laws (elasticity, hysteresis, contact, drift), each drawn by seed from one family or another.
`matched` takes the families that a baseline model is expected to know; the others take different ones.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from gcode.support.arrays import FloatArray
from testbench.worlds.kernels import bouc_wen, stop

Parameters = dict[str, float]


@dataclass(frozen=True)
class Law:
    """One law: its family, its parameters, and the function of them."""

    family: str
    parameters: Parameters
    function: Callable[..., FloatArray]

    def __call__(self, *signals: FloatArray) -> FloatArray:
        return self.function(self.parameters, *signals)


@dataclass(frozen=True)
class BaseWorld:
    """The four laws: all that the chain needs.

    Force over strain and friction force over its history [N]; ln conductance over contact force and strain, and over
    time.
    """

    name: str
    elasticity: Law
    hysteresis: Law
    contact: Law
    drift: Law

    def force(self, e: FloatArray) -> FloatArray:
        """Force [N] of the knit at strain `e`."""
        return self.elasticity(e) + self.hysteresis(e)

    @property
    def contacts_feel_force(self) -> bool:
        """Whether conductance follows the contact force (else only strain)."""
        return self.contact.family != "percolation"

    def laws(self) -> dict[str, Law]:
        """The laws by name."""
        return {name: getattr(self, name) for name in ("elasticity", "hysteresis", "contact", "drift")}

    def varied(self, law: str, parameter: str, value: float) -> BaseWorld:
        """The same world with one parameter changed."""
        old = self.laws()[law]
        changed: Any = {law: replace(old, parameters={**old.parameters, parameter: value})}
        return replace(self, **changed)

    def describe(self) -> dict:
        """Family and parameters of each law, JSON-ready."""
        return {n: {"family": law.family, "parameters": law.parameters} for n, law in self.laws().items()}


def soft_positive(x: FloatArray, width: float) -> FloatArray:
    """Softplus: contacts are never pressed with less than nothing."""
    return width * np.logaddexp(0.0, x / width)


def _fung(p: Parameters, e: FloatArray) -> FloatArray:
    return p["offset"] + p["slope"] * np.expm1(p["bend"] * e) / p["bend"]


def _polynomial(p: Parameters, e: FloatArray) -> FloatArray:
    return p["offset"] + p["slope"] * (e + p["square"] * e**2 + p["cube"] * e**3)


def _ogden(p: Parameters, e: FloatArray) -> FloatArray:
    stretch = 1 + np.maximum(e, -0.5)
    terms = stretch ** (p["power"] - 1) - stretch ** (-0.5 * p["power"] - 1)
    return p["offset"] + p["slope"] / (1.5 * p["power"]) * terms + p["linear"] * e


def _bilinear(p: Parameters, e: FloatArray) -> FloatArray:
    over = p["round"] * np.logaddexp(0.0, (e - p["knee"]) / p["round"])
    return p["offset"] + p["slope"] * (e + (p["ratio"] - 1) * over)


def _draw_elasticity(family: str, rng: np.random.Generator) -> Law:
    slope = rng.uniform(5, 15)
    p: Parameters = {"offset": rng.uniform(0, 0.1), "slope": slope}
    if family == "fung":
        return Law(family, p | {"bend": rng.uniform(2, 6)}, _fung)
    if family == "polynomial":
        return Law(family, p | {"square": rng.uniform(-2, 1), "cube": rng.uniform(8, 20)}, _polynomial)
    if family == "ogden":
        return Law(family, p | {"power": rng.uniform(7, 14), "linear": rng.uniform(0, 4)}, _ogden)
    knee = rng.uniform(0.1, 0.2)
    return Law(
        "bilinear", p | {"knee": knee, "ratio": rng.uniform(2, 4), "round": rng.uniform(0.01, 0.03)}, _bilinear
    )


def _slip_elements(p: Parameters, e: FloatArray) -> FloatArray:
    count = sum(name.startswith("width") for name in p)
    total = np.zeros_like(e)
    for k in range(count):
        total += p[f"friction{k}"] * stop(e, p[f"width{k}"]) / p[f"width{k}"]
    return total


def _bouc_wen(p: Parameters, e: FloatArray) -> FloatArray:
    z = bouc_wen(e, p["reach"], p["asymmetry"], p["power"])
    return p["friction"] * (1 + p["growth"] * np.maximum(e, 0)) * z


def _draw_hysteresis(family: str, stiffness: float, rng: np.random.Generator) -> Law:
    friction = stiffness * rng.uniform(0.015, 0.05)
    if family == "slip_elements":
        # few elements make loops with corners, many make them round: laboratories see both
        count = int(rng.choice([3, 6, 10]))
        widths = np.sort(np.exp(rng.uniform(np.log(0.004), np.log(0.06), count)))
        shares = rng.dirichlet([3.0] * count) * friction
        p = {f"width{k}": float(w) for k, w in enumerate(widths)}
        return Law(family, p | {f"friction{k}": float(s) for k, s in enumerate(shares)}, _slip_elements)
    p = {
        "friction": friction,
        "reach": rng.uniform(0.01, 0.04),
        "asymmetry": rng.uniform(0, 0.4),
        "power": rng.uniform(0.7, 2.0),
        "growth": rng.uniform(0, 4),
    }
    return Law("bouc_wen", p, _bouc_wen)


def _holm(p: Parameters, pressing_N: FloatArray, e: FloatArray) -> FloatArray:
    """R = rho/2 sqrt(pi H / (n P)) with a path beside and a path in series; `exponent`: 1/2 (Holm) unless given."""
    pressed = soft_positive(p["preload"] + pressing_N, 0.1 * p["preload"])
    contact_ohm = p["resistance"] * pressed ** -p.get("exponent", 0.5)
    return np.log(p["parallel"] + 1 / (p["series"] + contact_ohm))


def _percolation(p: Parameters, pressing_N: FloatArray, e: FloatArray) -> FloatArray:
    """Carbon black in rubber: gaps between particles open with strain, the film's friction closes some again."""
    open_gaps = p["gauge"] * e + p["tunnel"] * np.expm1(p["gap"] * np.maximum(e, -0.3)) / p["gap"]
    memory = p["memory"] * stop(e, p["memory_width"]) / p["memory_width"]
    return p["level"] - open_gaps - memory


def _draw_contact(family: str, friction: float, rng: np.random.Generator) -> Law:
    if family == "percolation":
        p = {
            "level": -np.log(rng.uniform(5e3, 2e5)),
            "gauge": rng.uniform(1, 4),
            "tunnel": rng.uniform(0.3, 2),
            "gap": rng.uniform(2, 6),
            "memory": rng.uniform(0.02, 0.1),
            "memory_width": rng.uniform(0.01, 0.05),
        }
        return Law(family, p, _percolation)
    resistance = np.exp(rng.uniform(np.log(1e5), np.log(8e5)))
    p = {
        "resistance": resistance,
        "preload": 1.5 * friction + rng.uniform(0.1, 0.4),
        "series": resistance * rng.uniform(0.02, 0.2),
        "parallel": rng.uniform(0.05, 0.5) / resistance,
    }
    if family != "holm":
        p["exponent"] = float(rng.choice([rng.uniform(0.28, 0.4), rng.uniform(0.65, 0.95)]))
    return Law(family, p, _holm)


def _logarithmic(p: Parameters, t: FloatArray) -> FloatArray:
    return p["rate"] * np.log1p(t / p["onset"])


def _exponential(p: Parameters, t: FloatArray) -> FloatArray:
    return p["rate"] * -np.expm1(-t / p["time"])


def _power(p: Parameters, t: FloatArray) -> FloatArray:
    return p["rate"] * (t / 1000) ** p["power"]


def _draw_drift(family: str, rng: np.random.Generator) -> Law:
    size = rng.uniform(0.02, 0.12) * rng.choice([1, 1, -1])
    if family == "logarithmic":
        return Law(family, {"rate": size / 4, "onset": np.exp(rng.uniform(1, 4))}, _logarithmic)
    if family == "exponential":
        return Law(family, {"rate": size, "time": rng.uniform(120, 1500)}, _exponential)
    power = 0.5 if family == "square_root" else rng.uniform(0.2, 0.9)
    return Law(family, {"rate": size, "power": power}, _power)


# --- worlds ---

ELASTICITIES = ("polynomial", "ogden", "bilinear")
DRIFTS = ("exponential", "power", "square_root")
MATCHED = {"elasticity": "fung", "hysteresis": "slip_elements", "contact": "holm", "drift": "logarithmic"}
WORLDS = ("matched", "mismatched", "other_elasticity", "bouc_wen", "other_contact", "other_drift", "carbon_black")


def families(world: str, rng: np.random.Generator) -> dict[str, str]:
    """Family of each law in `world`."""
    other = {
        "elasticity": str(rng.choice(ELASTICITIES)),
        "hysteresis": "bouc_wen",
        "contact": "other_power",
        "drift": str(rng.choice(DRIFTS)),
    }
    if world == "matched":
        return MATCHED
    if world == "carbon_black":
        elasticity = str(rng.choice(["fung", "polynomial", "ogden"]))
        return {**other, "elasticity": elasticity, "contact": "percolation"}
    if world == "mismatched":
        # the exponent is left alone in half of the cases: Holm's square root is the best-founded of the four
        return {**other, "contact": str(rng.choice(["holm", "other_power"]))}
    changed = "hysteresis" if world == "bouc_wen" else world.removeprefix("other_")
    return {**MATCHED, changed: other[changed]}


def draw_world(world: str, rng: np.random.Generator) -> BaseWorld:
    """A base world of the named kind, its parameters drawn from plausible ranges."""
    chosen = families(world, rng)
    elasticity = _draw_elasticity(chosen["elasticity"], rng)
    top_N = float(elasticity(np.array([0.3]))[0])
    hysteresis = _draw_hysteresis(chosen["hysteresis"], top_N, rng)
    friction = sum(v for name, v in hysteresis.parameters.items() if name.startswith("friction"))
    contact = _draw_contact(chosen["contact"], friction, rng)
    return BaseWorld(world, elasticity, hysteresis, contact, _draw_drift(chosen["drift"], rng))

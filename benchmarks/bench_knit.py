"""Speed of the knit model: vectorised effects against a plain-Python loop and SciPy's solve_ivp on the same equations.

    python benchmarks/bench_knit.py

23 minutes at 20 Hz. The preset is timed whole. The comparison runs one and the same small model three ways
(J-curve, Dahl friction, one Prony term, contact relaxation, Holm contact, overshoot, lag): as effects, as a loop over
samples in plain Python, and as one system of differential equations. All three must agree.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from testbench.knit.contact import Contact
from testbench.knit.elasticity import Elasticity
from testbench.knit.hysteresis import HysteresisBoucWen
from testbench.knit.model import KnitModel, inputs
from testbench.knit.presets import names, preset
from testbench.knit.pressure import ContactRelaxation
from testbench.knit.readout import ChannelLag
from testbench.knit.relaxation import StressRelaxation
from testbench.knit.transient import ElectricalOvershoot

DT_S, DURATION_S = 0.05, 23 * 60.0
TAUS_S = {"relaxation": 10.0, "contact": 20.0, "overshoot": 3.0, "lag": 0.5}


def motion() -> tuple[np.ndarray, np.ndarray]:
    """Three sines between 0 and 30 %; their rate is known exactly for solve_ivp."""
    t = np.arange(0, DURATION_S, DT_S)
    return t, strain_at(t)


def strain_at(t: Any) -> Any:
    """Strain over time."""
    return 0.15 - 0.07 * np.cos(0.71 * t) - 0.05 * np.cos(0.23 * t) - 0.03 * np.cos(1.37 * t)


def strain_rate_at(t: float) -> float:
    """Its derivative."""
    return 0.0497 * math.sin(0.71 * t) + 0.0115 * math.sin(0.23 * t) + 0.0411 * math.sin(1.37 * t)


MODEL = KnitModel.of(
    Elasticity(stiffness_N=8, curvature=3, offset_N=0),
    HysteresisBoucWen(friction_N=0.3, threshold=0.02, skew=0, growth=0),
    StressRelaxation(fraction=0.2, tau_s=TAUS_S["relaxation"]),
    ContactRelaxation(fraction=0.3, tau_s=TAUS_S["contact"]),
    Contact(contact_resistance_ohm=4e5, parallel_S=1e-7, series_ohm=1e4, preload_N=1),
    ElectricalOvershoot(gain=1, tau_s=TAUS_S["overshoot"]),
    ChannelLag(tau_s=TAUS_S["lag"]),
)


def conductance(force: float, sudden: float) -> float:
    """Holm's contact with both paths, and the overshoot, for one sample."""
    pressing = 1 + force
    softness = 0.1
    pressing = 0.5 * (pressing + math.sqrt(pressing * pressing + 4 * softness * softness))
    return (1e-7 + 1 / (1e4 + 4e5 / math.sqrt(pressing))) * math.exp(sudden)


def plain_python(strain: list[float]) -> list[float]:
    """The same model as one would first write it: a loop over samples (all filters exact for straight lines)."""
    gains = {}
    for name, tau in TAUS_S.items():
        a = math.exp(-DT_S / tau)
        b0 = 1 - (1 - a) * tau / DT_S
        gains[name] = (a, b0, 1 - a - b0)

    def step(name: str, y: float, new: float, old: float) -> float:
        a, b0, b1 = gains[name]
        return a * y + b0 * new + b1 * old

    e = e0 = strain[0]
    z, elastic = 0.0, 8 * math.expm1(3 * e) / 3
    first, relaxed = elastic, elastic
    force = pressed = slow = elastic
    followed = e
    g = read = conductance(force, 0.0)
    out = [read]
    for new in strain[1:]:
        sign = math.copysign(1.0, new - e)
        z = sign - (sign - z) * math.exp(-abs(new - e) / 0.02)
        bare = 8 * math.expm1(3 * new) / 3 + 0.3 * z
        relaxed = step("relaxation", relaxed, bare, elastic)
        new_force = bare - 0.2 * (relaxed - first)
        slow = step("contact", slow, new_force, force)
        pressed = new_force - 0.3 * (slow - first)
        followed = step("overshoot", followed, new, e)
        new_g = conductance(pressed, new - followed)
        read = step("lag", read, new_g, g)
        out.append(read)
        e, elastic, force, g = new, bare, new_force, new_g
    assert e0 == strain[0]
    return out


def differential_equations(t: np.ndarray) -> np.ndarray:
    """The same model as one system of ordinary differential equations, solved by RK45."""
    e0 = float(strain_at(0.0))
    first = 8 * math.expm1(3 * e0) / 3

    def chain(time_s: float, y: np.ndarray) -> tuple[float, float, float, float]:
        e = float(strain_at(time_s))
        bare = 8 * math.expm1(3 * e) / 3 + 0.3 * y[0]
        force = bare - 0.2 * (y[1] - first)
        pressed = force - 0.3 * (y[2] - first)
        return e, bare, force, conductance(pressed, e - y[3])

    def derivative(time_s: float, y: np.ndarray) -> list[float]:
        e, bare, force, g = chain(time_s, y)
        rate = strain_rate_at(time_s)
        return [
            (rate - abs(rate) * y[0]) / 0.02,
            (bare - y[1]) / TAUS_S["relaxation"],
            (force - y[2]) / TAUS_S["contact"],
            (e - y[3]) / TAUS_S["overshoot"],
            (g * 1e6 - y[4]) / TAUS_S["lag"],
        ]

    start = [0.0, first, first, e0, conductance(first, 0.0) * 1e6]
    solved = solve_ivp(derivative, (0, t[-1]), start, t_eval=t, rtol=1e-6, atol=1e-9)
    return np.asarray(solved.y[4]) * 1e-6


def best_of(count: int, work: Callable[[], Any]) -> tuple[float, Any]:
    """Shortest time in seconds of `count` runs, and the last result; the first result is warm-up where count > 1."""
    times, result = [], None
    for _ in range(count):
        start = time.perf_counter()
        result = work()
        times.append(time.perf_counter() - start)
    return min(times), result


def main() -> None:
    """Print the tables."""
    t, strain = motion()
    print(f"{DURATION_S / 60:.0f} min at {1 / DT_S:.0f} Hz, {len(t)} samples; best of 20 after warm-up")
    for name in names():
        model = preset(name)
        seconds, _ = best_of(20, lambda model=model: model.simulate(inputs(t, strain), DT_S))
        print(f"  preset {name:6s} {len(model.effects):2d} effects  {1e3 * seconds:7.2f} ms   (goal: 10 ms)")
    ours, signals = best_of(20, lambda: MODEL.simulate(inputs(t, strain), DT_S)["conductance_S"])
    loop, plain = best_of(3, lambda: plain_python(strain.tolist()))
    ivp, solved = best_of(1, lambda: differential_equations(t))
    print(f"the same {len(MODEL.effects)} effects three ways:")
    print(f"  effects        {1e3 * ours:9.2f} ms")
    for label, seconds, other in (("plain Python", loop, np.array(plain)), ("solve_ivp", ivp, solved)):
        error = float(np.max(np.abs(other - signals)) / np.ptp(signals))
        print(
            f"  {label:14s} {1e3 * seconds:9.2f} ms   {seconds / ours:6.0f} x slower   agrees to {error:.1e} of the span"
        )
    print("each effect alone, default parameters:")
    report_each(inputs(t, strain))


def report_each(signals: dict[str, np.ndarray]) -> None:
    """Time every catalogue effect on the same signals."""
    from testbench.knit.catalogue import baseline, load_catalogue

    state = baseline().simulate(signals, DT_S)
    times = {
        name: best_of(5, lambda cls=cls: cls().apply(state, DT_S))[0]
        for name, cls in load_catalogue().effects.items()
    }
    slowest = sorted(times, key=lambda name: -times[name])[:5]
    print(f"  median {1e3 * float(np.median(list(times.values()))):.2f} ms, slowest: ", end="")
    print(", ".join(f"{name} {1e3 * times[name]:.1f} ms" for name in slowest))


if __name__ == "__main__":
    main()

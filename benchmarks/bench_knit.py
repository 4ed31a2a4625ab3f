"""Speed of the knit model: effects against a plain-Python loop and SciPy's solve_ivp, on the same equations.

    python benchmarks/bench_knit.py

23 minutes at 20 Hz with all effects of the preset `pes`, three ways: as effects, as one first writes it (a loop over
samples in plain Python) and as one system of differential equations. All three must agree.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from pes_equations import RK_STEP_S, Equations, plain_python
from scipy.integrate import solve_ivp

from testbench.knit.catalogue import baseline, load_catalogue
from testbench.knit.model import inputs
from testbench.knit.presets import names, preset

DT_S, DURATION_S = 0.05, 23 * 60.0


def strain_at(t: Any) -> Any:
    """Strain over time: three sines between 0 and 30 %, so that its rate is known exactly."""
    return 0.15 - 0.07 * np.cos(0.71 * t) - 0.05 * np.cos(0.23 * t) - 0.03 * np.cos(1.37 * t)


def strain_rate_at(t: float) -> float:
    """Its derivative."""
    return 0.0497 * math.sin(0.71 * t) + 0.0115 * math.sin(0.23 * t) + 0.0411 * math.sin(1.37 * t)


def best_of(count: int, work: Callable[[], Any]) -> tuple[float, Any]:
    """Shortest time in seconds of `count` runs, and the last result."""
    times, result = [], None
    for _ in range(count):
        start = time.perf_counter()
        result = work()
        times.append(time.perf_counter() - start)
    return min(times), result


def with_solve_ivp(equations: Equations, t: np.ndarray) -> np.ndarray:
    """The same model as differential equations, solved by RK45 with steps that see every reversal."""
    start = equations.start(float(strain_at(0.0)))

    def derivative(time_s: float, y: np.ndarray) -> list[float]:
        return equations.derivative(float(strain_at(time_s)), strain_rate_at(time_s), y)

    solved = solve_ivp(derivative, (0, t[-1]), start, t_eval=t, rtol=1e-4, atol=1e-7, max_step=RK_STEP_S)
    return np.array([equations.conductance_S(strain_at(ti), ti, y) for ti, y in zip(t, solved.y.T, strict=True)])


def main() -> None:
    """Print the table."""
    t = np.arange(0, DURATION_S, DT_S)
    strain = strain_at(t)
    print(f"{DURATION_S / 60:.0f} min at {1 / DT_S:.0f} Hz, {len(t)} samples")
    for name in names():
        model = preset(name)
        seconds, _ = best_of(20, lambda model=model: model.simulate(inputs(t, strain), DT_S))
        print(f"  preset {name:6s} {len(model.effects):2d} effects {1e3 * seconds:9.2f} ms   (goal: 10 ms)")
    compare_three_ways(t, strain)
    report_each(inputs(t, strain))


def compare_three_ways(t: np.ndarray, strain: np.ndarray) -> None:
    """The preset `pes` as effects, as a loop and as differential equations."""
    model = preset("pes")
    equations = Equations(model)
    ours, signals = best_of(20, lambda: model.simulate(inputs(t, strain), DT_S)["conductance_S"])
    loop, plain = best_of(3, lambda: plain_python(model, strain.tolist(), DT_S))
    ivp, solved = best_of(1, lambda: with_solve_ivp(equations, t))
    print(f"all {len(model.effects)} effects of pes, three ways:")
    print(f"  effects        {1e3 * ours:9.2f} ms")
    for label, seconds, other in (("plain Python", loop, np.array(plain)), ("solve_ivp", ivp, solved)):
        error = float(np.sqrt(np.mean((other - signals) ** 2)) / np.ptp(signals))
        print(f"  {label:14s} {1e3 * seconds:9.2f} ms   {seconds / ours:6.0f} x slower   error {error:.0e} of span")


def report_each(signals: dict[str, np.ndarray]) -> None:
    """Time every catalogue effect alone on the same signals."""
    state = baseline().simulate(signals, DT_S)
    effects = {name: cls() for name, cls in load_catalogue().effects.items()}
    times = {name: best_of(5, lambda e=effect: e.apply(state, DT_S))[0] for name, effect in effects.items()}
    slowest = sorted(times, key=lambda name: -times[name])[:4]
    print(
        f"each of {len(times)} effects alone: median {1e3 * float(np.median(list(times.values()))):.2f} ms; slowest ",
        end="",
    )
    print(", ".join(f"{name} {1e3 * times[name]:.1f} ms" for name in slowest))


if __name__ == "__main__":
    main()

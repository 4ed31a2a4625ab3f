"""Parameters that the data push against a bound: what is not known of them counts, on the near side."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import dblquad

from testbench.fitting.evidence.evidence import NormalEquations, maximised
from testbench.fitting.evidence.hypothesis import Hypothesis, pinned
from testbench.fitting.evidence.priors import Priors


def normal_density(x: float, precision: float) -> float:
    return float(np.sqrt(precision / (2 * np.pi)) * np.exp(-0.5 * precision * x**2))


def cauchy_density(x: float, precision: float) -> float:
    return float(np.sqrt(precision) / np.pi / (1 + precision * x**2))


@pytest.mark.parametrize("push", [0.0, 0.7, 3.0, 40.0])
@pytest.mark.parametrize("tails", [False, True], ids=["gaussian", "cauchy"])
def test_the_evidence_is_the_integral_over_the_near_side_of_the_bound(push, tails):
    """Of two parameters that trade with each other one may not be negative; both lie best at zero."""
    rng = np.random.default_rng(0)
    designs = rng.standard_normal((2, 50)) + rng.standard_normal(50)
    free = designs[0] / np.linalg.norm(designs[0])
    beside = designs[1] - (designs[1] @ free) * free
    residual = rng.standard_normal(50)
    residual -= (residual @ free) * free
    residual -= ((residual @ beside) + push * np.linalg.norm(beside)) / (beside @ beside) * beside
    rows, precision = np.vstack([residual, designs]), np.array([4.0, 9.0])
    group, held = np.full(2, -1), np.array([False, True])
    priors = Priors((), np.zeros(2), precision, held & tails, group, (), frozenset())
    normal = NormalEquations({"force": rows @ rows.T}, 50.0, 1.0, {"force": 1e-9}, np.zeros(2), precision, group)
    evidence = maximised(pinned(normal, held), {"force": 1.0}, iterations=1)
    point = SimpleNamespace(
        normal=normal,
        evidence=replace(evidence, sigma={"force": 1.0}),
        priors=priors,
        vector=np.zeros(2),
        at_bound=held,
    )
    bounds = Hypothesis.bounds.func(point)

    density_of_t = cauchy_density if tails else normal_density

    def density(t: float, a: float) -> float:
        left = residual - a * designs[0] - t * designs[1]
        gain = 0.5 * (residual @ residual - left @ left)
        return float(np.exp(gain)) * normal_density(a, precision[0]) * density_of_t(t, precision[1])

    whole, _ = dblquad(density, -3.0, 3.0, 0.0, 3.0, epsabs=1e-12)
    alone = evidence.value + 0.5 * residual @ residual
    assert alone + bounds == pytest.approx(np.log(whole), abs=0.02 if tails else 1e-3)  # tails are flat for a bit

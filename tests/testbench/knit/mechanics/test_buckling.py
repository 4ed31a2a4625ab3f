"""A thin fabric buckles rather than pushes."""

import numpy as np
import pytest

from testbench.knit.mechanics.buckling import Buckling
from testbench.knit.mechanics.elasticity import Elasticity
from testbench.knit.mechanics.relaxation import StressRelaxation
from testbench.knit.model import KnitModel

DT_S = 0.1
OUT_AND_BACK = np.r_[np.linspace(0, 1, 500), np.linspace(1, 0, 500)]
RELAXES = KnitModel.of(Elasticity(stiffness_N=1.0, offset_N=0.2), StressRelaxation(fraction=0.6, tau_s=20.0))


def force_N(model: KnitModel) -> np.ndarray:
    return model.simulate({"strain_nominal": OUT_AND_BACK, "strain": OUT_AND_BACK}, DT_S)["force_N"]


def test_what_has_relaxed_does_not_push_on_the_way_back():
    pushes, buckles = force_N(RELAXES), force_N(RELAXES.plus(Buckling(rounding_N=1e-4)))
    assert pushes[-1] < 0.2 - 0.1
    np.testing.assert_allclose(buckles, np.maximum(pushes, 0.2), atol=1e-3)


def test_it_lies_loose_only_below_its_pretension():
    buckles = force_N(RELAXES.plus(Buckling(pretension_N=0.05, rounding_N=1e-4)))
    assert np.min(buckles) == pytest.approx(0.15, abs=1e-3)
    np.testing.assert_allclose(force_N(RELAXES.plus(Buckling(pretension_N=10.0))), force_N(RELAXES), atol=1e-9)


def test_an_effect_put_in_later_still_comes_before_it():
    model = KnitModel.of(Elasticity(stiffness_N=1.0), Buckling(rounding_N=1e-4)).plus(StressRelaxation(fraction=0.6))
    assert list(model)[-1] == "buckling"
    assert np.min(force_N(model)) >= Elasticity(stiffness_N=1.0).offset_N


def test_it_starts_where_the_force_stays_at_its_lowest_and_nowhere_else():
    flat = np.maximum(OUT_AND_BACK - 0.2, 0.0)
    (start,) = Buckling().starts({"strain": OUT_AND_BACK, "force_N": flat}, {})
    assert start["pretension_N"] == pytest.approx(0.0)
    assert not Buckling().starts({"strain": OUT_AND_BACK, "force_N": OUT_AND_BACK}, {})
    assert Buckling().starts({"strain": OUT_AND_BACK, "force_N": np.zeros_like(flat)}, {})

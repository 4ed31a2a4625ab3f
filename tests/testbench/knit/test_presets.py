"""Simulated campaigns of the presets show the figures published for the two sensors."""

from __future__ import annotations

import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from compensation.paper.published import COMPENSATED, RAW
from testbench.knit.presets import preset

SEEDS = tuple(range(100, 120))  # not those the presets were tuned on


@pytest.fixture(scope="module")
def figures() -> ModuleType:
    sys.path.insert(0, str(Path("datasets").resolve()))
    try:
        import paper_figures
    finally:
        sys.path.pop(0)
    return paper_figures


def before(name: str, seeds: tuple[int, ...], figures: ModuleType) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Means over the seeds for T, A and B: r2 of force, r2 of displacement, drift."""
    campaigns = [figures.campaign(preset(name), seed, figures.SLOW) for seed in seeds]
    force = [[figures.r2_before(r.force_N, r.conductance_S) for r in campaign] for campaign in campaigns]
    displacement = [[figures.r2_before(r.strain, r.conductance_S) for r in campaign] for campaign in campaigns]
    drifts = [[figures.drift(recording) for recording in campaign] for campaign in campaigns]
    return np.mean(force, axis=0), np.mean(displacement, axis=0), np.mean(drifts, axis=0)


@pytest.mark.parametrize("name", ["pes", "lycra"])
def test_raw_signal_is_as_poor_as_published(name: str, figures: ModuleType) -> None:
    """Mean r2 of force and of displacement with the conductance, and an upward drift, most in a new sensor."""
    force, displacement, drifts = before(name, SEEDS[:5], figures)
    assert force.mean() == pytest.approx(np.mean(RAW[name, "force"]), abs=0.05)
    assert displacement.mean() == pytest.approx(np.mean(RAW[name, "displacement"]), abs=0.05)
    assert 1.08 < drifts[0] < 1.3
    assert drifts.mean() > 1.04


@pytest.mark.slow
@pytest.mark.parametrize("name", ["pes", "lycra"])
def test_each_recording_is_as_poor_as_published(name: str, figures: ModuleType) -> None:
    """T, A and B one by one. A single figure of `pes` scatters by 0.05 with the trajectory, so many seeds."""
    force, displacement, _ = before(name, SEEDS, figures)
    assert force == pytest.approx(RAW[name, "force"], abs=0.06)
    assert displacement == pytest.approx(RAW[name, "displacement"], abs=0.08)


NO_CREEP = pytest.mark.xfail(reason="pes meets the r2 after compensation without a creep from T to B (decision 0015)")


@pytest.mark.parametrize("name", [pytest.param("pes", marks=NO_CREEP), "lycra"])
def test_displacement_creeps_away_from_force(name: str, figures: ModuleType) -> None:
    """Permanent set: the same force needs more and more displacement, from T over A to B."""
    needed = []
    for seed in SEEDS[:3]:
        campaign = figures.campaign(preset(name), seed, figures.SLOW)
        forces, strains = [one.force_N for one in campaign], [one.strain for one in campaign]
        near = [strain[np.abs(force - 1.5) < 0.1].mean() for strain, force in zip(strains, forces, strict=True)]
        needed.append(near)
    first, second, third = np.mean(needed, axis=0)
    assert third > second > first
    assert third > first + 0.003


@pytest.mark.slow
@pytest.mark.parametrize("name", ["pes", "lycra"])
def test_compensated_signal_is_as_good_as_published(name: str, figures: ModuleType) -> None:
    """r2 of the paper's network on T, A and B, each recording scaled by itself; means over five campaigns."""
    after = np.mean([figures.compensated(figures.campaign(preset(name), seed)) for seed in SEEDS[:5]], axis=0)
    assert after[:3] == pytest.approx(COMPENSATED[name, "force"], abs=0.06)
    assert after[3:6] == pytest.approx(COMPENSATED[name, "displacement"], abs=0.06)

"""Simulated campaigns of the presets show the figures published for the two sensors."""

from __future__ import annotations

import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from testbench.knit.presets import preset

SEEDS = (10, 11, 12, 13, 14)  # not those the presets were tuned on


@pytest.fixture(scope="module")
def figures() -> ModuleType:
    sys.path.insert(0, str(Path("datasets").resolve()))
    try:
        import paper_figures
    finally:
        sys.path.pop(0)
    return paper_figures


@pytest.mark.parametrize("name", ["pes", "lycra"])
def test_raw_signal_is_as_poor_as_published(name: str, figures: ModuleType) -> None:
    """Mean r2 of force and of displacement with the conductance, and an upward drift of the conductance."""
    campaigns = [figures.campaign(preset(name), seed) for seed in SEEDS]
    recordings = [recording for campaign in campaigns for recording in campaign]
    force = np.mean([figures.r2_before(r.force_N, r.conductance_S) for r in recordings])
    displacement = np.mean([figures.r2_before(r.strain, r.conductance_S) for r in recordings])
    published = figures.PUBLISHED[name]
    assert force == pytest.approx(np.mean(published.force_before), abs=0.05)
    assert displacement == pytest.approx(np.mean(published.displacement_before), abs=0.05)
    assert 1.1 < np.mean([figures.drift(campaign) for campaign in campaigns]) < 1.5


@pytest.mark.slow
@pytest.mark.parametrize("name", ["pes", "lycra"])
def test_compensated_signal_is_as_good_as_published(name: str, figures: ModuleType) -> None:
    """Mean held-out r2 of the paper's network over three campaigns."""
    after: dict[str, list[float]] = {"force_N": [], "strain": []}
    for seed in SEEDS[:3]:
        recordings = figures.campaign(preset(name), seed)
        banks = [figures.smoothing_bank(r.conductance_S) for r in recordings]
        for target, values in after.items():
            values.append(figures.learned(recordings, banks, target, network_starts=3))
    published = figures.PUBLISHED[name]
    assert np.mean(after["force_N"]) == pytest.approx(published.force_after, abs=0.05)
    assert np.mean(after["strain"]) == pytest.approx(published.displacement_after, abs=0.05)

"""Simulated campaigns of the presets show the figures published for the two sensors."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from compensation.paper.published import COMPENSATED, RAW, TRANSFER
from testbench.knit.model import KnitModel
from testbench.knit.presets import preset

# The recordings of one campaign.
Runs = list[Any]
SEEDS = tuple(range(100, 120))  # not those the presets were tuned on


def script(name: str) -> ModuleType:
    """A module of the folder datasets."""
    sys.path.insert(0, str(Path("datasets").resolve()))
    try:
        return importlib.import_module(name)
    finally:
        sys.path.pop(0)


@pytest.fixture(scope="module")
def figures() -> ModuleType:
    return script("paper_figures")


@pytest.mark.parametrize(("reach", "expected"), [(0.4, [0.6, 0.6]), (4.0, [0.0, 0.0])])
def test_tuner_comes_as_near_as_it_may_reach(reach: float, expected: list[float]) -> None:
    """Two figures, x and 2 y, both wanted at zero: from (1, 1) as far towards it as a step goes, and no farther."""
    tuner = script("tune_presets")
    slopes, steps = np.diag([1.0, 2.0]), np.ones(2)
    goals = tuner.Goals(np.zeros(2), np.ones(2), np.array([0.0, 1.0]))
    found = tuner.nearest_steps(slopes @ steps, slopes, goals, steps, reach)
    np.testing.assert_allclose(found, expected, atol=1e-9)


def test_tuner_counts_in_tolerances_and_leaves_a_free_side_alone() -> None:
    goals = script("tune_presets").Goals(np.array([0.5, 1.1, 5.0]), np.array([0.1, 0.05, 2.0]), np.array([0, -1, 1]))
    np.testing.assert_allclose(goals.distances(np.array([0.3, 1.2, 4.0])), [2.0, -2.0, -0.5])


# Specimens of the population that the presets were not tuned on, each with a campaign of its own number.
SPECIMENS = tuple(range(780, 800))


def before(runs: list[Runs], figures: ModuleType) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Means over campaigns for T, A and B: r2 of force, r2 of displacement, drift."""
    force = [[figures.r2_before(r.force_N, r.conductance_S) for r in campaign[:3]] for campaign in runs]
    displacement = [[figures.r2_before(r.strain, r.conductance_S) for r in campaign[:3]] for campaign in runs]
    drifts = [[figures.drift(recording) for recording in campaign[:3]] for campaign in runs]
    return np.mean(force, axis=0), np.mean(displacement, axis=0), np.mean(drifts, axis=0)


def of_the_middle(name: str, seeds: tuple[int, ...], figures: ModuleType) -> list[Runs]:
    """T, A and B of the preset itself."""
    return [figures.campaign(preset(name), seed, figures.SLOW) for seed in seeds]


@pytest.mark.parametrize("name", ["pes", "lycra"])
def test_raw_signal_is_as_poor_as_published(name: str, figures: ModuleType) -> None:
    """Mean r2 of force and of displacement with the conductance, and an upward drift, most in a new sensor."""
    force, displacement, drifts = before(of_the_middle(name, SEEDS[:5], figures), figures)
    assert force.mean() == pytest.approx(np.mean(RAW[name, "force"]), abs=0.05)
    assert displacement.mean() == pytest.approx(np.mean(RAW[name, "displacement"]), abs=0.05)
    assert 1.08 < drifts[0] < 1.3
    assert drifts.mean() > 1.04


# Decision 0015: what the presets miss, and by how much.
MISSED = {("lycra", "displacement"): [0.075, 0, 0]}
MISSED_AFTER = {("pes", "force"): [0, 0.065, 0]}
MISSED_BY_SPECIMENS = {("pes", "displacement"): [0.055, 0, 0], ("lycra", "displacement"): [0, 0.07, 0.08]}
WITHIN, WITHIN_FAST = 0.05, 0.1


@pytest.mark.slow
@pytest.mark.parametrize("name", ["pes", "lycra"])
def test_each_recording_is_as_poor_as_published(name: str, figures: ModuleType) -> None:
    """T, A and B one by one, within 0.05 but for one of them; means over ten campaigns."""
    found = before(of_the_middle(name, SEEDS[:10], figures), figures)
    for target, values in zip(("force", "displacement"), found[:2], strict=True):
        allowed = np.maximum(WITHIN, MISSED.get((name, target), [0, 0, 0]))
        assert (np.abs(values - RAW[name, target]) <= allowed).all(), (target, values)


SETS = {"permanent_set_recovering.fraction": 0.0, "permanent_set_worked.amount": 0.0}


def creep(model: KnitModel, seeds: tuple[int, ...], figures: ModuleType) -> np.ndarray:
    """Strain that A and B need beyond T for the same force, in the middle of the motion: shape (2,), mean over seeds.

    One parabola F(strain) with a level of its own for each recording, and the levels over its slope. The motion is
    given and the force follows: the other way round, strain where the force has a value, a wide loop hides the creep,
    for both of its branches pass there.
    """
    found = []
    for seed in seeds:
        campaign = figures.campaign(model, seed, figures.SLOW)
        which = np.repeat(np.arange(3), [len(one.strain) for one in campaign])
        strain, force_N = (np.concatenate([getattr(one, name) for one in campaign]) for name in ("strain", "force_N"))
        columns = np.column_stack([strain, strain**2, *(which == number for number in range(3))])
        linear, square, *levels = np.linalg.lstsq(columns, force_N, rcond=None)[0]
        slope = linear + 2 * square * strain.mean()
        found.append([(levels[0] - level) / slope for level in levels[1:]])
    return np.mean(found, axis=0)


@pytest.mark.parametrize("name", ["pes", "lycra"])
def test_displacement_creeps_away_from_force(name: str, figures: ModuleType) -> None:
    """Permanent set: the same force needs more and more displacement, from T over A to B, and not without the set."""
    second, third = creep(preset(name), SEEDS[:3], figures)
    assert third > second > 0
    assert third > 0.003
    assert np.abs(creep(preset(name).with_parameters(SETS), SEEDS[:3], figures)).max() < 0.001


@pytest.mark.slow
@pytest.mark.parametrize("name", ["pes", "lycra"])
def test_compensated_signal_is_as_good_as_published(name: str, figures: ModuleType) -> None:
    """r2 of the paper's network on T, A and B, each recording scaled by itself; means over ten campaigns."""
    runs = of_the_middle(name, SEEDS[:10], figures)
    after = np.mean([figures.compensated(run, wanted=figures.AFTER[:2]) for run in runs], axis=0)
    for target, values in (("force", after[:3]), ("displacement", after[3:])):
        allowed = np.maximum(WITHIN, MISSED_AFTER.get((name, target), [0, 0, 0]))
        assert (np.abs(values - COMPENSATED[name, target]) <= allowed).all(), (target, values)


@pytest.mark.slow
def test_fast_set_gains_what_is_published(figures: ModuleType) -> None:
    """Raw r2 and the three relative gains of the paper's network, within 0.1; medians over ten campaigns."""
    runs = [figures.campaign(preset("pes"), seed) for seed in SEEDS[:10]]
    raw = np.array(
        [figures.r2_before(run[figures.FAST_A].force_N, run[figures.FAST_A].conductance_S) for run in runs]
    )
    after = np.array([figures.compensated(run, wanted=figures.AFTER[2:]) for run in runs])
    there, finer, slow = np.median(after / raw[:, None] - 1, axis=0)
    assert np.median(raw) == pytest.approx(TRANSFER.raw, abs=WITHIN_FAST)
    assert there == pytest.approx(TRANSFER.gain_trained_there, abs=WITHIN_FAST)
    assert finer == pytest.approx(TRANSFER.gain_trained_there_finer, abs=WITHIN_FAST)
    assert slow == pytest.approx(TRANSFER.gain_trained_slow, abs=WITHIN_FAST)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["pes", "lycra"])
def test_specimens_are_as_poor_as_published(name: str, figures: ModuleType) -> None:
    """The population, not its middle alone: mean raw r2 of twenty specimens, each with a campaign of its own."""
    runs = [figures.campaign(preset(f"{name}@{number}"), number, figures.SLOW) for number in SPECIMENS]
    force, displacement, _ = before(runs, figures)
    for target, values in (("force", force), ("displacement", displacement)):
        allowed = np.maximum(WITHIN, MISSED_BY_SPECIMENS.get((name, target), [0, 0, 0]))
        assert (np.abs(values - RAW[name, target]) <= allowed).all(), (target, values)

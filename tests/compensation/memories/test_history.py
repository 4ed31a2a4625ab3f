"""Motion and play: known answers, and the stream equal to the batch."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from compensation.engines.network import Network
from compensation.memories.history import SETTLE_S, History, RunningHistory

DT_S = 0.05


def features(history: History, x: np.ndarray, steps: np.ndarray | None = None) -> np.ndarray:
    """From rest: no motion, and plays that follow x."""
    steps = np.full(len(x) - 1, DT_S) if steps is None else steps
    return history.features(np.asarray(x, dtype=float), steps, at_rest(history, x[0]))


def at_rest(history: History, x: float) -> np.ndarray:
    return np.repeat([0.0, x], [len(history.motion_taus_s), len(history.play_radii)])


def test_a_steady_ramp_has_its_speed_whichever_way_it_goes():
    ramp = 0.3 * DT_S * np.arange(4000)
    for x in (ramp, -ramp):
        assert features(History((0.5, 8.0)), x)[-1] == pytest.approx([0.3, 0.3], rel=1e-6)


def test_motion_fades_at_rest_with_its_time_constant():
    x = np.concatenate([0.3 * DT_S * np.arange(2000), np.full(600, 0.3 * DT_S * 1999)])
    motion = features(History((8.0,)), x)[:, 0]
    settled = 2000 + int(20 * SETTLE_S / DT_S)
    assert motion[settled + 160] / motion[settled] == pytest.approx(np.exp(-1), rel=1e-3)


def test_play_lags_by_its_radius_and_holds_through_small_turns():
    up, down = np.linspace(0, 2, 2000), np.linspace(2, 1.5, 500)
    play = features(History((), (0.5,)), np.concatenate([up, np.full(500, 2.0), down]))[:, 0]
    assert play[2499] == pytest.approx(1.5, abs=1e-6)
    np.testing.assert_allclose(play[2500:], 1.5, atol=1e-6)
    wider = features(History((), (0.1,)), np.concatenate([up, np.full(500, 2.0), down, np.full(500, 1.5)]))[:, 0]
    assert wider[-1] == pytest.approx(1.6, abs=1e-6)


@given(
    x=st.lists(st.floats(-5, 5), min_size=2, max_size=40),
    gaps=st.lists(st.sampled_from([0.0, 1e-6, 0.01, 0.05, 2.0]), min_size=40, max_size=40),
)
def test_stream_is_the_batch_at_any_sampling(x, gaps):
    history = History((0.5, 8.0), (0.2, 1.0))
    steps = np.array(gaps[: len(x) - 1])
    running, held = RunningHistory(history), at_rest(history, x[0])
    streamed = [running.update(value, step, held) for value, step in zip(x, [9.9, *steps], strict=True)]
    np.testing.assert_allclose(streamed, features(history, x, steps), rtol=1e-9, atol=1e-12)


def test_no_history_has_no_features():
    assert features(History(), np.ones(5)).shape == (5, 0)


def test_a_network_absorbs_an_affine_map():
    rng = np.random.default_rng(0)
    network = Network((rng.normal(size=(3, 4)), rng.normal(size=(4, 1))), (rng.normal(size=4), rng.normal(size=1)))
    raw, shift, scale = rng.normal(size=(20, 3)), rng.normal(size=3), rng.uniform(0.1, 3, 3)
    np.testing.assert_allclose(network.absorbing(shift, scale)(raw), network((raw - shift) * scale), atol=1e-12)

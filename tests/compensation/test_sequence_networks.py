"""The rivals without a framework: their gradients are those of their losses, and they learn what has a memory."""

from __future__ import annotations

import numpy as np
import pytest
import sequence_networks as networks


@pytest.mark.parametrize("kind", ["Gru", "Tcn"])
def test_gradients_are_those_of_differences(kind):
    network = networks.Gru(3) if kind == "Gru" else networks.Tcn(3, 5)
    assert networks.gradient_error(network) < 1e-6


@pytest.mark.parametrize("kind", ["Gru", "Tcn"])
def test_they_learn_a_delay_that_no_map_of_the_moment_knows(kind):
    network = networks.Gru(4) if kind == "Gru" else networks.Tcn(4, 3)
    rng = np.random.default_rng(0)
    counts = np.ones((4, 50))
    counts[:, :5] = 0.0

    def lessons(step: int):
        x = rng.standard_normal((4, 50))
        return x, np.roll(x, 2, axis=1), counts

    flat = networks.adam(network.loss, network.start(rng), lessons, 600, 2e-2)
    assert network.loss(flat, *lessons(0))[0] < 0.3

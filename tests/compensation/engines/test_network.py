"""A network from lists: what does not fit together is said in words of its own."""

from __future__ import annotations

import pytest

from compensation.engines.network import Network


@pytest.mark.parametrize(
    ("weights", "biases", "words"),
    [
        ([[[1.0], [2.0, 3.0]]], [[0.0]], "rows of weights of different lengths"),
        ([[[1.0, 2.0]]], [[0.0, 0.0]], "do not fit together into one output"),
        ([[[1.0]]], [], "as many weight matrices as bias vectors"),
        ([[[float("nan")]]], [[0.0]], "not a finite number"),
    ],
)
def test_lists_that_are_no_network_are_refused(weights, biases, words):
    with pytest.raises(ValueError, match=words):
        Network.from_lists(weights, biases)

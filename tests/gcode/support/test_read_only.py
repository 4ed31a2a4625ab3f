"""What frozen results hold."""

from __future__ import annotations

import copy
import json
import pickle
from dataclasses import asdict, dataclass

import numpy as np
import pytest

from gcode.support.read_only import ReadOnly, free_copy, read_only, read_only_array

CHANGES = (
    lambda mapping: mapping.__setitem__("a", 2),
    lambda mapping: mapping.__delitem__("a"),
    lambda mapping: mapping.__ior__({"a": 2}),
    lambda mapping: mapping.update(a=2),
    lambda mapping: mapping.setdefault("b", 2),
    lambda mapping: mapping.pop("a"),
    lambda mapping: mapping.popitem(),
    lambda mapping: mapping.clear(),
)


@pytest.mark.parametrize("change", CHANGES)
def test_a_read_only_mapping_refuses_every_change(change):
    for mapping in (read_only({"a": 1}), read_only({"within": {"a": 1}})["within"]):
        with pytest.raises(TypeError, match="not changed in place; change a copy"):
            change(mapping)
        assert mapping == {"a": 1}


def test_it_does_not_follow_what_it_was_made_of():
    given = {"a": {"b": 1}}
    kept = read_only(given)
    given["a"]["b"] = 2
    assert kept == {"a": {"b": 1}}


def test_it_is_pickled_copied_and_written_as_a_dict_is():
    @dataclass(frozen=True)
    class Result:
        errors: dict[str, float]

    kept = read_only({"a": {"b": 1.0}})
    for again in (pickle.loads(pickle.dumps(kept)), copy.copy(kept), copy.deepcopy(kept)):
        assert type(again) is ReadOnly
        assert again == kept
    assert json.loads(json.dumps(kept)) == asdict(Result(kept))["errors"] == kept
    free = dict(kept) | {"c": 2}
    free["a"] = 3
    assert kept["a"] == {"b": 1.0}


def test_an_array_is_the_same_numbers():
    values = np.arange(3.0)
    kept = read_only_array(values)
    with pytest.raises(ValueError, match="read-only"):
        kept[0] = 5
    values[0] = 7  # who made it may
    assert kept[0] == 7


def test_a_free_copy_is_free_all_through():
    kept = read_only({"a": {"b": [read_only({"c": 1})]}})
    free = free_copy(kept)
    free["a"]["b"][0]["c"] = 2
    free["a"]["d"] = 3
    assert kept == {"a": {"b": [{"c": 1}]}}

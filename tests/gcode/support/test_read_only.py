"""What frozen results hold."""

from __future__ import annotations

import copy
import json
import pickle
from dataclasses import asdict, dataclass, replace
from functools import cached_property

import numpy as np
import pytest

from gcode.support.read_only import ReadOnly, Unchanging, free_copy, read_only, read_only_array

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


def test_an_array_is_nobodys_to_change_and_is_copied_once():
    values = np.arange(3.0)
    seen = values.view()
    seen.flags.writeable = False  # as pandas gives a column: its owner may still change it
    kept, through = read_only_array(values), read_only_array(seen)
    with pytest.raises(ValueError, match="read-only"):
        kept[0] = 5
    values[0] = 7
    assert kept[0] == through[0] == 0
    assert read_only_array(kept) is kept
    assert np.shares_memory(read_only_array(kept[1:]), kept)


@dataclass(frozen=True, eq=False)
class Held(Unchanging):
    values: np.ndarray
    by_name: dict
    parts: tuple = ()
    names: frozenset = frozenset()

    @cached_property
    def doubled(self):
        return 2 * self.values


def test_a_result_is_unchanging_also_as_a_copy_and_out_of_a_pickle():
    values, names = np.arange(3.0), {"a"}
    held = Held(values, {"a": {"b": values}}, (values, {"c": 1}), names)
    values[0] = 7
    names.add("b")
    assert held.doubled[0] == 0
    for one in (
        held,
        pickle.loads(pickle.dumps(held)),
        copy.copy(held),
        copy.deepcopy(held),
        replace(held, names={"a"}),
    ):
        for array in (one.values, one.by_name["a"]["b"], one.parts[0]):
            assert array.tolist() == [0, 1, 2]
            with pytest.raises(ValueError, match="read-only"):
                array[0] = 5
        with pytest.raises(TypeError, match="not changed in place"):
            one.parts[1]["c"] = 2
        assert one.names == frozenset({"a"})


def test_a_free_copy_is_free_all_through():
    kept = read_only({"a": {"b": [read_only({"c": 1})]}})
    free = free_copy(kept)
    free["a"]["b"][0]["c"] = 2
    free["a"]["d"] = 3
    assert kept == {"a": {"b": [{"c": 1}]}}

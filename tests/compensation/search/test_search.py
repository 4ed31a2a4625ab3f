"""The sweep: its enumeration, resuming, ranking and its certainty."""

from __future__ import annotations

import ast
import json
import math
from pathlib import Path

import pandas as pd
import pytest

from compensation.cli import main
from compensation.commands.search import _certainty
from compensation.search import search, search_space
from compensation.search.ranking import rank, split_half_agreement
from gcode.support.errors import UserError
from tests.compensation.search.tasks import task_of


@pytest.fixture(scope="module")
def task(recordings, tmp_path_factory):
    return task_of(recordings, 60, tmp_path_factory.mktemp("search"))


# Copied from the paper's table, halves and quarters as printed.
PRINTED = """
    ( 1, 1 ), ( 1, H ), ( 1, Q ),
    ( 1, 1, 1 ), ( 1, 1, H ), ( 1, H, H ), ( 1, H, Q ),
    ( H, 1, 1 ), ( H, 1, H ), ( H, 1, Q ),
    ( 1, 1, 1, 1 ), ( 1, 1, 1, H ), ( 1, 1, H, H ),
    ( 1, H, H, H ), ( 1, H, H, Q ), ( 1, H, Q, Q ),
    ( 1, Q, Q, Q ), ( H, 1, 1, 1 ), ( H, 1, 1, H ),
    ( H, 1, H, H ), ( 1, H, H, H )
"""
PRINTED_BANKS = """
    0.5,0.1,0.025,0.0025 | 0.4,0.16,0.064,0.0256 | 0.4,0.16,0.064,0.0256,0.01024,0.004096,0.0016384
    0.2,0.04,0.008,0.0016 | 0.1,0.01,0.001 | 0.1,0.01,0.001,0.0001
"""


def test_the_912_of_the_paper_from_its_printed_lists():
    printed = ast.literal_eval("[" + PRINTED.replace("H", "0.5").replace("Q", "0.25") + "]")
    assert len(printed) == 21
    networks = {
        tuple(math.floor(base * share) for share in shares)
        for base in (2, 3, 4, 6, 8, 12, 16, 32)
        for shares in printed
    }
    networks = {sizes for sizes in networks if min(sizes) >= 2}
    assert len(networks) == 114
    assert set(search_space.hidden_layers()) == networks
    found = search_space.candidates()
    assert len({str(candidate) for candidate in found}) == len(found) == 912
    banks = {str(candidate).split(";")[0] for candidate in found}
    assert len(banks) == 8
    assert set(PRINTED_BANKS.replace("|", " ").split()) < banks
    ends = {(bank.count(",") + 1, float(bank.split(",")[-1])) for bank in banks}
    assert {(10, 0.0001048576), (7, 1.28e-05)} < ends
    best = "0.4,0.16,0.064,0.0256,0.01024,0.004096,0.0016384;4,2,2"
    assert best in map(str, found)


def test_list_prints_them_and_stops(capsys):
    assert main(["search", "--preset", "paper", "--list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines == [str(candidate) for candidate in search_space.candidates()]
    assert len(lines) == 912
    assert main(["search", "--list", "--sample", "7"]) == 0
    assert len(capsys.readouterr().out.splitlines()) == 7


def test_without_list_a_search_needs_its_arguments(capsys, tmp_path):
    assert main(["search", "--target", "force", "-o", str(tmp_path / "s.jsonl")]) == 2
    assert "needs 3 campaigns" in capsys.readouterr().err
    assert main(["search", "T", "A", "B", "-o", str(tmp_path / "s.jsonl")]) == 2
    assert "needs --target" in capsys.readouterr().err


def test_bases_that_are_empty_are_no_default(capsys):
    assert main(["search", "--list", "--bases", ""]) == 2
    assert "--bases must be whole numbers from 2 to 256 with commas" in capsys.readouterr().err


def some_jobs(count: int = 3, seeds: int = 2):
    return [(candidate, seed) for seed in range(seeds) for candidate in search_space.candidates()[: count * 40 : 40]]


def test_a_killed_sweep_goes_on(task, tmp_path):
    jobs, results = some_jobs(), tmp_path / "s.jsonl"
    whole = search.sweep(task, jobs, results, workers=1)
    lines = results.read_text().splitlines(keepends=True)
    results.write_text("".join(lines[:4]) + lines[4][:20])
    again = []
    rows = search.sweep(task, jobs, results, workers=1, progress=again.append)
    assert len(again) == len(jobs) - 3
    assert sorted(rows, key=json.dumps) == sorted(whole, key=json.dumps)
    assert search.sweep(task, jobs, results, workers=1, progress=pytest.fail) == rows


def test_what_two_sweeps_at_a_time_have_written_counts_once(task, tmp_path):
    jobs, results = some_jobs(), tmp_path / "s.jsonl"
    whole = search.sweep(task, jobs, results, workers=1)
    first, *rows = results.read_text().splitlines(keepends=True)
    results.write_text("".join([first, *rows, *rows]))
    assert sorted(search.sweep(task, jobs, results, workers=1), key=json.dumps) == sorted(whole, key=json.dumps)


def test_results_of_other_recordings_of_the_same_names_are_refused(recordings, tmp_path):
    task = task_of(recordings, 20.0, tmp_path)
    search.sweep(task, [], tmp_path / "s.jsonl")
    task_of([recordings[1], recordings[0], recordings[2]], 20.0, tmp_path)
    search._series.cache_clear()  # as in another process
    with pytest.raises(UserError, match="other recordings, target or engine"):
        search.sweep(task, [], tmp_path / "s.jsonl")


def test_results_of_another_sweep_are_refused(task, tmp_path):
    from dataclasses import replace

    results = tmp_path / "s.jsonl"
    search.sweep(task, [], results)
    with pytest.raises(UserError, match="other recordings, target or engine"):
        search.sweep(replace(task, target="displacement"), [], results)
    results.write_text("not ours\n")
    with pytest.raises(UserError, match="not a search"):
        search.sweep(task, [], results)


@pytest.mark.parametrize("line", ['{"a": 1}', "[1, 2]", '{"key": "x", "seed": 0, "E": "low"}'])
def test_a_line_that_is_no_result_is_named_and_nothing_is_changed(task, tmp_path, line):
    results = tmp_path / "s.jsonl"
    search.sweep(task, [], results)
    results.write_text(results.read_text() + line + "\nhalf a li")
    before = results.read_text()
    with pytest.raises(UserError, match="line 2 is not a result"):
        search.sweep(task, [], results)
    assert results.read_text() == before


def test_a_binary_file_is_not_a_search(task, tmp_path):
    (tmp_path / "s.jsonl").write_bytes(b"\x80\x04\x95\x00")
    with pytest.raises(UserError, match="not a search"):
        search.sweep(task, [], tmp_path / "s.jsonl")


def test_a_small_sample_meets_many_banks_and_networks():
    """Every 114th candidate would be one and the same network."""
    everything = search_space.candidates()
    eight = search_space.spread(everything, 8)
    assert len({one.bank for one in eight}) >= 6
    assert len({one.sizes for one in eight}) == 8
    assert search_space.spread(everything, 40)[:8] == eight
    assert {one.key for one in search_space.spread(everything, 5000)} == {one.key for one in everything}
    assert {one.key for one in search_space.spread(everything[:2], 5)} == {one.key for one in everything[:2]}


def row(key: str, seed: int, error: float, dead: bool = False) -> dict:
    return {
        "key": key,
        "seed": seed,
        "parameters": 10,
        "dead": dead,
        "E": error,
        "r2_A": 1 - error,
        "r2_B": 1 - error,
    }


def test_ranking_is_sure_when_candidates_are_apart():
    rows = [row("good", seed, 0.01 + 0.001 * seed) for seed in range(6)]
    rows += [row("bad", seed, 0.10 + 0.001 * seed) for seed in range(6)]
    first, second = rank(rows)
    assert (first.key, first.rank_low, first.rank_high, first.chance_first) == ("good", 1, 1, 1.0)
    assert (second.key, second.rank_low) == ("bad", 2)


def test_ranking_admits_when_it_is_not_sure():
    rows = [
        row(key, seed, 0.05 + 0.01 * ((seed * 7 + shift) % 5))
        for shift, key in enumerate("abcd")
        for seed in range(5)
    ]
    ranking = rank(rows)
    assert max(ranked.chance_first for ranked in ranking) < 0.6
    assert ranking[0].rank_high > 1


def test_dead_seeds_are_counted_but_do_not_decide():
    rows = [row("a", 0, 0.02), row("a", 1, 1.0, dead=True), row("b", 0, 0.03), row("b", 1, 0.03)]
    first, second = rank(rows)
    assert (first.key, first.dead, first.E) == ("a", 1, 0.02)
    assert second.dead == 0


def test_what_no_seed_brought_to_life_is_last():
    """A live network may have a larger E than a dead one, whose output is the mean."""
    rows = [row("dead", seed, 0.9, dead=True) for seed in range(5)] + [row("live", seed, 1.2) for seed in range(5)]
    first, last = rank(rows)
    assert (first.key, first.rank_high, first.chance_first) == ("live", 1, 1.0)
    assert (last.key, last.rank_low) == ("dead", 2)


def test_one_live_seed_of_five_is_no_certainty():
    """Of five seeds drawn again, none is the live one in 0.8^5 of the draws."""
    rows = [row("lucky", seed, 0.02, dead=seed > 0) for seed in range(5)] + [
        row("b", seed, 0.03) for seed in range(5)
    ]
    first, second = rank(rows)
    assert (first.key, first.rank_low, first.rank_high) == ("lucky", 1, 2)
    assert first.chance_first == pytest.approx(1 - 0.8**5, abs=0.05)
    assert second.chance_first == pytest.approx(0.8**5, abs=0.05)


def test_a_ranking_does_not_depend_on_which_worker_was_done_first():
    rows = [row(key, seed, 0.1 + 0.01 * ((seed * 7 + n) % 5)) for n, key in enumerate("abcde") for seed in range(5)]
    assert rank(rows[::-1]) == rank(rows) == rank(rows[7:] + rows[:7])


def test_the_first_is_none_of_its_rivals():
    apart = rank([row(key, seed, error) for key, error in (("a", 0.1), ("b", 0.5)) for seed in range(4)])
    assert "0 others cannot be told from it" in _certainty(apart, 1.0, 4)
    near = rank(
        [row(key, seed, 0.1 + 0.01 * ((seed + shift) % 4)) for shift, key in enumerate("ab") for seed in range(4)]
    )
    assert "1 others cannot be told from it" in _certainty(near, 1.0, 4)


def test_split_half_agreement():
    ordered = [row(str(key), seed, key * 0.1) for key in range(5) for seed in range(4)]
    assert split_half_agreement(ordered) == pytest.approx(1.0)
    assert split_half_agreement([row("a", 0, 0.1)]) is None


def test_a_search_reads_what_training_reads(task, tmp_path, capsys):
    """Time, resistance and force are enough; a force that was not tared is refused."""
    bare = [tmp_path / f"{name}.csv" for name in "TAB"]
    for path, whole in zip(bare, task.recordings, strict=True):
        pd.read_csv(whole).drop(columns="displacement_mm").to_csv(path, index=False)
    words = ["search", *map(str, bare), "--target", "force", "--sample", "1", "--seeds", "1", "--workers", "1"]
    assert main([*words, "-o", str(tmp_path / "s.jsonl")]) == 0
    table = pd.read_csv(task.recordings[2])
    table.assign(force_N=table["force_N"] + 50).to_csv(tmp_path / "untared.csv", index=False)
    words[3] = str(tmp_path / "untared.csv")
    assert main([*words, "-o", str(tmp_path / "u.jsonl")]) == 2
    assert "untared.csv: force_N lies between" in capsys.readouterr().err


def test_command_prints_table_picture_and_certainty(task, tmp_path, capsys):
    words = ["search", *task.recordings, "--gauge-length-mm", "25", "--target", "force", "--sample", "4"]
    out, picture = tmp_path / "s.jsonl", tmp_path / "s.png"
    assert main([*words, "--seeds", "2", "--workers", "1", "-o", str(out), "--plot", str(picture)]) == 0
    printed = capsys.readouterr().out
    assert "4 candidates, 2 seeds" in printed
    assert picture.stat().st_size > 5000
    assert len(out.read_text().splitlines()) == 1 + 8
    assert main([*words, "--seeds", "0", "-o", str(out)]) == 2
    assert "--seeds must be at least 1" in capsys.readouterr().err
    assert main([*words, "--top", "-3", "-o", str(out)]) == 2
    assert "--top must be at least 1" in capsys.readouterr().err
    assert main([*words, "--bases", "4,1", "-o", str(out)]) == 2
    assert "--bases must be whole numbers from 2" in capsys.readouterr().err
    assert main([*words, "--scheduler", "tcp://here:1", "-o", str(out)]) == 2
    assert "--scheduler needs --backend dask" in capsys.readouterr().err
    assert main([*words, "-o", str(out), "--plot", "s.txt"]) == 2
    assert "--plot must end in .png" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_dask_gives_the_same_rows(task, tmp_path):
    pytest.importorskip("distributed")
    here, there = (
        search.sweep(task, some_jobs(), Path(tmp_path, f"{backend}.jsonl"), workers=1, backend=backend)
        for backend in ("loky", "dask")
    )
    assert sorted(here, key=json.dumps) == sorted(there, key=json.dumps)


def test_two_candidates_are_ranked_by_their_seeds_all_the_same():
    rows = [row(key, seed, error) for key, error in (("a", 0.1), ("b", 0.3)) for seed in range(5)]
    said = _certainty(rank(rows), split_half_agreement(rows), 5)
    assert "2 candidates, 5 seeds: the first is first in" in said
    assert "use --seeds" not in said

"""The paper's tables: their pieces, on short recordings."""

from __future__ import annotations

import numpy as np
import pytest

from compensation.cli import main
from compensation.paper import published, reproduction, tables
from compensation.series import score
from compensation.training import tuning


@pytest.fixture(scope="module")
def runs(recordings):
    """Named as the table names them."""
    return dict(zip(("T", "A", "B"), recordings, strict=True))


def test_published_figures_agree_with_one_another():
    """E, the means over A and B, and the gains that the paper prints beside them."""
    assert score.error_of_two(*published.COMPENSATED["pes", "force"][1:]) == pytest.approx(0.0490, abs=1e-4)
    assert score.error_of_two(*published.COMPENSATED["lycra", "force"][1:]) == pytest.approx(0.0292, abs=1e-4)
    assert np.mean(published.COMPENSATED["pes", "displacement"][1:]) == pytest.approx(0.667)
    assert np.mean(published.COMPENSATED["lycra", "displacement"][1:]) == pytest.approx(0.639)
    gains = {("pes", "force"): (85, 68, 46), ("lycra", "force"): (20, 24, 13)}
    for key, percents in gains.items():
        pairs = zip(published.RAW[key], published.COMPENSATED[key], strict=True)
        assert [round(100 * (after / raw - 1)) for raw, after in pairs] == pytest.approx(percents, abs=1)
    gains_mm = {"pes": (0.386, 0.380, 0.375), "lycra": (0.350, 0.130, 0.179)}
    for sensor, differences in gains_mm.items():
        pairs = zip(published.RAW[sensor, "displacement"], published.COMPENSATED[sensor, "displacement"], strict=True)
        assert [after - raw for raw, after in pairs] == pytest.approx(differences, abs=2e-3)
    raw, after = published.TRANSFER.extreme
    assert after / raw - 1 == pytest.approx(1.28, abs=0.01)


def test_over_seeds_counts_the_dead(runs):
    series = reproduction.prepared(runs, "force")
    found = reproduction.over_seeds(series["T"], [series["A"], series["B"]], "force", 10)
    assert found.r2.shape == (10, 2)
    assert len(found.live) == 10 - found.dead.sum()
    assert (found.training_r2[found.dead] < 0.1).all()
    assert found.best_of(5).shape == (2, 2)
    assert found.best_of(5).min() > found.live.min() - 1e-12


def test_baselines_are_all_there_and_learn(runs):
    series = reproduction.prepared(runs, "force")
    found = reproduction.baselines(series["T"], [series["A"]], "force")
    assert list(found) == ["linear", "polynomial, 3rd order", "polynomial, 4th order", "random forest"]
    # A polynomial of 4th order runs away on recordings this short; the others must not.
    assert found["linear"][0] > 0.5
    assert found["random forest"][0] > 0.5


def test_result_table_shows_both(runs, monkeypatch):
    monkeypatch.setattr(tuning, "PENALTIES", (0.1,))
    monkeypatch.setattr(tuning, "BANKS", ((2.5, 7),))
    text = tables.results({"pes": [runs]}, "force", 5)
    for words in ("0.423", "0.0490", "each by its own scaler: all seeds", "all by T's scaler: live seeds", "tuned"):
        assert words in text
    assert "95 %" in text


def test_several_sensors_are_averaged(runs, recordings):
    several = [runs, dict(zip("TAB", recordings[::-1], strict=True))]
    text = tables.results({"pes": several}, "force", 2, engine="fast", tuned=False)
    raw = [[score.r2_before(s.truth, s.conductance_S) for s in ours.values()] for ours in map(forces, several)]
    assert "raw, ours (2 sensors)" in text
    for value in np.mean(raw, axis=0):
        assert f"{value:.3f} (" in text


def forces(runs):
    return reproduction.prepared(runs, "force")


def test_transfer_shows_gains_with_both_scalers(runs):
    named = dict(runs) | {"fast-T": runs["T"], "fast-A": runs["A"]}
    text = tables.transfer({"pes": [named]}, 2, engine="fast")
    assert "raw 0.644" in text
    assert "+24%; one recording from 0.349 to 0.795" in text
    assert text.count("trained on 0-50 %, a = 1.75") == 2


def test_one_seed_has_no_spread(tmp_path, capsys):
    assert main(["table", "-o", str(tmp_path), "--seeds", "1"]) == 2
    assert "at least 2" in capsys.readouterr().err


def test_a_transfer_without_a_live_seed_says_so(runs, monkeypatch):
    """A dead network's r2 of zero is no gain of -100 %."""
    from dataclasses import replace

    living = reproduction.over_seeds

    def dead(*args):
        found = living(*args)
        return replace(found, dead=np.ones_like(found.dead))

    monkeypatch.setattr(reproduction, "over_seeds", dead)
    text = tables.transfer({"pes": [{"T": runs["T"], "fast-T": runs["A"], "fast-A": runs["B"]}]}, 1, "fast")
    assert text.count("every seed is dead") == 6
    assert "-100%" not in text


def test_a_specimen_or_a_rate_without_a_live_seed_is_left_out(runs, monkeypatch):
    """Neither a nan nor a warning of numpy's: the spread is that of the specimen that lives."""
    rows = [np.empty((0, 3)), np.array([[0.5, 0.6, 0.7], [0.7, 0.6, 0.5]])]
    assert tables._seed_row("pes", "live", rows) == tables._seed_row("pes", "live", rows[1:])
    assert "0.600 (0.100)" in tables._seed_row("pes", "live", rows)
    nobody = reproduction.Seeds(np.zeros((2, 2)), np.ones(2, dtype=bool), np.zeros(2))
    monkeypatch.setattr(reproduction, "over_seeds", lambda *_: nobody)
    monkeypatch.setattr(reproduction, "baselines", lambda *_: {})
    text = tables.others({"pes": [runs]}, 2)
    assert text.count("every seed is dead") == 3
    assert "nan" not in text

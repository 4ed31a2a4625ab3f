"""Small recordings and results that the tests of figures share; all seeded."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from testbench.comparing.cell import Cell
from testbench.comparing.compare import Comparison, Place
from testbench.recordings.recording import Recording
from testbench.report.figures.comparison_figures import Overlay
from testbench.report.figures.ladder_figures import Step


def recording(count: int = 3000, force: bool = True, resistance: bool = True, temperature: bool = False) -> Recording:
    """A slow sine of 10 % strain at about 20 Hz with a little noise."""
    noise = np.random.default_rng(1)
    time_s = np.arange(count) * 0.05 + noise.uniform(0, 0.02, count)
    strain = 0.05 * (1 - np.cos(0.4 * time_s))
    channels = {"displacement_mm": 25 * strain}
    if force:
        channels["force_N"] = 20 * strain + noise.normal(0, 0.01, count)
    if resistance:
        channels["resistance_ohm"] = 2000 / (1 + 5 * strain) * np.exp(noise.normal(0, 0.002, count))
    if temperature:
        channels["temperature_C"] = 21 + 0.01 * time_s
    return Recording(time_s, channels, 25.0, "sample/recording.csv")


def overlay() -> Overlay:
    """A baseline that is wrong by a tenth and a second model that is right to the noise."""
    source = recording()
    strain, log_g = source.strain, np.log(source.conductance_S)
    measured = {"force": source["force_N"], "conductance": log_g}
    good = {"force": 20 * strain, "conductance": np.log((1 + 5 * strain) / 2000)}
    poor = {"force": 18 * strain, "conductance": good["conductance"] - strain}
    models = {"baseline": poor, "+ creep": good}
    return Overlay(source.time_s, strain, measured, models, {"force": 0.01, "conductance": 0.002}, 100.0)


def steps() -> list[Step]:
    """Two rungs."""
    floor = {"force": 0.01, "conductance": 0.002}
    return [
        Step("baseline", {"force": 0.12, "conductance": 0.031}, floor),
        Step("+ stress_relaxation", {"force": 0.011, "conductance": 0.0024}, floor),
    ]


def comparison(worst: tuple[Place, ...] | None = None) -> Comparison:
    """What `compare` gives, with one coordinate split by direction and one not."""
    cells = [Cell(0.01 * i, 0.01 * (i + 1), d, 0.01 * d * i, 0.002, 0.1) for i in range(5) for d in (1, -1)]
    elapsed = [replace(cell, direction=0, low=1e4 * cell.low, high=1e4 * cell.high) for cell in cells[::2]]
    maps = {"strain": tuple(cells), "elapsed_s": tuple(elapsed)}
    words = "modelled force is 0.12 N too high between 4.0 % and 5.0 % strain"
    usual = (Place("force", "strain", cells[0], 0.4, words),)
    both = ("force", "conductance")
    same = [dict.fromkeys(both, value) for value in (0.12, 0.01, 0.0)]
    return Comparison(*same, dict.fromkeys(both, maps), usual if worst is None else worst)


def score() -> dict:
    """The JSON of `compensation score` over a training and a held-out recording."""
    time_s = [0.05 * i for i in range(200)]
    wave = [float(np.sin(t)) for t in time_s]
    trace = {
        "time_s": time_s,
        "F": wave,
        "G": wave,
        "G_rescaled": [0.8 * v for v in wave],
        "p": [0.98 * v for v in wave],
    }
    row = {
        "r2_before": 0.42, "r2_after": 0.79, "r2_after_interval": [0.75, 0.82], "rho2_before": 0.5, "gain": 0.37,
        "rms_error": 0.05, "trace": trace, "zooms": [trace, trace, trace], "duration_s": 10.0, "samples": 200,
    }  # fmt: skip
    return {
        "format": "knitbench-score",
        "version": 1,
        "compensator": {"target": "force", "unit": "N", "parameters": 51},
        "recordings": [
            row | {"source": "pes-T/recording.csv", "role": "training"},
            row | {"source": "pes-A/recording.csv", "role": "held-out", "r2_after_interval": None},
        ],
        "summary": {
            "over": "held-out",
            "recordings": 1,
            "r2_before": 0.42,
            "r2_after": 0.79,
            "gain": 0.37,
            "E": None,
        },
    }


def diagnosis(verdict: str = "missing") -> dict:
    """The JSON of `testbench diagnose`, but for its models."""

    def entry(name: str, probability: float, gain: float) -> dict:
        tied = verdict == "missing" and gain > 0
        return {"effect": name, "law": name, "probability": probability, "log_evidence": 20 * gain, "gain": gain,
                "held_out_gain": [1.96, 1.8, 2.2] if gain > 0 else None, "error_share_left": 0.6,
                "tied_for_first": tied, "start": {}}  # fmt: skip

    found = [{"effect": "stress_relaxation", "law": "stress_relaxation", "probability": 0.61, "log_evidence": 24.0}]
    relaxation, creep, unknown, nothing = {
        "missing": (0.61, 0.36, 0.016, 0.004),
        "nothing_missing": (0.02, 0.0, 0.05, 0.92),
        "unknown": (0.07, 0.02, 0.88, 0.02),
    }[verdict]
    chances = {"nothing": nothing, "unknown": unknown, "stress_relaxation": relaxation, "load_cell_creep": creep}
    floor = {"force": 0.01, "conductance": 0.002}
    return {
        "verdict": verdict,
        "probabilities": chances | {"slack": 0.01},
        "found": found if verdict == "missing" else [],
        "ranking": [
            entry("stress_relaxation", relaxation, 1.2),
            entry("load_cell_creep", creep, 1.18),
            entry("slack", 0.01, -0.01),
        ],
        "tied": ["stress_relaxation", "load_cell_creep"] if verdict == "missing" else [],
        "base_misfits": ["elasticity_shape"],
        "depends_on": [{"channel": "force", "coordinate": "elapsed time", "gain": 0.7}],
        "left_unexplained": 0.07,
        "error_before": {"force": 0.12, "conductance": 0.031},
        "error_after": {"force": 0.011, "conductance": 0.0024},
        "noise_floor": floor,
    }


def experiment(log_odds: float = 22.0, grade: str = "decisive") -> dict:
    """As `testbench experiment --json` writes it."""
    first = {"protocol": "long-hold", "duration_s": 600.0, "log_odds": log_odds, "grade": grade, "channel": "force"}
    second = first | {"protocol": "noise", "log_odds": 0.4, "grade": "cannot tell"}
    left = {"force": {"time_s": [1.0, 2.0, 3.0], "over_noise": [0.0, 4.0, -1.0]}}
    rivals = ["load_cell_creep", "stress_relaxation"]
    return {"rivals": rivals, "gauge_length_mm": 25.0, "options": [first, second], "left": left}

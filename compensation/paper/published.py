"""Every figure that the paper prints; `compensation table` holds ours against it, and the presets are tuned to it.

Aigner and Stoeckl, "Machine Learning Based Compensation for Inconsistencies in Knitted Force Sensors" (2023,
arXiv:2306.12129): Tables 1 and 4 and the section "Further Experiments" of the paper, and the table of its supplement.
T is the training recording, A and B are the tests.
"""

from __future__ import annotations

from dataclasses import dataclass

# r2(F, G) and r2(d, G) on T, A, B.
RAW = {
    ("pes", "force"): (0.423, 0.471, 0.526),
    ("pes", "displacement"): (0.319, 0.319, 0.260),
    ("lycra", "force"): (0.703, 0.667, 0.734),
    ("lycra", "displacement"): (0.337, 0.479, 0.490),
}
# r2(F, p) and r2(d, p) on T, A, B: a = 2.5, N = 7, hidden layers (4, 2, 2).
COMPENSATED = {
    ("pes", "force"): (0.781, 0.791, 0.767),
    ("pes", "displacement"): (0.705, 0.699, 0.635),
    ("lycra", "force"): (0.841, 0.830, 0.828),
    ("lycra", "displacement"): (0.687, 0.609, 0.669),
}


@dataclass(frozen=True)
class Transfer:
    """The fast set, 0 to 50 % at up to 14 mm/s, PES patches, force: medians over the recordings, gains relative."""

    raw: float  # r2(F, G)
    gain_trained_there: float  # network trained on the fast set, a = 2.5
    gain_trained_there_finer: float  # the same with a = 1.75
    gain_trained_slow: float  # network trained on the slow set (0 to 30 %), a = 2.5
    extreme: tuple[float, float]  # r2 before and after of the recording that gained most


TRANSFER = Transfer(0.644, 0.15, 0.24, 0.23, (0.349, 0.795))
# v in mm/s and a in mm/s2: max, mean, SD.
TRAJECTORIES = {
    "paper-1": ((4.142, 0.943, 0.593), (19.05, 1.397, 1.303)),
    "paper-2": ((4.930, 0.979, 0.617), (18.61, 1.497, 1.343)),
    "paper-3": ((4.039, 1.030, 0.644), (19.25, 1.546, 1.414)),
    "fast": ((14.0, 2.87, 2.06), (65.54, 9.27, 7.87)),
}

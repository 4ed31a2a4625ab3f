"""What the paper reports, as far as it is known here; everything in `compensation table` is held against it.

Aigner and Stoeckl, "Machine Learning Based Compensation for Inconsistencies in Knitted Force Sensors" (2023,
arXiv:2306.12129) and its supplement. T is the training recording, A and B are the tests.
"""

from __future__ import annotations

RAW = {
    ("pes", "force"): (0.423, 0.471, 0.526),
    ("pes", "displacement"): (0.319, 0.319, 0.260),
    ("lycra", "force"): (0.703, 0.667, 0.734),
    ("lycra", "displacement"): (0.337, 0.479, 0.490),
}
# Rounded means after compensation.
COMPENSATED = {
    ("pes", "force"): 0.78,
    ("pes", "displacement"): 0.68,
    ("lycra", "force"): 0.83,
    ("lycra", "displacement"): 0.65,
}
E = {("pes", "force"): 0.0490, ("lycra", "force"): 0.0292}
# v in mm/s and a in mm/s2: max, mean, SD.
TRAJECTORIES = {
    "paper-1": ((4.142, 0.943, 0.593), (19.05, 1.397, 1.303)),
    "paper-2": ((4.930, 0.979, 0.617), (18.61, 1.497, 1.343)),
    "paper-3": ((4.039, 1.030, 0.644), (19.25, 1.546, 1.414)),
    "fast": ((14.0, 2.87, 2.06), (65.54, 9.27, 7.87)),
}

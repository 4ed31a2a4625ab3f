"""``gcode fit``: find a spec with given statistics."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from gcode.commands._numbers import number
from gcode.support.console import given

if TYPE_CHECKING:
    from gcode.trajectories.natural import Target
    from gcode.trajectories.noise_fit import FitResult

SUMMARY = "find a spec whose executed motion has given means and SDs of speed and acceleration"
EXAMPLE = "gcode fit --v-mean 0.943 --v-sd 0.593 --a-mean 1.397 --a-sd 1.303 -o mine.toml"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    number(parser, "--v-mean", "v_mean_mm_per_s", "MM/S", "mean of |v|", required=True)
    number(parser, "--v-sd", "v_sd_mm_per_s", "MM/S", "standard deviation of |v|", required=True)
    number(parser, "--a-mean", "a_mean_mm_per_s2", "MM/S2", "mean of |a|", required=True)
    number(parser, "--a-sd", "a_sd_mm_per_s2", "MM/S2", "standard deviation of |a|", required=True)
    number(parser, "--rate-hz", "rate_hz", "HZ", "rate at which they are taken (default 20)", default=20.0)
    number(parser, "--v-max", "v_max_mm_per_s", "MM/S", "speed limit; default 5 times --v-mean")
    number(parser, "--a-max", "a_max_mm_per_s2", "MM/S2", "acceleration limit; default 14 times --a-mean")
    number(parser, "--gauge-length-mm", "gauge_length_mm", "MM", "between the grips (default 25)", default=25.0)
    number(parser, "--low-percent", "low_percent", "%", "strain range, lower end (default 0)", default=0.0)
    number(parser, "--high-percent", "high_percent", "%", "strain range, upper end (default 30)", default=30.0)
    parser.add_argument("-o", "--output", metavar="TOML", help="write the spec here instead of printing it")


def run(args: argparse.Namespace) -> None:
    from gcode.support import files
    from gcode.support.console import Progress
    from gcode.trajectories.natural import Target
    from gcode.trajectories.noise_fit import SHAPES, fit
    from gcode.trajectories.trajectory import Limits, spec_to_toml

    files.check_place(args.output)
    target = Target(**given(args, Target.model_fields))
    usual = {"v_max_mm_per_s": 5.0 * target.v_mean_mm_per_s, "a_max_mm_per_s2": 14.0 * target.a_mean_mm_per_s2}
    limits = Limits(**usual | given(args, usual))
    asked = given(args, ("gauge_length_mm", "low_percent", "high_percent"))
    result = fit(target, limits, **asked, on_shape=Progress("fit", len(SHAPES)).step)
    text = spec_to_toml(result.spec)
    if args.output:
        files.write_text(args.output, text)
    else:
        print(text)
    _say(result, target, args.gauge_length_mm)
    if args.output:
        print(args.output)


def _say(result: FitResult, target: Target, gauge_length_mm: float) -> None:
    """How near the spec comes to each statistic."""
    print("statistic              wanted   mean off   worst of 4 new seeds")
    for name, mean in result.mean.items():
        print(f"{name:18s} {getattr(target, name):10.4g} {mean:+9.1%} {result.worst[name]:12.1%}")
    verdict = "near: every mean is within 3 %" if result.near else "not near: this target is out of reach within 3 %"
    print(f"{verdict} (gauge length {gauge_length_mm:g} mm)")

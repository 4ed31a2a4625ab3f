"""``gcode fit``: find a spec with given statistics."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from gcode.trajectories.noise_fit import FitResult
    from gcode.trajectories.target import Target

SUMMARY = "find a spec whose executed motion has given means and SDs of speed and acceleration"
EXAMPLE = "gcode fit --v-mean 0.943 --v-sd 0.593 --a-mean 1.397 --a-sd 1.303 -o mine.toml"
WANTED = ("v_mean_mm_per_s", "v_sd_mm_per_s", "a_mean_mm_per_s2", "a_sd_mm_per_s2")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    v_mean, v_sd, a_mean, a_sd = WANTED
    parser.add_argument("--v-mean", dest=v_mean, type=float, required=True, metavar="MM/S", help="mean of |v|")
    parser.add_argument(
        "--v-sd", dest=v_sd, type=float, required=True, metavar="MM/S", help="standard deviation of |v|"
    )
    parser.add_argument("--a-mean", dest=a_mean, type=float, required=True, metavar="MM/S2", help="mean of |a|")
    parser.add_argument(
        "--a-sd", dest=a_sd, type=float, required=True, metavar="MM/S2", help="standard deviation of |a|"
    )
    parser.add_argument(
        "--rate-hz", type=float, default=20.0, metavar="HZ", help="rate at which they are taken (default 20)"
    )
    parser.add_argument(
        "--v-max",
        dest="v_max_mm_per_s",
        type=float,
        metavar="MM/S",
        help="speed limit; default 5 times --v-mean",
    )
    parser.add_argument(
        "--a-max",
        dest="a_max_mm_per_s2",
        type=float,
        metavar="MM/S2",
        help="acceleration limit; default 14 times --a-mean",
    )
    parser.add_argument(
        "--gauge-length-mm",
        type=float,
        default=25.0,
        metavar="MM",
        help="sample length between the grips (default 25)",
    )
    parser.add_argument(
        "--low-percent", type=float, default=0.0, metavar="%", help="strain range, lower end (default 0)"
    )
    parser.add_argument(
        "--high-percent", type=float, default=30.0, metavar="%", help="strain range, upper end (default 30)"
    )
    parser.add_argument("-o", "--output", metavar="TOML", help="write the spec here instead of printing it")


def run(args: argparse.Namespace) -> None:
    from gcode.support import files
    from gcode.support.console import Progress
    from gcode.trajectories.noise_fit import SHAPES, fit
    from gcode.trajectories.target import Target
    from gcode.trajectories.toml_spec import spec_to_toml
    from gcode.trajectories.trajectory import Limits

    files.check_place(args.output)
    target = Target(rate_hz=args.rate_hz, **{name: getattr(args, name) for name in WANTED})
    v_max, a_max = args.v_max_mm_per_s, args.a_max_mm_per_s2
    limits = Limits(
        v_max_mm_per_s=5.0 * target.v_mean_mm_per_s if v_max is None else v_max,
        a_max_mm_per_s2=14.0 * target.a_mean_mm_per_s2 if a_max is None else a_max,
    )
    asked = {name: getattr(args, name) for name in ("gauge_length_mm", "low_percent", "high_percent")}
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

"""Speed of fit, compare and diagnose on two 23 min recordings, and where the time goes.

    python benchmarks/bench_fit.py

The reference is scipy.optimize.least_squares with its own numerical Jacobian on the same residuals, bounds and start:
what one would write without this package's staged simulation. All on one thread, in one run.
"""

from __future__ import annotations

import cProfile
import inspect
import pstats
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from testbench.comparing.compare import compare
from testbench.comparing.residual_coordinates import coordinates
from testbench.diagnosis import diagnose
from testbench.diagnosis.searching.proposals import laws_of
from testbench.fitting.baseline import starting_baseline
from testbench.fitting.evidence.evidence import maximised
from testbench.fitting.evidence.laplace import _PosteriorFit
from testbench.fitting.fit import fit
from testbench.fitting.parameters import free_parameters, shape_scales
from testbench.fitting.sensitivity import sensitivities
from testbench.knit.model import KnitModel
from testbench.measurements.measurement import Measurement
from testbench.measurements.noise_level import noise_floor
from testbench.measurements.splitting import split
from testbench.worlds import make_case

STAGES: dict[str, Callable[..., Any]] = {
    "simulating effects": KnitModel.simulate,
    "sensitivities": sensitivities,
    "fits": fit,
    "sensitivities of a diagnosis": _PosteriorFit.linearise,
    "evidence": maximised,
    "laws tried": laws_of,
    "coordinates": coordinates,
}


def timed(work: Callable[[], Any]) -> tuple[float, Any]:
    """CPU seconds and the result: wall-clock time would count other people's work."""
    start = time.process_time()
    result = work()
    return time.process_time() - start, result


def with_scipy(model: KnitModel, measurement: Measurement) -> KnitModel:
    """The same problem as one would first write it."""
    parameters = free_parameters(model, shape_scales(measurement))
    scale = {c: 3 * noise_floor(v[measurement.counts]) for c, v in measurement.measured.items()}

    def residual(x: np.ndarray) -> np.ndarray:
        left = measurement.residual(parameters.model_at(model, x))
        return np.concatenate([left[c][measurement.counts] / scale[c] for c in left])

    low, high = parameters.low, parameters.high
    start = np.clip(parameters.point_of(model), low + 1e-9, high - 1e-9)
    found = least_squares(residual, start, bounds=(low, high), x_scale="jac", loss="huber", max_nfev=25)
    return parameters.model_at(model, found.x)


def spread(model: KnitModel, measurement: Measurement) -> str:
    """Residual standard deviations."""
    left = measurement.residual(model)
    return ", ".join(f"{c} {np.std(v[measurement.counts]):.4g}" for c, v in left.items())


def where_time_goes(profile: cProfile.Profile) -> None:
    """Cumulative seconds of the stages; they contain one another."""
    table = pstats.Stats(profile).stats  # type: ignore[attr-defined]
    total = sum(row[2] for row in table.values())
    for label, stage in STAGES.items():
        rows = [row for (file, _, name), row in table.items() if (file, name) == _place(stage)]
        if rows:
            seconds, calls = sum(row[3] for row in rows), sum(row[1] for row in rows)
            print(f"    {label:<24}{seconds:>8.2f} s {100 * seconds / total:>5.0f} %   {calls} calls")


def _place(stage: Callable[..., Any]) -> tuple[str, str]:
    """How a profile calls a function."""
    return inspect.getfile(stage), stage.__name__


def main() -> None:
    """Print the table."""
    case = make_case("stress_relaxation", strength=5, seed=1, minutes=23, rate_hz=40)
    calibration, held = split(case.calibration, case.held_out)
    start = starting_baseline(calibration)
    fit(start, calibration, iterations=1)  # compiled kernels are loaded once a session
    reference_s, theirs = timed(lambda: with_scipy(start, calibration))
    fit_s, ours = timed(lambda: fit(starting_baseline(calibration), calibration))
    compare_s, _ = timed(lambda: compare(ours.model, held, free_offset=True))
    profile = cProfile.Profile()
    plain_s, result = timed(lambda: diagnose(case.calibration, case.held_out))
    profile.runcall(diagnose, case.calibration, case.held_out)
    print(
        f"two recordings of 23 min at 40 Hz, {len(calibration.counts)} grid points each; CPU seconds on one thread\n"
    )
    print(f"{'':<44}{'seconds':>8}{'x reference':>14}")
    for label, seconds in (
        ("scipy.optimize.least_squares (reference)", reference_s),
        (f"fit ({len(ours.parameters)} parameters)", fit_s),
        ("compare", compare_s),
        (f"diagnose ({result.verdict})", plain_s),
    ):
        print(f"{label:<44}{seconds:>8.2f}{seconds / reference_s:>14.2f}")
    print(f"\nresidual: scipy {spread(theirs, calibration)}; fit {spread(ours.model, calibration)}")
    print("\nwhere a diagnosis' time goes (profiled, stages contain one another):")
    where_time_goes(profile)


if __name__ == "__main__":
    main()

"""gcode's speed: making a program, the planner's segments per second, and limiting against toppra on the same job.

Run: python benchmarks/bench_gcode.py [--day]
"""

from __future__ import annotations

import logging
import resource
import sys
import time

import numpy as np

from gcode.mach4.controller import Machine, execute
from gcode.mach4.reader import read_program
from gcode.motion.limits import drive_within
from gcode.motion.path import Path
from gcode.programs.make import make
from gcode.trajectories.natural import Noise
from gcode.trajectories.planning import plan
from gcode.trajectories.presets import preset
from gcode.trajectories.trajectory import Limits, TrajectorySpec

V_MAX, A_MAX = 4.0, 20.0


def cpu(job):
    start = time.process_time()
    result = job()
    return time.process_time() - start, result


def best(job, times: int = 3):
    return min((cpu(job) for _ in range(times)), key=lambda pair: pair[0])


def making() -> None:
    seconds, made = best(lambda: make(preset("paper-1"), 51, 25.0))
    print(f"23 min at 20 Hz, tuned, limited, written, checked: {seconds:6.2f} s of CPU (goal 1 s)")
    program = read_program(made.program)
    seconds, _ = best(lambda: execute(program, Machine()))
    print(f"planner: {len(program.line) / seconds / 1e6:.1f} million segments/s")


def day() -> None:
    spec = preset("paper-1")
    spec = spec.model_copy(update={"pieces": (spec.pieces[0].model_copy(update={"duration_s": 86400.0}),)})
    seconds, _ = cpu(lambda: make(spec, 51, 25.0))
    peak_mb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"24 h at 20 Hz: {seconds:6.1f} s of CPU (goal 60 s), {peak_mb:.0f} MB at most (goal 1000 MB)")


def against_toppra() -> None:
    """The same path and limits. Ours slows the plan down where it must, toppra finds the fastest way through."""
    import toppra
    from toppra import algorithm, constraint

    logging.getLogger("toppra").setLevel(logging.ERROR)
    toppra.setup_logging("ERROR")
    noise = Noise(duration_s=1380.0, cells_per_s=0.6, octaves=2)
    free = plan(TrajectorySpec(pieces=(noise,), limits=Limits(v_max_mm_per_s=50, a_max_mm_per_s2=500)), 51, 25.0)
    path = Path(free.position_mm, np.full(len(free.position_mm) - 1, 0.05))
    ours_s, motion = best(lambda: drive_within(path, V_MAX, A_MAX))
    spline = toppra.SplineInterpolator(free.time_s, free.position_mm[:, None])
    bounds = [
        constraint.JointVelocityConstraint(np.array([[-V_MAX, V_MAX]])),
        constraint.JointAccelerationConstraint(np.array([[-A_MAX, A_MAX]])),
    ]

    def theirs():
        solver = algorithm.TOPPRA(bounds, spline, gridpoints=free.time_s, solver_wrapper="seidel")
        return solver.compute_parameterization(0, 0)

    theirs_s, _ = best(theirs, 2)
    fine = np.diff(motion.position_at(np.arange(0, motion.end_s, 1e-3)), 2) * 1e6
    print(f"limiting {len(path.duration_s)} segments to {V_MAX:g} mm/s and {A_MAX:g} mm/s2:")
    print(f"  ours   {1e3 * ours_s:8.1f} ms   (a at most {np.abs(fine).max():.2f} mm/s2 at 1 kHz)")
    print(f"  toppra {1e3 * theirs_s:8.1f} ms")
    print(f"  ratio  {theirs_s / ours_s:8.1f} x   (goal 5 x)")
    print(f"  the run takes {motion.end_s / free.duration_s - 1:+.1%} time, its stroke is kept exactly")


if __name__ == "__main__":
    making()
    against_toppra()
    if "--day" in sys.argv:
        day()

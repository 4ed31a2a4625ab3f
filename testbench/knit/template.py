"""A commented template for a user's own effect."""

from __future__ import annotations

from pathlib import Path

from gcode.support.errors import UserError
from gcode.support.files import write_text
from testbench.knit.catalogue import BUILT_IN
from testbench.knit.effect_names import check_name, class_name

TEMPLATE = '''"""My own effect for knitbench. Try it:  testbench effects --effects {file} --check"""

import numpy as np

from testbench.knit.effect import Effect, Stage, parameter


class {cls}(Effect):
    """What happens, in one sentence.

    ln G += gain * e        (the formula; here: conductance shifts with strain)

    Source: where the formula comes from.
    Valid: where it holds.
    """

    name = "{name}"
    # Where in the chain: KINEMATICS strain, MECHANICS and TENSION force_N, PRESSURE contact_force_N,
    # CONTACT and ELECTRICAL conductance_S, READOUT force_N and conductance_S.
    stage = Stage.ELECTRICAL
    reads = ("strain", "conductance_S")  # also there: time_s, strain_nominal, force_N, contact_force_N
    writes = ("conductance_S",)
    strength = "gain"  # the parameter whose 0 means "no effect"
    look = "what a person sees in the data when this effect is there"

    gain: float = parameter(0.1, unit="1", low=-5, high=5, doc="change of ln G per unit of strain")

    def apply(self, signals, dt_s):
        # Whole arrays in, new arrays out; never change an input in place.
        # For memory, testbench.knit.filters has lowpass(x, tau_s, dt_s) and rate(x, dt_s).
        return {{"conductance_S": signals["conductance_S"] * np.exp(self.gain * signals["strain"])}}
'''


def write_template(name: str, path: Path) -> None:
    """Write a template that keeps the rules.

    Raises
    ------
    UserError
        If `name` is no usable name, `path` does not end in .py, or the file exists: somebody's work must not be
        overwritten.
    """
    check_name(name, str(path), BUILT_IN)
    if path.suffix != ".py":
        raise UserError(f"{path}: an effects file is Python, and its name must end in .py; choose another")
    if path.exists():
        raise UserError(f"{path} exists already; choose another name, or another place")
    write_text(path, TEMPLATE.format(cls=class_name(name), name=name, file=path.name))

"""One specimen and its instruments, drawn from a seed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from worlds_fourth.laws import (
    CONTACT_LOOPS,
    COURSES,
    DRIFTS,
    PLACES,
    Conduction,
    ContactLoops,
    Elasticity,
    Friction,
    draw_conduction,
    draw_contact_loops,
    draw_elasticity,
    draw_friction,
)
from worlds_fourth.randoms import Rng, stream

STRAINS = (0.3, 0.5)  # at the end of the stroke
LEAST_OHM, MOST_OHM = 2e4, 2e6


@dataclass(frozen=True)
class Instruments:
    """Errors of the readings.

    Attributes
    ----------
    zero_N, step_N : float
        Error of the zero of the force, and the step of its converter.
    bits, reference_ohm : int, float
        Of the divider that reads the resistance.
    colour_force, colour_resistance : float
        How alike neighbouring samples of the noise are, 0 for white noise.
    outliers : float
        Share of samples whose noise is 5 to 12 times as large.
    """

    zero_N: float
    step_N: float
    bits: int
    reference_ohm: float
    colour_force: float
    colour_resistance: float
    outliers: float

    @property
    def kind(self) -> str:
        """Kind of the noise in a word."""
        if self.outliers:
            return "with_outliers"
        return "coloured" if self.colour_force or self.colour_resistance else "white"


@dataclass(frozen=True)
class Specimen:
    """Its laws and numbers, and the ranges of both readings in the calibration without any effect.

    Attributes
    ----------
    seed : int
    elasticity, friction, conduction, contact_loops
        Base laws (see `laws`).
    viscosity, viscosity_s : float
        Share of the elastic force that relaxes, and its time; 0 where none does.
    contact_viscosity, contact_viscosity_s : float
        The same of the driver of the contacts.
    log_r_middle : float
        ln R, R in ohm, in the middle of the stroke.
    drift, drift_place, drift_height : str, str, float
        Drift of ln R (see `laws.drift`).
    instruments : Instruments
    force_range_N, log_r_range : tuple of float
        Lowest and highest reading without any effect.
    """

    seed: int
    elasticity: Elasticity
    friction: Friction
    viscosity: float
    viscosity_s: float
    conduction: Conduction
    log_r_middle: float
    contact_loops: ContactLoops
    contact_viscosity: float
    contact_viscosity_s: float
    drift: str
    drift_place: str
    drift_height: float
    instruments: Instruments
    force_range_N: tuple[float, float] = (0.0, 1.0)
    log_r_range: tuple[float, float] = (0.0, 1.0)

    @property
    def end(self) -> float:
        """Strain at the end of the stroke."""
        return self.elasticity.max_strain

    @property
    def top_N(self) -> float:
        """Elastic force at the end of the stroke."""
        return self.elasticity.top_N

    def told(self) -> dict[str, Any]:
        """For the truth of a case."""
        return {
            "max_strain": self.end,
            "rest_force_N": self.elasticity.rest_N,
            "top_force_N": self.top_N,
            "elasticity": {"law": self.elasticity.name},
            "friction": {"law": self.friction.name, "text": self.friction.text},
            "viscosity": [self.viscosity, self.viscosity_s],
            "conduction": {"law": self.conduction.name, "text": self.conduction.text},
            "course": {"law": self.conduction.course},
            "log_g_range": self.conduction.range,
            "contact_loops": {"law": self.contact_loops.name},
            "contact_viscosity": [self.contact_viscosity, self.contact_viscosity_s],
            "drift": {"law": self.drift, "height": self.drift_height},
            "drift_place": {"law": self.drift_place},
        }


def draw_specimen(seed: int, attempt: int = 0) -> Specimen:
    """Draw a specimen; another attempt of the same seed is another specimen."""
    rng = stream(seed, "base", attempt) if attempt else stream(seed, "base")
    end = float(rng.choice(STRAINS))
    top_N = float(np.exp(rng.uniform(np.log(1.0), np.log(5.2))))
    rest_N = float(min(rng.uniform(0.005, 0.3), 0.15 * top_N))
    elasticity = draw_elasticity(rng, end, rest_N, top_N)
    friction = draw_friction(rng, end, rest_N, top_N)
    viscosity, viscosity_s = _viscosity(rng, 0.5)
    course = str(rng.choice(list(COURSES), p=list(COURSES.values())))
    loops_name = str(rng.choice(CONTACT_LOOPS))
    conduction = draw_conduction(rng, elasticity, course, loops_name == "force")
    log_r_middle = rng.uniform(np.log(LEAST_OHM) + 0.95, np.log(MOST_OHM) - 0.95)
    loops = draw_contact_loops(rng, loops_name, conduction.range)
    contact_viscosity, contact_viscosity_s = _viscosity(rng, 0.4)
    drift, place = str(rng.choice(list(DRIFTS))), str(rng.choice(PLACES))
    return Specimen(
        seed=seed,
        elasticity=elasticity,
        friction=friction,
        viscosity=viscosity,
        viscosity_s=viscosity_s,
        conduction=conduction,
        log_r_middle=log_r_middle,
        contact_loops=loops,
        contact_viscosity=contact_viscosity,
        contact_viscosity_s=contact_viscosity_s,
        drift=drift,
        drift_place=place,
        drift_height=rng.uniform(0.003, 0.02),
        instruments=_instruments(rng, log_r_middle),
    )


def _viscosity(rng: Rng, chance: float) -> tuple[float, float]:
    share = rng.uniform(0.008, 0.02) if rng.random() < chance else 0.0
    return share, float(np.exp(rng.uniform(np.log(1.0), np.log(15.0))))


def _instruments(rng: Rng, log_r_middle: float) -> Instruments:
    return Instruments(
        zero_N=rng.uniform(-0.01, 0.01),
        step_N=float(rng.choice([0.6e-3, 1.2e-3, 2.4e-3])),
        bits=int(rng.choice([14, 15, 16, 18])),
        reference_ohm=float(np.exp(log_r_middle + rng.uniform(-0.7, 0.7))),
        colour_force=rng.uniform(0.2, 0.5) if rng.random() < 0.25 else 0.0,
        colour_resistance=rng.uniform(0.2, 0.6) if rng.random() < 0.25 else 0.0,
        outliers=rng.uniform(1e-4, 6e-4) if rng.random() < 0.2 else 0.0,
    )

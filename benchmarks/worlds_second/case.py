"""One case: two recordings of a drawn sensor with a hidden effect, and the truth about it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from gcode.support.errors import UserError
from testbench.recordings.channels import FORCE, RESISTANCE, TEMPERATURE
from testbench.recordings.recording import Recording
from worlds_second.chain import Hook
from worlds_second.choice import Hidden, choose
from worlds_second.draws import stream
from worlds_second.protocols import draw_motion
from worlds_second.rig import NAMES, Rig
from worlds_second.sensor import draw_sensor
from worlds_second.strength import reach


@dataclass(frozen=True)
class Case:
    """Two recordings of one sensor, each started fresh with its own motion, and what is hidden in them.

    Attributes
    ----------
    calibration, held_out : Recording
    truth : dict
        Ready for JSON: ``verdict`` (``missing`` where an effect of the catalogue's mechanisms is hidden, ``unknown``
        where only others are, ``nothing_missing``), ``effects``, ``base``, ``noise_floor``, ``noise_kind``,
        ``displacement_noise_mm`` and ``recipe``. An effect's ``magnitude`` is in its form's own measure: the share of
        the force that creeps for ``load_cell_creep``, a length over the stroke for ``permanent_set``.
    """

    calibration: Recording
    held_out: Recording
    truth: dict[str, Any]


def make_case(
    effect: str | None,
    strength: float = 5.0,
    seed: int = 0,
    *,
    minutes: float = 23.0,
    rate_hz: float = 40.0,
    noise: float = 1.0,
    protocol: str = "perlin",
    channels: Sequence[str] = (FORCE, RESISTANCE),
    leave_out: str | Sequence[str] | None = None,
    only_laws: Mapping[str, Sequence[str]] | None = None,
    max_strain: float | None = None,
    reclamped: bool = False,
) -> Case:
    """Make a sensor with a hidden effect and record it twice.

    Parameters
    ----------
    effect : str, optional
        A mechanism (`MECHANISMS`) or a kind of no catalogue (`UNKNOWN_KINDS`), either as ``name`` or ``name:form``;
        ``"none"``; ``"unknown"``, which draws such a kind; or two of these joined by a comma. None draws.
    strength : float
        What the sensor's own base laws cannot absorb of each effect: RMS over all samples of the recorded
        channels, in noise floors. What is out of an effect's reach ends lower; the truth says what was reached.
    seed : int
        One seed is one sensor with its motions and noise, whatever the effect.
    minutes, rate_hz : float
        Length of each recording and its sampling rate.
    noise : float
        1 is the noise of the paper's rig (5 mN, 8e-4 in ln G, 1 um).
    protocol : str
        ``perlin``, ``ramp_hold``, ``cyclic``, ``staircase`` or ``multisine``.
    channels : sequence of str
        ``force_N``, ``resistance_ohm`` or both, and ``temperature_C`` if wanted.
    leave_out : str or sequence of str, optional
        Base laws that are not drawn: ``"fung"`` or ``"drift:none"``.
    only_laws : mapping, optional
        Families restricted to some members: ``{"elasticity": ["fung"]}``.
    max_strain : float, optional
        Strain at the end of the stroke; drawn otherwise (mostly 0.25 to 0.6, some soft, some stiff).
    reclamped : bool
        The held-out recording has other zeros of displacement and force.

    Raises
    ------
    UserError
        If an argument is out of its range; the message says what is allowed.
    """
    recipe = {
        "effect": effect, "strength": strength, "seed": seed, "minutes": minutes, "rate_hz": rate_hz,
        "noise": noise, "protocol": protocol, "channels": list(channels),
        "leave_out": leave_out if leave_out is None or isinstance(leave_out, str) else list(leave_out),
        "only_laws": only_laws and {family: list(names) for family, names in only_laws.items()},
        "max_strain": max_strain, "reclamped": reclamped,
    }  # fmt: skip
    _check(channels, strength, noise, seed)
    sensor = draw_sensor(seed, max_strain=max_strain, only_laws=only_laws, leave_out=leave_out)
    motions = [
        draw_motion(stream(seed, "motion", protocol, str(index)), protocol, minutes, rate_hz, index, reclamped)
        for index in (0, 1)
    ]
    rig = Rig(sensor, seed, noise, motions, channels)
    hidden = choose(effect, seed, set(rig.floors), sensor.feels_force)
    hooks, effects = _scaled(rig, hidden, strength)
    truth = {
        "verdict": _verdict(hidden),
        "effects": effects,
        "base": sensor.described(),
        "noise_floor": dict(rig.floors),
        "noise_kind": rig.noise_kind,
        "displacement_noise_mm": rig.displacement_noise_mm,
        "recipe": recipe,
    }
    return Case(rig.record(0, hooks), rig.record(1, hooks), truth)


def _check(channels: Sequence[str], strength: float, noise: float, seed: int) -> None:
    strange = [name for name in channels if name not in (*NAMES, TEMPERATURE)]
    if isinstance(channels, str) or strange or not set(NAMES) & set(channels):
        raise UserError(
            f"channels must name force_N, resistance_ohm or both, and temperature_C if wanted; got {channels}"
        )
    if not strength > 0:
        raise UserError(f"strength must be a positive number of noise floors, got {strength:g}")
    if not noise > 0:
        raise UserError(f"noise must be positive (1 is the rig of the paper), got {noise:g}")
    if seed < 0:
        raise UserError(f"seed must not be negative, got {seed}")


def _verdict(hidden: Sequence[Hidden]) -> str:
    if not hidden:
        return "nothing_missing"
    return "missing" if any(one.in_catalogue for one in hidden) else "unknown"


def _scaled(rig: Rig, hidden: Sequence[Hidden], strength: float) -> tuple[list[Hook], list[dict[str, Any]]]:
    """What the effects do to the sensor, each alone brought to the strength asked for, and the truth about them."""
    hooks, effects = [], []
    for one in hidden:
        magnitude = reach(strength, one.form.largest, partial(_strength, rig, one))
        got = rig.strength(one.hooks(magnitude))
        reached = {
            "magnitude": magnitude,
            "strength_requested": float(strength),
            "strength_reached": got.pop("both"),
            "strength_by_channel": got,
        }
        effects.append({**one.described(), **reached})
        hooks += one.hooks(magnitude)
    return hooks, effects


def _strength(rig: Rig, one: Hidden, magnitude: float) -> float:
    return rig.strength(one.hooks(magnitude))["both"]

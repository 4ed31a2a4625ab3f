"""A case: two recordings of one sensor with an effect hidden in it, and the truth about them."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gcode.support.arrays import FloatArray
from gcode.support.errors import UserError
from testbench.recordings.channels import DISPLACEMENT, FORCE, RESISTANCE, TEMPERATURE
from testbench.recordings.recording import Recording
from testbench.worlds import strength as strengths
from testbench.worlds.base import WORLDS, BaseWorld, draw_world
from testbench.worlds.chain import Form, Hidden, Scene, Usual, run
from testbench.worlds.coloured_noise import KINDS, quantised, unit_noise
from testbench.worlds.effects import FORMS, UNKNOWN
from testbench.worlds.kernels import lowpass
from testbench.worlds.motions import GAUGE_LENGTH_MM, PROTOCOLS, sample_times

CATALOGUE = tuple(name for name in FORMS if name not in UNKNOWN)
OUTSIDE = tuple(sorted(UNKNOWN))
NOISES = (*KINDS, "any")
DECOY_SHARE = 0.15
LEAST_SAMPLES, MOST_MADE_SAMPLES = 200, 20_000_000  # the second: 48 h at 100 Hz
READING_NOISE_MM = (0.0003, 0.005)  # standard deviation of a displacement reading, drawn for each sensor


@dataclass(frozen=True)
class Case:
    """Two recordings and what is hidden in them.

    Attributes
    ----------
    calibration, held_out : Recording
        The same sensor, started fresh, on two trajectories of one kind.
    truth : dict
        What was hidden, how strongly, in which base world, over which noise floor. JSON-ready.
    """

    calibration: Recording
    held_out: Recording
    truth: dict[str, Any]


def make_case(
    effect: str | None = None,
    strength: float = 5.0,
    world: str = "matched",
    seed: int = 0,
    minutes: float = 23.0,
    rate_hz: float = 40.0,
    noise: str = "any",
    *,
    protocol: str = "perlin",
    form: str | None = None,
    channels: Sequence[str] = (FORCE, RESISTANCE),
) -> Case:
    """Hide an effect in a sensor and record it twice.

    Parameters
    ----------
    effect : str, optional
        A name of `CATALOGUE`; ``"none"``; ``"unknown"`` (one of `OUTSIDE`, drawn by seed) or a name of `OUTSIDE`;
        two or more names joined by commas. Left out: drawn by seed.
    strength : float
        What the base laws cannot absorb, over the noise floor (see `testbench.worlds.strength`). Each of several
        effects has it alone.
    world : str
        One of `WORLDS`.
    seed : int
        One seed, one sensor, motion and noise: the effect changes nothing but itself.
    minutes, rate_hz : float
        Length [min] and mean sampling rate [Hz] of each recording.
    noise : str
        One of `NOISES`: white, white with an AR(1) or pink share, or any of these by seed.
    protocol : str
        One of `PROTOCOLS`.
    form : str, optional
        The form of a single effect; drawn by seed when left out.
    channels : sequence of str
        Which of ``force_N``, ``resistance_ohm`` are recorded.

    Raises
    ------
    UserError
        For an unknown name or an impossible number.
    """
    if seed < 0:
        raise UserError(f"seed: must be 0 or a positive whole number, got {seed}")
    _check(world, noise, protocol, channels, strength=strength, minutes=minutes, rate_hz=rate_hz)
    base = draw_world(world, rng_of(seed, "base", world))
    bench = Bench(base, seed, minutes, rate_hz, noise, protocol)
    chosen = [choose(name, form, seed, base) for name in names_of(effect, seed)]
    hidden = [bench.scale(one, shape, strength) for one, shape in chosen]
    truth = bench.truth(hidden, [bench.report(one, strength) for one in hidden])
    truth["recipe"] = {"effect": effect, "strength": strength, "world": world, "seed": seed, "minutes": minutes}
    truth["recipe"] |= {"rate_hz": rate_hz, "noise": noise, "protocol": protocol, "channels": list(channels)}
    recordings = [bench.recording(part, hidden, channels) for part in PARTS]
    return Case(recordings[0], recordings[1], truth)


PARTS = ("calibration", "held_out")


class Bench:
    """One sensor on the tester: its motion, its surroundings and its noise, the same whatever is hidden."""

    def __init__(self, base: BaseWorld, seed: int, minutes: float, rate_hz: float, noise: str, protocol: str):
        self.base, self.seed, self.rate_hz = base, seed, rate_hz
        rng = rng_of(seed, "noise")
        self.noise_kind = str(rng.choice(KINDS)) if noise == "any" else noise
        self.top_N = float(base.force(np.array([0.0, 0.3]))[1])
        self.motion = {part: self._motion(part, minutes, protocol) for part in PARTS}
        self.usual = Usual()
        force, ln_g = self.signals("calibration", ())
        self.usual = Usual(_range(force), _range(ln_g), float(ln_g.mean()))
        swing = float(np.quantile(ln_g, 0.99) - np.quantile(ln_g, 0.01))
        self.floor_N = self.top_N * float(np.exp(rng.uniform(np.log(0.001), np.log(0.003))))
        self.floor_ln = swing * float(np.exp(rng.uniform(np.log(0.0015), np.log(0.004))))
        self.floor_mm = float(np.exp(rng_of(seed, "encoder").uniform(*np.log(READING_NOISE_MM))))
        self.typical_ohm = float(np.exp(-np.median(ln_g)))
        self._basis: dict[str, FloatArray] = {}
        self._plain: dict[str, FloatArray] = {}

    def _motion(self, part: str, minutes: float, protocol: str) -> tuple[FloatArray, FloatArray, FloatArray]:
        t = sample_times(minutes, self.rate_hz, rng_of(self.seed, part, "clock"))
        strain = PROTOCOLS[protocol](t, rng_of(self.seed, part, "motion"))
        return t, strain, ambient_K(t, rng_of(self.seed, part, "ambient"))

    def scene(self, part: str) -> Scene:
        """The motion and the surroundings of one recording, before any law has acted."""
        t, strain, ambient = self.motion[part]
        return Scene(t, strain, ambient, self.top_N, self.usual, (self.seed, zlib.crc32(part.encode())))

    def signals(self, part: str, hidden: Sequence[Hidden], base: BaseWorld | None = None) -> Any:
        """Force [N] and ln of conductance [S] of one recording without noise, shape (n,) each."""
        return run(base or self.base, self.scene(part), hidden)

    def whitened(self, part: str, hidden: Sequence[Hidden], base: BaseWorld | None = None) -> FloatArray:
        """Both channels over their noise floors, thinned, in one row."""
        force, ln_g = self.signals(part, hidden, base)
        thin = slice(None, None, strengths.THIN)
        return np.concatenate([force[thin] / self.floor_N, ln_g[thin] / self.floor_ln])

    def left_over(self, part: str, hidden: Sequence[Hidden]) -> FloatArray:
        """What the base laws cannot absorb of `hidden`, in noise floors."""
        if part not in self._basis:
            self._basis[part] = strengths.basis(self.base, lambda base: self.whitened(part, (), base))
            self._plain[part] = self.whitened(part, ())
        return strengths.unabsorbed(self.whitened(part, hidden) - self._plain[part], self._basis[part])

    def scale(self, form: Form, shape: dict[str, float], target: float) -> Hidden:
        """`form` at the magnitude that makes its strength `target`."""

        def strength_of(magnitude: float) -> float:
            return strengths.rms(self.left_over("calibration", [Hidden(form, shape, magnitude)]))

        return Hidden(form, shape, strengths.magnitude_for(target, form.most, strength_of))

    def report(self, one: Hidden, requested: float) -> dict[str, Any]:
        """What is to be known of one hidden effect: its form, its magnitude and how strong it became, JSON-ready."""
        left = {part: self.left_over(part, [one]) for part in PARTS}
        half = len(left["calibration"]) // 2
        raw = self.whitened("calibration", [one]) - self._plain["calibration"]
        reached = strengths.rms(left["calibration"])
        return {
            "effect": one.form.effect,
            "form": one.form.name,
            "in_catalogue": one.form.effect not in UNKNOWN,
            "stages": list(one.form.changes),
            "shape": dict(one.shape),
            "magnitude": one.magnitude,
            "strength_requested": requested,
            "strength_reached": reached,
            "reached": bool(abs(reached / requested - 1) <= 0.2),
            "strength_in_held_out": strengths.rms(left["held_out"]),
            "strength_by_channel": {
                "force": strengths.rms(left["calibration"][:half]),
                "conductance": strengths.rms(left["calibration"][half:]),
            },
            "strength_before_absorption": strengths.rms(raw),
        }

    def truth(self, hidden: Sequence[Hidden], reports: list[dict]) -> dict[str, Any]:
        """All that is sealed with a case: what was hidden, in which world, over which noise floors, JSON-ready."""
        names = [one.form.effect for one in hidden]
        outside = any(name in UNKNOWN for name in names)
        verdict = "nothing_missing" if not names else "unknown" if outside else "missing"
        return {
            "verdict": verdict,
            "effects": reports,
            "base": {"world": self.base.name, **self.base.describe()},
            "noise_floor": {"force": self.floor_N, "conductance": self.floor_ln},
            "displacement_noise_mm": self.floor_mm,
            "noise_floor_units": {"force": "N", "conductance": "ln S"},
            "noise_kind": self.noise_kind,
            "joint_strength": strengths.rms(self.left_over("calibration", hidden)) if hidden else 0.0,
            "definition_of_strength": " ".join((strengths.__doc__ or "").split()),
        }

    def recording(self, part: str, hidden: Sequence[Hidden], channels: Sequence[str]) -> Recording:
        """What the instruments write of one of the two recordings."""
        t, strain, ambient = self.motion[part]
        force, ln_g = self.signals(part, hidden)
        rngs = rng_of(self.seed, part, "noise"), rng_of(self.seed, part, "encoder")
        read = self.read(strain, ambient, force, ln_g, hidden, *rngs)
        unread = {FORCE, RESISTANCE} - set(channels)
        return Recording(t, {c: v for c, v in read.items() if c not in unread}, GAUGE_LENGTH_MM, source=part)

    def read(
        self,
        strain: FloatArray,
        ambient: FloatArray,
        force: FloatArray,
        ln_g: FloatArray,
        hidden: Sequence[Hidden],
        rng: np.random.Generator,
        encoder: np.random.Generator,
    ) -> dict[str, FloatArray]:
        """Readings of every channel: noise, steps of the converters, and a thermometer where there is one."""
        count = len(strain)
        noise_N, noise_ln = (unit_noise(self.noise_kind, count, self.rate_hz, rng) for _ in range(2))
        step_ohm = self.typical_ohm * self.floor_ln / 4
        ohm = quantised(np.exp(-(ln_g + self.floor_ln * noise_ln)), step_ohm)
        read = {
            DISPLACEMENT: np.round(strain * GAUGE_LENGTH_MM + self.floor_mm * encoder.standard_normal(count), 4),
            FORCE: quantised(force + self.floor_N * noise_N, self.floor_N / 4),
            RESISTANCE: np.maximum(ohm, step_ohm),
        }
        if self._has_thermometer(hidden):
            read[TEMPERATURE] = np.round(23 + ambient + 0.02 * rng.standard_normal(count), 2)
        return read

    def _has_thermometer(self, hidden: Sequence[Hidden]) -> bool:
        """Where temperature matters the form says so; elsewhere a thermometer sometimes hangs there for nothing."""
        said = [one.shape["measured"] for one in hidden if "measured" in one.shape]
        return bool(max(said)) if said else bool(rng_of(self.seed, "decoy").uniform() < DECOY_SHARE)


def _range(values: FloatArray) -> tuple[float, float]:
    return float(values.min()), float(values.max())


def ambient_K(t: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Room temperature over its value at the start [K]: a slow walk and a heater that cycles."""
    steps = rng.standard_normal(len(t)) * np.sqrt(np.gradient(t))
    walk = lowpass(t, np.cumsum(steps) * 0.04, 90.0)
    cycle = 0.5 * np.sin(2 * np.pi * t / rng.uniform(300, 1200) + rng.uniform(0, 2 * np.pi))
    total = walk + cycle + rng.normal(0, 1.0) * t / 1380
    return total - total[0]


def names_of(effect: str | None, seed: int) -> list[str]:
    """The effects to hide; "unknown" and a missing name are drawn by seed."""
    rng = rng_of(seed, "effect")
    if effect is None:
        effect = str(rng.choice([*CATALOGUE, "none", "none", "unknown", "unknown"]))
    names = [name.strip() for name in effect.split(",")]
    if names == ["none"]:
        return []
    if "none" in names:
        raise UserError(f"effect: none cannot be joined with others, got {effect!r}")
    names = [str(rng.choice(OUTSIDE)) if name == "unknown" else name for name in names]
    for name in names:
        if name not in FORMS:
            allowed = ", ".join([*CATALOGUE, "none", "unknown", *OUTSIDE])
            raise UserError(f"effect: no effect {name!r} to hide; choose from {allowed}")
    if len(set(names)) < len(names):
        raise UserError(f"effect: {effect!r} names one effect twice; name each once")
    return names


def choose(name: str, form: str | None, seed: int, base: BaseWorld) -> tuple[Form, dict[str, float]]:
    """A form of an effect, the one named or one that shows in this world, drawn by seed; and its shape parameters."""
    forms = FORMS[name]
    rng = rng_of(seed, "form", name)
    felt = [f for f in forms if base.contacts_feel_force or set(forms[f].changes) != {"pressure"}]
    drawn = str(rng.choice(felt))
    if form is not None and form not in forms:
        raise UserError(f"form: {name} has the forms {', '.join(forms)}, got {form!r}")
    one = forms[form or drawn]
    return one, one.draw(rng)


def rng_of(seed: int, *labels: str) -> np.random.Generator:
    """A generator of its own for every purpose, so that one choice never shifts another."""
    return np.random.default_rng([seed, *(zlib.crc32(label.encode()) for label in labels)])


def _check(world: str, noise: str, protocol: str, channels: Sequence[str], **numbers: float) -> None:
    for what, came, allowed in (
        ("world", world, WORLDS),
        ("noise", noise, NOISES),
        ("protocol", protocol, tuple(PROTOCOLS)),
    ):
        if came not in allowed:
            raise UserError(f"{what}: must be one of {', '.join(allowed)}, got {came!r}")
    if not channels or set(channels) - {FORCE, RESISTANCE}:
        raise UserError(f"channels: must be {FORCE}, {RESISTANCE} or both, got {list(channels)}")
    for what, number in numbers.items():
        if not (np.isfinite(number) and number > 0):
            raise UserError(f"{what}: must be a positive number, got {number}")
    samples = numbers["minutes"] * 60 * numbers["rate_hz"]
    if samples < LEAST_SAMPLES:
        raise UserError(
            f"minutes: {numbers['minutes']} min at {numbers['rate_hz']} Hz is under {LEAST_SAMPLES} samples; "
            "ask for more"
        )
    if samples > MOST_MADE_SAMPLES:
        raise UserError(
            f"minutes: {numbers['minutes']} min at {numbers['rate_hz']} Hz are more than the "
            f"{MOST_MADE_SAMPLES} samples that are simulated at once; ask for less"
        )

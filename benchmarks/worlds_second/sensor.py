"""A sensor: base laws drawn freely from their families, and the sizes that make it soft, typical or stiff."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from simulated_case import laws_of, stream

from worlds_second.draws import draw_all
from worlds_second.laws import FAMILIES, LAW_FAMILIES, Member
from worlds_second.laws.contact import STRAIN_DRIVEN

TYPICAL, SOFT, STIFF = (0.25, 0.6), (0.8, 1.6), (0.01, 0.03)
FEWEST_STEP = 0.1  # a parameter near zero is stepped as if it were this large


@dataclass(frozen=True)
class Law:
    """One drawn member of a family and its parameters."""

    family: str
    name: str
    parameters: Mapping[str, float]

    def __call__(self, *signals: Any) -> Any:
        return self.member.function(*signals, **self.parameters)

    @property
    def member(self) -> Member:
        """Where it was drawn from."""
        return FAMILIES[self.family][self.name]


@dataclass(frozen=True)
class Sensor:
    """The drawn sensor.

    Attributes
    ----------
    max_strain : float
        Strain at the end of the stroke (dimensionless); the laws work on strain relative to it.
    gauge_length_mm, force_full_N, resistance_full_ohm : float
        Length at rest, elastic force at the end of the stroke, and the scale of the resistance.
    pretension : float
        Relative strain of the sample where the displacement reads zero.
    laws : mapping of family to Law
    """

    max_strain: float
    gauge_length_mm: float
    force_full_N: float
    resistance_full_ohm: float
    pretension: float
    laws: Mapping[str, Law] = field(default_factory=dict)

    @property
    def stroke_mm(self) -> float:
        """Largest displacement."""
        return self.max_strain * self.gauge_length_mm

    @property
    def feels_force(self) -> bool:
        """Whether the conductance depends on the force, or on the strain alone."""
        return self.laws["contact"].name not in STRAIN_DRIVEN or self.laws["resistance_loops"].name == "play_force"

    def stepped(self, share: float) -> list[tuple[Sensor, float]]:
        """This sensor with each parameter moved a little in turn, and by how much."""
        return [*self._stepped_sizes(share), *self._stepped_laws(share)]

    def _stepped_sizes(self, share: float) -> list[tuple[Sensor, float]]:
        step = share * FEWEST_STEP
        return [
            (replace(self, force_full_N=self.force_full_N * (1 + share)), self.force_full_N * share),
            (replace(self, resistance_full_ohm=self.resistance_full_ohm * (1 + share)), share),
            (replace(self, pretension=self.pretension + step), step),
        ]

    def _stepped_laws(self, share: float) -> list[tuple[Sensor, float]]:
        out = []
        for family, law in self.laws.items():
            for name, value in law.parameters.items():
                step = share * max(abs(value), FEWEST_STEP)
                moved = replace(law, parameters={**law.parameters, name: value + step})
                out.append((replace(self, laws={**self.laws, family: moved}), step))
        return out

    def described(self) -> dict[str, Any]:
        """What was drawn, ready for JSON."""
        sizes = {name: getattr(self, name) for name in self.__dataclass_fields__ if name != "laws"}
        laws = {family: {"law": law.name, **law.parameters} for family, law in self.laws.items()}
        return {**sizes, **laws}


def draw_sensor(seed: int, asked: str = "") -> Sensor:
    """Draw the sensor of a seed, on wish with some laws only (see `laws_of`)."""
    laws = {family: _draw_law(seed, family, names) for family, names in laws_of(asked, LAW_FAMILIES).items()}
    rng = stream(seed, "sizes")
    ranges, chance = (TYPICAL, SOFT, STIFF), rng.choice(3, p=[0.74, 0.13, 0.13])
    return Sensor(
        max_strain=float(rng.uniform(*ranges[chance])),
        gauge_length_mm=float(rng.uniform(30.0, 100.0)),
        force_full_N=float(10.0 ** rng.uniform(0.0, 1.0)),
        resistance_full_ohm=float(10.0 ** rng.uniform(2.0, 5.0)),
        pretension=float(rng.uniform(0.0, 0.06)),
        laws=laws,
    )


def _draw_law(seed: int, family: str, names: Sequence[str]) -> Law:
    name = str(stream(seed, family).choice(list(names)))
    return Law(family, name, draw_all(FAMILIES[family][name].ranges, stream(seed, family, name)))

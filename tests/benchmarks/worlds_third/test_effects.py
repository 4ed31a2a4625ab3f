"""Every effect of the third simulator acts where it says, as strongly as asked, and not at all at size zero."""

from __future__ import annotations

import numpy as np
import pytest
from worlds_third import MECHANISMS, UNKNOWN_KINDS, Case, make_case
from worlds_third.effects import choose_effect
from worlds_third.effects.choice import KNOWN
from worlds_third.effects.unknown import FORMS
from worlds_third.sensor import make_sensor, respond
from worlds_third.signals import Signals

from testbench.recordings.channels import FORCE, RESISTANCE

SHORT = {"minutes": 4.0, "rate_hz": 20.0}
KINDS = [*MECHANISMS, *UNKNOWN_KINDS]


def changes(case: Case, plain: Case) -> dict[str, np.ndarray]:
    """What the effect did to force in N and ln G, calibration first; the noise of both cases is the same."""
    pairs = [(case.calibration, plain.calibration), (case.held_out, plain.held_out)]
    force = np.concatenate([one[FORCE] - other[FORCE] for one, other in pairs])
    log_g = np.concatenate([np.log(other[RESISTANCE] / one[RESISTANCE]) for one, other in pairs])
    return {"force": force, "conductance": log_g}


def own_residual(change: np.ndarray, plain: Case) -> float:
    """RMS after a fit of less than the simulator takes out: an offset, a slope over strain and log time."""
    recordings = (plain.calibration, plain.held_out)
    columns = [np.concatenate([np.ones(len(r)) for r in recordings])]
    columns.append(np.concatenate([r.strain for r in recordings]))
    columns.append(np.concatenate([np.log1p(r.time_s / 5.0) for r in recordings]))
    matrix = np.column_stack(columns)
    return float(np.sqrt(np.mean((change - matrix @ np.linalg.lstsq(matrix, change)[0]) ** 2)))


def test_no_two_forms_have_one_name() -> None:
    assert len({(form.mechanism, form.name) for form in KNOWN}) == len(KNOWN)


@pytest.mark.parametrize("name", KINDS)
def test_an_effect_is_as_strong_as_asked_in_its_channel(name: str) -> None:
    seed = 40 + KINDS.index(name)
    case, plain = make_case(name, 5.0, seed, **SHORT), make_case("none", 5.0, seed, **SHORT)
    told = case.truth["effects"][0]
    assert told["strength_reached"] == pytest.approx(5.0, rel=0.1)
    main = told["main_channel"]
    if main == "both":
        main = max(told["strength_by_channel"], key=told["strength_by_channel"].get)
    assert told["strength_by_channel"][main] == pytest.approx(5.0, rel=0.1)
    done = changes(case, plain)
    assert own_residual(done[main], plain) > 0.9 * 5.0 * case.truth["noise_floor"][main]
    if told["stages"] == ["readout"] or told["main_channel"] == "conductance":
        (other,) = {"force", "conductance"} - {main}
        assert np.sqrt(np.mean(done[other] ** 2)) < 0.1 * case.truth["noise_floor"][other]
    assert case.truth["verdict"] == ("missing" if name in MECHANISMS else "unknown")


@pytest.mark.parametrize("form", [*KNOWN, *FORMS], ids=lambda form: f"{form.mechanism}:{form.name}")
def test_an_effect_of_no_size_is_none(form: object) -> None:
    def run(size: float | None, tops: tuple[float, float, float] = (1.0, -1.0, 0.0)) -> Signals:
        time_s = np.arange(0, 60, 0.05)
        drive, room = 0.5 - 0.5 * np.cos(time_s), np.sin(time_s / 20)
        s = Signals(time_s, drive, room, 20.0, tops=tops)
        effect = choose_effect(f"{form.mechanism}:{form.name}", 5, 0, ["force", "conductance"])
        return respond(make_sensor(5), s, [] if size is None else [effect.hook(size * form.limit, "calibration")])

    plain = run(None)
    tops = float(plain.force.max()), float(plain.log_g.min()), float(plain.log_g.max())
    none, some = run(1e-9, tops), run(0.3, tops)
    assert np.abs(none.force - plain.force).max() < 1e-6
    assert np.abs(none.log_g - plain.log_g).max() < 1e-6
    for name in ("force", "log_g"):
        assert np.all(np.isfinite(getattr(some, name)))
    assert np.abs(some.force - plain.force).max() + np.abs(some.log_g - plain.log_g).max() > 1e-4


def test_an_effect_of_15_floors_is_larger_than_one_of_5() -> None:
    plain = make_case("none", 5.0, 3, **SHORT)
    weak, strong = (make_case("coating_wear:archard", k, 3, **SHORT) for k in (5.0, 15.0))
    ratio = changes(strong, plain)["conductance"].std() / changes(weak, plain)["conductance"].std()
    assert ratio == pytest.approx(3.0, rel=0.05)


def test_two_effects_at_once_are_both_there() -> None:
    case = make_case("periodic_interference:hum,load_cell_creep", 5.0, 4, **SHORT)
    done = changes(case, make_case("none", 5.0, 4, **SHORT))
    assert [one["effect"] for one in case.truth["effects"]] == ["periodic_interference", "load_cell_creep"]
    assert done["force"].std() > 3 * case.truth["noise_floor"]["force"]
    assert done["conductance"].std() > 3 * case.truth["noise_floor"]["conductance"]


def test_the_resistance_alone_shows_an_effect_on_the_force() -> None:
    case = make_case("stress_relaxation", 5.0, 6, channels=[RESISTANCE], **SHORT)
    plain = make_case("none", 5.0, 6, channels=[RESISTANCE], **SHORT)
    assert case.truth["base"] == plain.truth["base"] | {"drive": {"law": "by_force"}}
    assert case.truth["effects"][0]["strength_by_channel"]["conductance"] > 4

"""Laws that hold for every form of every hidden effect, whoever adds one."""

from __future__ import annotations

import numpy as np
import pytest

from testbench.worlds.base import WORLDS, draw_world
from testbench.worlds.chain import Hidden, Scene, Usual, run
from testbench.worlds.effects import FORMS, UNKNOWN
from testbench.worlds.kernels import lowpass_two_way
from testbench.worlds.motions import PROTOCOLS, sample_times

ALL = [form for forms in FORMS.values() for form in forms.values()]
NAMES = [f"{form.effect}-{form.name}" for form in ALL]
OWNED = {
    "kinematics": {"force", "ln_g"},
    "mechanics": {"force", "ln_g"},
    "pressure": {"ln_g"},
    "electrical": {"ln_g"},
    "readout": {"force", "ln_g"},
}


def _usual() -> Usual:
    """Range of the sensor of these tests."""
    t = sample_times(3, 40.0, np.random.default_rng(1))
    strain = PROTOCOLS["perlin"](t, np.random.default_rng(2))
    scene = Scene(t, strain, np.sin(t / 60), 5.0, Usual(), (3,))
    force, ln_g = run(draw_world("matched", np.random.default_rng(4)), scene)
    return Usual((force.min(), force.max()), (ln_g.min(), ln_g.max()), ln_g.mean())


def _scene(rate_hz: float = 40.0) -> Scene:
    t = sample_times(3, rate_hz, np.random.default_rng(1))
    strain = PROTOCOLS["perlin"](t, np.random.default_rng(2))
    return Scene(t, strain, np.sin(t / 60), 5.0, _usual(), (3,))


def _read(form, share: float, rate_hz: float = 40.0) -> dict[str, np.ndarray]:
    base = draw_world("matched", np.random.default_rng(4))
    shape = form.draw(np.random.default_rng(5))
    force, ln_g = run(base, _scene(rate_hz), [Hidden(form, shape, share * form.most)])
    return {"force": force, "ln_g": ln_g}


@pytest.mark.parametrize("form", ALL, ids=NAMES)
def test_magnitude_zero_is_the_base_world_exactly(form):
    base = draw_world("matched", np.random.default_rng(4))
    plain = run(base, _scene())
    hidden = _read(form, 0.0)
    assert np.array_equal(plain[0], hidden["force"])
    assert np.array_equal(plain[1], hidden["ln_g"])


@pytest.mark.parametrize("form", ALL, ids=NAMES)
def test_a_vanishing_magnitude_changes_next_to_nothing(form):
    tiny, plain = _read(form, 1e-7), _read(form, 0.0)
    for name in plain:
        assert np.max(np.abs(tiny[name] - plain[name])) < 1e-3


@pytest.mark.parametrize("form", ALL, ids=NAMES)
def test_the_effect_shows_in_its_own_channels_alone_and_stays_finite(form):
    strong, plain = _read(form, 0.3), _read(form, 0.0)
    allowed = set().union(*(OWNED[stage] for stage in form.changes))
    changed = {name for name in plain if not np.array_equal(strong[name], plain[name])}
    assert changed
    assert changed <= allowed
    assert all(np.isfinite(values).all() for values in strong.values())


@pytest.mark.parametrize("form", ALL, ids=NAMES)
def test_the_effect_does_not_depend_on_the_sampling_rate(form):
    """Sampled three times as densely, the same motion gives nearly the same change."""
    coarse_t, fine_t = _scene(40).t, np.arange(0, 3 * 60, 1 / 120.0)
    strain = np.interp(fine_t, coarse_t, _scene(40).commanded)
    base = draw_world("matched", np.random.default_rng(4))
    one = Hidden(form, form.draw(np.random.default_rng(5)), 0.2 * form.most)

    def change_on(scene_of) -> list[np.ndarray]:
        plain, hidden = run(base, scene_of()), run(base, scene_of(), [one])
        return [b - a for a, b in zip(plain, hidden, strict=True)]

    coarse, fine = (
        change_on(_scene),
        change_on(lambda: Scene(fine_t, strain, np.sin(fine_t / 60), 5.0, _usual(), (3,))),
    )
    size, far = 0.0, 0.0
    for change, dense in zip(coarse, fine, strict=True):
        other = np.interp(coarse_t, fine_t, dense)
        size, far = size + np.sum(change**2), far + np.sum((change - other)[40:-40] ** 2)
    assert far < 0.15**2 * size


def test_nothing_follows_a_reversal_before_there_was_one():
    form, t = FORMS["electrical_overshoot"]["after_reversals"], np.arange(0, 8, 0.025)
    strain = np.interp(t, [0, 1, 4, 8], [0.1, 0.1, 0.25, 0.1])  # a rest, one way out, one way back
    base, shape = draw_world("matched", np.random.default_rng(4)), {"tau": 2.0, "sign": 1.0}
    plain, hidden = (
        run(base, Scene(t, strain, 0 * t, 5.0, _usual(), (3,)), [Hidden(form, shape, size)])[1] for size in (0.0, 0.5)
    )
    assert np.array_equal(hidden[t <= 4], plain[t <= 4])
    assert np.max(np.abs(hidden - plain)[t > 4]) == pytest.approx(0.5, rel=1e-3)


@pytest.mark.parametrize(("way", "tau"), [(1, 2.0), (-1, 7.0)])
def test_a_follower_of_two_ways_is_that_of_its_formula_at_any_rate(way, tau):
    """Of a ramp c t the answer is c (t - tau (1 - exp(-t / tau)))."""
    for rate_hz in (2.0, 40.0):
        t = np.arange(0, 20, 1 / rate_hz)
        found = lowpass_two_way(t, way * 0.3 * t, 2.0, 7.0)
        assert found == pytest.approx(way * 0.3 * (t + tau * np.expm1(-t / tau)), abs=1e-12)


def test_every_effect_of_the_issue_has_two_forms_or_more():
    known = set(FORMS) - UNKNOWN
    assert len(known) == 17
    assert min(len(FORMS[name]) for name in known) >= 2
    assert len(UNKNOWN) >= 5


@pytest.mark.parametrize("world", WORLDS)
def test_conductance_rises_with_stretch_except_in_carbon_black(world):
    for seed in range(5):
        base = draw_world(world, np.random.default_rng(seed))
        e = np.linspace(0, 0.3, 200)
        force = base.force(e)
        assert np.all(np.diff(force) > 0)
        ln_g = base.contact(force, e)
        assert (ln_g[-1] > ln_g[0]) == (world != "carbon_black")

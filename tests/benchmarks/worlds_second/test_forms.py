"""Every form of every mechanism, and every kind of no catalogue."""

import numpy as np
import pytest
from worlds_second import MECHANISMS, make_case
from worlds_second.choice import choose
from worlds_second.effects import FOREIGN, KNOWN
from worlds_second.sensor import draw_sensor

from testbench.recordings.channels import FORCE, RESISTANCE

FORMS = [(kind, name) for kind, forms in {**KNOWN, **FOREIGN}.items() for name in forms]


@pytest.mark.parametrize(("kind", "name"), FORMS)
def test_every_form_makes_valid_recordings(kind, name):
    """`Recording` itself raises where a value is not finite or a resistance not positive."""
    plain = make_case("none", seed=21, minutes=3.0, rate_hz=10.0)
    case = make_case(f"{kind}:{name}", seed=21, minutes=3.0, rate_hz=10.0)
    found = case.truth["effects"][0]
    assert (found["effect"], found["form"]) == (kind, name)
    assert found["stages"]
    assert 0 < found["strength_reached"] < 1.2 * found["strength_requested"]
    base = draw_sensor(21)
    changed = choose(f"{kind}:{name}", 21, {"force", "conductance"})[0].form.channels(base.feels_force)
    for channel, key in ((FORCE, "force"), (RESISTANCE, "conductance")):
        same = np.array_equal(plain.calibration[channel], case.calibration[channel])
        assert same != (key in changed)


@pytest.mark.parametrize("mechanism", MECHANISMS)
def test_seeds_draw_all_forms_of_a_mechanism(mechanism):
    drawn = {choose(mechanism, seed, {"force", "conductance"})[0].form.name for seed in range(60)}
    assert drawn == set(KNOWN[mechanism])


def test_both_channels_see_the_same_yarns_snap():
    plain, case = (make_case(one, 30.0, seed=3, minutes=4.0) for one in ("none", "snapping_yarns"))
    ratio = np.log(case.calibration[RESISTANCE] / plain.calibration[RESISTANCE])
    jump = int(np.argmax(np.abs(np.diff(ratio))))
    force = np.log(np.abs(case.calibration[FORCE] / plain.calibration[FORCE]))
    assert abs(force[jump - 5 : jump + 1].mean()) < abs(force[jump + 1 : jump + 7].mean())

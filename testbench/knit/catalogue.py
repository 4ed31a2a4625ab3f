"""The catalogue: name of an effect -> its class. A new built-in effect is one name in `LAWS`."""

from __future__ import annotations

import ast
import importlib
import importlib.util
import sys
from collections import Counter
from dataclasses import dataclass, field
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

from gcode.support.errors import UserError
from gcode.support.strict import read_bytes
from testbench.knit.effect import Effect
from testbench.knit.effect_names import check_free, class_name
from testbench.knit.model import FORMAT, FORMAT_VERSION, KnitModel, by_stage

# Names of the effects by the file of their classes: `mullins_softening` is `MullinsSoftening`. Of a mechanism, the
# law that is called like it comes first.
LAWS = {
    "mechanics.elasticity": "elasticity elasticity_cubic elasticity_ogden elasticity_two_slopes elasticity_gent",
    "mechanics.hysteresis": "hysteresis hysteresis_on_tension hysteresis_bouc_wen",
    "conduction.contact": "contact",
    "conduction.pressure": (
        "contact_drive contact_saturation contact_saturation_hard contact_saturation_bend contact_hysteresis"
    ),
    "conduction.electrical": (
        "drift drift_exponential drift_power coating_wear coating_wear_running_in coating_wear_through "
        "coating_wear_load coating_wear_weibull coating_cracks coating_cracks_weibull electrical_hysteresis"
    ),
    "mechanics.buckling": "buckling",
    "readout.reading_age": "force_age conductance_age",
    "kinematics.mounting": "displacement_zeros force_zeros",
    "kinematics.permanent_set": (
        "permanent_set permanent_set_yield permanent_set_recovering permanent_set_worked "
        "permanent_set_viscoplastic permanent_set_creep"
    ),
    "kinematics.slip": "clamp_slip clamp_slip_repeated clamp_slip_once clamp_slip_sliding clamp_slip_events",
    "kinematics.grip": (
        "actuator_backlash actuator_backlash_windup actuator_backlash_compensated leadscrew_ripple "
        "leadscrew_ripple_wave slack slack_gradual"
    ),
    "mechanics.relaxation": (
        "stress_relaxation stress_relaxation_two_times stress_relaxation_spectrum stress_relaxation_findley "
        "stress_relaxation_power stress_relaxation_log stress_relaxation_nonlinear stress_relaxation_activated "
        "stress_relaxation_arm stress_relaxation_arm_power stress_relaxation_series stress_relaxation_prony"
    ),
    "mechanics.rate_stiffening": (
        "viscous_rate_stiffening viscous_rate_stiffening_maxwell viscous_rate_stiffening_eyring "
        "viscous_rate_stiffening_log viscous_rate_stiffening_magnitude viscous_rate_stiffening_curve"
    ),
    "mechanics.damage": (
        "mullins_softening mullins_softening_damage mullins_softening_power mullins_softening_healing "
        "mullins_softening_curve cyclic_fatigue cyclic_fatigue_log cyclic_fatigue_weibull cyclic_fatigue_swings"
    ),
    "mechanics.jamming": "jamming_stiffening jamming_stiffening_locking jamming_stiffening_power",
    "conduction.contact_relaxation": (
        "contact_relaxation contact_relaxation_spectrum contact_relaxation_prony contact_relaxation_asymmetric "
        "contact_relaxation_spots contact_relaxation_activated electrical_overshoot_force contact_creep"
    ),
    "conduction.piezoresistance": (
        "piezoresistance yarn_elongation yarn_elongation_power piezoresistance_tunnelling piezoresistance_percolation"
    ),
    "conduction.transient": (
        "electrical_overshoot electrical_overshoot_conductance electrical_overshoot_prony "
        "electrical_overshoot_motion shoulder_peak shoulder_peak_anywhere shoulder_peak_after_turn "
        "shoulder_peak_way_back rate_resistance rate_resistance_magnitude rate_resistance_two_ways"
    ),
    "conduction.breaking": (
        "electrical_overshoot_magnitude electrical_overshoot_two_ways electrical_overshoot_two_ways_prony"
    ),
    "conduction.turning": (
        "electrical_overshoot_reversal electrical_overshoot_turn electrical_overshoot_anew contact_ageing"
    ),
    "conduction.heat": (
        "self_heating self_heating_two_masses self_heating_prony self_heating_current self_heating_divider "
        "temperature_drift temperature_drift_trend temperature_drift_wander thermal_softening "
        "thermal_softening_wander"
    ),
    "readout.channel_lag": (
        "channel_lag channel_lag_resistance channel_lag_two_filters channel_lag_force "
        "channel_lag_force_two_filters channel_lag_force_delay channel_lag_delay"
    ),
    "readout.adc_saturation": "adc_saturation adc_saturation_high adc_saturation_soft adc_saturation_force",
    "readout.load_cell": "load_cell_creep load_cell_creep_two_times load_cell_creep_log load_cell_zero_drift",
    "readout.interference": "periodic_interference periodic_interference_wave periodic_interference_force",
    "shapes.base_laws": (
        "elasticity_shape hysteresis_shape contact_shape drift_shape contact_drift_shape contact_loops_shape"
    ),
}
BUILT_IN = {name: file for file, names in LAWS.items() for name in names.split()}
BASELINE = ("elasticity", "hysteresis", "contact", "drift")
ENTRY_POINT_GROUP = "knitbench.effects"


@dataclass
class Catalogue:
    """Effects by name, and what could not be loaded.

    Attributes
    ----------
    effects : dict of str to type of Effect
    broken : dict of str to str
        Plug-ins that failed to load, with the reason. They are listed, never a crash.
    """

    effects: dict[str, type[Effect]] = field(default_factory=dict)
    broken: dict[str, str] = field(default_factory=dict)

    def __getitem__(self, name: str) -> type[Effect]:
        try:
            return self.effects[name]
        except KeyError:
            raise UserError(
                f"no effect called {name}; `testbench effects` lists them all; your own are named by `effects`"
            ) from None

    def add(self, effect: type[Effect], source: str) -> None:
        """Add an effect of the user's own.

        Raises
        ------
        UserError
            If its name, or that of its mechanism, is taken: models elsewhere mean another effect by it.
        """
        check_free(effect.name, source, self.effects)
        check_free(effect.mechanism, source, ())
        self.effects[effect.name] = effect

    def without(self, mechanism: str) -> Catalogue:
        """The catalogue without any law of a mechanism."""
        rest = {name: law for name, law in self.effects.items() if law.mechanism != mechanism}
        return Catalogue(rest, self.broken)

    def mechanisms(self) -> dict[str, list[type[Effect]]]:
        """Effects grouped by what happens physically: the name of the mechanism -> its laws, the namesake first."""
        groups: dict[str, list[type[Effect]]] = {}
        for effect in self.effects.values():
            groups.setdefault(effect.mechanism, []).append(effect)
        return groups


def load_catalogue(user_file: str | Path | None = None) -> Catalogue:
    """Built-in effects, installed plug-ins and, where given, a user's own file.

    Raises
    ------
    UserError
        If `user_file` cannot be loaded: the user asked for it by name, so it must not be skipped silently. Nor may
        it replace an effect that models elsewhere mean by that name.
    """
    catalogue = Catalogue()
    for name, file in BUILT_IN.items():
        catalogue.effects[name] = getattr(importlib.import_module(f"testbench.knit.{file}"), class_name(name))
    for point in entry_points(group=ENTRY_POINT_GROUP):
        try:
            catalogue.add(point.load(), point.name)
        except KeyboardInterrupt:
            raise
        except BaseException as error:  # a broken plug-in is somebody else's bug, sys.exit in it, too: list it
            catalogue.broken[point.name] = f"{type(error).__name__}: {error}"
    if user_file is not None:
        for effect in _effects_in_file(Path(user_file)).values():
            catalogue.add(effect, str(user_file))
    return catalogue


def _effects_in_file(path: Path) -> dict[str, type[Effect]]:
    if not path.is_file():
        raise UserError(f"{path}: no such effects file; `testbench effects --new NAME` writes a template")
    spec = importlib.util.spec_from_file_location(f"knitbench_user_{path.stem}", path)
    if spec is None or spec.loader is None:
        raise UserError(f"{path}: an effects file is Python; its name must end in .py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # where a dataclass looks up what its annotations mean
    try:
        spec.loader.exec_module(module)
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # sys.exit would end the command as if all were well
        raise UserError(
            f"{path}: cannot be loaded: {type(error).__name__}: {str(error).partition(chr(10))[0]}"
        ) from error
    finally:
        sys.modules.pop(spec.name, None)
    found: dict[str, type[Effect]] = {}
    for value in vars(module).values():
        if not (isinstance(value, type) and issubclass(value, Effect) and value.__module__ == spec.name):
            continue
        if value.name and found.setdefault(value.name, value) is not value:
            raise UserError(f"{path}: two effects are called {value.name}; give each a name of its own")
    _check_classes(path)
    if not found:
        raise UserError(f"{path}: no Effect class with a name; `testbench effects --new NAME` writes a template")
    return found


def _check_classes(path: Path) -> None:
    """Refuse two classes of one name: Python keeps the second alone."""
    tree = ast.parse(read_bytes(path, "file of effects"))
    counted = Counter(node.name for node in tree.body if isinstance(node, ast.ClassDef))
    for name, count in counted.items():
        if count > 1:
            raise UserError(f"{path}: two classes are called {name}; give each a name of its own")


def model_from_dict(data: Any, catalogue: Catalogue, source: str = "model") -> KnitModel:
    """Rebuild a model from `KnitModel.to_dict`.

    Raises
    ------
    UserError
        For another format or version, unknown effects, unknown parameters or values out of bounds.
    """
    if not isinstance(data, dict) or data.get("format") != FORMAT:
        raise UserError(f"{source}: not a knitbench model (its format must be {FORMAT!r})")
    if data.get("version") != FORMAT_VERSION:
        raise UserError(f"{source}: model version {data.get('version')!r}; this knitbench reads {FORMAT_VERSION}")
    model, saved = KnitModel(), []
    try:
        for entry in data["effects"]:
            effect = catalogue[entry["effect"]](**entry["parameters"])
            before, model = model, model.plus(effect, entry["name"])
            saved += [name for name in model if name not in before]
    except UserError as error:
        raise UserError(f"{source}: {error}") from None
    except (KeyError, TypeError) as error:
        raise UserError(f"{source}: malformed list of effects ({error})") from None
    # Within a stage they act in the order in which they were saved, which need not be that of `plus`.
    return by_stage({name: model[name] for name in saved if name in model})


def baseline() -> KnitModel:
    """A plain sensor: elasticity, hysteresis, contact and drift, with default parameters.

    A diagnosis starts from these and a few more, drawn to its data (`testbench fit`).

    Returns
    -------
    KnitModel

    Examples
    --------
    >>> import testbench as tb
    >>> tb.baseline()
    <KnitModel elasticity + hysteresis + contact + drift>
    """
    effects = load_catalogue().effects
    return KnitModel.of(*(effects[name]() for name in BASELINE))

"""The catalogue: name of an effect -> its class. A new built-in effect is one line in `BUILT_IN`."""

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
from testbench.knit.effect_names import check_free
from testbench.knit.model import FORMAT, FORMAT_VERSION, KnitModel, by_stage

BUILT_IN = {
    # the baseline
    "elasticity": "testbench.knit.mechanics.elasticity:Elasticity",
    "hysteresis": "testbench.knit.mechanics.hysteresis:Hysteresis",
    "contact": "testbench.knit.conduction.contact:Contact",
    "contact_drive": "testbench.knit.conduction.pressure:ContactDrive",
    "drift": "testbench.knit.conduction.electrical:Drift",
    # other laws of the baseline's mechanisms
    "elasticity_cubic": "testbench.knit.mechanics.elasticity:ElasticityCubic",
    "elasticity_ogden": "testbench.knit.mechanics.elasticity:ElasticityOgden",
    "elasticity_two_slopes": "testbench.knit.mechanics.elasticity:ElasticityTwoSlopes",
    "elasticity_gent": "testbench.knit.mechanics.elasticity:ElasticityGent",
    "hysteresis_on_tension": "testbench.knit.mechanics.hysteresis:HysteresisOnTension",
    "hysteresis_bouc_wen": "testbench.knit.mechanics.hysteresis:HysteresisBoucWen",
    "drift_exponential": "testbench.knit.conduction.electrical:DriftExponential",
    "drift_power": "testbench.knit.conduction.electrical:DriftPower",
    "coating_wear": "testbench.knit.conduction.electrical:CoatingWear",
    "coating_wear_running_in": "testbench.knit.conduction.electrical:CoatingWearRunningIn",
    "coating_wear_through": "testbench.knit.conduction.electrical:CoatingWearThrough",
    "coating_wear_load": "testbench.knit.conduction.electrical:CoatingWearLoad",
    "coating_wear_weibull": "testbench.knit.conduction.electrical:CoatingWearWeibull",
    "coating_cracks": "testbench.knit.conduction.electrical:CoatingCracks",
    "coating_cracks_weibull": "testbench.knit.conduction.electrical:CoatingCracksWeibull",
    "electrical_hysteresis": "testbench.knit.conduction.electrical:ElectricalHysteresis",
    "buckling": "testbench.knit.mechanics.buckling:Buckling",
    "force_age": "testbench.knit.readout.reading_age:ForceAge",
    "conductance_age": "testbench.knit.readout.reading_age:ConductanceAge",
    "displacement_zeros": "testbench.knit.kinematics.mounting:DisplacementZeros",
    "force_zeros": "testbench.knit.kinematics.mounting:ForceZeros",
    # kinematics
    "permanent_set": "testbench.knit.kinematics.permanent_set:PermanentSet",
    "permanent_set_yield": "testbench.knit.kinematics.permanent_set:PermanentSetYield",
    "permanent_set_recovering": "testbench.knit.kinematics.permanent_set:PermanentSetRecovering",
    "permanent_set_worked": "testbench.knit.kinematics.permanent_set:PermanentSetWorked",
    "permanent_set_viscoplastic": "testbench.knit.kinematics.permanent_set:PermanentSetViscoplastic",
    "permanent_set_creep": "testbench.knit.kinematics.permanent_set:PermanentSetCreep",
    "clamp_slip": "testbench.knit.kinematics.slip:ClampSlip",
    "clamp_slip_repeated": "testbench.knit.kinematics.slip:ClampSlipRepeated",
    "clamp_slip_once": "testbench.knit.kinematics.slip:ClampSlipOnce",
    "clamp_slip_sliding": "testbench.knit.kinematics.slip:ClampSlipSliding",
    "clamp_slip_events": "testbench.knit.kinematics.slip:ClampSlipEvents",
    "actuator_backlash": "testbench.knit.kinematics.grip:ActuatorBacklash",
    "actuator_backlash_windup": "testbench.knit.kinematics.grip:ActuatorBacklashWindup",
    "actuator_backlash_compensated": "testbench.knit.kinematics.grip:ActuatorBacklashCompensated",
    "leadscrew_ripple": "testbench.knit.kinematics.grip:LeadscrewRipple",
    "leadscrew_ripple_wave": "testbench.knit.kinematics.grip:LeadscrewRippleWave",
    "slack": "testbench.knit.kinematics.grip:Slack",
    "slack_gradual": "testbench.knit.kinematics.grip:SlackGradual",
    # mechanics
    "stress_relaxation": "testbench.knit.mechanics.relaxation:StressRelaxation",
    "stress_relaxation_two_times": "testbench.knit.mechanics.relaxation:StressRelaxationTwoTimes",
    "stress_relaxation_spectrum": "testbench.knit.mechanics.relaxation:StressRelaxationSpectrum",
    "stress_relaxation_findley": "testbench.knit.mechanics.relaxation:StressRelaxationFindley",
    "stress_relaxation_power": "testbench.knit.mechanics.relaxation:StressRelaxationPower",
    "stress_relaxation_log": "testbench.knit.mechanics.relaxation:StressRelaxationLog",
    "stress_relaxation_nonlinear": "testbench.knit.mechanics.relaxation:StressRelaxationNonlinear",
    "stress_relaxation_arm": "testbench.knit.mechanics.relaxation:StressRelaxationArm",
    "stress_relaxation_arm_power": "testbench.knit.mechanics.relaxation:StressRelaxationArmPower",
    "stress_relaxation_series": "testbench.knit.mechanics.relaxation:StressRelaxationSeries",
    "stress_relaxation_prony": "testbench.knit.mechanics.relaxation:StressRelaxationProny",
    "viscous_rate_stiffening": "testbench.knit.mechanics.rate_stiffening:ViscousRateStiffening",
    "viscous_rate_stiffening_maxwell": "testbench.knit.mechanics.rate_stiffening:ViscousRateStiffeningMaxwell",
    "viscous_rate_stiffening_eyring": "testbench.knit.mechanics.rate_stiffening:ViscousRateStiffeningEyring",
    "viscous_rate_stiffening_log": "testbench.knit.mechanics.rate_stiffening:ViscousRateStiffeningLog",
    "viscous_rate_stiffening_power": "testbench.knit.mechanics.rate_stiffening:ViscousRateStiffeningPower",
    "viscous_rate_stiffening_magnitude": "testbench.knit.mechanics.rate_stiffening:ViscousRateStiffeningMagnitude",
    "viscous_rate_stiffening_relative": "testbench.knit.mechanics.rate_stiffening:ViscousRateStiffeningRelative",
    "viscous_rate_stiffening_curve": "testbench.knit.mechanics.rate_stiffening:ViscousRateStiffeningCurve",
    "mullins_softening": "testbench.knit.mechanics.damage:MullinsSoftening",
    "mullins_softening_damage": "testbench.knit.mechanics.damage:MullinsSofteningDamage",
    "mullins_softening_power": "testbench.knit.mechanics.damage:MullinsSofteningPower",
    "mullins_softening_healing": "testbench.knit.mechanics.damage:MullinsSofteningHealing",
    "mullins_softening_curve": "testbench.knit.mechanics.damage:MullinsSofteningCurve",
    "cyclic_fatigue": "testbench.knit.mechanics.damage:CyclicFatigue",
    "cyclic_fatigue_log": "testbench.knit.mechanics.damage:CyclicFatigueLog",
    "cyclic_fatigue_weibull": "testbench.knit.mechanics.damage:CyclicFatigueWeibull",
    "cyclic_fatigue_swings": "testbench.knit.mechanics.damage:CyclicFatigueSwings",
    "jamming_stiffening": "testbench.knit.mechanics.jamming:JammingStiffening",
    "jamming_stiffening_locking": "testbench.knit.mechanics.jamming:JammingStiffeningLocking",
    "jamming_stiffening_power": "testbench.knit.mechanics.jamming:JammingStiffeningPower",
    # contact and electrical
    "contact_relaxation": "testbench.knit.conduction.contact_relaxation:ContactRelaxation",
    "contact_relaxation_spectrum": "testbench.knit.conduction.contact_relaxation:ContactRelaxationSpectrum",
    "contact_relaxation_prony": "testbench.knit.conduction.contact_relaxation:ContactRelaxationProny",
    "contact_relaxation_asymmetric": "testbench.knit.conduction.contact_relaxation:ContactRelaxationAsymmetric",
    "contact_relaxation_spots": "testbench.knit.conduction.contact_relaxation:ContactRelaxationSpots",
    "contact_relaxation_activated": "testbench.knit.conduction.contact_relaxation:ContactRelaxationActivated",
    "electrical_overshoot_force": "testbench.knit.conduction.contact_relaxation:ElectricalOvershootForce",
    "contact_creep": "testbench.knit.conduction.contact_relaxation:ContactCreep",
    "contact_ageing": "testbench.knit.conduction.ageing:ContactAgeing",
    "contact_saturation": "testbench.knit.conduction.pressure:ContactSaturation",
    "contact_saturation_hard": "testbench.knit.conduction.pressure:ContactSaturationHard",
    "contact_saturation_bend": "testbench.knit.conduction.pressure:ContactSaturationBend",
    "contact_hysteresis": "testbench.knit.conduction.pressure:ContactHysteresis",
    "piezoresistance": "testbench.knit.conduction.piezoresistance:Piezoresistance",
    "yarn_elongation": "testbench.knit.conduction.piezoresistance:YarnElongation",
    "yarn_elongation_power": "testbench.knit.conduction.piezoresistance:YarnElongationPower",
    "piezoresistance_tunnelling": "testbench.knit.conduction.piezoresistance:PiezoresistanceTunnelling",
    "piezoresistance_percolation": "testbench.knit.conduction.piezoresistance:PiezoresistancePercolation",
    "electrical_overshoot": "testbench.knit.conduction.transient:ElectricalOvershoot",
    "electrical_overshoot_conductance": "testbench.knit.conduction.transient:ElectricalOvershootConductance",
    "electrical_overshoot_prony": "testbench.knit.conduction.transient:ElectricalOvershootProny",
    "electrical_overshoot_magnitude": "testbench.knit.conduction.breaking:ElectricalOvershootMagnitude",
    "electrical_overshoot_two_ways": "testbench.knit.conduction.breaking:ElectricalOvershootTwoWays",
    "electrical_overshoot_two_ways_prony": "testbench.knit.conduction.breaking:ElectricalOvershootTwoWaysProny",
    "electrical_overshoot_motion": "testbench.knit.conduction.transient:ElectricalOvershootMotion",
    "electrical_overshoot_reversal": "testbench.knit.conduction.turning:ElectricalOvershootReversal",
    "electrical_overshoot_turn": "testbench.knit.conduction.turning:ElectricalOvershootTurn",
    "electrical_overshoot_anew": "testbench.knit.conduction.turning:ElectricalOvershootAnew",
    "shoulder_peak": "testbench.knit.conduction.transient:ShoulderPeak",
    "shoulder_peak_anywhere": "testbench.knit.conduction.transient:ShoulderPeakAnywhere",
    "shoulder_peak_after_turn": "testbench.knit.conduction.transient:ShoulderPeakAfterTurn",
    "shoulder_peak_way_back": "testbench.knit.conduction.transient:ShoulderPeakWayBack",
    "rate_resistance": "testbench.knit.conduction.transient:RateResistance",
    "rate_resistance_magnitude": "testbench.knit.conduction.transient:RateResistanceMagnitude",
    "rate_resistance_two_ways": "testbench.knit.conduction.transient:RateResistanceTwoWays",
    "self_heating": "testbench.knit.conduction.heat:SelfHeating",
    "self_heating_two_masses": "testbench.knit.conduction.heat:SelfHeatingTwoMasses",
    "self_heating_prony": "testbench.knit.conduction.heat:SelfHeatingProny",
    "self_heating_current": "testbench.knit.conduction.heat:SelfHeatingCurrent",
    "self_heating_divider": "testbench.knit.conduction.heat:SelfHeatingDivider",
    "temperature_drift": "testbench.knit.conduction.heat:TemperatureDrift",
    "temperature_drift_trend": "testbench.knit.conduction.heat:TemperatureDriftTrend",
    "temperature_drift_wander": "testbench.knit.conduction.heat:TemperatureDriftWander",
    "thermal_softening": "testbench.knit.conduction.heat:ThermalSoftening",
    "thermal_softening_wander": "testbench.knit.conduction.heat:ThermalSofteningWander",
    # read-out
    "channel_lag": "testbench.knit.readout.channel_lag:ChannelLag",
    "channel_lag_resistance": "testbench.knit.readout.channel_lag:ChannelLagResistance",
    "channel_lag_two_filters": "testbench.knit.readout.channel_lag:ChannelLagTwoFilters",
    "channel_lag_force": "testbench.knit.readout.channel_lag:ChannelLagForce",
    "channel_lag_force_two_filters": "testbench.knit.readout.channel_lag:ChannelLagForceTwoFilters",
    "channel_lag_force_delay": "testbench.knit.readout.channel_lag:ChannelLagForceDelay",
    "channel_lag_delay": "testbench.knit.readout.channel_lag:ChannelLagDelay",
    "adc_saturation": "testbench.knit.readout.adc_saturation:AdcSaturation",
    "adc_saturation_high": "testbench.knit.readout.adc_saturation:AdcSaturationHigh",
    "adc_saturation_soft": "testbench.knit.readout.adc_saturation:AdcSaturationSoft",
    "adc_saturation_force": "testbench.knit.readout.adc_saturation:AdcSaturationForce",
    "load_cell_creep": "testbench.knit.readout.load_cell:LoadCellCreep",
    "load_cell_creep_two_times": "testbench.knit.readout.load_cell:LoadCellCreepTwoTimes",
    "load_cell_creep_log": "testbench.knit.readout.load_cell:LoadCellCreepLog",
    "load_cell_zero_drift": "testbench.knit.readout.load_cell:LoadCellZeroDrift",
    "periodic_interference": "testbench.knit.readout.interference:PeriodicInterference",
    "periodic_interference_wave": "testbench.knit.readout.interference:PeriodicInterferenceWave",
    "periodic_interference_force": "testbench.knit.readout.interference:PeriodicInterferenceForce",
    # shape freedom of the base laws
    "elasticity_shape": "testbench.knit.shapes.base_laws:ElasticityShape",
    "hysteresis_shape": "testbench.knit.shapes.base_laws:HysteresisShape",
    "contact_shape": "testbench.knit.shapes.base_laws:ContactShape",
    "drift_shape": "testbench.knit.shapes.base_laws:DriftShape",
    "contact_drift_shape": "testbench.knit.shapes.base_laws:ContactDriftShape",
    "contact_loops_shape": "testbench.knit.shapes.base_laws:ContactLoopsShape",
}
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
    for name, target in BUILT_IN.items():
        module, _, attribute = target.partition(":")
        catalogue.effects[name] = getattr(importlib.import_module(module), attribute)
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

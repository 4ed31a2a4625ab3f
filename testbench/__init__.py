"""Simulate, record, fit, compare and diagnose knitted strain sensors.

Examples
--------
>>> import gcode
>>> import testbench as tb
>>> a = tb.example(tb.effects.StressRelaxation(fraction=0.3))
>>> fit = tb.fit(a, progress=False)
>>> where = tb.compare(a, fit.model)
>>> model = fit.model + tb.effects.StressRelaxation(fraction=0.3)
>>> sim = tb.simulate(model, gcode.generate("paper-1", seed=3, duration_s=60))
>>> sim.gauge_length_mm
25.0
"""

from typing import TYPE_CHECKING

from gcode.support.lazy import lazy_exports

if TYPE_CHECKING:  # for type checkers and editors; in a running program `_HOMES` says where a name is imported from
    from gcode.support.errors import UserError as UserError
    from testbench import effects as effects
    from testbench.api.arguments import read as read
    from testbench.api.bench.aligning import AlignmentResult as AlignmentResult
    from testbench.api.bench.aligning import align as align
    from testbench.api.bench.capturing import RecordResult as RecordResult
    from testbench.api.bench.capturing import record as record
    from testbench.api.bench.capturing import resume_recording as resume_recording
    from testbench.api.bench.running import RunResult as RunResult
    from testbench.api.bench.running import run as run
    from testbench.api.bench.serving import serve_rig as serve_rig
    from testbench.api.bench.simulating import example as example
    from testbench.api.bench.simulating import simulate as simulate
    from testbench.api.experiments.designing import NextExperiment as NextExperiment
    from testbench.api.experiments.designing import next_experiment as next_experiment
    from testbench.api.experiments.investigating import investigate as investigate
    from testbench.api.experiments.investigation import InvestigationResult as InvestigationResult
    from testbench.api.files.datasets import DatasetResult as DatasetResult
    from testbench.api.files.datasets import dataset as dataset
    from testbench.api.files.hiding import HiddenCase as HiddenCase
    from testbench.api.files.hiding import hide as hide
    from testbench.api.files.importing import ImportResult as ImportResult
    from testbench.api.files.importing import import_file as import_file
    from testbench.api.files.reporting import ReportResult as ReportResult
    from testbench.api.files.reporting import make_report as make_report
    from testbench.api.files.verifying import VerifiedCampaign as VerifiedCampaign
    from testbench.api.files.verifying import VerifyResult as VerifyResult
    from testbench.api.files.verifying import verify as verify
    from testbench.api.missing.contributing import ContributionResult as ContributionResult
    from testbench.api.missing.contributing import contribution as contribution
    from testbench.api.missing.diagnosing import DiagnosisResult as DiagnosisResult
    from testbench.api.missing.diagnosing import diagnose as diagnose
    from testbench.api.missing.proposing import ProposalResult as ProposalResult
    from testbench.api.missing.proposing import propose as propose
    from testbench.api.models.adding import add as add
    from testbench.api.models.adding import undo as undo
    from testbench.api.models.comparing import ComparisonResult as ComparisonResult
    from testbench.api.models.comparing import compare as compare
    from testbench.api.models.fitting import FitResult as FitResult
    from testbench.api.models.fitting import fit as fit
    from testbench.api.models.ladder import Ladder as Ladder
    from testbench.api.models.ladder import ladder as ladder
    from testbench.design.protocols import Bounds as Bounds
    from testbench.importing.sheet import Hints as Hints
    from testbench.importing.wish import Wish as Wish
    from testbench.knit.catalogue import baseline as baseline
    from testbench.knit.effect import Effect as Effect
    from testbench.knit.effect import Stage as Stage
    from testbench.knit.effect import parameter as parameter
    from testbench.knit.model import KnitModel as KnitModel
    from testbench.knit.presets import preset as preset
    from testbench.recordings.instruments import Instruments as Instruments
    from testbench.recordings.recording import Recording as Recording

_HOMES = {
    "gcode.support.errors": ["UserError"],
    "testbench": ["effects"],
    "testbench.api.arguments": ["read"],
    "testbench.api.bench.aligning": ["AlignmentResult", "align"],
    "testbench.api.bench.capturing": ["RecordResult", "record", "resume_recording"],
    "testbench.api.bench.running": ["RunResult", "run"],
    "testbench.api.bench.serving": ["serve_rig"],
    "testbench.api.bench.simulating": ["example", "simulate"],
    "testbench.api.experiments.designing": ["NextExperiment", "next_experiment"],
    "testbench.api.experiments.investigating": ["investigate"],
    "testbench.api.experiments.investigation": ["InvestigationResult"],
    "testbench.api.files.datasets": ["DatasetResult", "dataset"],
    "testbench.api.files.hiding": ["HiddenCase", "hide"],
    "testbench.api.files.importing": ["ImportResult", "import_file"],
    "testbench.api.files.reporting": ["ReportResult", "make_report"],
    "testbench.api.files.verifying": ["VerifiedCampaign", "VerifyResult", "verify"],
    "testbench.api.missing.contributing": ["ContributionResult", "contribution"],
    "testbench.api.missing.diagnosing": ["DiagnosisResult", "diagnose"],
    "testbench.api.missing.proposing": ["ProposalResult", "propose"],
    "testbench.api.models.adding": ["add", "undo"],
    "testbench.api.models.comparing": ["ComparisonResult", "compare"],
    "testbench.api.models.fitting": ["FitResult", "fit"],
    "testbench.api.models.ladder": ["Ladder", "ladder"],
    "testbench.design.protocols": ["Bounds"],
    "testbench.importing.sheet": ["Hints"],
    "testbench.importing.wish": ["Wish"],
    "testbench.knit.catalogue": ["baseline"],
    "testbench.knit.effect": ["Effect", "Stage", "parameter"],
    "testbench.knit.model": ["KnitModel"],
    "testbench.knit.presets": ["preset"],
    "testbench.recordings.instruments": ["Instruments"],
    "testbench.recordings.recording": ["Recording"],
}
__all__, __getattr__, __dir__ = lazy_exports(__name__, _HOMES)

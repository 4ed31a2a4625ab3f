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
    from testbench.api.adding import add as add
    from testbench.api.adding import undo as undo
    from testbench.api.aligning import AlignmentResult as AlignmentResult
    from testbench.api.aligning import align as align
    from testbench.api.arguments import read as read
    from testbench.api.capturing import RecordResult as RecordResult
    from testbench.api.capturing import record as record
    from testbench.api.capturing import resume_recording as resume_recording
    from testbench.api.comparing import ComparisonResult as ComparisonResult
    from testbench.api.comparing import compare as compare
    from testbench.api.contributing import ContributionResult as ContributionResult
    from testbench.api.contributing import contribution as contribution
    from testbench.api.datasets import DatasetResult as DatasetResult
    from testbench.api.datasets import dataset as dataset
    from testbench.api.designing import NextExperiment as NextExperiment
    from testbench.api.designing import next_experiment as next_experiment
    from testbench.api.diagnosing import DiagnosisResult as DiagnosisResult
    from testbench.api.diagnosing import diagnose as diagnose
    from testbench.api.fitting import FitResult as FitResult
    from testbench.api.fitting import fit as fit
    from testbench.api.hiding import HiddenCase as HiddenCase
    from testbench.api.hiding import hide as hide
    from testbench.api.importing import ImportResult as ImportResult
    from testbench.api.importing import import_file as import_file
    from testbench.api.investigating import investigate as investigate
    from testbench.api.investigation import InvestigationResult as InvestigationResult
    from testbench.api.ladder import Ladder as Ladder
    from testbench.api.ladder import ladder as ladder
    from testbench.api.proposing import ProposalResult as ProposalResult
    from testbench.api.proposing import propose as propose
    from testbench.api.reporting import ReportResult as ReportResult
    from testbench.api.reporting import make_report as make_report
    from testbench.api.running import RunResult as RunResult
    from testbench.api.running import run as run
    from testbench.api.serving import serve_rig as serve_rig
    from testbench.api.simulating import example as example
    from testbench.api.simulating import simulate as simulate
    from testbench.api.verifying import VerifyResult as VerifyResult
    from testbench.api.verifying import verify as verify
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
    "testbench.api.adding": ["add", "undo"],
    "testbench.api.aligning": ["AlignmentResult", "align"],
    "testbench.api.arguments": ["read"],
    "testbench.api.capturing": ["RecordResult", "record", "resume_recording"],
    "testbench.api.comparing": ["ComparisonResult", "compare"],
    "testbench.api.contributing": ["ContributionResult", "contribution"],
    "testbench.api.datasets": ["DatasetResult", "dataset"],
    "testbench.api.designing": ["NextExperiment", "next_experiment"],
    "testbench.api.diagnosing": ["DiagnosisResult", "diagnose"],
    "testbench.api.fitting": ["FitResult", "fit"],
    "testbench.api.hiding": ["HiddenCase", "hide"],
    "testbench.api.importing": ["ImportResult", "import_file"],
    "testbench.api.investigating": ["investigate"],
    "testbench.api.investigation": ["InvestigationResult"],
    "testbench.api.ladder": ["Ladder", "ladder"],
    "testbench.api.proposing": ["ProposalResult", "propose"],
    "testbench.api.reporting": ["ReportResult", "make_report"],
    "testbench.api.running": ["RunResult", "run"],
    "testbench.api.serving": ["serve_rig"],
    "testbench.api.simulating": ["example", "simulate"],
    "testbench.api.verifying": ["VerifyResult", "verify"],
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

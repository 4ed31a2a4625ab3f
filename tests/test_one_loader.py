"""Every place that reads a file or parses text: those below, with the reason, and no other.

Files come from strangers; `gcode.support.strict` bounds their size, their depth and their numbers. Whoever adds a raw
reader either goes through it, or adds a line here that says why not.
"""

from __future__ import annotations

import ast
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).parents[1]
PACKAGES = ("gcode", "testbench", "compensation")
# Calls that parse, unpickle or evaluate, by module; `*` is every name of it.
PARSERS = {
    "json": {"load", "loads", "JSONDecoder"},
    "tomllib": {"load", "loads"},
    "csv": {"reader", "DictReader"},
    "pd": {"read_*"},
    "pandas": {"read_*"},
    "np": {"load", "loadtxt", "genfromtxt", "fromfile", "memmap", "fromregex"},
    "numpy": {"load", "loadtxt", "genfromtxt", "fromfile", "memmap", "fromregex"},
    "pickle": {"*"},
    "marshal": {"*"},
    "shelve": {"*"},
    "dill": {"*"},
    "cloudpickle": {"*"},
    "yaml": {"*"},
    "joblib": {"load"},
    "openpyxl": {"load_workbook"},
    "nptdms": {"*"},
    "TdmsFile": {"*"},
    "ast": {"literal_eval"},
    "runpy": {"*"},
    "pyarrow": {"*"},
    "pq": {"*"},
    "io": {"open"},
    "os": {"open", "fdopen"},
    "model_validate_json": {"*"},
}
BARE = {"open", "eval", "exec", "compile", "__import__", "literal_eval", "safe_load", "load_workbook", "ExcelReader"}
METHODS = {"open", "read_text", "read_bytes", "model_validate_json", "exec_module"}

OURS = "a file of this package"
AFTER_CHECK = "after check_plain: a plain file of a bounded size"
ROUND_TRIP = "data of ours through JSON, no file"
WRITES = "written, not read"
LOCK = "locked, not read"
NULL = "the null device, in the place of a closed stream"

ITSELF = "the loader itself"
ALLOWED: dict[tuple[str, str], tuple[int, str]] = {
    ("compensation/search/search.py", ".open"): (1, WRITES),
    ("compensation/search/search.py", "json.loads"): (1, ROUND_TRIP),
    ("gcode/support/console.py", "os.open"): (1, WRITES),
    ("gcode/support/disk.py", "os.open"): (3, WRITES),
    ("gcode/support/streams.py", "open"): (1, NULL),
    ("gcode/support/streams.py", "os.open"): (1, NULL),
    ("gcode/support/strict.py", "json.loads"): (1, ITSELF),
    ("gcode/support/strict.py", "os.fdopen"): (1, ITSELF),
    ("gcode/support/strict.py", "os.open"): (1, ITSELF),
    ("gcode/support/strict.py", "tomllib.loads"): (1, ITSELF),
    ("gcode/trajectories/trajectory.py", ".open"): (2, AFTER_CHECK),
    ("gcode/trajectories/trajectory.py", "np.loadtxt"): (1, AFTER_CHECK),
    ("testbench/api/missing/diagnosing.py", "json.loads"): (1, ROUND_TRIP),
    ("testbench/campaigns/campaign.py", "json.loads"): (1, ROUND_TRIP),
    ("testbench/campaigns/datasets/dataset.py", "os.open"): (1, LOCK),
    ("testbench/importing/files/excel_file.py", ".open"): (1, AFTER_CHECK),
    ("testbench/importing/files/excel_file.py", "ExcelReader"): (1, AFTER_CHECK),
    ("testbench/importing/files/json_file.py", "json.loads"): (
        1,
        "what others wrote, NaN too: of a bounded size, and whatever is wrong with it, it is no JSON",
    ),
    ("testbench/importing/files/tdms_file.py", "TdmsFile.read"): (1, AFTER_CHECK),
    ("testbench/importing/files/text_file.py", ".open"): (2, AFTER_CHECK),
    ("testbench/importing/files/unpacking.py", ".open"): (
        1,
        "a part of a workbook, counted as it unpacks",
    ),
    ("testbench/importing/files/text_file.py", "csv.reader"): (2, AFTER_CHECK),
    ("testbench/importing/files/text_file.py", "pd.read_csv"): (1, AFTER_CHECK),
    ("testbench/knit/catalogue.py", ".exec_module"): (1, "effects that a person named: testbench.trust"),
    ("testbench/knit/rules.py", "json.loads"): (1, ROUND_TRIP),
    ("testbench/knit/presets/__init__.py", ".read_text"): (1, OURS),
    ("testbench/knit/presets/__init__.py", "json.loads"): (1, OURS),
    ("testbench/proposing/laws/law.py", "compile"): (1, "a formula that the search itself has put together"),
    ("testbench/proposing/laws/law.py", "eval"): (1, "a formula that the search itself has put together"),
    ("testbench/proposing/writing.py", "compile"): (1, "the effect that was just written, tried"),
    ("testbench/proposing/writing.py", "exec"): (1, "the effect that was just written, tried"),
    ("testbench/recordings/csv_columns.py", ".open"): (2, AFTER_CHECK),
    ("testbench/recordings/csv_columns.py", "csv.reader"): (2, AFTER_CHECK),
    ("testbench/recordings/csv_columns.py", "pd.read_csv"): (1, AFTER_CHECK),
    ("testbench/recordings/manifest.py", ".open"): (1, "the header of a file that was just hashed"),
    ("testbench/recordings/versions.py", ".read_bytes"): (1, OURS),
    ("testbench/report/writing/page.py", ".read_text"): (4, OURS),
    ("testbench/rig/acquisition/appender.py", "os.open"): (1, LOCK),
    ("testbench/rig/acquisition/resume.py", ".open"): (1, AFTER_CHECK),
    ("testbench/rig/connection/serial_port.py", ".open"): (1, "a port"),
    ("testbench/rig/acquisition/stopping.py", "os.open"): (1, "the terminal, of which only the foreground is asked"),
    ("testbench/rig/acquisition/appender.py", ".open"): (4, WRITES),
    ("testbench/rig/acquisition/sink.py", ".open"): (1, WRITES),
    ("testbench/studio/pages/campaign/compensate.py", "os.fdopen"): (1, "what strict.open_plain opened"),
    ("testbench/studio/tail.py", "os.fdopen"): (1, "what strict.open_plain opened"),
    ("testbench/studio/jobs/outliving.py", "os.open"): (1, LOCK),
    ("testbench/studio/pages/campaign_card.py", ".open"): (1, "a dialog"),
    ("testbench/studio/parts/picture.py", ".read_text"): (1, OURS),
    ("testbench/studio/shell.py", ".read_text"): (1, OURS),
}


def calls_of(path: Path) -> Counter[str]:
    """How often a file makes each call that could read or parse."""
    found: Counter[str] = Counter()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Call) and (name := _name(node.func)):
            found[name] += 1
    return found


def _name(called: ast.expr) -> str:
    if isinstance(called, ast.Name):
        return called.id if called.id in BARE else ""
    if not isinstance(called, ast.Attribute):
        return ""
    owner = called.value.id if isinstance(called.value, ast.Name) else getattr(called.value, "attr", "")
    known = PARSERS.get(owner, set())
    if called.attr in known or "*" in known or ("read_*" in known and called.attr.startswith("read_")):
        return f"{owner}.{called.attr}"
    if owner == "strict":
        return ""
    return f".{called.attr}" if called.attr in METHODS else ""


def all_calls() -> dict[tuple[str, str], int]:
    found = {}
    for package in PACKAGES:
        for path in sorted((ROOT / package).rglob("*.py")):
            for name, count in calls_of(path).items():
                found[path.relative_to(ROOT).as_posix(), name] = count
    return found


def test_every_reader_is_known():
    found, known = all_calls(), {key: count for key, (count, _) in ALLOWED.items()}
    new = {key: count for key, count in found.items() if count > known.get(key, 0)}
    gone = {key: count for key, count in known.items() if found.get(key, 0) < count}
    assert not new, "reads a file past the one loader (gcode.support.strict); see the docstring"
    assert not gone, "take these out of the list"


def test_the_test_sees_what_it_looks_for(tmp_path):
    code = "import json\njson.load(f)\nx.read_text()\nopen('a')\npd.read_csv(p)\npickle.loads(b)\nyaml.full_load(s)\n"
    (tmp_path / "a.py").write_text(code)
    assert set(calls_of(tmp_path / "a.py")) == {
        "json.load",
        ".read_text",
        "open",
        "pd.read_csv",
        "pickle.loads",
        "yaml.full_load",
    }

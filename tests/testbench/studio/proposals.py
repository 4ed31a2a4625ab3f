"""The files of a proposed law, as ``testbench propose`` leaves them; the law is that of the template."""

from __future__ import annotations

import json
from pathlib import Path

from testbench.knit.catalogue import baseline, load_catalogue
from testbench.knit.template import write_template
from testbench.studio import proposed_law

FOUND = {
    "verdict": "proposed",
    "laws": [
        {
            "effect": "sleeve_law",
            "words": "the force rises with the memory of the strain",
            "latex": r"F \mathrel{+}= a\,z,\quad z = e",
            "parameters": {"gain_N": 0.51},
            "units": {"gain_N": "N"},
            "meanings": {"gain_N": "a: change of F for each unit of z"},
            "log_evidence": 88.0,
            "gains_in": 1.0,
            "best_in": 0.9,
            "tied": 0,
            "alternatives": [],
        }
    ],
    "not_judged": ["no temperature was recorded"],
    "error_before": {"force": 0.05},
    "error_after": {"force": 0.01},
    "noise_floor": {"force": 0.009},
}


def write_proposal(folder: Path, model: Path) -> None:
    """Beside the model file of a campaign, a law that is proposed to be put on top of its ladder."""
    folder.mkdir()
    write_template("sleeve_law", folder / "sleeve_law.py")
    before = json.loads(model.read_text())
    effect = load_catalogue(folder / "sleeve_law.py")["sleeve_law"]()
    after = {**before, **baseline().plus(effect, "sleeve_law").to_dict()}
    model = {key: after[key] for key in ("format", "version", "effects")}
    after["history"] = [*before["history"], {**before["history"][-1], "step": "+ sleeve_law", "model": model}]
    (folder / proposed_law.MODEL).write_text(json.dumps(after))
    (folder / proposed_law.JSON).write_text(json.dumps(FOUND | {"history": after["history"]}))

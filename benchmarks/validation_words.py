"""The page about the validation, as Markdown for a reviewer of a journal: methods, data, results, limits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from diagnosis_score import markdown
from validation_data import Material, Pair

from testbench.diagnosis.judging.probabilities import NOTHING

Row = Mapping[str, Any]
UNITS = {"force": "N", "conductance": "ln S"}

METHODS = """
Each recording is averaged onto a uniform grid. A baseline of physical laws (elasticity, friction, contacts or
piezoresistance, drift) is fitted to it, and compared with the same baseline with one mechanism of the catalogue,
with nothing, and with a free-form map over strain, rate, history and time (*unknown*). Models are compared by
their log evidence (Laplace's approximation; MacKay, Neural Computation 4 (1992) 415), tempered for misfit that
all laws share (power posterior; Grunwald & van Ommen, Bayesian Anal. 12 (2017) 1069); the probabilities below are
posterior ones over all hypotheses, prior included. [How the diagnosis judges](diagnosis.md) gives the model, the
priors and the constants.

Nothing was chosen on the held-out recording. Free in it are the zero of the force, the gain of the conductance,
and what an effect declares as its own for each recording. Errors are RMS over the held-out samples, in N and in
ln S. The noise is estimated from second differences of the readings: what no smooth model can explain. Where a
material has one recording, its last third is held out. Where a specimen was pulled several times, all pulls but the
last are one history, and each has its own zeros of force and displacement, for it was clamped anew.

*As known* means that the answer agrees with what is known of the material, written down below it **before** the run;
it is not a proof that this mechanism is at work. Where the verdict is *unknown*, none is named: the most probable
mechanism may leave more than half of what it should explain. The verdict is *missing* where *nothing* and *unknown*
together have less than half: then many mechanisms may share the rest, each with less than *nothing* has alone.
"""

LIMITS = """
- No public data set has a knitted sensor with displacement, force *and* resistance. These materials are the
  nearest, and the conductance of most of them falls with stretch, where that of a contact-governed knit rises.
- What is known of a material is known of its kind. No mechanism was switched off in a specimen to prove the
  answer, as the simulated cases can do; a mechanism of the same trace would be named alike.
- Gauge lengths, units or zeros that are not told were given stand-in values, named with the material. They scale
  parameters, not which mechanism is found.
- Recordings without temperature cannot tell a slow drift of the room from one of the sensor.
- The recordings were seen while the diagnosis was developed, some of them often. The simulated cases above are
  the only ones that were made after it was fixed.
- There are few materials: shares over them are no rates.
"""


def page(
    materials: Sequence[Material],
    rows: Mapping[str, Row],
    simulated: Row | None,
    versions: Mapping[str, str],
) -> str:
    """The whole page."""
    parts = [
        "# Validation: measured recordings, and whether probabilities are true",
        made_by(versions),
        summary(materials, rows),
    ]
    parts += ["## Methods", METHODS.strip(), "## Data", data_table(materials)]
    parts.append("## Results, material by material")
    parts += [section(material, rows) for material in materials]
    parts += ["## Simulated sensors: are the probabilities true?", reliability_words(simulated)]
    parts += ["## Limits", LIMITS.strip()]
    return "\n\n".join(parts) + "\n"


def made_by(versions: Mapping[str, str]) -> str:
    """How to make the page again."""
    said = ", ".join(f"{name} {version}" for name, version in versions.items())
    command = "    python benchmarks/validation.py --data DIR -o docs/validation.md --simulated RESULTS.jsonl"
    public = "The recordings are public, and not part of this repository."
    return f"This page is written by\n\n{command}\n\nwith {said}. {public}"


def summary(materials: Sequence[Material], rows: Mapping[str, Row]) -> str:
    """One line a pair."""
    lines = []
    for material in materials:
        for pair in material.pairs:
            row = rows[pair.key]
            if "verdict" not in row:
                lines.append([material.title, pair.title, why_not(row), "", "", ""])
                continue
            name, chance = top(row)
            errors = "; ".join(fall(row, channel) for channel in row["error_before"])
            known = agreement(material, row)
            answer = f"{spoken(name)} ({100 * chance:.0f} %)"
            lines.append([material.title, pair.title, answer, known, errors, f"{row['seconds']:.0f}"])
    said = [agreement(m, rows[p.key]) for m in materials for p in m.pairs if "verdict" in rows[p.key]]
    failed = sum("error" in rows[p.key] for m in materials for p in m.pairs)
    skipped = sum("skipped" in rows[p.key] for m in materials for p in m.pairs)
    named = f"{said.count('yes')} as known, {said.count('no')} otherwise, {said.count('none named')} without a name"
    count = f"{len(said)} pairs were diagnosed: {named}; {failed} failed, {skipped} were skipped."
    header = [
        "material",
        "recordings",
        "most probable",
        "as known",
        "held-out error: before, after (noise)",
        "seconds",
    ]
    return f"{count}\n\n{markdown(header, lines)}"


def agreement(material: Material, row: Row) -> str:
    """Whether the answer agrees with what is known; *nothing* and *unknown* name no mechanism."""
    answer = top(row)[0] if row["verdict"] == "missing" else row["verdict"].removesuffix("_missing")
    return "yes" if answer in material.plausible else "none named" if row["verdict"] != "missing" else "no"


def top(row: Row) -> tuple[str, float]:
    """The most probable hypothesis."""
    return max(row["probabilities"].items(), key=lambda one: one[1])


def why_not(row: Row) -> str:
    """Why a pair has no answer."""
    return str(row["skipped"]) if "skipped" in row else f"failed: {row.get('error')}"


def fall(row: Row, channel: str) -> str:
    """Error before and after, and the noise."""
    before, after, noise = (row[key][channel] for key in ("error_before", "error_after", "noise_floor"))
    return f"{channel} {before:.3g}, {after:.3g} ({noise:.2g}) {UNITS.get(channel, '')}"


def data_table(materials: Sequence[Material]) -> str:
    """Sources and licences."""
    lines = [[one.title, one.source, one.licence] for one in materials]
    words = (
        "Measured by others, published with the papers or codes they belong to; tidied to one CSV a recording. Where "
        "no licence is stated all rights are reserved: the recordings are read, and never passed on."
    )
    return f"{words}\n\n{markdown(['material', 'source', 'licence'], lines)}"


def section(material: Material, rows: Mapping[str, Row]) -> str:
    """One material."""
    likely = ", ".join(map(spoken, material.plausible))
    parts = [f"### {material.title}", f"**Known:** {material.known} Agrees with it: {likely}."]
    parts += [told(pair, rows[pair.key]) for pair in material.pairs]
    return "\n\n".join(parts)


def told(pair: Pair, row: Row) -> str:
    """One pair: what the tool says, and the picture."""
    if "verdict" not in row:
        return f"**{pair.title}**: {why_not(row)}."
    chances = ", ".join(
        f"{'nothing is missing' if name == NOTHING else spoken(name)} {100 * chance:.0f} %"
        for name, chance in row["probabilities"].items()
        if chance >= 0.01
    )
    steps = ", then ".join(f"{spoken(one['law'])} ({100 * one['probability']:.0f} %)" for one in row["found"])
    put_in = (
        f"Put in: {steps}; {100 * row['left']:.0f} % of the error above the noise is left."
        if steps
        else "Nothing was put in."
    )
    tied = f" Hardly told apart: {', '.join(map(spoken, row['tied']))}." if row["tied"] else ""
    rest = ""
    if row["depends_on"] and row["verdict"] == "unknown":
        first = row["depends_on"][0]
        rest = f" What is left depends most on {first['coordinate']} ({first['channel']})."
    lines = [
        f"**{pair.title}** ({row['minutes']:.1f} min, {row['samples']} samples; held out: {row['held_out']}).",
        f"*{spoken(row['verdict'])}*: {chances}. {put_in}{tied}{rest}",
        f"![{pair.title}](images/{row['picture']})",
    ]
    return "\n\n".join(lines)


def spoken(name: str) -> str:
    """A name of the code in words."""
    return name.replace("_", " ")


def reliability_words(simulated: Row | None) -> str:
    """The reliability diagram, or that there is none."""
    if simulated is None:
        return (
            "No results were given (`--simulated`, from `benchmarks/bench_diagnosis.py --results`); "
            "[how often the diagnosis is right](benchmark-diagnosis.md) has the last ones."
        )
    made = ", ".join(simulated["simulators"])
    strengths = ", ".join(f"{one:g}" for one in simulated["strengths"])
    minutes = ", ".join(f"{one:g}" for one in simulated["minutes"])
    words = (
        f"{simulated['cases']} sensors, each with laws, motion and noise of its own, by simulators that share no "
        f"code with the model ({made}); effects of {strengths} times the noise, recordings of {minutes} min. A "
        "probability is true if what is said with 90 % is right in nine of ten cases; cases with two effects at once "
        "have no one answer, and are not in the first table."
    )
    return (
        f"{words}\n\n![Reliability](images/{simulated['picture']})\n\n{simulated['table']}\n\n{simulated['glance']}"
    )

"""What the fuzz targets are fed: documents with anything wrong in them; programs, tables and wires by grammar."""

from __future__ import annotations

import copy
import json
from typing import Any

from hypothesis import strategies as st

from testbench.rig.protocol.wire import Sample, encode

NASTY: tuple[Any, ...] = (
    None, True, 0, -1, 1, 5, 1.5, -0.0, 1e300, -1e300, 5e-324, 2**31, 2**63, 2**64, 10**30, "", " ", "0", "nan", "-1",
    "1e999", "a" * 600, "\0", "\x1b[2J", "../../x", "/etc/passwd", "é", "\ud800", [], {}, [[]], [None], {"": {}},
    [1, "a", None], {"effects": []}, "1-999999999999", "2-1", [0] * 50, "program.tap", "f" * 64, "recording",
)  # fmt: skip
RAW = ("NaN", "Infinity", "-Infinity", "1e999", "1" * 5000, "[" * 3000, '{"a":' * 500, "{}", "0x10", "'", "")
MARK = '"@@RAW@@"'


def places(data: Any, path: tuple = ()) -> list[tuple]:
    """Every address in a nested document."""
    found = [path]
    items = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    for key, value in items:
        found += places(value, (*path, key))
    return found


def _holder(data: Any, path: tuple) -> Any:
    for key in path[:-1]:
        data = data[key]
    return data


@st.composite
def damaged_documents(draw, documents: tuple[Any, ...], reseal=json.dumps) -> str:
    """JSON text of one of `documents` with one to three entries changed, taken out, doubled or made raw nonsense."""
    data = copy.deepcopy(draw(st.sampled_from(documents)))
    raw = ""
    for _ in range(draw(st.integers(1, 3))):
        path = draw(st.sampled_from(places(data)[1:] or [()]))
        if not path:
            return draw(st.sampled_from(["", "null", "5", "[]", '"x"', *RAW]))
        holder, key = _holder(data, path), path[-1]
        kind = draw(st.sampled_from(["nasty", "nasty", "gone", "raw", "extra"]))
        if kind == "nasty":
            holder[key] = copy.deepcopy(draw(st.sampled_from(NASTY)))
        elif kind == "gone":
            del holder[key]
        elif kind == "raw":
            holder[key], raw = json.loads(MARK), draw(st.sampled_from(RAW))
        elif isinstance(holder, dict):
            holder[draw(st.sampled_from(["x", "path", "format", "a" * 300]))] = copy.deepcopy(
                draw(st.sampled_from(NASTY))
            )
    try:
        text = reseal(data)
    except (KeyError, TypeError, ValueError):
        text = json.dumps(data)
    return text.replace(MARK, raw, 1)


def damaged_bytes(texts: tuple[bytes, ...]):
    """One of `texts` with bytes changed, cut, doubled or put in."""

    @st.composite
    def one(draw) -> bytes:
        data = bytearray(draw(st.sampled_from(texts)))
        for _ in range(draw(st.integers(1, 4))):
            at, size = draw(st.integers(0, max(len(data) - 1, 0))), draw(st.integers(0, 40))
            data[at : at + draw(st.integers(0, 8))] = draw(
                st.one_of(
                    st.binary(max_size=12), st.sampled_from([b"\0" * 20, b"\n", b",", b"\r", bytes(data[:size])])
                )
            )
        return bytes(data)

    return one()


_NUMBER = st.one_of(
    st.sampled_from(
        ["0", "1", "-1", "0.5", "1e5", "NAN", "1.", ".5", "--1", "9" * 200, "#1", "0.0000001", "1000000"]
    ),
    st.floats(-20, 20, allow_nan=False).map(lambda value: f"{value:.4f}"),
)
_WORD = st.tuples(
    st.sampled_from(
        ["G", "G0", "G1", "G4", "X", "X", "F", "F", "P", "M", "M30", "G9", "G2", "G5", "(", ")", "Y", ";"]
    ),
    _NUMBER,
).map("".join)
_COMMENT = st.tuples(
    st.sampled_from(
        [
            "SEED",
            "RATE_HZ",
            "SPEC.NAME",
            "SPEC.PIECES.0.KIND",
            "SPEC.PIECES",
            "SPEC",
            "GAUGE_LENGTH_MM",
            "STEPS",
            "SHA256",
        ]
    ),
    st.one_of(_NUMBER, st.sampled_from(["NOISE", "[[[", "{}", "-", "1" * 190, "null", "G93"])),
).map(lambda pair: f"({pair[0]}: {pair[1]})")
_LINE = st.one_of(
    _COMMENT,
    st.lists(_WORD, max_size=4).map(" ".join),
    st.sampled_from(
        ["G90 G21 G94", "G1 X1 F60", "G1 X0 F60", "G1 X1.0000 F6.0 (STEPS 9999999)", "G4 P1.5", "M30", "%"]
    ),
    st.text(max_size=20),
)
programs = st.lists(_LINE, max_size=12).map("\n".join)

_CELL = st.one_of(
    st.sampled_from([
        "", "nan", "inf", "1e999", "x", "1,5", '"', "0", "-1", "9" * 400, " 3 ", "é", "1e-320", "\t", ";", "True",
    ]),
    st.floats(0, 100).map(lambda value: f"{value:.3f}"),
)  # fmt: skip
_HEADER = st.lists(
    st.sampled_from([
        "time_s", "displacement_mm", "force_N", "resistance_ohm", "temperature_C", "", "x", '"a', "strain_mm_mm",
    ]),
    max_size=6,
)  # fmt: skip


@st.composite
def tables(draw) -> str:
    """A CSV, or nearly one."""
    separator = draw(st.sampled_from([",", ",", ",", ";", "\t", "|"]))
    names = draw(st.one_of(_HEADER, st.just(["time_s", "displacement_mm", "force_N"])))
    rows = draw(st.lists(st.lists(_CELL, max_size=6), max_size=6))
    counted = [[str(n), *row] for n, row in enumerate(rows)] if draw(st.booleans()) else rows
    return draw(st.sampled_from(["\n", "\r\n", "\r"])).join(separator.join(row) for row in [names, *counted])


_WHOLE = st.one_of(st.integers(0, 2**32 + 5), st.integers(0, 30), st.just(2**32 - 1))
_SAMPLE = st.builds(
    Sample,
    st.integers(0, 3),
    _WHOLE,
    _WHOLE,
    st.one_of(st.none(), st.integers(-(10**10), 10**10)),
    st.one_of(st.none(), st.integers(0, 10**15)),
    st.integers(-(10**10), 10**10),
    st.one_of(st.none(), st.none(), st.integers(-(10**7), 10**7)),
)
wires = st.lists(
    st.one_of(
        _SAMPLE.map(encode),
        _SAMPLE.map(lambda sample: encode(sample)[:20]),
        st.binary(max_size=40),
        st.sampled_from([b"$K1,", b"$", b"\n", b"\r\n", b"$" * 300, b"\0" * 300, b"$K2,1\n"]),
    ),
    max_size=12,
)

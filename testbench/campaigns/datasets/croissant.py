"""``croissant.json``: what a data set holds, for tools that read Croissant (MLCommons, format 1.0)."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from gcode.support.console import knitbench_version
from gcode.support.files import write_json
from testbench.campaigns.datasets.parquet_checksums import PARQUET
from testbench.recordings.channels import UNITS

NAME = "croissant.json"
CONFORMS = "http://mlcommons.org/croissant/1.0"
_OWN_WORDS = (
    "citeAs column equivalentProperty extract field fileObject fileProperty fileSet format includes "
    "isLiveDataset jsonPath key md5 parentField path recordSet references regex repeated replace "
    "samplingRate separator source subField transform"
)
CONTEXT: dict[str, Any] = {
    "@language": "en",
    "@vocab": "https://schema.org/",
    "sc": "https://schema.org/",
    "cr": "http://mlcommons.org/croissant/",
    "rai": "http://mlcommons.org/croissant/RAI/",
    "dct": "http://purl.org/dc/terms/",
    "conformsTo": "dct:conformsTo",
    "data": {"@id": "cr:data", "@type": "@json"},
    "dataType": {"@id": "cr:dataType", "@type": "@vocab"},
    "examples": {"@id": "cr:examples", "@type": "@json"},
    **{word: f"cr:{word}" for word in _OWN_WORDS.split()},
}


def write_croissant(out: Path, name: str, splits: Sequence[str], columns: Sequence[str]) -> Path:
    """Write the description of the Parquet files of a data set: one set of files and of records a split.

    Parameters
    ----------
    out : Path
        Folder of the data set.
    name : str
    splits, columns : sequence of str
        Those that are there.
    """
    data = {
        "@context": CONTEXT,
        "@type": "sc:Dataset",
        "conformsTo": CONFORMS,
        "name": name,
        "description": "Simulated tensile campaigns of knitted resistance strain sensors, split by specimen.",
        "license": "https://spdx.org/licenses/MIT.html",
        "version": "1.0.0",
        "citeAs": f"{name}, simulated with knitbench {knitbench_version()}",
        "distribution": [_files(split) for split in splits],
        "recordSet": [_records(split, columns) for split in splits],
    }
    write_json(out / NAME, data)
    return out / NAME


def _files(split: str) -> dict[str, Any]:
    return {
        "@type": "cr:FileSet",
        "@id": f"{split}-files",
        "name": f"{split}-files",
        "description": f"One Parquet file a campaign of the {split} specimens.",
        "encodingFormat": "application/x-parquet",
        "includes": f"{PARQUET}/{split}/*.parquet",
    }


def _records(split: str, columns: Sequence[str]) -> dict[str, Any]:
    return {
        "@type": "cr:RecordSet",
        "@id": split,
        "name": split,
        "description": f"Samples of the {split} specimens, in order of time within each campaign.",
        "field": [_field(split, column) for column in columns],
    }


def _field(split: str, column: str) -> dict[str, Any]:
    unit = f", in {UNITS[column]}" if column in UNITS else ""
    return {
        "@type": "cr:Field",
        "@id": f"{split}/{column}",
        "name": column,
        "description": f"{column}{unit}",
        "dataType": "sc:Float" if column in UNITS else "sc:Text",
        "source": {"fileSet": {"@id": f"{split}-files"}, "extract": {"column": column}},
    }

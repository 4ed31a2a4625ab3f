"""How far level and gain of a measured sensor move between two recordings, which no training on the first can know.

    python benchmarks/compensator_levels.py [--kinds measured,others,further]

A straight line through the conductance is fitted on the first recording and on the second. Printed are, in standard
deviations of the first target: by how much the line's zero has moved; by how much the target's own mean has, which is
what would be left of it had the level been taken from the recording's mean; and the ratio of the two slopes. Then the
r2 on the second of the first's line as it is, with the right zero, with the right gain, and with both.
"""

from __future__ import annotations

import argparse

import numpy as np
from compensator_cases import material, real
from compensator_options import MEASURED, add_kinds

from compensation.series import score
from compensation.series.preprocessing import Series

COLUMNS = ("zero", "mean", "slope", "raw", "line", "+ zero", "+ gain", "+ both")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    add_kinds(parser, ("measured", "others", "further"), MEASURED)
    args = parser.parse_args()
    print(f"{'pair':62}" + "".join(f" {name:>7}" for name in COLUMNS))
    materials: dict[str, list[list[float]]] = {}
    for case in real(args.kinds):
        for target in case.targets:
            (first, *_), (second, *_) = case.series(target)
            row = moved(first, second)
            materials.setdefault(material(case), []).append(row)
            print(f"{f'{case.name}, {target}'[:62]:62}" + "".join(f" {value:7.3f}" for value in row))
    every = [row for rows in materials.values() for row in rows]
    for name, rows in {**materials, "all": every}.items():
        found = np.array(rows)
        apart = [*np.sqrt(np.mean(found[:, :2] ** 2, axis=0)), np.exp(np.sqrt(np.mean(np.log(found[:, 2]) ** 2)))]
        cells = "".join(f" {value:7.3f}" for value in (*apart, *found[:, 3:].mean(axis=0)))
        print(f"{f'{name}, {len(rows)} rows: root mean squares (slope: a factor), means':62}" + cells)


def moved(first: Series, second: Series) -> list[float]:
    """The numbers of `COLUMNS`; the slope's ratio as a positive number, since no sensor turned round."""
    x, y = first.conductance_S, first.truth
    centre, spread = y.mean(), y.std()
    slope = np.cov(x, y)[0, 1] / x.var(ddof=1)
    line = centre + slope * (second.conductance_S - x.mean())
    ratio = np.cov(line, second.truth)[0, 1] / line.var(ddof=1)
    shift = second.truth.mean() - line.mean()
    ways = (line, line + shift, centre + ratio * (line - centre), line.mean() + shift + ratio * (line - line.mean()))
    raw = score.r2_before(second.truth, second.conductance_S, np.sign(slope))
    changes = [shift / spread, (second.truth.mean() - centre) / spread, abs(ratio)]
    return [*changes, raw, *(score.r2(second.truth, way) for way in ways)]


if __name__ == "__main__":
    main()

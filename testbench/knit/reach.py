"""Which effects of a model change a signal: by themselves, or by what reads what they write."""

from __future__ import annotations

from collections.abc import Collection

from testbench.knit.effect import Stage
from testbench.knit.model import KnitModel


def reaching(model: KnitModel, signals: Collection[str]) -> set[str]:
    """Names of the effects that change any of these signals, as they are in the end.

    A model knows no recording: whatever is put into it may change what nobody measured, and then no data tell of it.

    Examples
    --------
    >>> import testbench as tb
    >>> model = tb.baseline() + tb.effects.LoadCellCreep(fraction=0.01)
    >>> sorted(set(model) - reaching(model, ["conductance_S"]))
    ['load_cell_creep']
    """
    wanted, found = set(signals), set[str]()
    for name, effect in reversed(list(model.effects.items())):
        if effect.stage < Stage.PRESSURE and "contact_force_N" in wanted:
            wanted.add("force_N")  # so far the two are one
        if wanted & set(effect.writes):
            found.add(name)
            wanted |= {*effect.reads, *effect.optional_reads}
    return found

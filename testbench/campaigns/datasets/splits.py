"""Which campaigns are for training, validation and test: a specimen is in one of them only."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable

TRAIN, VALIDATION, TEST = "train", "validation", "test"
SPLITS = (TRAIN, VALIDATION, TEST)
HELD_SHARE = 0.1  # of the specimens, for validation and again for test


def split_of(specimens: Iterable[str]) -> dict[str, str]:
    """Specimen -> split. A tenth each for validation and test, at least one each of three or more specimens.

    Which ones is decided by a hash of their names: the same specimens are split in the same way everywhere.

    Examples
    --------
    >>> split_of(["pes@1", "pes@2", "pes@3"])
    {'pes@3': 'test', 'pes@1': 'validation', 'pes@2': 'train'}
    """
    mixed = sorted(set(specimens), key=lambda name: hashlib.sha256(name.encode()).hexdigest())
    held = max(round(HELD_SHARE * len(mixed)), 1) if len(mixed) >= len(SPLITS) else 0
    return {
        name: TEST if place < held else VALIDATION if place < 2 * held else TRAIN for place, name in enumerate(mixed)
    }

"""Which campaigns are for training, validation and test: a specimen is in one of them only."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable

TRAIN, VALIDATION, TEST = "train", "validation", "test"
SPLITS = (TRAIN, VALIDATION, TEST)
HELD_SHARE = 0.1  # of the specimens, for validation and again for test


def split_of(specimens: Iterable[str]) -> dict[str, str]:
    """Specimen -> split. About a tenth each for validation and test, at least one each of three or more specimens.

    Each is decided by a hash of its name, so that a data set that grows keeps for training what it trained with. Only
    where a split would be empty does the specimen of the next lowest hash go there.

    Examples
    --------
    >>> split_of(["pes@1", "pes@2", "pes@3"])
    {'pes@3': 'test', 'pes@1': 'validation', 'pes@2': 'train'}
    """
    share = {name: int.from_bytes(hashlib.sha256(name.encode()).digest()[:8]) / 2**64 for name in specimens}
    mixed = sorted(share, key=lambda name: share[name])
    if len(mixed) < len(SPLITS):
        return dict.fromkeys(mixed, TRAIN)
    test = min(max(sum(one < HELD_SHARE for one in share.values()), 1), len(mixed) - 2)
    held = min(max(sum(one < 2 * HELD_SHARE for one in share.values()), test + 1), len(mixed) - 1)
    return {name: TEST if n < test else VALIDATION if n < held else TRAIN for n, name in enumerate(mixed)}

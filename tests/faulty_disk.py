"""A disk that fails at any single call, or loses its power there: the way SQLite is tested.

`FaultyDisk` stands in for `gcode.support.disk.DISK`. It works on real files and keeps a second picture beside them:
what would be on the platter, file by file and name by name, if the power went now. A file's bytes are there once it
was synced; a name in a folder once the folder was.
"""

from __future__ import annotations

import errno
import os
from dataclasses import dataclass, field
from pathlib import Path

from numpy.random import default_rng

from gcode.support.disk import Disk

REFUSALS = {"full": errno.ENOSPC, "broken": errno.EIO}
AFTER_A_CUT = ("lost", "kept", "torn")  # what happens to bytes and names that nobody synced


class PowerCut(BaseException):
    """The power is gone: nothing that the program does from here on reaches the disk."""


@dataclass
class Node:
    """A file or a folder: what the program sees, and what the platter has."""

    seen: bytearray | None = None
    kept: bytes = b""
    names: dict[str, Node] = field(default_factory=dict)
    kept_names: dict[str, Node] = field(default_factory=dict)


class FaultyDisk(Disk):
    """Fails at call number `at` (from 0), counted over everything that changes or syncs a file.

    Parameters
    ----------
    root : Path
        Folder that all the work is in.
    at : int
        The call that fails; beyond the last one nothing fails.
    kind : {"full", "broken", "power"}
        No room, an I/O error, or the power goes.
    lasting : bool
        Whether every later call that needs the disk fails too, until `mend`.
    """

    def __init__(self, root: Path, at: int = 1 << 60, kind: str = "full", lasting: bool = False) -> None:
        self.root, self.at, self.kind, self.lasting = root, at, kind, lasting
        self.calls, self.dead, self.failing = 0, False, False
        self.tree = Node()
        self.open: dict[int, Node] = {}

    def mend(self) -> None:
        """From here on nothing fails."""
        self.at, self.failing = 1 << 60, False

    def _called(self, frees: bool = False) -> None:
        """Count a call; fail if it is due. What frees room works on a full disk."""
        number, self.calls = self.calls, self.calls + 1
        if self.dead:
            raise PowerCut
        if number == self.at and self.kind == "power":
            self.dead = True
            raise PowerCut
        if number == self.at or self.failing:
            self.failing = self.lasting
            if not (frees and self.kind == "full"):
                raise OSError(REFUSALS[self.kind], os.strerror(REFUSALS[self.kind]))

    def _node(self, path: Path) -> Node:
        node = self.tree
        for name in path.relative_to(self.root).parts:
            node = node.names.setdefault(name, Node())
        return node

    def create(self, path: Path) -> int:
        self._called()
        handle = super().create(path)
        self._node(path.parent).names[path.name] = self.open[handle] = Node(bytearray())
        return handle

    def grow(self, path: Path) -> int:
        if not path.exists():
            self._called()
        handle = super().grow(path)
        node = self.open[handle] = self._node(path)
        if node.seen is None:
            node.seen = bytearray(path.read_bytes())
            node.kept = bytes(node.seen)
        return handle

    def write(self, handle: int, data: bytes) -> int:
        short = data
        if self.calls == self.at and self.kind != "power" and len(data) > 1:
            # A disk that fills up takes a part first, and says so only at the next call.
            short, self.at, self.calls = data[: len(data) // 2], self.at + 1, self.calls + 1
        else:
            try:
                self._called()
            except PowerCut:
                if handle in self.open and not self.dead:
                    self.open[handle].seen += data[: len(data) // 3]
                raise
        taken = super().write(handle, short)
        self.open[handle].seen += short[:taken]
        return taken

    def truncate(self, handle: int, size: int) -> None:
        self._called(frees=True)
        super().truncate(handle, size)
        del self.open[handle].seen[size:]

    def sync(self, handle: int) -> None:
        self._called()
        if handle in self.open:
            self.open[handle].kept = bytes(self.open[handle].seen)

    def close(self, handle: int) -> None:
        self.open.pop(handle, None)
        super().close(handle)

    def rename(self, old: Path, new: Path) -> None:
        self._called()
        super().rename(old, new)
        self._node(new.parent).names[new.name] = self._node(old.parent).names.pop(old.name)

    def remove(self, path: Path) -> None:
        if path.exists():
            self._called(frees=True)
        super().remove(path)
        self._node(path.parent).names.pop(path.name, None)

    def make_folder(self, path: Path) -> None:
        self._called()
        super().make_folder(path)
        self._node(path)

    def sync_folder(self, path: Path) -> None:
        self._called()
        node = self._node(path)
        node.kept_names = dict(node.names)

    def after_the_cut(self, target: Path, fate: str, seed: int = 0) -> Path:
        """Write what is on the disk when the power is back into the new folder `target`."""
        self._restore(self.tree, target, fate, default_rng(seed))
        return target

    def _restore(self, node: Node, target: Path, fate: str, rng) -> None:
        target.mkdir()
        for name, child in (node.kept_names if fate == "lost" else node.names).items():
            if child.seen is None:
                self._restore(child, target / name, fate, rng)
            else:
                (target / name).write_bytes(self._bytes(child, fate, rng))

    @staticmethod
    def _bytes(node: Node, fate: str, rng) -> bytes:
        seen = bytes(node.seen or b"")
        if fate == "kept":
            return seen
        if fate == "lost" or not seen.startswith(node.kept):
            return node.kept
        # Torn: the length was kept, of the new bytes only some; the rest is zeros, at the end or before it.
        new = bytearray(seen[len(node.kept) :])
        if new:
            cut = int(rng.integers(0, len(new) + 1))
            hole = slice(0, cut) if rng.random() < 0.3 else slice(cut, None)
            new[hole] = bytes(len(new[hole]))
        return node.kept + bytes(new)

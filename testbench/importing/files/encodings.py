"""In which encoding a text was written."""

from __future__ import annotations

import codecs
import re
from contextlib import suppress

from gcode.support.errors import UserError
from testbench.importing.vocabulary.roles import accented_words_in

# The Western one first, which others must have more names than.
_BY_NAMES = ("cp1252", "cp1250", "cp1251", "cp850", "gb18030", "big5", "cp932", "cp949")
_UTF16 = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
MOST_LINES = 200  # of more than ASCII, in which names are looked for
_NO_TEXT = re.compile(rb"[\0-\x08]")
_IN_PAIRS = re.compile(rb"(?:[\0-\x80]|[\xa1-\xff]{2})*")  # bytes above ASCII, of Chinese characters


def encoding_of(raw: bytes) -> str | None:
    """The encoding of a file's first bytes; None where they are no text.

    UTF-8 and UTF-16 show themselves. Of the others, it is the one in which the text has names of what we look for.
    Where it has none, GBK writes every Chinese character as two bytes above 0xA0, while the letters and
    signs of Latin-1 (``ü``, ``µ``, ``°``) stand alone among plain letters. Single lines that are no text, as a serial
    port gives them before a board has begun to talk, leave the others one.
    """
    if not is_text(raw):
        if raw.startswith(_UTF16):
            return "utf-16"
        even, odd = raw[0::2].count(0), raw[1::2].count(0)
        if max(even, odd) < 0.3 * len(raw) or min(even, odd) > 0.05 * len(raw):
            return None
        return "utf-16-le" if odd > even else "utf-16-be"
    if _decoded(raw, "utf-8-sig") is not None:
        return "utf-8-sig"
    texts = {name: text for name in _BY_NAMES if (text := _decoded(raw, name)) is not None}
    names = {name: _names_in(text) for name, text in texts.items()}
    if any(names.values()):
        return max(names, key=lambda name: names[name])
    if _IN_PAIRS.fullmatch(raw) and "gb18030" in texts:
        return "gb18030"
    return "cp1252" if "cp1252" in texts else "latin-1"


def is_text(raw: bytes) -> bool:
    """Whether most lines are free of the bytes that no text of one byte a letter has."""
    lines = raw.splitlines()
    return 2 * sum(bool(_NO_TEXT.search(line)) for line in lines) < len(lines)


def _decoded(raw: bytes, encoding: str) -> str | None:
    with suppress(UnicodeDecodeError):
        return raw.decode(encoding)
    return None


def _names_in(text: str) -> int:
    return len(accented_words_in("\n".join([line for line in text.splitlines() if not line.isascii()][:MOST_LINES])))


def known_encoding(name: str) -> str:
    """`name` if Python knows it.

    Raises
    ------
    UserError
        If it does not.
    """
    try:
        found = codecs.lookup(name)
        b"0".decode(found.name, errors="replace")  # hex and the like are no encodings of text
        return found.name
    except (LookupError, UnicodeError):
        raise UserError(f"--encoding must be one such as utf-8, latin-1, gbk or shift-jis, got {name!r}") from None

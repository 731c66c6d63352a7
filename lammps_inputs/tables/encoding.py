"""Text of tables in the encodings that programs and spreadsheets write."""

from __future__ import annotations

import codecs

from granwave.lammps_inputs.files import decoded

_UTF16 = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
_WESTERN = "cp1252"  # code page of Windows; contains Latin-1
_CONTROLS = bytes(set(range(32)) - set(b"\t\n\v\f\r"))


def decoded_table(raw: bytes) -> str:
    """Return the text of a table: UTF-8, UTF-16 with a byte-order mark, or Latin-1 (as in µm).

    Raises
    ------
    ValueError
        It is no text; the message gives the line.
    """
    if raw.startswith(_UTF16):
        try:
            return raw.decode("utf-16")
        except UnicodeDecodeError:
            text = "found UTF-16 that is damaged, expected text; save it as UTF-8"
            raise UnicodeError(text) from None
    try:
        return decoded(raw)
    except UnicodeError:
        if _is_western(raw):
            return raw.decode(_WESTERN)
        raise


def start_of(raw: bytes, n: int) -> str:
    """Return the first characters of a text, of ``n`` bytes, whatever its encoding."""
    start = raw[:n]
    if raw.startswith(_UTF16):
        return start.decode("utf-16", errors="replace")
    return start.decode("utf-8-sig", errors="replace")


def _is_western(raw: bytes) -> bool:
    """Return True for text of Windows or Latin-1: no control characters, no unused bytes."""
    if raw.translate(None, _CONTROLS) != raw:
        return False
    try:
        raw.decode(_WESTERN)
    except UnicodeDecodeError:
        return False
    return True

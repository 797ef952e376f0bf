"""What may be read at all, and the two small formats that settings come in. Standard library only.

Whatever opens a path that it was given asks `check_file` first: a pipe can be read but once, which is not enough for a
digest and a reader, and /dev/zero has no end.
"""

from __future__ import annotations

import codecs
import logging
import os
import stat
from pathlib import Path
from typing import Any

from ipcli.errors import FormatError

log = logging.getLogger(__name__)
CUT = "the file ends without an end of line: its last number may be cut"  # what `cut_number` found, in words
BINARY = 1 << 12  # bytes at the start of a file, among which no text has a zero
LONGEST_INTEGER = 19  # letters: shorter ones have at most 64 bits
MOST_BYTES = 1 << 24  # of a file of settings; those that come with a capture's calibration have kilobytes


def check_file(path: Path | str) -> Path:
    """`path`, unless it is a pipe, a socket, a device or a name that no file can have: then FormatError.

    What is not there is not complained of: whoever opens it knows what is missing.
    """
    try:
        mode = os.stat(path).st_mode
    except OSError:
        return Path(path)
    except ValueError:  # a zero byte, or a lone surrogate
        raise FormatError(repr(str(path)), "no name of a file", fix="Correct it where it stands") from None
    if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):
        what = "a pipe or a device, which can be read but once or has no end"
        raise FormatError(path, what, fix="Give a file or folder")
    return Path(path)


def read_small_text(path: Path) -> str:
    """A UTF-8 text of at most MOST_BYTES, without its byte order mark. FormatError for anything else."""
    try:
        if check_file(path).stat().st_size > MOST_BYTES:
            raise FormatError(path, "too large", expected=f"at most {MOST_BYTES} bytes", got=path.stat().st_size)
        return path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise FormatError(path, f"cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        head = error.object[:BINARY]
        if b"\0" in head and not head.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
            raise FormatError(
                path, "not a text, but a binary file such as a picture", fix="Give another file"
            ) from error
        raise FormatError(path, f"not a readable text file: {error}", fix="Save it as UTF-8") from error


def cut_number(text: str) -> bool:
    """Whether a table of numbers ends without an end of line, so that its last number may have lost digits."""
    return text.rstrip(" \t")[-1:] in set("0123456789.-+eE")


def warn_if_cut(path: Path, text: str) -> None:
    """Say in the log that a list of lines whose last has no end may have lost its end.

    No text format that is read asks for the last end of line, and editors leave it out: so it is not refused.
    """
    if cut_number(text):
        log.warning("%s: %s. Check the copy, or end the line", path, CUT)
    elif text and not text.endswith(("\n", "\r")):
        log.warning("%s: the file ends without an end of line: more may be missing. Check the copy, or end it", path)


def read_toml(path: Path, *, fix: str | None = None) -> dict[str, Any]:
    """The table of a TOML file. FormatError with `fix` for anything else, a number of 5000 digits and 5000 brackets
    included, which the parser takes ill in ways of its own, and whole numbers beyond the 64 bits that TOML has.
    """
    import tomllib

    text = read_small_text(path)
    if cut_number(text):
        warn_if_cut(path, text)
    try:
        table = tomllib.loads(text)
    except (ValueError, RecursionError, OverflowError) as error:
        raise FormatError(path, f"not valid TOML: {_reason(error)}", fix=fix) from error
    if _is_beyond(table):
        raise FormatError(path, "not valid TOML: a whole number of more than 64 bits", fix=fix)
    return table


def _is_beyond(table: dict[str, Any]) -> bool:
    """Whether a whole number of more than 64 bits, for which floats have no place, is in a table."""
    left: list[Any] = [table]
    while left:
        value = left.pop()
        if isinstance(value, (dict, list)):
            left += value.values() if isinstance(value, dict) else value
        elif isinstance(value, int) and not -(1 << 63) <= value < 1 << 63:
            return True
    return False


def json_of(text: str) -> Any:
    """What a JSON text says, whole numbers of more than 64 bits as floats, which may be infinite. ValueError for
    anything else, brackets nested too deep included.
    """
    import json

    try:
        return json.loads(
            text, parse_int=lambda digits: int(digits) if len(digits) < LONGEST_INTEGER else float(digits)
        )
    except RecursionError:
        raise ValueError("nested too deep") from None


def read_json(path: Path, *, fix: str | None = None) -> dict[str, Any]:
    """The object of a JSON file. FormatError with `fix` for anything else."""
    try:
        found = json_of(read_small_text(path))
    except ValueError as error:
        raise FormatError(path, f"not valid JSON: {_reason(error)}", fix=fix) from error
    if not isinstance(found, dict):
        raise FormatError(path, "not what it should hold", expected="a JSON object", got=type(found).__name__, fix=fix)
    return found


def _reason(error: Exception) -> str:
    return "nested too deep" if isinstance(error, RecursionError) else " ".join(str(error).split())

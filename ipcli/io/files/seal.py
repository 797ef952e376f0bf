"""Pages that prove themselves: the last line is a digest of all before it and of the name that it was written under."""

from __future__ import annotations

import hashlib
from pathlib import Path

START, END = "<!-- ipcli report ", " -->\n"


def sealed(text: str, name: str) -> str:
    """An HTML page with its seal, for a file of that name."""
    return f"{text}{START}{_digest(text.encode(), name)}{END}"


def is_sealed(path: Path) -> bool:
    """Whether a file is, byte for byte, what was sealed for its name."""
    text, _, seal = path.read_bytes().rpartition(START.encode())
    return seal.decode(errors="replace") == _digest(text, path.name) + END


def _digest(text: bytes, name: str) -> str:
    return hashlib.sha256(name.encode("utf-8", "surrogateescape") + b"\0" + text).hexdigest()

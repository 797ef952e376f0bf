"""Models of COLMAP, opened by pycolmap once their counts are known to be sound."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from ipcli.errors import FormatError

if TYPE_CHECKING:
    import pycolmap

LEAST_BYTES = {"cameras": 24, "images": 65, "rigs": 8, "frames": 8, "points3D": 43}  # of an item of each binary file


def read_model(folder: Path, fix: str) -> pycolmap.Reconstruction:
    """The model in a folder, text or binary; FormatError, which advises `fix`, when it is none or is cut."""
    import pycolmap

    check_counts(folder, fix)
    try:
        return pycolmap.Reconstruction(str(folder))
    except (ValueError, IndexError, RuntimeError) as error:
        words = f"model cannot be read: {' '.join(str(error).split())[:120]}"
        raise FormatError(folder, words, expected="cameras, images and points3D as .bin or .txt", fix=fix) from None


def check_counts(folder: Path, fix: str) -> None:
    """FormatError for a binary model file too short for its own count: pycolmap would read on without end."""
    for stem, least in LEAST_BYTES.items():
        path = folder / f"{stem}.bin"
        if path.is_file():
            size = path.stat().st_size
            with path.open("rb") as stream:
                count = int.from_bytes(stream.read(8), "little")
            if size < 8 or count * least > size - 8:
                got = f"{size} bytes for {count} items"
                raise FormatError(path, "cut or empty", expected=f"{least} bytes an item or more", got=got, fix=fix)

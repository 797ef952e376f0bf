"""Work in progress: what chains leave in a folder beside an output, so that a run that was killed goes on
where it was.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from shutil import rmtree
from urllib.parse import quote

import numpy as np

from ipcli.errors import FormatError
from ipcli.io.files import npz

LONGEST = 150  # letters of the name of an item that its file's name keeps


@dataclass(frozen=True)
class Checkpoint:
    """A hidden folder of one file an item, named after the output and the digest of the run: another run takes none of
    it.
    """

    folder: Path

    @classmethod
    def of(cls, output: Path, digest: str) -> Checkpoint:
        """That of the run with this digest."""
        start = os.fsencode(output.name)[:200].decode(errors="ignore")
        return cls(output.with_name(f".{start}.{digest[:16]}.work"))

    def load(self, name: str) -> dict[str, np.ndarray] | None:
        """What was last saved for this item; None if there is nothing sound."""
        path = self._path(name)
        try:
            return npz.read(path) if path.is_file() else None
        except FormatError:
            return None

    def save(self, name: str, arrays: Mapping[str, np.ndarray]) -> None:
        """Keep numeric arrays for this item in place of those before, whole or not at all."""
        npz.write(self._path(name), arrays, durable=False)  # what a power cut damages is found out when it is loaded

    def clear(self) -> None:
        """Forget all items, when the output is there."""
        rmtree(self.folder, ignore_errors=True)

    def _path(self, name: str) -> Path:
        plain = quote(name, safe=" ")
        if len(plain) > LONGEST:  # more than file systems take
            plain = f"{plain[:LONGEST]}.{sha256(name.encode('utf-8', 'surrogatepass')).hexdigest()[:16]}"
        return self.folder / f"{plain}.npz"

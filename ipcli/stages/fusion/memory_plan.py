"""Whether a fusion fits into the memory, decided and said before it starts."""

from __future__ import annotations

import logging
from dataclasses import dataclass

from ipcli import memory, threads
from ipcli.errors import IpcliError
from ipcli.measurements.views import View
from ipcli.models.fusion import footprint as sizes
from ipcli.models.fusion.footprint import FusionSize, footprint, side_by_size, side_within
from ipcli.models.fusion.parameters import Fusion

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class MemoryPlan:
    """The tiles in which a fusion keeps the limit, and what it takes."""

    fusion: Fusion
    size: FusionSize
    asked: int  # side of the tiles without a limit, 0 for all at once
    side: int
    fits: bool

    @classmethod
    def of(cls, reference: View, views: int, fusion: Fusion) -> MemoryPlan:
        """For that many views, taken to be as large as the reference. The number of threads has no say in the tiles, so
        that it has none in the map.
        """
        held = (reference.depth, reference.confidence, reference.image, reference.truth)
        size = FusionSize(
            reference.depth.shape,
            sum(array.nbytes // reference.depth.size for array in held if array is not None),
            views,
            reference.confidence is not None,
            threads.available(),
        )
        asked, side = side_by_size(size, fusion), side_within(size, fusion, memory.budget())
        return cls(fusion, size, asked, asked if side is None else side, side is not None)

    def say(self, name: str, level: int = logging.INFO) -> None:
        """Say what the fusion into `name` takes, aloud if the limit changes it. IpcliError if it fits in no way."""
        limit, need = memory.told(memory.budget()), memory.told(footprint(self.size, self.fusion, self.side))
        if not self.fits:
            least = memory.told(footprint(self.size, self.fusion, sizes.SIDES[-1]))
            cure = "leave out fusion.tile" if self.fusion.tile is not None else "give a smaller --camera"
            raise IpcliError(
                f"{name}: {self.size.words} take {need} and in the smallest tiles {least}, but --max-memory is "
                f"{limit}. Raise it, or {cure}"
            )
        way = f"in tiles of {self.side} px" if self.side else "at once"
        why = ""
        if self.side != self.asked:
            level = logging.WARNING
            before = memory.told(footprint(self.size, self.fusion, self.asked))
            why = f", since it would take {before} {'in larger ones' if self.asked else 'at once'}"
        log.log(level, "%s: %s, %s: about %s of the %s of --max-memory%s", name, self.size.words, way, need, limit, why)

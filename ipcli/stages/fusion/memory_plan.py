"""Whether a fusion fits into the memory, decided and said before it starts."""

from __future__ import annotations

import logging
from dataclasses import dataclass, replace

from ipcli import memory, threads
from ipcli.errors import IpcliError
from ipcli.measurements.views import View
from ipcli.models.fusion import footprint as sizes
from ipcli.models.fusion.footprint import FusionSize, footprint, side_within
from ipcli.models.fusion.parameters import Fusion
from ipcli.models.fusion.tiles import side_of_tiles

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class MemoryPlan:
    """The settings of a fusion with the tiles that the limit asks for, and what it takes."""

    fusion: Fusion
    size: FusionSize
    asked: int  # side of the tiles without a limit
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
        asked, side = side_of_tiles(fusion, size.shape, views), side_within(size, fusion, memory.budget())
        chosen = fusion if side is None or side == asked else replace(fusion, tile=side)
        return cls(chosen, size, asked, side is not None)

    def say(self, name: str, level: int = logging.INFO) -> None:
        """Say what the fusion into `name` takes, aloud if the limit changes it. IpcliError if it fits in no way."""
        side = side_of_tiles(self.fusion, self.size.shape, self.size.views)
        limit, need = memory.told(memory.budget()), memory.told(footprint(self.size, self.fusion, side))
        if not self.fits:
            least = memory.told(footprint(self.size, self.fusion, sizes.SIDES[-1]))
            cure = "leave out fusion.tile" if self.fusion.tile is not None else "give a smaller --camera"
            raise IpcliError(
                f"{name}: {self.size.words} take {need} and in the smallest tiles {least}, but --max-memory is "
                f"{limit}. Raise it, or {cure}"
            )
        way = f"in tiles of {side} px" if side else "at once"
        why = ""
        if side != self.asked:
            level = logging.WARNING
            before = memory.told(footprint(self.size, replace(self.fusion, tile=self.asked), self.asked))
            why = f", since it would take {before} {'in larger ones' if self.asked else 'at once'}"
        log.log(level, "%s: %s, %s: about %s of the %s of --max-memory%s", name, self.size.words, way, need, limit, why)

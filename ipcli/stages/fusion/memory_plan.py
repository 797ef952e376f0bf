"""Whether a fusion or a merge fits into the memory, decided and said before it starts."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass

from ipcli import memory, threads
from ipcli.errors import IpcliError
from ipcli.measurements.views import View
from ipcli.models.fusion import footprint as sizes
from ipcli.models.fusion.footprint import FusionSize, MergeSize, footprint, side_by_size, side_within
from ipcli.models.fusion.parameters import Fusion, Merge

log = logging.getLogger(__name__)
SPARE = 8  # maps at hand beyond the neighbours of one


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


@dataclass(frozen=True)
class MergePlan:
    """How many maps a merge holds at hand to keep the limit, and how large its cloud may grow."""

    size: MergeSize
    wanted: int  # maps at hand without a limit
    maps: int

    @classmethod
    def of(cls, pixels: Sequence[int], merge: Merge) -> MergePlan:
        """For maps of so many pixels each."""
        held = min(merge.neighbours + SPARE, len(pixels))
        size = MergeSize(max(pixels), sum(pixels), threads.count(), held, min(merge.agree, len(pixels) - 1))
        return cls(size.within(memory.budget()), held, len(pixels))

    @property
    def most_points(self) -> int:
        """Points that the cloud may have."""
        return self.size.most_cells(memory.budget())

    def say(self, name: str, level: int = logging.INFO) -> None:
        """Say what the merge takes, aloud if the limit may get in its way. IpcliError if not even the maps fit."""
        limit, need = memory.budget(), self.size.footprint(self.size.cells())
        least = self.size.footprint(0)
        if least > limit:
            raise IpcliError(
                f"{name}: {self.maps} maps of up to {self.size.largest / 1e6:.3g} Mpx take {memory.told(least)} and "
                f"more, but --max-memory is {memory.told(limit)}. Raise it, or fuse into a smaller --camera"
            )
        more = ""
        if need > limit or self.size.held < self.wanted:
            level = logging.WARNING
            more = f", with {self.size.held} maps at hand in place of {self.wanted}" * (self.size.held < self.wanted)
        if need > limit:
            more += f"; a cloud of more than {self.most_points} points is refused: a larger --spacing makes it less"
        pixels = f"{self.maps} maps, {self.size.pixels / 1e6:.3g} Mpx in all"
        log.log(
            level,
            "%s: %s: at most %s of the %s of --max-memory%s",
            name,
            pixels,
            memory.told(need),
            memory.told(limit),
            more,
        )

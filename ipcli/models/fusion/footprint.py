"""How much memory a fusion and the merge of fused maps take, told from sizes alone before they start.

And in which tiles, or with how many maps at hand, they fit a limit.

The figures are bytes a pixel of what is alive at the widest moment, counted in the code and held against the peak of
real runs by `benchmarks.fusion.memory`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from ipcli.measurements.accuracy import MAP_PIXELS, thinning
from ipcli.models.fusion.cells import WAITING
from ipcli.models.fusion.parameters import METHODS, Fusion
from ipcli.models.fusion.tiles import EVERY, MARGIN

PROCESS = 350_000_000  # bytes of the interpreter, its libraries and compiled kernels
PUBLISHING = 480_000_000  # the same while mesh and pages are drawn
PICTURED = 150  # of the page, a pixel that it is drawn from
MAPS = 35  # of the reference: depth, mean, median, confidence, uncertainty, normals, observations, what is filled
FILLING = 16  # of the reference, while holes are filled
WORKING = 250  # of a tile, whatever the number of views: the iteration, and normals in double precision
OBSERVATION = 12  # of a tile, a view: as reprojected, sorted, and once more while it is sorted
WEIGHT = 12  # the same of a given confidence
OWN_CONFIDENCE = 24  # of a method with a confidence for each observation
VIEW = 4  # a view as it stays in memory, and as much again while it is read
SIDE = 1024  # pixels of a tile, unless told otherwise
SIDES = (512, 256)  # of smaller ones that are tried where those do not fit
LARGE = 2_500_000_000  # bytes of the observations and the iteration from which on a map is fused in tiles by itself


@dataclass(frozen=True)
class FusionSize:
    """What decides about memory: the reference (h, w), bytes of a pixel of it, the number of views, taken to be as
    large, and how many are read at once.
    """

    shape: tuple[int, int]
    reference_bytes: int
    views: int
    given_confidence: bool = False
    at_once: int = 1

    @property
    def words(self) -> str:
        """In words, as `20 Mpx of 3 views`."""
        return f"{self.shape[0] * self.shape[1] / 1e6:.3g} Mpx of {self.views} view{'s' if self.views > 1 else ''}"


def side_by_size(size: FusionSize, fusion: Fusion) -> int:
    """Side of the tiles to fuse in, 0 for all at once: by the sizes alone, so that any machine makes the same map."""
    if fusion.tile is not None:
        return -(-fusion.tile // EVERY) * EVERY
    h, w = size.shape
    return SIDE if h * w * pixel_bytes(size, fusion) > LARGE else 0


def pixel_bytes(size: FusionSize, fusion: Fusion) -> int:
    """Bytes that a pixel takes while it is fused."""
    observation = OBSERVATION + (WEIGHT if size.given_confidence and fusion.confidence.given else 0)
    observation += OWN_CONFIDENCE if METHODS[fusion.method].each_view else 0
    return WORKING + size.views * observation


def footprint(size: FusionSize, fusion: Fusion, side: int) -> int:
    """Bytes at the peak of a fusion in tiles of that side, 0 for all at once."""
    h, w = size.shape
    pixels, view = h * w, h * w * (VIEW + (4 if size.given_confidence else 0))
    own = pixel_bytes(size, fusion)
    resting = PROCESS + pixels * size.reference_bytes
    drawn = PICTURED * pixels // thinning(pixels, MAP_PIXELS) ** 2 + PUBLISHING - PROCESS + MAPS * pixels
    if not side:
        return resting + size.views * view + max(pixels * own, drawn)
    tile = min(side + 2 * MARGIN, h) * min(side + 2 * MARGIN, w)
    kept = 4 * size.views * pixels // EVERY**2
    reading = min(size.at_once, size.views) * view  # of each view what may land in the tile, which may be all
    fusing = MAPS * pixels + max(FILLING * pixels, reading + tile * own)
    return resting + kept + max(2 * view, fusing, drawn)


def side_within(size: FusionSize, fusion: Fusion, limit: int) -> int | None:
    """Side of the tiles, 0 for all at once, in which a fusion keeps a limit in bytes; None if it does in none.

    That of `side_by_size`, unless it is too much and the settings do not ask for it: then the largest that fits.
    """
    asked = side_by_size(size, fusion)
    smaller = [side for side in (SIDE, *SIDES) if not asked or side < asked]
    tried = [asked] if fusion.tile is not None else [asked, *smaller]
    return next((side for side in tried if footprint(size, fusion, side) <= limit), None)


MERGING = 300_000_000  # bytes of the process that merges
HELD = 40  # of a map at hand, a pixel: the map and its surface
ASKED = 220  # of a map while others are asked about its pixels, and of what becomes of these
POINT = 280  # a point of the cloud while points are averaged, those that wait included
WRITTEN = 420  # a point of the cloud while artefact, PLY and pages are written


@dataclass(frozen=True)
class MergeSize:
    """What decides about the memory of a merge: the pixels of the largest map and of all, how many are merged at once
    and are at hand beside, and how many others confirm a point.
    """

    largest: int
    pixels: int
    at_once: int
    held: int
    agree: int

    def cells(self) -> int:
        """Points of the cloud, at most: a place is seen by those who confirm it too."""
        return self.pixels // (self.agree + 1)

    def footprint(self, cells: int) -> int:
        """Bytes at the peak of a merge whose cloud has so many points."""
        waiting = min(max(WAITING, cells) + self.at_once * self.largest, self.pixels)
        merging = max(self.at_once * self.largest * ASKED, (cells + waiting) * POINT)
        return max(MERGING + self.held * self.largest * HELD + merging, PUBLISHING + cells * WRITTEN)

    def most_cells(self, limit: int) -> int:
        """How many points of the cloud fit into a limit in bytes."""
        low, high = 0, self.pixels + 1
        while high - low > 1:
            middle = (low + high) // 2
            low, high = (middle, high) if self.footprint(middle) <= limit else (low, middle)
        return low

    def within(self, limit: int) -> MergeSize:
        """With as many maps at hand as a limit in bytes allows, but for each that is merged one that it asks."""
        held = self.held
        while held > 2 * self.at_once and replace(self, held=held).footprint(self.cells()) > limit:
            held -= 1
        return replace(self, held=held)

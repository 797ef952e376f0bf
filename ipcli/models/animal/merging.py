"""Aspects of one part that show the same side, registered and merged (thesis 6.3.2).

Two photographs from the left, or an image of another pose beside one of the reference pose: each pair of aspects of a
part is registered, the pairs are brought in tune, and each aspect takes the mean thickness of all as its own image
would show them. So no aspect is the reference. (The union of the thesis would keep the largest mistake of each.)
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from ipcli.measurements.part_images import PartImage, PartMatches
from ipcli.models.animal.aspects import Aspect
from ipcli.models.animal.parameters import Registration
from ipcli.models.animal.registration import AspectSurface, match_start, register, synchronised
from ipcli.models.animal.reposed import tells_shape
from ipcli.progress import Progress, silent

MOST_RESIDUAL = 0.3  # of the heights: beyond it two aspects do not show one shape, and are left alone


@dataclass(frozen=True, eq=False)
class Overlay:
    """Two registered aspects of a part: first_from_second (4, 4) in pixels, what is left of the heights, whether that
    was little enough to merge them, and the heights (h, w) of the first and of the second laid over it, at the start
    and in the end.
    """

    part: int
    images: tuple[str, str]
    transform: np.ndarray
    residual: float
    is_used: bool
    heights: np.ndarray
    before: np.ndarray
    after: np.ndarray


def alike(
    images: Sequence[PartImage], keys: Iterable[tuple[str, int]], matches: Sequence[PartMatches], other_pose: str
) -> list[tuple[int, str, str]]:
    """Part and names of every two images whose aspects of it are to be registered, each pair in the images' order.

    These are images with one and the same named view, and those with matches. Images of the other pose that can give a
    model of their own are paired with one another only, and none is where `other_pose` is "ignore".
    """
    if other_pose == "ignore":
        keys = [key for key in keys if all(image.is_reference for image in images if image.name == key[0])]
    is_posed = tells_shape([image for image in images if not image.is_reference])
    place = {image.name: k for k, image in enumerate(images)}
    by_part: dict[int, list[PartImage]] = {}
    for name, part in keys:
        by_part.setdefault(part, []).append(images[place[name]])
    marked = {(match.part, frozenset(match.images)) for match in matches}
    found = []
    for part, shown in sorted(by_part.items()):
        for one, two in combinations(sorted(shown, key=lambda image: place[image.name]), 2):
            same_side = one.view is not None and one.view == two.view
            same_model = one.is_reference == two.is_reference or not is_posed
            if same_model and (same_side or (part, frozenset((one.name, two.name))) in marked):
                found.append((part, one.name, two.name))
    return found


def merged(
    aspects: Mapping[tuple[str, int], Aspect],
    pairs: Sequence[tuple[int, str, str]],
    matches: Sequence[PartMatches],
    params: Registration,
    progress: Progress = silent,
) -> tuple[dict[tuple[str, int], Aspect], list[Overlay]]:
    """All aspects, those of `pairs` (see `alike`) merged, and how each pair lies."""
    keys = dict.fromkeys((name, part) for part, one, two in pairs for name in (one, two))
    surfaces = {key: AspectSurface.of(*aspects[key].surface()) for key in keys}
    overlays = []
    for done, (part, one, two) in enumerate(pairs):
        progress(done / len(pairs), f"registering part {part + 1} of {two} to {one}")
        overlays.append(_overlay(part, (one, two), surfaces, matches, params))
    result = dict(aspects)
    used = [overlay for overlay in overlays if overlay.is_used]
    for group in _together(used):
        common = synchronised(_table(group, used))
        own = [surfaces[key] for key in group]
        for k, key in enumerate(group):
            back = np.linalg.inv(common[k])
            seen = [own[k].thickness(surface, back @ common[m]) for m, surface in enumerate(own)]
            result[key] = corrected(aspects[key], own[k], np.mean(seen, axis=0) - own[k].heights)
    return result, overlays


def _overlay(
    part: int,
    names: tuple[str, str],
    surfaces: Mapping[tuple[str, int], AspectSurface],
    matches: Sequence[PartMatches],
    params: Registration,
) -> Overlay:
    first, second = (surfaces[name, part] for name in names)
    start = None
    for match in matches:
        if match.part == part and set(match.images) == set(names):
            start = match_start(first, second, match.points if match.images == names else match.points[:, ::-1])
    found = register(first, second, params, start)
    before, after = first.seen(second, found.start), first.seen(second, found.transform)
    is_used = found.residual <= MOST_RESIDUAL
    return Overlay(part, names, found.transform, found.residual, is_used, first.heights, before, after)


def _together(overlays: Sequence[Overlay]) -> list[list[tuple[str, int]]]:
    """Keys of aspects that hang together by pairs."""
    groups: list[list[tuple[str, int]]] = []
    for overlay in overlays:
        keys = [(name, overlay.part) for name in overlay.images]
        touched = [group for group in groups if any(key in group for key in keys)]
        joined = list(dict.fromkeys([key for group in touched for key in group] + keys))
        groups = [group for group in groups if group not in touched] + [joined]
    return groups


def _table(group: Sequence[tuple[str, int]], overlays: Sequence[Overlay]) -> list[list[np.ndarray | None]]:
    """Pairwise transforms i_from_j of a group, as `synchronised` takes them."""
    table: list[list[np.ndarray | None]] = [[None] * len(group) for _ in group]
    for overlay in overlays:
        one, two = ((name, overlay.part) for name in overlay.images)
        if one in group:
            i, j = group.index(one), group.index(two)
            table[i][j], table[j][i] = overlay.transform, np.linalg.inv(overlay.transform)
    return table


def corrected(aspect: Aspect, surface: AspectSurface, change: np.ndarray) -> Aspect:
    """The aspect with a change (h, w), in the surface's picture, added to its heights, at 0 or above."""
    rows, columns = aspect.picture.shape
    left, top = surface.corner
    low = max(top, 0), max(left, 0)
    high = min(top + change.shape[0], rows), min(left + change.shape[1], columns)
    picture = aspect.picture.copy()
    inside = slice(low[0], high[0]), slice(low[1], high[1])
    picture[inside] += change[low[0] - top : high[0] - top, low[1] - left : high[1] - left].astype(np.float32)
    picture = np.maximum(picture, np.float32(0))
    return replace(aspect, picture=picture, mask=picture > 0)

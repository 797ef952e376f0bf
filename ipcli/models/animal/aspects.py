"""Aspects: a part's mask in one image, lifted to a closed surface by finite elements (thesis 6.3.1, algorithm 6.1)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ipcli.geometry.triangulation import reflect, triangulate_mask
from ipcli.inverse.regularize import finite_elements
from ipcli.measurements.part_images import PartImage, PartTree
from ipcli.models.animal.loads import load
from ipcli.models.animal.parameters import Inflation
from ipcli.progress import Progress, silent

LEAST_SHARE = 0.25  # of the pixels of a part in its largest mask
LEAST_PIXELS = 12  # of a mask that can be triangulated
CAP = 0.25  # of the length of a cut: how far a part is carried on across it
CUT_MARGIN = 1  # pixels between two parts that still count as touching


@dataclass(frozen=True, eq=False)
class Aspect:
    """Half thickness over a mask, in pixels of its image: a triangulation and the same as a picture."""

    points: np.ndarray  # (n, 2) column, row
    triangles: np.ndarray  # (m, 3)
    heights: np.ndarray  # (n,)
    mask: np.ndarray  # (h, w) bool: the mask that was lifted, with what was added where other parts cut or hide it
    picture: np.ndarray  # (h, w) float32 heights of all pixels, 0 outside

    def surface(self) -> tuple[np.ndarray, np.ndarray]:
        """The closed surface: vertices (k, 3) of (column, row, height) and faces."""
        return reflect(self.points, self.triangles, self.heights)


def inflate(mask: np.ndarray, params: Inflation, flatness: float = 1.0) -> Aspect:
    """Lift the largest blob of a mask (h, w) bool; heights are divided by `flatness`.

    sqrt-poisson is the root of a membrane under a constant load (Baran and Lehtinen 2009): a strip becomes a round
    limb. The others are the membrane (or plate, with `bending`) itself under the load of (6.4) in one of its forms.
    """
    from scipy.ndimage import binary_fill_holes

    spacing = max(np.sqrt(2.3 * mask.sum() / params.triangles), 0.8)
    points, triangles = triangulate_mask(mask, spacing, params.smoothing)
    lifting = load(binary_fill_holes(mask), params)  # as the triangulation is
    if params.bending > 0:
        bending = (params.bending * _largest_radius(mask)) ** 2
        heights = finite_elements.plate(points, triangles, lifting, bending, 1.0)
    else:
        heights = finite_elements.membrane(points, triangles, lifting)
    lifted = np.maximum(heights, 0.0)
    picture = _picture(points, lifted, mask.shape)
    if params.load == "sqrt-poisson":  # between the points the membrane is interpolated: its root is steep at the rim
        lifted, picture = np.sqrt(lifted), np.sqrt(picture)
    return Aspect(points, triangles, lifted / flatness, mask, picture / np.float32(flatness))


def lift_all(
    images: Sequence[PartImage],
    tree: PartTree,
    params: Inflation,
    progress: Progress = silent,
) -> dict[tuple[str, int], Aspect]:
    """The aspects of all parts in all images that are to give them their shape, by name of image and part.

    An image that shows less than a quarter as many pixels of a part as another does is passed over.
    """
    work = []
    for part in range(len(tree)):
        areas = [int(image.mask(part).sum()) if image.gives(part) else 0 for image in images]
        least = max(LEAST_PIXELS, LEAST_SHARE * max(areas))
        work += [(image, part) for image, area in zip(images, areas, strict=True) if area >= least]
    aspects = {}
    for done, (image, part) in enumerate(work):
        progress(done / len(work), f"{tree.names[part]} in {image.name}")
        try:
            mask = completed(image.mask(part), image.silhouette)
            aspects[image.name, part] = inflate(mask, params, tree.flatness[part])
        except ValueError:  # too thin for a triangle: the other views alone tell of it
            continue
    return aspects


def _largest_radius(mask: np.ndarray) -> float:
    from scipy.ndimage import distance_transform_edt

    return float(distance_transform_edt(np.pad(mask, 1)).max())


def _picture(points: np.ndarray, heights: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    from scipy.interpolate import LinearNDInterpolator

    picture = np.zeros(shape, np.float32)
    low = np.maximum(np.floor(points.min(axis=0)).astype(int), 0)
    high = np.minimum(np.ceil(points.max(axis=0)).astype(int) + 1, [shape[1], shape[0]])
    u, v = np.meshgrid(np.arange(low[0], high[0]), np.arange(low[1], high[1]))
    picture[low[1] : high[1], low[0] : high[0]] = LinearNDInterpolator(points, heights, fill_value=0.0)(u, v)
    return picture


def completed(own: np.ndarray, silhouette: np.ndarray) -> np.ndarray:
    """A part's mask with what other parts probably hide of it, (h, w) bool.

    Notches narrower than the part are closed, as far as other parts cover them. Across each edge that it shares with
    another part a cap a quarter as deep as the edge is long is added: the edge is a cut and no contour, and a surface
    that came down to it would pinch the joint.
    """
    if not own.any():
        return own
    around = _around(own)
    near, hidden = own[around], (silhouette & ~own)[around]
    whole = own.copy()
    whole[around] |= hidden & (_closed(near) | _caps(near, hidden))
    return whole


def _around(own: np.ndarray) -> tuple[slice, slice]:
    """The box of a mask with as much around it as a closing or a cap may add."""
    rows, columns = np.nonzero(own)
    margin = 2 + int(max(np.ptp(rows), np.ptp(columns)))
    down, across = (slice(max(int(at.min()) - margin, 0), int(at.max()) + margin + 1) for at in (rows, columns))
    return down, across


def _closed(own: np.ndarray) -> np.ndarray:
    """Closing with a disc as large as the largest that fits."""
    from scipy.ndimage import binary_fill_holes, distance_transform_edt

    radius = int(np.ceil(_largest_radius(own)))
    grown = distance_transform_edt(~np.pad(own, radius + 1)) <= radius
    shrunk = distance_transform_edt(grown) > radius
    return binary_fill_holes(shrunk)[radius + 1 : -radius - 1, radius + 1 : -radius - 1]


def _caps(own: np.ndarray, hidden: np.ndarray) -> np.ndarray:
    """Caps over the cuts: pixels within a share of the length of a shared edge."""
    from scipy.ndimage import binary_dilation, distance_transform_edt, label

    cut = own & binary_dilation(hidden, np.ones((3, 3), bool), CUT_MARGIN)
    edges, count = label(cut, np.ones((3, 3)))
    caps = np.zeros(own.shape, bool)
    for edge in range(1, count + 1):
        rows, columns = np.nonzero(edges == edge)
        extent = max(np.ptp(rows), np.ptp(columns)) + 1
        if extent >= 3:
            away = distance_transform_edt(edges != edge)
            caps |= away <= CAP * extent
    return caps

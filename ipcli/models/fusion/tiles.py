"""The fusion of a large map tile by tile: memory is then that of one tile's observations, one view a thread and the
map.

A tile is fused with a margin that is thrown away. The noise scale and lambda are those of the whole map, from windows
spread over it. What the data of a pixel say dies away within some ten pixels; only holes wider than the margin may be
filled otherwise.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import islice, product

import numpy as np

from ipcli.errors import NoSolution
from ipcli.inverse.regularize.fidelity import Observations
from ipcli.measurements.views import View
from ipcli.models.fusion.fuse import (
    Fused,
    PassScale,
    balanced_lambda,
    first_pass,
    fuse_layers,
    fuse_unfilled,
    passes_after_first,
    with_holes_filled,
)
from ipcli.models.fusion.holes import UNSEEN
from ipcli.models.fusion.observations import Normalised, measure
from ipcli.models.fusion.parameters import METHODS, Fusion
from ipcli.models.fusion.reassociation import reassociate
from ipcli.models.fusion.reprojection import Layers, reproject_all
from ipcli.models.fusion.windows import Excerpts, Landing, Part, Window, tiles
from ipcli.progress import Progress, silent

MARGIN = 64  # pixels around a tile
EVERY = 4  # so many-th rows and columns are kept of what each view said; divides the side of a tile
WINDOW = 256  # pixels along a side of a window, of which there are WINDOWS x WINDOWS
WINDOWS = 3


def fuse_in_tiles(
    views: Sequence[View],
    reference: View,
    fusion: Fusion,
    side: int,
    *,
    inverse: bool,
    progress: Progress = silent,
    part: Part | None = None,
) -> Fused:
    """As `fuse`, tile by tile. A tile that nothing reaches stays NaN.

    Each view is asked for once as a whole, and then for every tile its rectangle that may land there, by `part` if that
    can read it. `layers` keeps every 4th row and column; the history is that of the tile with the largest gap.
    """
    read = part or (lambda k, window: window.camera(views[k]))
    landings = [Landing.of(views[k], reference) for k in range(len(views))]
    excerpts = partial(Excerpts, read, landings)
    shape, scales = reference.depth.shape, survey(excerpts, reference, fusion, side, inverse=inverse)
    whole, windows = empty(len(views), shape, scales[-1]), tiles(shape, side)
    for done, window in enumerate(windows):
        progress(0.1 + 0.8 * done / len(windows), f"fusing tile {done + 1} of {len(windows)}")
        wide = window.wider(MARGIN)
        try:
            own = fuse_unfilled(excerpts(wide), wide.camera(reference), fusion, inverse=inverse, scales=scales)
        except NoSolution:
            continue
        inner = window.within(wide)
        for name in ("depth", "filled", "confidence", "uncertainty", "normals", "observations", "mean", "median"):
            window.of(getattr(whole, name))[:] = inner.of(getattr(own, name))
        kept = own.layers[
            :, inner.rows.start : inner.rows.stop : EVERY, inner.columns.start : inner.columns.stop : EVERY
        ]
        top, left = window.rows.start // EVERY, window.columns.start // EVERY
        whole.layers[:, top : top + kept.shape[1], left : left + kept.shape[2]] = kept
        if len(own.history) and (not len(whole.history) or own.history[-1, 3] > whole.history[-1, 3]):
            whole = replace(whole, history=own.history)
    return with_holes_filled(whole, reference, fusion, inverse=inverse)


def empty(k: int, shape: tuple[int, int], scale: PassScale) -> Fused:
    """A map of which nothing is known yet."""

    def nothing() -> np.ndarray:
        return np.full(shape, np.nan, np.float32)

    kept = np.full((k, *(-(-n // EVERY) for n in shape)), np.nan, np.float32)
    return Fused(
        nothing(),
        np.full(shape, UNSEEN, np.uint8),
        np.zeros(shape, np.float32),
        nothing(),
        np.full((*shape, 3), np.nan, np.float32),
        np.zeros(shape, np.uint16),
        nothing(),
        nothing(),
        kept,
        scale.lam,
        scale.units.scale,
        np.empty((0, 5)),
        EVERY,
    )


def survey(
    excerpts: Callable[[Window], Excerpts], reference: View, fusion: Fusion, side: int, *, inverse: bool
) -> list[PassScale]:
    """The scale of each pass, from windows spread over the map, or from the first tile that sees anything if they do
    not.
    """
    shape = reference.depth.shape
    corners = [sorted({(n - min(WINDOW, n)) * i // (WINDOWS - 1) for i in range(WINDOWS)}) for n in shape]
    spread = [
        Window(*(slice(at, at + min(WINDOW, n)) for at, n in zip(corner, shape, strict=True)))
        for corner in product(*corners)
    ]
    seen = list(_seen(excerpts, reference, spread))
    seen = seen or list(islice(_seen(excerpts, reference, tiles(shape, side)), 1))
    if not seen:
        raise NoSolution(
            "no view has a valid depth inside the reference view: check the poses, their direction and the unit"
        )
    scales: list[PassScale] = []
    now = [layers for _, _, layers in seen]
    for done in range(passes_after_first(fusion) + 1):
        if done:
            for i, (views, camera, forward) in enumerate(seen):
                end = fuse_layers(now[i], camera, first_pass(fusion), inverse=inverse, scale=scales[-1]).end
                now[i] = reassociate(end.depth, views, camera, forward, end.units)
        scales.append(_scale(now, fusion, inverse))
    return scales


def _seen(
    excerpts: Callable[[Window], Excerpts], reference: View, windows: Sequence[Window]
) -> Iterator[tuple[Excerpts, View, Layers]]:
    """What of the views, the cameras of the windows that a view reaches, and what the views say there."""
    for window in windows:
        camera, views = window.camera(reference), excerpts(window)
        layers = reproject_all(views, camera)
        if np.isfinite(layers.depth).any():
            yield views, camera, layers


def _scale(windows: Sequence[Layers], fusion: Fusion, inverse: bool) -> PassScale:
    """Units and lambda of the observations of windows of one shape."""
    depth = np.concatenate([layers.depth for layers in windows], axis=1)
    weights = None
    if fusion.confidence.given and windows[0].confidence is not None:
        weights = np.concatenate([layers.confidence for layers in windows], axis=1)
    units = measure(depth, weights, inverse=inverse)
    if fusion.lam is not None:
        return PassScale(units, fusion.lam)
    return PassScale(
        units, balanced_lambda(Observations.of(Normalised(units, depth, weights), weights), METHODS[fusion.method])
    )

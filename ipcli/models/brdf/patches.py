"""What small patches say of their normals, given the reflectance map (thesis 7.4.3, in the order that works).

With light and material unknown a patch says almost nothing of its normal. Once the map is found, generated surfaces are
seen through it, a tree of mixtures is learnt from their patches, and its posterior mean normals join those of the prior
shape, each as sure as it is.
"""

from __future__ import annotations

import numpy as np

from ipcli.models.brdf import tree
from ipcli.models.brdf.energy import cell_normals
from ipcli.models.brdf.grid import Grid, grid
from ipcli.models.brdf.parameters import Patches
from ipcli.models.brdf.reflectance import Map
from ipcli.models.brdf.scenes import surface
from ipcli.models.brdf.solid import Pictured
from ipcli.rng import stream

NOISE = 0.01


def posterior(picture: Pictured, reflectance: Map, albedo: np.ndarray, params: Patches) -> tree.PatchPosterior:
    """The posterior at each cell (c) of a picture whose map and albedo (c,) are known; nothing is known at the edge."""
    look, hidden, normals = _lesson(reflectance, max(picture.grid.mask.shape), params)
    mean = look.mean(axis=0)
    axes = np.linalg.svd(look - mean, full_matrices=False)[2][: params.components]
    learnt = tree.learn(
        hidden, (look - mean) @ axes.T, normals, stream(0, "patches", "tree"), (6, 8, 8)[-len(hidden) - 1 :]
    )
    seen, whole = cut(picture.grid, picture.intensity / albedo, params.side)
    said = tree.posterior(learnt, (seen - mean) @ axes.T)
    n, length, evidence = np.tile([0.0, 0.0, 1.0], (len(whole), 1)), np.zeros(len(whole)), np.full(len(whole), np.nan)
    n[whole], length[whole], evidence[whole] = said.normals, said.concentration, said.evidence
    return tree.PatchPosterior(n, length, evidence)


def joined(prior: np.ndarray, said: tree.PatchPosterior, params: Patches) -> np.ndarray:
    """Normals (c, 3) of the product of two von Mises-Fisher densities: that about the prior's, and that of the
    patches.

    A balloon errs least where it faces the viewer. Patches are as sure as their posterior's mean is long, r, and as the
    map allows: 1 / kappa = (1 - r^2) / (r (3 - r^2)) + 1 / most, the first as Banerjee et al. have it (JMLR 2005).
    """
    r = np.minimum(said.concentration, 1.0)
    told = r * (3 - r * r)
    sure = told / (1 - r * r + told / params.most)
    total = params.balloon * prior[:, 2:] ** 2 * prior + sure[:, None] * said.normals
    return total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-12)


def _lesson(reflectance: Map, side: int, params: Patches) -> tuple[np.ndarray, list[np.ndarray], np.ndarray]:
    """Looks (n, side^2), what is hidden (slopes about, normals) and normals (n, 3) of patches of generated solids."""
    looks, about, normals = [], [], []
    for number in range(params.surfaces):
        rng = stream(0, "patches", str(number))
        made = surface(rng, side, sheets=0.0)
        cells = grid(made.mask)
        n = cell_normals(cells, made.height[made.mask])
        shade = reflectance.slopes(n)[0] + NOISE * rng.normal(size=len(n))
        look, whole = cut(cells, shade, params.side)
        if not len(look):
            continue
        chosen = rng.choice(len(look), min(params.each, len(look)), replace=False)
        around = np.concatenate([cut(cells, n[:, axis], params.side)[0] for axis in (0, 1)], axis=1)
        looks.append(look[chosen])
        about.append(around[chosen])
        normals.append(n[whole][chosen])
    every = np.concatenate(about)
    axes = np.linalg.svd(every - every.mean(axis=0), full_matrices=False)[2][:4]
    of = np.concatenate(normals)
    return np.concatenate(looks), [every @ axes.T, of], of


def cut(cells: Grid, values: np.ndarray, side: int) -> tuple[np.ndarray, np.ndarray]:
    """Patches (m, side^2) of values (c,) around those cells (c,) bool whose patch is whole."""
    rows, columns = np.divmod(np.flatnonzero(cells.mask)[cells.corners[:, 0]], cells.mask.shape[1])
    half = side // 2
    image = np.full((cells.mask.shape[0] + 2 * half, cells.mask.shape[1] + 2 * half), np.nan)
    image[rows + half, columns + half] = values
    windows = np.lib.stride_tricks.sliding_window_view(image, (side, side))[rows, columns].reshape(len(rows), -1)
    whole = np.isfinite(windows).all(axis=1)
    return windows[whole], whole

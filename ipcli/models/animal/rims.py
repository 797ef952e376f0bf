"""Mean curvature flow inside a visual hull that keeps every silhouette covered.

The flow (6.9) rounds what the hull leaves square, and would draw the surface off the rims that the images prove. After
each step the field is lowered along every ray of a silhouette until the ray meets the surface again as near to the rim
as its pixel is.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ipcli.geometry.level_sets import STABLE, curvature_speed
from ipcli.geometry.voxels import FAR, Sight

DEEP = 1.5  # voxels behind the rim beyond which a ray need only meet the surface at that depth


def round_off(
    phi: np.ndarray,
    hull: np.ndarray,
    sights: Sequence[Sight],
    rims: Sequence[np.ndarray],
    steps: int,
    reach: float = np.inf,
) -> np.ndarray:
    """The field (nx, ny, nz) after `steps` explicit steps of flow, within `hull`, with all rims kept.

    `rims` are the fields of the silhouettes, each as `Sight.silhouette_distance` gives it; `reach` as `keep_rims` takes
    it. All in voxels.
    """
    wanted = [wanted_depth(sight, rim) for sight, rim in zip(sights, rims, strict=True)]
    phi = np.maximum(phi, hull)
    for _ in range(steps):
        phi = np.maximum(phi + np.float32(STABLE) * curvature_speed(phi), hull)
        phi = keep_rims(phi, hull, sights, wanted, reach)
    return phi


def wanted_depth(sight: Sight, rim: np.ndarray) -> np.ndarray:
    """For each ray the value that the field must fall to on it; FAR for rays beside the silhouette."""
    least = sight.least(rim)
    return np.where(least < 0, np.maximum(least, -DEEP), FAR)


def keep_rims(
    phi: np.ndarray,
    hull: np.ndarray,
    sights: Sequence[Sight],
    wanted: Sequence[np.ndarray],
    reach: float = np.inf,
) -> np.ndarray:
    """The field lowered along the rays of each camera that do not reach the wanted depth, but not beyond the hull.

    A ray is lowered less and less away from where it comes nearest to the surface, and not at all from `reach` voxels
    on; as a whole, it makes everything beside it thicker.
    """
    for sight, want in zip(sights, wanted, strict=True):
        least = sight.least(phi)
        lack = np.where(want < FAR, least - want, 0.0)
        lower = np.clip(lack, 0, None).astype(np.float32)
        lower[lack > FAR / 2] = 0  # no point of the grid lies on the ray
        if not lower.any():
            continue
        lowered = lower[sight.ray]
        if np.isfinite(reach):
            nearest = sight.least(sight.depth, (lowered > 0) & (phi <= least[sight.ray]))
            away = np.abs(sight.depth - nearest[sight.ray])
            lowered *= np.clip(1 - away / np.float32(reach), 0, None)
        phi = np.maximum(phi - lowered, hull)
    return phi

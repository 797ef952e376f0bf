"""Dense 2.5D registration of two aspects of one part (thesis 6.3.2, algorithm 6.2, (6.7), (6.8)).

An aspect is a closed surface over its image: points (column, row, depth) in pixels, the depth growing away from the
viewer and 0 in the plane of the mask, so that the near side lies at -height. A transform between two aspects is a map
of such points, (4, 4), a similarity or affine. Both ways are compared, the second aspect as the first one's image shows
it and the first as the second's does, so that it does not matter which is the reference. Beside a part its height is 0;
otherwise it would be best to shrink the other to nothing.

Each step is the box-constrained linear problem of `inverse.regularize.least_absolute`, taken by composition,
T <- exp(dxi) T, and only if the deviation (6.7) itself falls.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ipcli.geometry.alignment import align
from ipcli.geometry.lie import affine_exp, affine_log
from ipcli.geometry.orthographic import Orthographic
from ipcli.geometry.part_masks import first_faces
from ipcli.inverse.regularize.least_absolute import primal_dual, reweighted
from ipcli.models.animal.parameters import Registration

LEVELS = (8, 4, 2, 1)  # pixels between the samples of a level, each a Gaussian of half as many
MARGIN = 8  # pixels around a part in which the other is looked for
ANGLES = 24  # turns within the image that are tried for a start
STEPS = 12  # linear problems a level at the most
LEAST_STEP = 0.02  # pixels a sample; a smaller box ends a level
LEAST_MATCHES = 4  # that give a start in space (the thesis: more than 3)


@dataclass(frozen=True, eq=False)
class AspectSurface:
    """A closed surface in the pixels of an image: vertices (n, 3), faces (m, 3), and its heights as the image shows
    them from the pixel `corner` (column, row) on.
    """

    vertices: np.ndarray
    faces: np.ndarray
    corner: np.ndarray
    heights: np.ndarray  # (h, w)

    @classmethod
    def of(cls, vertices: np.ndarray, faces: np.ndarray) -> AspectSurface:
        """The surface with a picture of itself, some pixels larger than it."""
        low, high = vertices[:, :2].min(axis=0), vertices[:, :2].max(axis=0)
        corner = np.floor(low).astype(int) - MARGIN
        columns, rows = np.ceil(high).astype(int) + MARGIN + 1 - corner
        return cls(vertices, faces, corner, rendered(vertices, faces, corner, (int(rows), int(columns))))

    @property
    def middle(self) -> np.ndarray:
        """(3,), of its volume seen from the front."""
        rows, columns = np.mgrid[: self.heights.shape[0], : self.heights.shape[1]]
        total = self.heights.sum()
        at = [float((grid * self.heights).sum() / total) for grid in (columns, rows)]
        return np.array([at[0] + self.corner[0], at[1] + self.corner[1], 0.0])

    def seen(self, other: AspectSurface, transform: np.ndarray) -> np.ndarray:
        """Heights (h, w) of another surface in this one's picture, its points mapped by `transform`."""
        moved = other.vertices @ transform[:3, :3].T + transform[:3, 3]
        return rendered(moved, other.faces, self.corner, self.heights.shape)

    def thickness(self, other: AspectSurface, transform: np.ndarray) -> np.ndarray:
        """Half thickness (h, w) of another surface in this one's picture, wherever the plane of its mask went."""
        behind = np.diag([1.0, 1.0, -1.0, 1.0]) @ transform
        return (self.seen(other, transform) + self.seen(other, behind)) / 2


@dataclass(frozen=True, eq=False)
class Registered:
    """first_from_second (4, 4), the start that it was found from, and the deviation (6.7) that is left in both images
    over the sum of both surfaces' heights.
    """

    transform: np.ndarray
    start: np.ndarray
    residual: float


def rendered(vertices: np.ndarray, faces: np.ndarray, corner: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """Heights (h, w) float64 of the near side of a closed surface above the plane of the mask; 0 beside it."""
    camera = Orthographic(np.eye(3), 1.0, -corner.astype(np.float64))
    _, depth = first_faces(vertices, faces, camera, shape)
    return np.nan_to_num(-depth.astype(np.float64), nan=0.0)


def generators(group: str, middle: np.ndarray, radius: float) -> np.ndarray:
    """A basis (k, 4, 4) of the algebra of a group: 3 shifts, then 3 turns and the scale, or all 9 linear maps, about
    `middle`; each moves a point `radius` away by one pixel.
    """
    if group == "similarity":
        turns = np.array([[[0, 0, 0], [0, 0, -1], [0, 1, 0]], [[0, 0, 1], [0, 0, 0], [-1, 0, 0]],
                          [[0, -1, 0], [1, 0, 0], [0, 0, 0]]], np.float64)  # fmt: skip
        linear = np.concatenate([turns, np.eye(3)[None]])
    else:
        linear = np.eye(9).reshape(9, 3, 3)
    basis = np.zeros((3 + len(linear), 4, 4))
    basis[:3, :3, 3] = np.eye(3)
    basis[3:, :3, :3] = linear / radius
    basis[3:, :3, 3] = -linear @ middle / radius
    return basis


def jacobian(heights: np.ndarray, corner: np.ndarray, basis: np.ndarray) -> np.ndarray:
    """Derivatives (k, h, w) of a picture of heights as the surface moves along each element (k, 4, 4) of an algebra.

    The point (u, v, -d) moves by V; the picture changes by -V_z - d_u V_u - d_v V_v.
    """
    rows, columns = np.mgrid[: heights.shape[0], : heights.shape[1]]
    points = np.stack([columns + corner[0], rows + corner[1], -heights, np.ones_like(heights)])
    velocity = np.einsum("kab,bhw->kahw", basis[:, :3], points)
    along_rows, along_columns = np.gradient(heights)
    return -velocity[:, 2] * (heights > 0) - along_columns * velocity[:, 0] - along_rows * velocity[:, 1]


def deviations(first: AspectSurface, second: AspectSurface, transform: np.ndarray, step: int) -> np.ndarray:
    """p (n,) of (6.8) in both pictures, blurred and sampled every `step` pixels."""
    one = first.seen(second, transform) - first.heights
    two = second.seen(first, np.linalg.inv(transform)) - second.heights
    return np.concatenate([_sampled(one, step), _sampled(two, step)])


def linearised(
    first: AspectSurface, second: AspectSurface, transform: np.ndarray, basis: np.ndarray, step: int
) -> tuple[np.ndarray, np.ndarray]:
    """p (n,) and J (n, k) of (6.8) for T = exp(sum x_i basis_i) transform, in both pictures.

    The inverse transform moves by exp(-T^-1 dxi T) on the left.
    """
    back = np.linalg.inv(transform)
    one, two = first.seen(second, transform), second.seen(first, back)
    slopes = jacobian(one, first.corner, basis), jacobian(two, second.corner, -back @ basis @ transform)
    p = np.concatenate([_sampled(one - first.heights, step), _sampled(two - second.heights, step)])
    columns = [np.concatenate([_sampled(a, step), _sampled(b, step)]) for a, b in zip(*slopes, strict=True)]
    return p, np.stack(columns, axis=1)


def _sampled(picture: np.ndarray, step: int) -> np.ndarray:
    from scipy.ndimage import gaussian_filter

    return gaussian_filter(picture, step / 2, mode="constant")[::step, ::step].ravel() if step > 1 else picture.ravel()


def register(
    first: AspectSurface, second: AspectSurface, params: Registration, start: np.ndarray | None = None
) -> Registered:
    """Register the second surface to the first, from a start (4, 4) or from the outlines, coarse to fine."""
    from_outlines = outline_start(first, second) if start is None else start
    radius = max(float(np.sqrt((first.heights > 0).sum() / np.pi)), 1.0)
    basis = generators(params.group, first.middle, radius)
    solve: Callable[..., np.ndarray] = primal_dual if params.method == "primal-dual" else reweighted
    transform = from_outlines
    for step in (level for level in LEVELS if level == 1 or 3 * level <= radius):
        transform = _level(first, second, transform, basis, step, solve)
    left = float(np.abs(deviations(first, second, transform, 1)).sum())
    return Registered(transform, from_outlines, left / float(first.heights.sum() + second.heights.sum()))


def _level(
    first: AspectSurface,
    second: AspectSurface,
    transform: np.ndarray,
    basis: np.ndarray,
    step: int,
    solve: Callable[..., np.ndarray],
) -> np.ndarray:
    """The transform after the steps of one level: the box is halved when a step does not lessen the deviation."""
    bound = float(step)
    p, slopes = linearised(first, second, transform, basis, step)
    for _ in range(STEPS):
        told = slopes.any(axis=1)  # the other samples change with nothing
        moved = solve(p[told], slopes[told], bound)
        trial = affine_exp(np.tensordot(moved, basis, 1)) @ transform
        if np.abs(deviations(first, second, trial, step)).sum() < np.abs(p).sum():
            transform = trial
            p, slopes = linearised(first, second, transform, basis, step)
            bound = min(bound, 2 * float(np.abs(moved).max()))
        else:
            bound = min(bound, float(np.abs(moved).max())) / 2
        if bound < LEAST_STEP * step:
            break
    return transform


def outline_start(first: AspectSurface, second: AspectSurface) -> np.ndarray:
    """The similarity within the image that lays middle on middle, area on area, turned as fits both pictures best."""
    scale = float(np.sqrt((first.heights > 0).sum() / (second.heights > 0).sum()))
    found = []
    for angle in 2 * np.pi * np.arange(ANGLES) / ANGLES:
        transform = np.eye(4)
        transform[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
        transform[:3, :3] *= scale
        transform[:3, 3] = first.middle - transform[:3, :3] @ second.middle
        found.append((float(np.abs(deviations(first, second, transform, 4)).sum()), transform))
    return min(found, key=lambda pair: pair[0])[1]


def match_start(first: AspectSurface, second: AspectSurface, matches: np.ndarray) -> np.ndarray:
    """The similarity that carries matched pixels (n, 2, 2), of the first and the second image as (column, row), lifted
    to the surfaces, onto each other. ValueError for fewer than four.
    """
    if len(matches) < LEAST_MATCHES:
        raise ValueError(f"{len(matches)} matches; a start takes {LEAST_MATCHES}")
    one, two = (_lifted(surface, matches[:, k]) for k, surface in enumerate((first, second)))
    return align(two, one, with_scale=True).matrix


def _lifted(surface: AspectSurface, pixels: np.ndarray) -> np.ndarray:
    from scipy.ndimage import map_coordinates

    at = (pixels - surface.corner).T[::-1]
    return np.column_stack([pixels, -map_coordinates(surface.heights, at, order=1)])


def synchronised(pairs: Sequence[Sequence[np.ndarray | None]], rounds: int = 6) -> list[np.ndarray]:
    """common_from_k (4, 4) of each aspect from the pairwise transforms pairs[i][j] = i_from_j, None where not known.

    Least squares over the pairs' logarithms log(X_i T_ij X_j^-1) in the common frame, by Gauss-Newton steps
    exp(s_i) X_i: no aspect is the reference. ValueError if they do not all hang together.
    """
    known = [(i, j, transform) for i, row in enumerate(pairs) for j, transform in enumerate(row)
             if i != j and transform is not None]  # fmt: skip
    reached = {0: np.eye(4)}
    for _ in pairs:
        for i, j, transform in known:
            if i in reached and j not in reached:
                reached[j] = reached[i] @ transform
    if len(reached) < len(pairs):
        raise ValueError("aspects that no pair connects")
    common = [reached[k] for k in range(len(pairs))]
    laplacian = np.zeros((len(pairs), len(pairs)))
    for i, j, _ in known:
        laplacian[i, i] += 1
        laplacian[i, j] -= 1
    for _ in range(rounds):
        asked = np.zeros((len(pairs), 4, 4))
        for i, j, transform in known:
            asked[i] += affine_log(common[i] @ transform @ np.linalg.inv(common[j]))
        steps = -np.tensordot(np.linalg.pinv(laplacian), asked, 1)
        common = [affine_exp(step) @ own for step, own in zip(steps, common, strict=True)]
    return common

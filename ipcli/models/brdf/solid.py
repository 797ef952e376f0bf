"""A solid from its own picture: the silhouette is an occluding rim, and the light is found with the shape (self-
calibration).

The prior shape is the inflated silhouette. In turn, the reflectance map is fitted to the picture as harmonics of order
2 on the normals of the present shape, and the shape is moved by Gauss-Newton on the energy given the map.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ipcli.models.brdf.energy import ShadedProblem, cell_normals, energy, gauss_newton
from ipcli.models.brdf.grid import Grid, grid, inflate
from ipcli.models.brdf.parameters import Solid
from ipcli.models.brdf.reflectance import BANDS, Harmonics, harmonic_basis

REWEIGHTINGS = 8


@dataclass(frozen=True, eq=False)
class Pictured:
    """A picture on the grid of inference."""

    grid: Grid
    intensity: np.ndarray  # (c,) grey on the cells, over its 95th percentile
    colour: np.ndarray  # (n, 3) linear, on the pixels
    inflated: np.ndarray  # (n,) height of the balloon of the mask, pixels of the grid


@dataclass(frozen=True, eq=False)
class Shape:
    """A height field with the map that explains the picture."""

    height: np.ndarray  # (n,)
    reflectance: Harmonics
    omega: float  # weight of the shading: 1 when the first fit was good
    residual: float  # mean |I - R(n)| of the last fit
    energy: float
    albedo: np.ndarray  # (c,) factor of each cell
    is_concave: bool  # whether the prior shape is hollow


def pictured(colour: np.ndarray, mask: np.ndarray, side: int) -> Pictured:
    """A linear picture (h, w, 3) and its mask (h, w), made small so that the longest side of the mask has `side`
    pixels.
    """
    small, small_mask = shrink(colour, mask, side)
    of_mask = grid(small_mask)
    values = small[small_mask]
    intensity = of_mask.on_cells(values.mean(axis=1))
    scale = max(float(np.percentile(intensity, 95)), 1e-9) if len(intensity) else 1.0
    return Pictured(of_mask, intensity / scale, values / scale, inflate(small_mask)[small_mask])


def shrink(colour: np.ndarray, mask: np.ndarray, side: int) -> tuple[np.ndarray, np.ndarray]:
    """Picture and mask at the size of inference, averaged over the mask only; never enlarged. Cropped to the mask by
    the caller.
    """
    import cv2

    h, w = mask.shape
    factor = min(1.0, side / max(h, w))
    size = (max(2, round(w * factor)), max(2, round(h * factor)))
    weight = cv2.resize(mask.astype(np.float64), size, interpolation=cv2.INTER_AREA)
    sums = cv2.resize(np.where(mask[..., None], colour, 0.0).astype(np.float64), size, interpolation=cv2.INTER_AREA)
    return sums / np.maximum(weight, 1e-6)[..., None], weight > 0.5


def fit_harmonics(intensity: np.ndarray, normals: np.ndarray, ridge: float, width: float = 0.03) -> Harmonics:
    """Harmonics that explain intensities (c,) at normals (c, 3): robust least squares with a ridge on all but the
    constant.
    """
    basis = harmonic_basis(normals)
    hold = ridge * len(basis) * np.diag([0.0] + [1.0] * (BANDS - 1)) + 1e-9 * np.eye(BANDS)
    weight = np.ones(len(basis))
    c = np.zeros(BANDS)
    for _ in range(REWEIGHTINGS):
        c = np.linalg.solve((basis.T * weight) @ basis + hold, basis.T @ (weight * intensity))
        weight = 1 / np.maximum(1, np.abs(intensity - basis @ c) / width)
    return Harmonics(c)


def solid(
    picture: Pictured,
    params: Solid,
    prior: np.ndarray | None = None,
    start: np.ndarray | None = None,
    prior_normals: np.ndarray | None = None,
    omega: float = 0.0,
) -> Shape:
    """The surface of a solid. `prior` (n,) replaces the balloon, `start` (n,) where the steps begin, `prior_normals`
    (c, 3) the normals of the prior, `omega` the weight of the shading that else follows from the first fit.
    """
    prior = picture.inflated if prior is None else prior
    height = prior if start is None else start
    labels = colours(picture, params.albedos)
    n0 = cell_normals(picture.grid, prior) if prior_normals is None else prior_normals
    problem = ShadedProblem(picture.grid, picture.intensity, prior, n0, params.weights)
    for turn in range(params.rounds + 1):
        n = cell_normals(picture.grid, height)
        flat, albedo = without_albedo(picture.intensity, n, labels, params.ridge)
        problem = replace(problem, intensity=flat)
        reflectance = fit_harmonics(flat, n, params.ridge)
        residual = float(np.abs(flat - reflectance.slopes(n)[0]).mean())
        omega = omega or min(1.0, params.residual / max(residual, 1e-9))
        steps = params.steps if turn < params.rounds else params.last_steps
        height = gauss_newton(problem, reflectance, omega, height, steps)
    n = cell_normals(picture.grid, height)
    residual = float(np.abs(problem.intensity - reflectance.slopes(n)[0]).mean())
    return Shape(
        height, reflectance, omega, residual, energy(problem, reflectance, omega, height), albedo, bool(prior.sum() < 0)
    )


def averaged(shapes: Sequence[Shape], temperature: float) -> Shape:
    """The likeliest of some shapes at the mean of their heights, weighed by exp(-(E - E_min) / (temperature E_min))."""
    energies = np.array([shape.energy for shape in shapes])
    weight = weights_of(energies - energies.min(), temperature * energies.min())
    height = (weight[:, None] * np.stack([shape.height for shape in shapes])).sum(axis=0)
    return replace(shapes[int(weight.argmax())], height=height)


def weights_of(energies: np.ndarray, scale: float) -> np.ndarray:
    """Weights (k,) of explanations by their energies above the least, which add up to 1; those fall by e a `scale`."""
    weight = np.exp(-energies / max(scale, 1e-9))
    return weight / weight.sum()


def without_albedo(
    intensity: np.ndarray, normals: np.ndarray, labels: np.ndarray, ridge: float
) -> tuple[np.ndarray, np.ndarray]:
    """Intensities (c,) over the brightness of the colour of each cell, and that brightness, 1 on average."""
    albedo = np.ones(len(intensity))
    if labels.max(initial=0) == 0:
        return intensity, albedo
    for _ in range(4):
        shade = np.maximum(fit_harmonics(intensity / albedo, normals, ridge).slopes(normals)[0], 0.02)
        scale = np.array([np.median(intensity[labels == k] / shade[labels == k]) for k in range(labels.max() + 1)])
        albedo = np.maximum(scale, 0.05)[labels]
        albedo = albedo / albedo.mean()
    return intensity / albedo, albedo


def colours(picture: Pictured, most: int, spread: float = 0.1) -> np.ndarray:
    """The colour (c,) int of each cell: k-means on log R/G and log B/G; all 0 when they do not differ by `spread`."""
    values = np.maximum(picture.colour, 0.01)
    chroma = picture.grid.on_cells(
        np.stack([np.log(values[:, 0] / values[:, 1]), np.log(values[:, 2] / values[:, 1])], axis=-1)
    )
    labels = np.zeros(len(chroma), int)
    if most < 2 or len(chroma) < 10 * most or np.linalg.norm(chroma.std(axis=0)) < spread:
        return labels
    centres, labels = _kmeans(chroma, most)
    return np.unique(labels, return_inverse=True)[1]


def _kmeans(points: np.ndarray, count: int, rounds: int = 30) -> tuple[np.ndarray, np.ndarray]:
    """Lloyd's iteration from centres spread along the direction of most variance: no chance in it."""
    axis = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2][0]
    order = np.argsort(points @ axis, kind="stable")
    centres = np.stack([part.mean(axis=0) for part in np.array_split(points[order], count)])
    labels = np.zeros(len(points), int)
    for _ in range(rounds):
        labels = ((points[:, None] - centres) ** 2).sum(axis=-1).argmin(axis=1)
        centres = np.stack(
            [points[labels == k].mean(axis=0) if (labels == k).any() else centres[k] for k in range(count)]
        )
    return centres, labels


def enlarge(values: np.ndarray, small_mask: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """A displacement (n,) in pixels of the small grid as an image (h, w) on the full mask, in its pixels; 0 outside.

    Beyond the small mask it goes on as the nearest pixel has it; between the pixels it is a cubic spline, which keeps
    slopes.
    """
    from scipy.ndimage import distance_transform_edt, map_coordinates

    image = np.zeros(small_mask.shape)
    image[small_mask] = values
    nearest = distance_transform_edt(~small_mask, return_distances=False, return_indices=True)
    filled = image[tuple(nearest)]
    factors = [large / small for large, small in zip(mask.shape, small_mask.shape, strict=True)]
    at = np.meshgrid(*[(np.arange(n) + 0.5) / f - 0.5 for n, f in zip(mask.shape, factors, strict=True)], indexing="ij")
    grown = map_coordinates(filled, at, order=3, mode="nearest")
    return np.where(mask, grown * np.sqrt(factors[0] * factors[1]), 0.0)

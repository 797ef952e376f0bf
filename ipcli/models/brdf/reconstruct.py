"""From one picture and its mask to a surface: rim, then light and material, then the surface (design of chapter 7).

The rim posterior says how much the silhouette is an occluding rim; the surface of the solid and that of the sheet are
averaged with it. Heights are in pixels of the picture, towards the viewer; the view is orthographic.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ipcli.models.brdf import patches
from ipcli.models.brdf.basrelief import bas_relief
from ipcli.models.brdf.energy import cell_normals
from ipcli.models.brdf.grid import inflate, normals
from ipcli.models.brdf.library import Library
from ipcli.models.brdf.material import statistics
from ipcli.models.brdf.parameters import Inference
from ipcli.models.brdf.refine import forward_normals, refine
from ipcli.models.brdf.reflectance import Chart, Harmonics, chart_normals
from ipcli.models.brdf.rim import features
from ipcli.models.brdf.sheet import Explained, representatives, sheet
from ipcli.models.brdf.solid import Pictured, Shape, averaged, enlarge, fit_harmonics, pictured, shrink, solid
from ipcli.progress import Progress, silent

UP = 2  # harmonic whose sign tells light from above


@dataclass(frozen=True, eq=False)
class Reconstruction:
    """What one picture told, on the pixels of the mask's box."""

    height: np.ndarray  # (h, w) pixels, NaN outside
    normals: np.ndarray  # (h, w, 3), NaN outside
    prior: np.ndarray  # (h, w) the shape it set out from
    confidence: np.ndarray  # (h, w) in [0, 1]: agreement of the explanations
    shading: np.ndarray  # (h, w) the picture as the map explains it, on the scale of the picture; NaN outside
    chart: np.ndarray  # (s, s) the map that was found, of the explanation with the greater weight
    sheet: float  # posterior that the silhouette is a cut edge
    features: np.ndarray  # (f,) of `rim.FEATURES`
    solid_height: np.ndarray | None  # (h, w) each explanation by itself
    sheet_height: np.ndarray | None
    residual: float  # mean |I - R(n)|, in 95th percentiles of the picture
    tie: float  # E of the other relief less that of the one taken, over their mean; near 0: the picture does not tell
    is_above: bool  # whether the light that was found comes from above
    explained: Explained | None
    maps: np.ndarray  # indices of the library's charts that were compared
    by_look: np.ndarray  # (b,) material posterior of the classifier alone

    def probe_posterior(self, library: Library) -> np.ndarray:
        """Weights of the maps summed over headings and materials (p,); NaN where no maps were compared."""
        return self._summed(library.probe, len(library.probes))

    def material_posterior(self, library: Library) -> np.ndarray:
        """Posterior of the classifier times the weights of the maps summed over probes and headings (b,), where there
        are any.
        """
        summed = self._summed(library.material, len(library.materials))
        joint = self.by_look * np.where(np.isnan(summed), 1.0, summed)
        return joint / joint.sum() if joint.sum() > 0 else self.by_look

    def _summed(self, index: np.ndarray, count: int) -> np.ndarray:
        if self.explained is None:
            return np.full(count, np.nan)
        return np.bincount(index[self.maps], self.explained.weight, minlength=count)


@dataclass(frozen=True, eq=False)
class _Sizes:
    """The picture at the sizes that are needed."""

    mask: np.ndarray
    fine: Pictured
    coarse: Pictured
    balloon: np.ndarray  # (h, w) at full size


def reconstruct(
    colour: np.ndarray,
    mask: np.ndarray,
    library: Library,
    params: Inference,
    tell: Progress = silent,
) -> Reconstruction:
    """The surface in a linear picture (h, w, 3) cropped to its mask (h, w)."""
    if params.relief == "concave":  # of a solid, see `_solid`; of a sheet here
        params = replace(params, sheet=replace(params.sheet, relief=-params.sheet.relief))
    picture = _Sizes(
        mask, pictured(colour, mask, params.side), pictured(colour, mask, params.sweep_side), inflate(mask)
    )
    found = features(picture.fine)
    share = {"solid": 0.0, "sheet": 1.0, "mixed": 0.5}.get(params.rim, float(library.judge.sheet(found)))
    share = 0.0 if share < params.least else 1.0 if share > 1 - params.least else share
    tell(0.05, "rim")
    shape, tie = _solid(picture, params) if share < 1 else (None, np.nan)
    tell(0.2, "light")
    maps = representatives(library.grey(), params.maps)
    explained = None
    if share > 0:
        tables = library.grey()[maps]
        explained = sheet(
            picture.fine, picture.coarse, tables, params.sheet, lambda done: tell(0.2 + 0.7 * done, "maps")
        )
    if params.refine == "convex" and shape is not None:
        shape = _refined(picture, params, shape)
    return _joined(picture, params, library, share, found, shape, tie, explained, maps)


def _solid(picture: _Sizes, params: Inference) -> tuple[Shape, float]:
    """The relief that is asked for, and by how much the picture prefers it to the other one."""
    convex = solid(picture.fine, params.solid)
    concave = solid(picture.fine, params.solid, prior=-picture.fine.inflated)
    first, other = (concave, convex) if _takes_concave(params.relief, convex) else (convex, concave)
    tie = (other.energy - first.energy) / max((other.energy + first.energy) / 2, 1e-12)
    return _with_patches(picture.fine, params, first) if params.use_patches == "prior" else first, tie


def _with_patches(picture: Pictured, params: Inference, shape: Shape) -> Shape:
    """The solid once more, with what patches say under the map that was found joined to the prior normals; the mean of
    both, for where patches contradict the picture the energy rises.
    """
    prior = _sign(shape) * picture.inflated
    said = patches.posterior(picture, shape.reflectance, shape.albedo, params.patches)
    joined = patches.joined(cell_normals(picture.grid, prior), said, params.patches)
    again = solid(picture, params.solid, prior, shape.height, joined, shape.omega)
    return averaged((shape, again), params.patches.temperature)


def _refined(picture: _Sizes, params: Inference, shape: Shape) -> Shape:
    """The solid after the convex refinement: another solver of the same terms, with TGV in place of bending."""
    grid = picture.fine.grid
    height = grid.image(shape.height, 0.0)
    prior = forward_normals(grid.image(_sign(shape) * picture.fine.inflated, 0.0), grid.mask)
    pixels = np.where(np.isfinite(values := grid.to_pixels(picture.fine.intensity / shape.albedo)), values, 0.0)
    weight = replace(params.refinement, normal=params.solid.weights.normal, photo=shape.omega * params.refinement.photo)
    refined = refine(height, prior, grid.image(pixels, 0.0), grid.mask, shape.reflectance, weight)
    return replace(shape, height=refined[grid.mask])


def _takes_concave(relief: str, convex: Shape) -> bool:
    return relief == "concave" or (relief == "light-above" and convex.reflectance.coefficients[UP] < 0)


def _joined(
    picture: _Sizes,
    params: Inference,
    library: Library,
    share: float,
    found: np.ndarray,
    shape: Shape | None,
    tie: float,
    explained: Explained | None,
    maps: np.ndarray,
) -> Reconstruction:
    mask, heights, weights = picture.mask, [], []
    if shape is not None:
        heights.append(_full(picture, shape.height, _sign(shape)))
        weights.append(1 - share)
    if explained is not None:
        heights += [_full(picture, height, params.sheet.relief) for height in explained.heights]
        weights += list(share * explained.share)
    mean = np.einsum("k,khw->hw", np.array(weights), np.stack([np.nan_to_num(h) for h in heights]))
    chart, cells, own = _chart(shape, explained, share, library, maps)
    shade = cells.slopes(cell_normals(picture.fine.grid, own))[0]
    prior = (1 - share) * (_sign(shape) if shape else 1.0) + share * params.sheet.relief
    return Reconstruction(
        height=np.where(mask, mean, np.nan),
        normals=normals(mean, mask),
        prior=np.where(mask, prior * picture.balloon, np.nan),
        confidence=_agreement(heights, weights, mask),
        shading=_shading(cells, normals(mean, mask), mask),
        chart=chart,
        sheet=share,
        features=found,
        solid_height=heights[0] if shape is not None else None,
        sheet_height=_mean(heights[-len(explained.share) :], explained.share, mask) if explained is not None else None,
        residual=float(np.abs(picture.fine.intensity - shade).mean()),
        tie=tie,
        is_above=bool((shape.reflectance.coefficients[UP] if shape else _upward(cells)) > 0),
        explained=explained,
        maps=maps,
        by_look=library.classifier.posterior(statistics(picture.fine)),
    )


def _sign(shape: Shape | None) -> float:
    return -1.0 if shape is not None and shape.is_concave else 1.0


def _full(picture: _Sizes, height: np.ndarray, relief: float) -> np.ndarray:
    """A shape on the small grid at full size: the balloon is blown up anew, only the displacement from it is
    enlarged.
    """
    small = picture.fine
    moved = enlarge(height - relief * small.inflated, small.grid.mask, picture.mask)
    whole = relief * picture.balloon + moved
    return np.where(picture.mask, whole - whole[picture.mask].mean(), np.nan)


def _mean(heights: list[np.ndarray], share: np.ndarray, mask: np.ndarray) -> np.ndarray:
    return np.where(mask, np.einsum("k,khw->hw", share, np.stack([np.nan_to_num(h) for h in heights])), np.nan)


def _chart(
    shape: Shape | None, explained: Explained | None, share: float, library: Library, maps: np.ndarray
) -> tuple[np.ndarray, Harmonics | Chart, np.ndarray]:
    """The map of the weightier explanation, as a table and as a map, and the surface (n,) it goes with."""
    if shape is not None and share <= 0.5:
        n = chart_normals()
        return shape.reflectance.slopes(n.reshape(-1, 3))[0].reshape(n.shape[:2]), shape.reflectance, shape.height
    assert explained is not None
    chart = Chart(library.grey()[maps[explained.best[0]]], float(explained.scales[0]))
    return chart.scale * chart.table, chart, explained.heights[0]


def _upward(chart: Harmonics | Chart) -> float:
    n = chart_normals(33).reshape(-1, 3)
    return float((chart.slopes(n)[0] * n[:, 1]).sum())


def _agreement(heights: list[np.ndarray], weights: list[float], mask: np.ndarray) -> np.ndarray:
    """Length (h, w) of the weighted mean of the normals of all explanations: 1 where they agree."""
    mean = sum(w * np.nan_to_num(normals(np.nan_to_num(h), mask)) for w, h in zip(weights, heights, strict=True))
    return np.where(mask, np.linalg.norm(mean, axis=-1), np.nan)


def _shading(reflectance: Harmonics | Chart, n: np.ndarray, mask: np.ndarray) -> np.ndarray:
    image = np.full(mask.shape, np.nan)
    image[mask] = reflectance.slopes(n[mask])[0]
    return image


def integrated(
    given: np.ndarray, colour: np.ndarray, mask: np.ndarray, library: Library, params: Inference
) -> Reconstruction:
    """The bas-relief of given normals (h, w, 3), NaN unknown, with the light that the picture has on it."""
    fine, height = pictured(colour, mask, params.side), bas_relief(given, mask, params.plate)
    of_relief = normals(np.nan_to_num(height), mask)
    shrunk, _ = shrink(np.nan_to_num(of_relief), mask, params.side)
    n = fine.grid.on_cells(shrunk[fine.grid.mask])
    n = n / np.maximum(np.linalg.norm(n, axis=1, keepdims=True), 1e-9)
    reflects = fit_harmonics(fine.intensity, n, params.solid.ridge)
    known = np.isfinite(given).all(axis=-1)
    agreement = np.where(known, (np.nan_to_num(given) * np.nan_to_num(of_relief)).sum(axis=-1), 0.0)
    return Reconstruction(
        height=height,
        normals=of_relief,
        prior=np.where(mask, 0.0, np.nan),
        confidence=np.where(mask, np.clip(agreement, 0, 1), np.nan),
        shading=_shading(reflects, of_relief, mask),
        chart=reflects.slopes(chart_normals().reshape(-1, 3))[0].reshape(chart_normals().shape[:2]),
        sheet=0.0,
        features=features(fine),
        solid_height=None,
        sheet_height=None,
        residual=float(np.abs(fine.intensity - reflects.slopes(n)[0]).mean()),
        tie=np.nan,
        is_above=bool(reflects.coefficients[UP] > 0),
        explained=None,
        maps=np.zeros(0, int),
        by_look=library.classifier.posterior(statistics(fine)),
    )


def baselines(mask: np.ndarray) -> dict[str, np.ndarray]:
    """Heights (h, w) that need no picture: flat, and the balloon of the silhouette."""
    return {"flat": np.where(mask, 0.0, np.nan), "inflation": np.where(mask, inflate(mask), np.nan)}

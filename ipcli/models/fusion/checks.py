"""What can be checked about the geometry of views and the end of a fusion, in words that name the cure.

Whether poses, axes and units are right shows in how far views agree with the reference: each likely mistake is undone
in turn, and warned of when the views then agree far better, so that sound data cannot set off an alarm by its noise.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from ipcli.measurements.accuracy import thinned_camera, thinning
from ipcli.measurements.views import View, relative
from ipcli.models.fusion.reprojection import reproject_all

OTHERS = 4  # views that are compared with the reference, those seen from furthest away
BETTER = 2.0  # so many times closer, at least, must views agree without a mistake
LEAST_SEEN = 0.05  # share of the reference that has to be seen to compare
LEAST_PARALLAX = 0.5  # px: with less, the units of depth and baseline are asked about
LOOSE = 50.0  # tolerances: a fusion whose gap ends above that has not converged
SHIFT_BETTER = 1.15  # the same of poses that are moved on by one view, which changes less; sound sequences reach .99
OFF_CENTRE = 0.2  # of the width or height: a principal point so far from the middle is doubted
ONE_FACTOR = 1.15  # both coordinates of the principal point are off by one factor if they differ by no more
ANOTHER_UNIT = 25.0  # times as far away as in other maps is a surface whose unit is doubted; an inch has 25.4 mm
UNLIKE = 0.1  # of the median share of points that maps see alike, below which the pose of a map is doubted
PIXELS = 1_000_000  # of a view that is looked at whole; of a larger one, so many-th rows and columns
OPENGL = np.diag([1.0, -1.0, -1.0, 1.0])


def _inverted(view: View) -> View:
    return replace(view, cam_from_world=np.ascontiguousarray(np.linalg.inv(view.cam_from_world)))


def _flipped(view: View) -> View:
    return replace(view, cam_from_world=OPENGL @ view.cam_from_world)


def _flipped_inverted(view: View) -> View:
    return replace(view, cam_from_world=np.ascontiguousarray(OPENGL @ np.linalg.inv(view.cam_from_world)))


def _shrunk(factor: float) -> Callable[[View], View]:
    return lambda view: replace(view, depth=view.depth / np.float32(factor))


MISTAKES: tuple[tuple[Callable[[View], View], str], ...] = (
    (_inverted, "the poses seem to be given in the other direction: see --pose"),
    (_flipped, "the poses seem to have OpenGL's axes (y up, looking along -z): turn y and z of the camera"),
    (
        _flipped_inverted,
        "the poses seem to be given in the other direction and with OpenGL's axes (y up, looking along -z): see --pose,"
        " and turn y and z of the camera",
    ),
)


def geometry_warnings(views: Sequence[View], reference: View) -> list[str]:
    """Likely mistakes of calibration, poses and units, in words; about poses none for a reference that has seen nothing
    itself. Views, in their order, are asked for one by one.
    """
    seen = [thinned(view) for view in views]
    found = centre_warnings([view for view in seen if view.name != reference.name or np.isfinite(view.depth).any()])
    reference = thinned(reference)
    others = [view for view in seen if view.name != reference.name]
    baseline = {view.name: float(np.linalg.norm(relative(reference, view)[:3, 3])) for view in others}
    others = sorted(others, key=lambda view: -baseline[view.name])[:OTHERS]
    if not others or not np.isfinite(reference.depth).any():
        return found
    return found + (_pose_warnings(others, reference, baseline[others[0].name]) or shift_warnings(seen, reference))


def merge_warnings(names: Sequence[str], poses: np.ndarray, depths: np.ndarray, counts: np.ndarray) -> list[str]:
    """What is odd about maps that were merged, from their cam_from_world (m, 4, 4), the median depth (m,) of each, and
    its points, those confirmed and those contradicted (m, 3): one camera twice, another unit, a pose that does not fit.
    """
    found = []
    for one, two in combinations(range(len(names)), 2):
        if np.allclose(poses[one], poses[two], rtol=1e-9, atol=1e-9 * depths[one]):
            found.append(
                f"{names[one]} and {names[two]} have one and the same camera, and confirm one another for that. Leave "
                "one of them out"
            )
    shares = counts[:, 1] / np.maximum(counts[:, 0], 1)
    with_points = np.flatnonzero(counts[:, 0] > 0)
    for k in with_points.tolist() if len(with_points) > 1 else ():
        times = float(depths[k] / np.median(depths[with_points[with_points != k]]))
        if not 1 / ANOTHER_UNIT < times < ANOTHER_UNIT:
            found.append(f"{names[k]} sees its surface {times:.2g} times as far away as the others: another unit?")
        elif shares[k] < UNLIKE * np.median(shares[with_points]):
            alike = f"only {shares[k]:.1%} of its points are seen alike by other maps"
            found.append(f"{names[k]}: {alike}. Check its pose and unit")
    return found


def thinned(view: View) -> View:
    """The view by some of its rows and columns, if it has more than PIXELS; without pictures."""
    step = thinning(view.depth.size, PIXELS)
    depth = np.ascontiguousarray(view.depth[::step, ::step])
    camera = thinned_camera(view.intrinsics, step)
    return View(view.name, depth, camera, view.cam_from_world)


def _pose_warnings(others: Sequence[View], reference: View, baseline: float) -> list[str]:
    tried = list(MISTAKES)
    depth = float(np.nanmedian(reference.depth))
    parallax = reference.intrinsics[0, 0] * baseline / depth
    if 0 < parallax < LEAST_PARALLAX:
        tried = [(_shrunk(factor), _unit_hint(factor, parallax)) for factor in (1e3, 1e6)] + tried
    now = disagreement(others, reference)
    found = [(disagreement([undo(view) for view in others], undo(reference)), text) for undo, text in tried]
    best, text = min(found, key=lambda item: item[0])
    if not best * BETTER < now:
        return []
    return [f"the views disagree by {100 * now:.2g} % of the depth, but by {100 * best:.2g} % if undone: {text}"]


def shift_warnings(views: Sequence[View], reference: View) -> list[str]:
    """That the views of a sequence agree better if each has the pose of the one after it, or of the one before: seen
    from the reference and, somewhat at least, from the views next to it. The pose of one view alone may just be off.
    """
    found = [(then, now, word) for then, now, word in shifted(views, reference) if then * SHIFT_BETTER < now]
    if not found:
        return []
    at = [view.name for view in views].index(reference.name)
    beside = [shifted(views, views[k]) for k in (at - 1, at + 1) if 0 <= k < len(views)]
    found = [one for one in found if all(then < now for near in beside for then, now, word in near if word == one[2])]
    if not found:
        return []
    then, now, word = min(found)
    return [
        f"neighbouring views disagree by {100 * now:.2g} % of the depth, but by {100 * then:.2g} % if each has the "
        f"pose of the view {word} it: the poses seem to be shifted against the images. Look whether the first pose is "
        "that of the first image, and mend the names or numbers of the poses; an estimated path that is off here looks "
        "alike"
    ]


def shifted(views: Sequence[View], reference: View) -> list[tuple[float, float, str]]:
    """The disagreement of the neighbours of the reference if each has the pose of the view after it and before it, that
    with its own, and "after" or "before"; none for a sequence too short.
    """
    at = next((k for k, view in enumerate(views) if view.name == reference.name), None)
    if at is None or len(views) < 4:
        return []
    found = []
    for shift, word in ((1, "after"), (-1, "before")):
        near = [k for k in range(at - OTHERS // 2, at + OTHERS // 2 + 1) if min(k, k + shift) >= 0]
        near = [k for k in near if max(k, k + shift) < len(views)]
        if at not in near or len(near) < 3:
            continue
        moved = {k: replace(views[k], cam_from_world=views[k + shift].cam_from_world) for k in near}
        now = disagreement([views[k] for k in near if k != at], reference)
        found.append((disagreement([moved[k] for k in near if k != at], moved[at]), now, word))
    return found


def centre_warnings(views: Sequence[View]) -> list[str]:
    """That a principal point is far from the middle of its image, which a calibration at another size would explain."""
    for view in views:
        size = np.array(view.depth.shape[::-1], np.float64)
        share = (view.intrinsics[:2, 2] + 0.5) / size
        if np.abs(share - 0.5).max() <= OFF_CENTRE:
            continue
        where = (
            f"the principal point of view {view.name} lies at {share[0]:.0%} of the width and {share[1]:.0%} of the "
        )
        factor = float(np.sqrt(np.prod(2 * view.intrinsics[:2, 2].clip(0) / (size - 1))))
        if share.max() < ONE_FACTOR * share.min():
            why = f"the calibration seems to be of images {factor:.2g} times as large: divide --intrinsics by that"
        else:
            why = "unless the images are crops, the calibration is of another camera or size: see --intrinsics"
        return [f"{where}height: {why}"]
    return []


def _unit_hint(factor: float, parallax: float) -> str:
    return (
        f"depth seems to be {factor:.0f} times too large for the translation of the poses ({parallax:.2g} px of "
        f"parallax): give {factor:.0f} times the --depth-scale (1 where none is given)"
    )


def disagreement(views: Sequence[View], reference: View) -> float:
    """Median of |depth seen by views - depth of the reference| over the latter; infinite where too little is seen."""
    layers = reproject_all(views, reference).depth
    seen = np.isfinite(layers) & np.isfinite(reference.depth)
    if seen.mean() < LEAST_SEEN:
        return float("inf")
    share = np.abs(layers - reference.depth)[seen] / np.broadcast_to(reference.depth, layers.shape)[seen]
    return float(np.median(share))


def convergence_warnings(history: np.ndarray, tolerance: float) -> list[str]:
    """That the iteration ended far from a solution, going by rows (round, iteration, energy, gap, merit)."""
    if not len(history) or not history[-1, 3] > LOOSE * tolerance:
        return []
    return [
        f"the fusion did not converge: its relative gap is {history[-1, 3]:.2g} where {tolerance:g} was asked for; "
        "smoothing may be missing. Raise --set fusion.solver.iterations, or look for values far off all others"
    ]

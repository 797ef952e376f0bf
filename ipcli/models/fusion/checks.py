"""What can be checked about the geometry of views and the end of a fusion, in words that name the cure.

Whether poses, axes and units are right shows in how far views agree with the reference: each likely mistake is undone
in turn, and warned of when the views then agree far better, so that sound data cannot set off an alarm by its noise.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from ipcli.measurements.views import View, relative
from ipcli.models.fusion.reprojection import reproject_all

OTHERS = 4  # views that are compared with the reference, those seen from furthest away
BETTER = 2.0  # so many times closer, at least, must views agree without a mistake
LEAST_SEEN = 0.05  # share of the reference that has to be seen to compare
LEAST_PARALLAX = 0.5  # px: with less, the units of depth and baseline are asked about
LOOSE = 50.0  # tolerances: a fusion whose gap ends above that has not converged
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
    """Likely mistakes of poses and units, in words; none for a reference that has seen nothing itself."""
    others = [view for view in views if view.name != reference.name]
    baseline = {view.name: float(np.linalg.norm(relative(reference, view)[:3, 3])) for view in others}
    others = sorted(others, key=lambda view: -baseline[view.name])[:OTHERS]
    if not others or not np.isfinite(reference.depth).any():
        return []
    tried = list(MISTAKES)
    depth = float(np.nanmedian(reference.depth))
    parallax = reference.intrinsics[0, 0] * baseline[others[0].name] / depth
    if 0 < parallax < LEAST_PARALLAX:
        tried = [(_shrunk(factor), _unit_hint(factor, parallax)) for factor in (1e3, 1e6)] + tried
    now = disagreement(others, reference)
    found = [(disagreement([undo(view) for view in others], undo(reference)), text) for undo, text in tried]
    best, text = min(found, key=lambda item: item[0])
    if not best * BETTER < now:
        return []
    return [f"the views disagree by {100 * now:.2g} % of the depth, but by {100 * best:.2g} % if undone: {text}"]


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
        "smoothing may be missing. Look for values far off all others, or raise --set fusion.solver.iterations"
    ]

"""Local and global adjustment of the map: which frames and points, outliers, matching anew, the disparity offset."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ipcli.geometry.rig import Rig
from ipcli.kernels import matching
from ipcli.models.gaze import bundle, pose
from ipcli.models.gaze.features import WORST
from ipcli.models.gaze.parameters import Mapping
from ipcli.models.gaze.scene_map import NONE, SceneMap

ANCHORS = 12  # frames held fixed around a local window
REACH = 4.0  # pixels around its expected place where a point is matched anew
BLOCKS = 4  # contiguous parts of the sequence whose offsets are compared
CERTAIN = 3.0  # standard errors beyond which an offset counts as proven


def local(scene: SceneMap, rig: Rig, p: Mapping) -> None:
    """Adjust the last frames of the map and the points they see, under the frames around them (3.8)."""
    window = list(range(max(len(scene.frames) - p.window, 0), len(scene.frames)))
    ids = scene.points_of(window)
    ids = ids[[len(scene.observers[point]) > 1 for point in ids]]
    if len(window) < 2 or len(ids) < 10:
        return
    anchors = [f for f in scene.covisible(ids, ANCHORS + len(window)) if f not in window][:ANCHORS]
    positions = anchors + window
    free = np.array([position in window for position in positions])
    if not anchors:
        free[0] = False
    problem = scene.problem(positions, free, ids)
    solution = bundle.solve(problem, rig, loss=p.loss, iterations=6, tolerance=1e-3)
    _apply(scene, positions, ids, solution)


def everything(
    scene: SceneMap, rig: Rig, p: Mapping, *, free_offset: bool = False, with_covariance: bool = False
) -> bundle.Solution:
    """Adjust all frames and points, the first frame fixed; drop what does not fit; leave the offset to the caller."""
    positions = list(range(len(scene.frames)))
    ids = np.array([point for point in range(scene.count) if len(scene.observers[point]) > 1], int)
    free = np.ones(len(positions), bool)
    free[0] = False
    problem = scene.problem(positions, free, ids)
    solution = bundle.solve(
        problem, rig, loss=p.loss, iterations=30, free_offset=free_offset, with_covariance=with_covariance
    )
    _apply(scene, positions, ids, solution)
    return solution


def _apply(scene: SceneMap, positions: list[int], ids: np.ndarray, solution: bundle.Solution) -> None:
    for position, moved in zip(positions, solution.poses, strict=True):
        if moved is not scene.frames[position].pose:
            scene.carry(position, moved)
    scene.points[ids] = solution.points


def drop_outliers(scene: SceneMap, rig: Rig, error: float) -> int:
    """Forget sightings that are off by more than `error` pixels in either camera; how many."""
    dropped = 0
    for position, frame in enumerate(scene.frames):
        hit = np.flatnonzero(frame.ids != NONE)
        seen = scene.sightings(frame.features, hit, frame.ids[hit])
        off = np.nan_to_num(np.abs(pose.residuals(rig, frame.pose, seen)), nan=0.0).max(axis=1, initial=0.0)
        bad = hit[off > error]
        scene.forget(position, bad)
        dropped += len(bad)
    return dropped


def match_anew(scene: SceneMap, rig: Rig, neighbours: int = 15) -> tuple[int, int]:
    """Look in every frame for the points of the frames around it; how many were found, and how many merged."""
    found, pairs = 0, []
    for position, frame in enumerate(scene.frames):
        ids = frame.ids[frame.ids != NONE]
        around = scene.points_of([f for f in scene.covisible(ids, neighbours) if f != position])
        around = np.setdiff1d(around, ids)
        inside = scene.points[around] @ frame.pose[:3, :3].T + frame.pose[:3, 3]
        expected = in_picture(rig, inside)
        radius = np.full(len(around), REACH)
        match, _ = matching.near(
            expected, frame.features.left, scene.descriptors[around], frame.features.descriptors, frame.features.rows,
            radius, 0.9**2, WORST,
        )  # fmt: skip
        hit = np.flatnonzero(match >= 0)
        seen = scene.sightings(frame.features, match[hit], around[hit])
        fits = pose.stereo_error(pose.residuals(rig, frame.pose, seen)) < (REACH / 2) ** 2
        for point, feature in zip(around[hit[fits]], match[hit[fits]], strict=True):
            if frame.ids[feature] == NONE:
                scene.observe(position, int(feature), int(point))
                found += 1
            else:
                pairs.append((frame.ids[feature], point))
    return found, scene.merge(np.array(pairs, int).reshape(-1, 2))


def in_picture(rig: Rig, inside: np.ndarray) -> np.ndarray:
    """Undistorted pixels (n, 2) in camera 0 of points in the rig's frame; NaN outside its picture."""
    expected = rig.project(0, inside)
    margin = 0.2 * rig.sizes[0]
    outside = ~((expected > -margin) & (expected < rig.sizes[0] + margin)).all(axis=1)
    return np.where(outside[:, None], np.nan, expected)


@dataclass(frozen=True, eq=False)
class Offset:
    """The disparity offset as the whole sequence and its contiguous blocks see it, in pixels."""

    value: float
    blocks: np.ndarray  # (b,)

    @property
    def error(self) -> float:
        """Standard error of the blocks' mean; infinite for fewer than three."""
        known = self.blocks[np.isfinite(self.blocks)]
        return float(known.std(ddof=1) / np.sqrt(len(known))) if len(known) > 2 else float("inf")

    @property
    def is_certain(self) -> bool:
        """Whether it is more than three standard errors from 0, and the blocks agree on its sign."""
        known = self.blocks[np.isfinite(self.blocks)]
        agree = bool((np.sign(known) == np.sign(self.value)).all())
        return agree and abs(self.value) > CERTAIN * self.error


def estimate_offset(scene: SceneMap, rig: Rig, p: Mapping) -> Offset:
    """The offset of the right camera, free in an adjustment of everything and of each contiguous block alone."""
    whole = _offset_of(scene, rig, p, list(range(len(scene.frames))))
    parts = np.array_split(np.arange(len(scene.frames)), BLOCKS)
    blocks = [_offset_of(scene, rig, p, list(part)) if len(part) >= 4 else np.nan for part in parts]
    return Offset(whole, np.array(blocks))


def _offset_of(scene: SceneMap, rig: Rig, p: Mapping, positions: list[int]) -> float:
    inside = np.zeros(len(scene.frames), bool)
    inside[positions] = True
    ids = scene.points_of(positions)
    ids = ids[[inside[scene.observers[point]].sum() > 1 for point in ids]]
    free = np.ones(len(positions), bool)
    free[0] = False
    if len(positions) < 2 or len(ids) < 50:
        return float("nan")
    solution = bundle.solve(scene.problem(positions, free, ids), rig, loss=0.5, iterations=30, free_offset=True)
    return solution.offset

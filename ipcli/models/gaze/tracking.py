"""Localising frame after frame in the map that grows with them: the online part of gaze-sfm (thesis 3.2)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ipcli.geometry import lie
from ipcli.geometry.rig import Rig
from ipcli.kernels import matching
from ipcli.models.gaze import adjustment, pose
from ipcli.models.gaze.adjustment import in_picture
from ipcli.models.gaze.features import WORST, StereoFeatures
from ipcli.models.gaze.parameters import Localisation
from ipcli.models.gaze.retrieval import Album
from ipcli.models.gaze.scene_map import NONE, SceneMap
from ipcli.rng import stream

WIDE = 0.08  # of the picture's width: how far from where it is expected a point is looked for with a predicted pose
CLOSE = (15.0, 5.0)  # pixels, with a pose that is found, first and then
STEADY = 0.5  # share of the points found by prediction that must fit for the prediction to be trusted
PLENTY = 0.35  # share of the stereo points that a prediction must explain, else past frames are looked through as well
NEIGHBOURS = 10  # frames whose points are looked for once the pose is roughly known


@dataclass(eq=False)
class Track:
    """What became of a frame. Lost frames have a NaN pose and a reason."""

    number: int
    pose: np.ndarray  # (4, 4) rig_from_world
    covariance: np.ndarray  # (6, 6) of the twist on the left
    ids: np.ndarray  # (m,) map points it rests on
    left: np.ndarray  # (m, 2) where they were seen
    right: np.ndarray  # (m, 2)
    sigma: np.ndarray  # (m,)
    error: float = np.nan  # pixels, root mean square
    position: int = NONE  # in the map, NONE for a frame that is not part of it
    how: str = ""  # "first", "predicted", "recognised" or "lost"
    reason: str = ""
    features: int = 0
    stereo: int = 0
    vertical: float = np.nan

    @property
    def is_lost(self) -> bool:
        """Whether there is no pose."""
        return not np.isfinite(self.pose).all()


class Tracker:
    """Feed it frames in order. State: the map, the album of past frames, and the last poses."""

    def __init__(self, rig: Rig, album: Album, p: Localisation, seed: int, known: SceneMap | None = None):
        self.rig, self.album, self.p, self.seed = rig, album, p, seed
        self.scene = SceneMap() if known is None else known
        self.tracks: list[Track] = []
        self.keep_map = known is not None  # localise only: the map is somebody else's

    def add(self, number: int, features: StereoFeatures) -> Track:
        """Localise a frame, add it to the map where it brings something new."""
        track = self._locate(number, features)
        track.features, track.stereo = len(features), int(np.isfinite(features.points[:, 0]).sum())
        track.vertical = features.vertical
        self.tracks.append(track)
        return track

    def _locate(self, number: int, features: StereoFeatures) -> Track:
        if not features.usable or len(features) < self.p.tracking.least:
            return _lost(number, "picture too dark or without texture")
        if not self.scene.frames:
            return self._first(number, features)
        how, vector = "predicted", None
        best = self._predicted(features)
        if best is None or len(best[2]) < PLENTY * max(np.isfinite(features.points[:, 0]).sum(), 1):
            vector = self.album.vector(features.descriptors)
            other = self._recognised(features, vector)
            if other is not None and (best is None or len(other[2]) > len(best[2])):
                best, how = other, "recognised"
        if best is None:
            return _lost(number, "no past frame explains it")
        estimate, chosen, ids = best
        if len(np.unique(ids)) < self.p.tracking.least:
            return _lost(number, f"its pose rests on {len(np.unique(ids))} points only")
        track = _track(number, estimate, features, chosen, ids, how)
        if not self.keep_map and self._is_new(track, features):
            self._insert(track, features, chosen, ids, vector)
        return track

    def _first(self, number: int, features: StereoFeatures) -> Track:
        """The first frame is the world; it needs points of its own."""
        if np.isfinite(features.points[:, 0]).sum() < self.p.tracking.least:
            return _lost(number, "too few points matched between the cameras to begin a map")
        identity = pose.Pose(np.eye(4), np.zeros((6, 6)), np.ones(0, bool), 0.0)
        none = np.empty(0, int)
        track = _track(number, identity, features, none, none, "first")
        self._insert(track, features, none, none, None)
        return track

    def _predicted(self, features: StereoFeatures):
        """From the last motion; None if the last frames are lost or the prediction does not hold."""
        last = self.tracks[-1] if self.tracks else None
        if last is None or last.is_lost:
            return None
        guess = last.pose
        if len(self.tracks) > 1 and not self.tracks[-2].is_lost:
            guess = last.pose @ lie.se3_inverse(self.tracks[-2].pose) @ last.pose
        positions = self.scene.covisible(last.ids, NEIGHBOURS) if len(last.ids) else [len(self.scene.frames) - 1]
        around = self.scene.points_of(positions)
        chosen, ids = self._guided(features, guess, around, WIDE * self.rig.sizes[0, 0], 0.8)
        if len(ids) < 2 * self.p.tracking.least:
            return None
        return self._completed(
            features, self._agreed(features, chosen, ids, max(2 * self.p.tracking.least, STEADY * len(ids)))
        )

    def _agreed(self, features: StereoFeatures, chosen: np.ndarray, ids: np.ndarray, least: float):
        """RANSAC on both cameras and refinement; None when fewer than `least` agree."""
        seen = self.scene.sightings(features, chosen, ids)
        rng = stream(self.seed, "gaze-sfm", str(len(self.tracks)))
        start = pose.ransac(self.rig, seen, self.p.tracking, rng)
        if start is None:
            return None
        found = pose.refine(self.rig, start, seen, cut=self.p.tracking.error)
        if len(np.unique(ids[found.inliers])) < least:
            return None
        return found, chosen[found.inliers], ids[found.inliers]

    def _recognised(self, features: StereoFeatures, vector: np.ndarray):
        """From past frames that look alike, by RANSAC on both cameras."""
        alike = self.album.similar(vector, self.p.tracking.similar)
        positions = sorted({*alike, len(self.scene.frames) - 1})
        around = self.scene.points_of(positions)
        chosen, ids = _described(features, self.scene.descriptors[around], around, self.scene.points)
        if len(ids) < self.p.tracking.least:
            return None
        return self._completed(features, self._agreed(features, chosen, ids, self.p.tracking.least // 2))

    def _completed(self, features: StereoFeatures, found):
        """Look for all points around with the pose known, and refine; None stays None."""
        if found is None:
            return None
        best, _, ids = found
        around = self.scene.points_of(self.scene.covisible(ids, NEIGHBOURS))
        for radius in CLOSE:
            chosen, ids = self._guided(features, best.rig_from_world, around, radius, 0.9)
            if len(ids) < self.p.tracking.least:
                return None
            seen = self.scene.sightings(features, chosen, ids)
            best = pose.refine(self.rig, best.rig_from_world, seen, cut=self.p.tracking.error)
        return best, chosen[best.inliers], ids[best.inliers]

    def _guided(self, features: StereoFeatures, guess: np.ndarray, around: np.ndarray, radius: float, ratio: float):
        """Features (m,) and the map points (m,) found near where the pose puts them, one to one."""
        inside = self.scene.points[around] @ guess[:3, :3].T + guess[:3, 3]
        expected = in_picture(self.rig, inside)
        match, distance = matching.near(
            expected, features.left, self.scene.descriptors[around], features.descriptors, features.rows,
            np.full(len(around), radius), ratio**2, WORST,
        )  # fmt: skip
        return _one_to_one(match, distance, around)

    def _is_new(self, track: Track, features: StereoFeatures) -> bool:
        """Whether the map would gain from this frame."""
        last = self.scene.frames[-1].pose
        turned = np.degrees(lie.angle(last[:3, :3], track.pose[:3, :3]))
        known = len(track.ids) / max(track.stereo or int(np.isfinite(features.points[:, 0]).sum()), 1)
        depth = np.nanmedian(features.points[:, 2]) if np.isfinite(features.points).any() else np.inf
        moved = np.linalg.norm(lie.se3_inverse(last)[:3, 3] - lie.se3_inverse(track.pose)[:3, 3])
        p = self.p.mapping
        return bool(turned > p.turn or known < p.overlap or len(track.ids) < p.few or moved > 0.1 * depth)

    def _insert(self, track: Track, features: StereoFeatures, chosen: np.ndarray, ids: np.ndarray, vector) -> None:
        """Make the frame part of the map and adjust around it."""
        of_features = np.full(len(features), NONE)
        of_features[chosen] = ids
        track.position = self.scene.add_frame(track.number, features, track.pose, of_features)
        self.album.add(track.position, self.album.vector(features.descriptors) if vector is None else vector)
        adjustment.local(self.scene, self.rig, self.p.mapping)
        track.pose = self.scene.frames[track.position].pose


def _described(features: StereoFeatures, descriptors: np.ndarray, around: np.ndarray, points: np.ndarray):
    """Features and map points whose descriptors are nearest to each other, and clearly so."""
    if not len(around) or not len(features):
        return np.empty(0, int), np.empty(0, int)
    a, b = descriptors.astype(np.float32), features.descriptors.astype(np.float32)
    own, other = np.square(a).sum(axis=1), np.square(b).sum(axis=1)
    distances = other - 2 * (a @ b.T)  # of the first set's own length, which no comparison along a row needs
    best = distances.argmin(axis=1)
    rows = np.arange(len(a))
    least = distances[rows, best] + own
    distances[rows, best] = np.inf
    second = distances.min(axis=1) + own if distances.shape[1] > 1 else np.full(len(a), np.inf)
    good = np.flatnonzero((least <= WORST) & (least < 0.85**2 * second))
    back = (own[:, None] - 2 * (a @ b[best[good]].T)).argmin(axis=0)  # of those that are left alone
    good = good[back == good]
    return best[good], around[good]


def _one_to_one(match: np.ndarray, distance: np.ndarray, around: np.ndarray):
    """Of several points that chose one feature the nearest keeps it."""
    hit = np.flatnonzero(match >= 0)
    hit = hit[np.argsort(distance[hit], kind="stable")]
    _, first = np.unique(match[hit], return_index=True)
    hit = hit[np.sort(first)]
    return match[hit], around[hit]


def _track(number: int, estimate: pose.Pose, features: StereoFeatures, chosen, ids, how: str) -> Track:
    return Track(
        number, estimate.rig_from_world, estimate.covariance, ids, features.left[chosen], features.right[chosen],
        features.sigma[chosen], estimate.error, how=how,
    )  # fmt: skip


def _lost(number: int, reason: str) -> Track:
    none = np.empty((0, 2))
    return Track(
        number, np.full((4, 4), np.nan), np.full((6, 6), np.nan), np.empty(0, int), none, none, np.empty(0),
        how="lost", reason=reason,
    )  # fmt: skip

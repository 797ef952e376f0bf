"""The map: points with a descriptor each, and the frames they were seen in."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from ipcli.geometry import lie
from ipcli.models.gaze.bundle import BundleProblem
from ipcli.models.gaze.features import StereoFeatures
from ipcli.models.gaze.pose import Sightings

NONE = -1


@dataclass(eq=False)
class MapFrame:
    """A frame that is part of the map."""

    number: int  # in the recording
    features: StereoFeatures
    pose: np.ndarray  # (4, 4) rig_from_world
    ids: np.ndarray  # (n,) map point of each feature, NONE without


@dataclass(eq=False)
class SceneMap:
    """Points grow by doubling; a point's number never changes."""

    points: np.ndarray = field(default_factory=lambda: np.empty((0, 3)))
    descriptors: np.ndarray = field(default_factory=lambda: np.empty((0, 128), np.uint8))
    observers: list[list[int]] = field(default_factory=list)  # positions in `frames`
    frames: list[MapFrame] = field(default_factory=list)
    count: int = 0

    def add_points(self, points: np.ndarray, descriptors: np.ndarray) -> np.ndarray:
        """Numbers of the new points."""
        need = self.count + len(points)
        if need > len(self.points):
            room = max(need, 2 * len(self.points), 4096)
            self.points = np.resize(self.points, (room, 3)) if self.count else np.zeros((room, 3))
            self.descriptors = (
                np.resize(self.descriptors, (room, 128)) if self.count else np.zeros((room, 128), np.uint8)
            )
        ids = np.arange(self.count, need)
        self.points[ids], self.descriptors[ids] = points, descriptors
        self.observers += [[] for _ in ids]
        self.count = need
        return ids

    def add_frame(self, number: int, features: StereoFeatures, pose: np.ndarray, ids: np.ndarray) -> int:
        """Position of the new frame. Features with a point but no number become new map points."""
        ids = ids.copy()
        fresh = np.flatnonzero((ids == NONE) & np.isfinite(features.points).all(axis=1))
        world = (features.points[fresh] - pose[:3, 3]) @ pose[:3, :3]
        ids[fresh] = self.add_points(world, features.descriptors[fresh])
        position = len(self.frames)
        self.frames.append(MapFrame(number, features, pose, ids))
        for point in ids[ids != NONE]:
            self.observers[point].append(position)
        return position

    def covisible(self, ids: Iterable[int], count: int) -> list[int]:
        """Positions of the frames that see most of these points."""
        votes = Counter(position for point in ids for position in self.observers[point])
        return [position for position, _ in sorted(votes.items(), key=lambda vote: (-vote[1], -vote[0]))[:count]]

    def points_of(self, positions: Sequence[int]) -> np.ndarray:
        """Numbers of all points that these frames see."""
        seen = [self.frames[position].ids for position in positions]
        ids = np.unique(np.concatenate(seen)) if seen else np.empty(0, int)
        return ids[ids != NONE]

    def merge(self, pairs: np.ndarray) -> int:
        """Make one point of each pair (m, 2), keeping the one seen more often; how many were merged."""
        target = np.arange(self.count)
        merged = 0
        for a, b in pairs:
            a, b = self._root(target, a), self._root(target, b)
            if a == b or set(self.observers[a]) & set(self.observers[b]):
                continue
            keep, gone = (a, b) if len(self.observers[a]) >= len(self.observers[b]) else (b, a)
            target[gone] = keep
            for position in self.observers[gone]:
                ids = self.frames[position].ids
                ids[ids == gone] = keep
            self.observers[keep] += self.observers[gone]
            self.observers[gone] = []
            merged += 1
        return merged

    @staticmethod
    def _root(target: np.ndarray, point: int) -> int:
        while target[point] != point:
            point = target[point]
        return int(point)

    def observe(self, position: int, feature: int, point: int) -> None:
        """Note that a frame sees a point."""
        self.frames[position].ids[feature] = point
        self.observers[point].append(position)

    def forget(self, position: int, features: np.ndarray) -> None:
        """Take sightings of a frame back."""
        ids = self.frames[position].ids
        for feature in features:
            if ids[feature] != NONE:
                self.observers[ids[feature]].remove(position)
                ids[feature] = NONE

    def sightings(self, features: StereoFeatures, chosen: np.ndarray, ids: np.ndarray) -> Sightings:
        """Map points as these features of a frame see them."""
        return Sightings(self.points[ids], features.left[chosen], features.right[chosen], features.sigma[chosen])

    def problem(self, positions: Sequence[int], free: np.ndarray, ids: np.ndarray) -> BundleProblem:
        """The bundle problem of these frames (in this order) and points."""
        number = np.full(self.count, NONE)
        number[ids] = np.arange(len(ids))
        seen, pixels, sigma = [], [], []
        for order, position in enumerate(positions):
            frame = self.frames[position]
            hit = np.flatnonzero(frame.ids != NONE)
            hit = hit[number[frame.ids[hit]] != NONE]
            for camera, image in enumerate((frame.features.left, frame.features.right)):
                known = hit[np.isfinite(image[hit, 0])]
                columns = (np.full(len(known), order), np.full(len(known), camera), number[frame.ids[known]])
                seen.append(np.stack(columns, axis=1))
                pixels.append(image[known])
                sigma.append(frame.features.sigma[known])
        poses = np.stack([self.frames[position].pose for position in positions])
        return BundleProblem(
            poses, free, self.points[ids], np.concatenate(seen), np.concatenate(pixels), np.concatenate(sigma)
        )

    def carry(self, position: int, pose: np.ndarray) -> None:
        """Give a frame another pose; points that it alone sees move with it."""
        frame = self.frames[position]
        own = [p for p in frame.ids[frame.ids != NONE] if len(self.observers[p]) == 1]
        world_from_world = lie.se3_inverse(pose) @ frame.pose
        self.points[own] = self.points[own] @ world_from_world[:3, :3].T + world_from_world[:3, 3]
        frame.pose = pose

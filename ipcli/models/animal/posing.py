"""Find the pose in which a body looks like labelled images: along the tree of its parts, then all joints at once.

What pulls: points of the surface that fall outside the silhouette go back into it; points that are seen go to pixels of
their own part; and each part's pixels ask for a point of theirs near by. The last of these keeps a limb stretched out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ipcli.geometry import lie
from ipcli.geometry.alignment import align
from ipcli.geometry.meshes import volume
from ipcli.geometry.orthographic import Orthographic, fibonacci
from ipcli.geometry.part_masks import first_faces, render
from ipcli.geometry.voxels import signed_distance
from ipcli.measurements.part_images import NONE, PartImage, pixels_of
from ipcli.models.animal.articulation import JointedBody, Posture
from ipcli.models.animal.whole import overlap

POINTS, LEAST_POINTS = 2000, 40  # of the whole surface, and of a segment
PIXELS = 80  # of the rim of a part in an image, and of all of it
DIRECTIONS = 220  # tried for each part
TWISTS = (0.0, -0.6, 0.6)  # radians about them, for parts that are not long
STUMP = 1e-3  # of the size: a part whose middle is nearer to its joint has no direction
KEPT = 5  # candidates that are refined
SLACK = 0.004  # of the size: errors below it do not pull
ROBUST = (0.06, 0.02)  # of the size, beyond which errors count less and less: first and last
COVER = 3.0  # weight of pixels that ask for a point
BENDS = (0.003, 0.001)  # of the size a radian: what bending a joint costs; both are tried
ROUNDS, STEPS = 6, 12  # of looking which points are seen, and of Gauss-Newton in each
PLACED = (0, 2)  # rounds before which parts are placed one by one
ALONE_STEPS = 10  # of Gauss-Newton for one part


@dataclass(frozen=True, eq=False)
class Target:
    """One image to be matched: distances, in pixels, to the silhouette and to each part where it is shown, with their
    slopes; and pixels (m, 2) of each part.
    """

    camera: Orthographic
    image: PartImage
    outside: np.ndarray  # (h, w) 0 within the silhouette
    away: dict[int, np.ndarray]  # (h, w) by part
    pixels: dict[int, np.ndarray]  # (m, 2) column, row

    @classmethod
    def of(cls, image: PartImage, camera: Orthographic, rng: np.random.Generator) -> Target:
        """That of an image and its camera."""
        away, pixels, outlines = {}, {}, image.outlines()
        for part in np.unique(image.labels[image.labels > 0]) - 1:
            mask = image.mask(int(part))
            away[int(part)] = np.maximum(signed_distance(mask), 0.0)
            rim = outlines.get(int(part), np.empty((0, 2)))
            pixels[int(part)] = np.concatenate([_some(rim, PIXELS, rng), _some(pixels_of(mask), PIXELS, rng)])
        return cls(camera, image, np.maximum(signed_distance(image.silhouette), 0.0), away, pixels)


@dataclass(frozen=True, eq=False)
class Samples:
    """Points (n, 3) on a body in its rest pose, the segment and part (n,) of each and the vertices (n,) they are."""

    points: np.ndarray
    segment: np.ndarray
    part: np.ndarray
    vertex: np.ndarray

    def of_parts(self, parts: Sequence[int]) -> Samples:
        """Those of some parts."""
        own = np.isin(self.part, parts)
        return Samples(self.points[own], self.segment[own], self.part[own], self.vertex[own])


def samples_of(body: JointedBody, rng: np.random.Generator) -> Samples:
    """About so many vertices, of each segment as its share of the surface is."""
    counts = np.bincount(body.segment, minlength=len(body))
    wanted = np.maximum(np.ceil(POINTS * counts / counts.sum()).astype(int), LEAST_POINTS)
    chosen = np.concatenate(
        [rng.permutation(np.flatnonzero(body.segment == k))[:count] for k, count in enumerate(wanted)]
    )
    segment = body.segment[chosen]
    return Samples(body.vertices[chosen], segment, body.part[segment], chosen)


def fit(
    body: JointedBody, rough: JointedBody, images: Sequence[PartImage], cameras: Sequence[Orthographic], seed: int = 0
) -> Posture:
    """The pose of `body` in which it looks like images (with cameras) of another pose.

    `rough` is a model made of these images alone: its joints and limbs give the pose to begin with, and its size the
    scale.
    """
    rng = np.random.default_rng(seed)
    targets = [Target.of(image, camera, rng) for image, camera in zip(images, cameras, strict=True)]
    samples = samples_of(body, rng)
    poses = [_fitted(Fitting(body, targets, rough.size, bend), samples, rough) for bend in BENDS]
    return max(poses, key=lambda pose: likeness(pose.skinned(body), body, images, cameras))


def _fitted(fitting: Fitting, samples: Samples, rough: JointedBody) -> Posture:
    """The pose that one cost of bending gives: the root first, then part by part down the tree, then all at once."""
    body = fitting.body
    root = body.part[0]
    pose = first_pose(body, rough)
    pose = fitting.refined(pose, samples.of_parts([root]), body.part == root, ALONE_STEPS, with_place=True)
    for number, robust in enumerate(np.geomspace(*ROBUST, ROUNDS)):
        if number in PLACED:
            for part in dict.fromkeys(body.part.tolist()):
                pose = pose if part == root else fitting.placed(pose, samples, part, rough)
        fitting = replace(fitting, robust=float(robust))
        seen = fitting.visible(pose, samples)
        pose = fitting.refined(pose, samples, np.ones(len(body), bool), STEPS, with_place=True, seen=seen)
    return pose


def likeness(
    vertices: np.ndarray, body: JointedBody, images: Sequence[PartImage], cameras: Sequence[Orthographic]
) -> float:
    """The mean overlap in [0, 1] of a body, with its vertices (n, 3) moved, with the labels of the images."""
    shares = []
    for image, camera in zip(images, cameras, strict=True):
        labels, _ = render(vertices, body.faces, body.face_part + 1, camera, image.labels.shape)
        shares.append(overlap(image.labels, labels, int(body.part.max()) + 1)[0])
    return float(np.mean(shares))


def first_pose(body: JointedBody, rough: JointedBody) -> Posture:
    """The similarity that carries the joints of a body to those of another with the same parts."""
    pairs = [(_first(body, part), _first(rough, part)) for part in set(body.part.tolist()) & set(rough.part.tolist())]
    here = np.array([body.joint[k] for k, _ in pairs])
    there = np.array([rough.joint[k] for _, k in pairs])
    scale = (volume(rough.vertices, rough.faces) / volume(body.vertices, body.faces)) ** (1 / 3)
    rotation = np.eye(3)
    if len(pairs) >= 3:
        rotation = align(here, there, with_scale=False).rotation
    turns = np.tile(np.eye(3), (len(body), 1, 1))
    turns[0] = rotation
    place = there.mean(axis=0) + scale * rotation @ (body.joint[0] - here.mean(axis=0))
    return Posture(turns, place, scale)


def _first(body: JointedBody, part: int) -> int:
    return int(np.flatnonzero(body.part == part)[0])


@dataclass(frozen=True, eq=False)
class Fitting:
    """A body, the images it is to look like, and the length that errors are measured by."""

    body: JointedBody
    targets: Sequence[Target]
    size: float
    bend: float = BENDS[0]
    robust: float = ROBUST[0]

    def visible(self, pose: Posture, samples: Samples) -> np.ndarray:
        """Whether each image sees each sample (images, n) in this pose."""
        vertices = pose.skinned(self.body)
        seen = []
        for target in self.targets:
            _, depth = first_faces(vertices, self.body.faces, target.camera, target.image.labels.shape)
            points = vertices[samples.vertex]
            behind = target.camera.depth(points) - depth[target.camera.pixel(points, depth.shape)]
            seen.append(~(behind > 0.02 * self.size))
        return np.array(seen)

    def placed(self, pose: Posture, samples: Samples, part: int, rough: JointedBody) -> Posture:
        """The pose with one part turned so that it fits best, tried in all directions."""
        from scipy.spatial.transform import Rotation

        body = self.body
        first = _first(body, part)
        own = samples.of_parts([part])
        rotations, joints = pose.motions(body)
        parent = np.eye(3) if body.parent[first] == NONE else rotations[body.parent[first]]
        arm = own.points.mean(axis=0) - body.joint[first]
        if np.linalg.norm(arm) < STUMP * self.size:
            return pose  # no direction to turn
        axis = arm / np.linalg.norm(arm)
        directions = [parent @ axis, *fibonacci(DIRECTIONS)]
        if part in rough.part:
            told = rough.vertices[rough.part[rough.segment] == part].mean(axis=0) - rough.joint[_first(rough, part)]
            if np.linalg.norm(told) > STUMP * self.size:
                directions.insert(0, told / np.linalg.norm(told))
        is_long = (body.part == part).sum() > 1
        tried = [
            lie.exp(twist * np.asarray(d)) @ Rotation.align_vectors(d, parent @ axis)[0].as_matrix() @ parent
            for d in directions
            for twist in ((0.0,) if is_long else TWISTS)
        ]
        lost = [self.cost(joints[first] + pose.scale * (own.points - body.joint[first]) @ r.T, own.part) for r in tried]
        costs = np.array(lost) + self.bend * np.array([lie.angle(parent, r) for r in tried]) * len(self.targets) * 0.5
        found = [self.refined(pose, own, body.part == part, ALONE_STEPS)]
        for k in np.argsort(costs)[:KEPT]:
            turns = pose.turns.copy()
            turns[first] = parent.T @ tried[k]
            found.append(self.refined(replace(pose, turns=turns), own, body.part == part, ALONE_STEPS))
        left = [self.cost(p.rigid(body, own.points, own.segment), own.part) + self.bending(p) for p in found]
        return found[int(np.argmin(left))]

    def bending(self, pose: Posture) -> float:
        """What the bends of a pose cost, over the size."""
        return float(self.bend * np.sqrt((lie.angle(np.eye(3), pose.turns[1:]) ** 2).mean()))

    def cost(self, points: np.ndarray, part: np.ndarray) -> float:
        """Mean error of points (n, 3) of some parts in all images, over the size."""
        total = 0.0
        for target in self.targets:
            at = target.camera.project(points)
            pixel = 1 / (target.camera.scale * self.size)
            total += _soft(_sample(target.outside, at)[0] * pixel).mean()
            for k in np.unique(part):
                if k in target.pixels:
                    own = at[part == k]
                    total += 0.5 * _soft(_sample(target.away[k], own)[0] * pixel).mean()
                    total += _soft(_nearest(target.pixels[k], own)[1] * pixel).mean()
        return float(total)

    def refined(
        self,
        pose: Posture,
        samples: Samples,
        free: np.ndarray,
        steps: int,
        with_place: bool = False,
        seen: np.ndarray | None = None,
    ) -> Posture:
        """Gauss-Newton on the turns of the `free` segments (s,) bool and, with `with_place`, place and scale."""
        damping = 1e-3
        best = self._system(pose, samples, free, with_place, seen)
        for _ in range(steps):
            matrix, gradient, value = best
            for _ in range(4):
                step = np.linalg.solve(matrix + damping * np.diag(np.diag(matrix) + 1e-9), -gradient)
                tried = self._stepped(pose, step, free, with_place)
                system = self._system(tried, samples, free, with_place, seen)
                if system[2] < value:
                    pose, best, damping = tried, system, damping / 4
                    break
                damping *= 8
            else:
                break
        return pose

    def _stepped(self, pose: Posture, step: np.ndarray, free: np.ndarray, with_place: bool) -> Posture:
        vectors = np.zeros((len(self.body), 3))
        count = 3 * int(free.sum())
        vectors[free] = step[:count].reshape(-1, 3)
        length = np.linalg.norm(vectors, axis=1, keepdims=True)
        vectors *= np.minimum(1.0, 0.5 / np.maximum(length, 1e-12))
        shift, log_scale = (step[count : count + 3] * self.size, step[count + 3]) if with_place else (np.zeros(3), 0.0)
        return pose.turned(self.body, vectors, shift, float(np.clip(log_scale, -0.2, 0.2)))

    def _system(
        self,
        pose: Posture,
        samples: Samples,
        free: np.ndarray,
        with_place: bool,
        seen: np.ndarray | None,
    ) -> tuple[np.ndarray, np.ndarray, float]:
        """Normal equations and value of the robust sum of squares around a pose."""
        points = pose.rigid(self.body, samples.points, samples.segment)
        rotations, joints = pose.motions(self.body)
        slopes = self._slopes(joints, samples, points, free, with_place)
        count = slopes.shape[2]
        matrix, gradient, value = np.zeros((count, count)), np.zeros(count), 0.0
        for number, target in enumerate(self.targets):
            look = np.ones(len(points), bool) if seen is None else seen[number]
            for rows, errors, weight in self._errors(target, points, samples.part, look):
                moved = np.einsum("na,nac->nc", rows[1], slopes[rows[0]])
                squared = (errors / self.robust) ** 2
                robust = 1 / (1 + squared)
                value += weight * self.robust**2 * float(np.log1p(squared).sum())
                matrix += weight * moved.T @ (robust[:, None] * moved)
                gradient += weight * moved.T @ (robust * errors)
        for number, k in enumerate(np.flatnonzero(free)):
            if self.body.parent[k] == NONE:
                continue
            parent = rotations[self.body.parent[k]]
            bend, own = self.bend * parent @ lie.log(pose.turns[k]), slice(3 * number, 3 * number + 3)
            value += float(bend @ bend)
            matrix[own, own] += self.bend**2 * np.eye(3)
            gradient[own] += self.bend * bend
        if with_place:
            matrix[-1, -1] += 1e-6
        return matrix, gradient, value

    def _slopes(
        self, joints: np.ndarray, samples: Samples, points: np.ndarray, free: np.ndarray, with_place: bool
    ) -> np.ndarray:
        """How points (n, 3) move with the unknowns (n, 3, c), in sizes, with the joints (s, 3) where they are."""
        below = self.body.below
        blocks = []
        for k in np.flatnonzero(free):
            turned = -lie.hat((points - joints[k]) / self.size)
            blocks.append(turned * below[k][samples.segment][:, None, None])
        if with_place:
            blocks.append(np.tile(np.eye(3), (len(points), 1, 1)))
            blocks.append(((points - joints[0]) / self.size)[:, :, None])
        return np.concatenate(blocks, axis=2)

    def _errors(self, target: Target, points: np.ndarray, part: np.ndarray, look: np.ndarray):
        """Kinds of errors: (rows of points, slopes (m, 3) against them), errors (m,), weight; all in sizes."""
        camera = target.camera
        at = camera.project(points)
        unit = 1 / (camera.scale * self.size)
        plane = camera.rotation[:2]
        views = len(self.targets)
        error, slope = _sample(target.outside, at)
        out = np.flatnonzero(error > 0)
        yield (out, slope[out] @ plane), _slack(error[out] * unit), 1 / (len(points) * views)
        present = np.unique(part)
        for k in present:
            if k not in target.away:
                continue
            own = np.flatnonzero(part == k)
            error, slope = _sample(target.away[k], at[own])
            beside = (error > 0) & look[own]
            yield (own[beside], slope[beside] @ plane), _slack(error[beside] * unit), 0.5 / (len(points) * views)
            nearest, away = _nearest(target.pixels[k], at[own])
            apart = away > 0
            toward = (at[own][nearest] - target.pixels[k])[apart] / away[apart, None]
            weight = COVER / (len(away) * len(present) * views)
            yield (own[nearest[apart]], toward @ plane), _slack(away[apart] * unit), weight


def _some(pixels: np.ndarray, count: int, rng: np.random.Generator) -> np.ndarray:
    """Up to so many of some pixels (n, 2)."""
    return pixels[rng.permutation(len(pixels))[:count]]


def _slack(errors: np.ndarray) -> np.ndarray:
    return np.maximum(errors - SLACK, 0.0)


def _soft(errors: np.ndarray) -> np.ndarray:
    errors = _slack(errors)
    return np.minimum(errors, 2 * ROBUST[0])


def _sample(picture: np.ndarray, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A picture of distances (h, w) at pixels (n, 2): values (n,) and slopes (n, 2), growing beyond its border."""
    high = np.array([picture.shape[1] - 1.001, picture.shape[0] - 1.001])
    within = np.clip(at, 0.0, high)
    low = within.astype(int)
    fx, fy = (within - low).T
    x, y = low.T
    a, b, c, d = picture[y, x], picture[y, x + 1], picture[y + 1, x], picture[y + 1, x + 1]
    value = (1 - fy) * ((1 - fx) * a + fx * b) + fy * ((1 - fx) * c + fx * d)
    slope = np.stack([(1 - fy) * (b - a) + fy * (d - c), (1 - fx) * (c - a) + fx * (d - b)], axis=1)
    beyond = at - within
    return value + np.linalg.norm(beyond, axis=1), slope + np.sign(beyond)


def _nearest(pixels: np.ndarray, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """For each pixel (m, 2) the index of the nearest of points (n, 2), and how far (m,)."""
    squared = (pixels**2).sum(axis=1)[:, None] - 2 * pixels @ at.T + (at**2).sum(axis=1)
    nearest = squared.argmin(axis=1)
    return nearest, np.linalg.norm(pixels - at[nearest], axis=1)

"""Over the frames once more, with their final poses: points of regard, and where attention turns to something else."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from ipcli.geometry import lie
from ipcli.measurements.recording import Frame, Gaze, HeadRecording
from ipcli.models.gaze import gric, regard
from ipcli.models.gaze.localise import Path
from ipcli.models.gaze.parameters import Keyframes, Looking
from ipcli.models.gaze.scene_map import NONE
from ipcli.models.gaze.sparse_surface import sparse_surface
from ipcli.models.gaze.surface import Matcher, Surface
from ipcli.models.gaze.tracking import NEIGHBOURS, Track
from ipcli.progress import Progress, silent

NEARER = 0.5  # share of the nearest map point's depth up to which the dense matching still searches


@dataclass(frozen=True, eq=False)
class Regards:
    """A point of regard for every gaze sample, in the world."""

    frames: np.ndarray  # (n,) nearest frame, -1 none
    points: np.ndarray  # (n, 3) metres, NaN unless hit
    covariances: np.ndarray  # (n, 3, 3)
    outcomes: np.ndarray  # (n,) text, one of regard.OUTCOMES
    origins: np.ndarray  # (n, 3) where the ray begins
    directions: np.ndarray  # (n, 3) unit vectors
    pixels: np.ndarray  # (n, 2) of the gaze in the nearest frame's picture


def regards_of(
    path: Path,
    recording: HeadRecording,
    p: Looking,
    tell: Progress = silent,
    keep: Callable[[int, Surface], None] | None = None,
) -> Regards:
    """Points of regard of all samples. `keep` is shown the surface of each frame that has any."""
    gaze = recording.gaze
    assert gaze is not None
    poses = np.stack([track.pose for track in path.tracks])
    gap = 0.75 * float(np.median(np.diff(recording.times))) if len(recording.times) > 1 else 1.0
    frames = regard.nearest_frames(recording.times, gaze.times, gap)
    origins, directions, inside = regard.rays_of(gaze, path.rig)
    at = regard.poses_at(recording.times, poses, gaze.times)
    out = _empty(gaze, frames, inside, poses)
    matcher = Matcher(path.rig, p.disparity_sigma)
    wanted = np.unique(frames[out.outcomes == ""])
    for done, k in enumerate(wanted):
        samples = np.flatnonzero((frames == k) & (out.outcomes == ""))
        rig_now = _relative(poses[k], at[samples])
        o = np.einsum("nij,nj->ni", rig_now[:, :3, :3], origins[samples]) + rig_now[:, :3, 3]
        d = np.einsum("nij,nj->ni", rig_now[:, :3, :3], directions[samples])
        surface = _surface(path, path.tracks[k], recording.load(int(k)), matcher, d)
        if keep:
            keep(int(k), surface)
        world = lie.se3_inverse(poses[k])
        out.origins[samples], out.directions[samples] = o @ world[:3, :3].T + world[:3, 3], d @ world[:3, :3].T
        for sample, origin, direction in zip(samples, o, d, strict=True):
            found = regard.look(surface, origin, direction, p)
            out.outcomes[sample] = found.outcome
            out.points[sample], out.covariances[sample] = regard.in_world(found, poses[k], path.tracks[k].covariance)
        tell((done + 1) / len(wanted), "points of regard")
    return out


def _empty(gaze: Gaze, frames: np.ndarray, inside: np.ndarray, poses: np.ndarray) -> Regards:
    """Outcomes that are known without looking; "" where the ray has yet to be followed."""
    count = len(gaze.times)
    lost = (frames < 0) | ~np.isfinite(poses[np.maximum(frames, 0)]).all(axis=(1, 2))
    outcomes = np.where(~gaze.valid, regard.INVALID, np.where(~inside, regard.OUTSIDE, np.where(lost, regard.LOST, "")))
    outcomes = outcomes.astype("<U10")
    nothing = np.full((count, 3), np.nan)
    return Regards(
        frames, nothing, np.full((count, 3, 3), np.nan), outcomes, nothing.copy(), nothing.copy(), gaze.pixels.copy()
    )


def _relative(pose: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Motions (n, 4, 4) from the rig at the gaze times to the rig of the frame; none where the pose between is lost."""
    known = np.isfinite(at).all(axis=(1, 2))
    moved = np.tile(np.eye(4), (len(at), 1, 1))
    moved[known] = pose @ lie.se3_inverse(at[known])
    return moved


def _surface(path: Path, track: Track, frame: Frame, matcher: Matcher, directions: np.ndarray) -> Surface:
    """By dense matching or a depth camera; before a single camera by the points of the map."""
    rows = matcher.rows_of(directions)
    if frame.right is not None or frame.depth is not None:
        return matcher.surface(frame, _nearest(path, track), rows)
    around = path.scene.points_of(path.scene.covisible(track.ids, NEIGHBOURS))
    inside = path.scene.points[around] @ track.pose[:3, :3].T + track.pose[:3, 3]
    return sparse_surface(inside, path.rig.intrinsics[0], matcher.shape, rows)


def _nearest(path: Path, track: Track) -> float:
    """Metres to what lies nearest before the head, with room for what has no feature."""
    inside = path.scene.points[track.ids] @ track.pose[:3, :3].T + track.pose[:3, 3]
    z = inside[:, 2][inside[:, 2] > 0]
    return NEARER * float(np.percentile(z, 2)) if len(z) else 0.5


@dataclass(eq=False)
class Subsequences:
    """Coherent subsequences, and the curves they were decided by (figure 3.6); a row a frame."""

    numbers: np.ndarray  # (k,) of the subsequence, -1 for a lost frame
    keyframes: np.ndarray  # (k,) bool
    score_f: np.ndarray  # (k,) GRIC of the fundamental matrix to the keyframe, NaN for too few matches
    score_h: np.ndarray
    changes: np.ndarray  # (k,) delta, pixels
    parted: np.ndarray  # (k,) angle between the gaze and the subsequence's PORs, in sigmas of the gaze
    matches: np.ndarray  # (k,)
    flow: np.ndarray  # (k,) median displacement, pixels


@dataclass(eq=False)
class _Open:
    """The subsequence that is being filled."""

    key: int
    gaze: np.ndarray
    regards: list[np.ndarray] = field(default_factory=list)
    changed: list[bool] = field(default_factory=list)


def subsequences(
    path: Path, gaze_pixels: np.ndarray, frame_regards: np.ndarray, p: Keyframes, sigma: float
) -> Subsequences:
    """Split the frames where attention turns (3.5)-(3.7).

    `gaze_pixels` (k, 2): undistorted pixels of the gaze in each frame; `frame_regards` (k, 3): its point of regard; NaN
    unknown. `sigma`: of the gaze, radians. Matches with the keyframe are the map points that both frames see.
    """
    count = len(path.tracks)
    score_f, score_h, changes, parted, flow = (np.full(count, np.nan) for _ in range(5))
    out = Subsequences(
        np.full(count, -1), np.zeros(count, bool), score_f, score_h, changes, parted, np.zeros(count, int), flow
    )
    tau = p.tau * sigma * path.rig.focal
    current: _Open | None = None
    number = -1
    for k, track in enumerate(path.tracks):
        if track.is_lost:
            current = None
            continue
        begins = current is None
        if current is not None:
            begins = _turns(path, k, current, gaze_pixels, frame_regards, out, tau, sigma, p)
        if begins or current is None:
            number += 1
            out.keyframes[k] = True
            current = _Open(k, gaze_pixels[k])
        if np.isfinite(frame_regards[k]).all() and not (current.changed and current.changed[-1]):
            current.regards.append(frame_regards[k])
        out.numbers[k] = number
    return out


def _turns(path: Path, k: int, current: _Open, pixels, regards, out: Subsequences, tau, sigma, p: Keyframes) -> bool:
    """Fill the curves of frame k, and say whether a new subsequence begins with it."""
    before, now = _seen(path, path.tracks[current.key]), _seen(path, path.tracks[k])
    _, a, b = np.intersect1d(before[0], now[0], return_indices=True)
    found = gric.motion(before[1][a], now[1][b], p.sigma)
    out.score_f[k], out.score_h[k] = found.score_f, found.score_h
    out.matches[k], out.flow[k] = found.matches, found.flow
    out.changes[k] = gric.change(found, current.gaze, pixels[k], p.rule)
    if current.regards and np.isfinite(regards[k]).all():
        centre = lie.se3_inverse(path.tracks[k].pose)[:3, 3]
        before, now = np.median(current.regards, axis=0) - centre, regards[k] - centre
        angle = np.arctan2(np.linalg.norm(np.cross(before, now)), before @ now)
        out.parted[k] = angle / sigma
    changed = bool(out.changes[k] > tau) if p.rule == "printed" else bool(out.parted[k] > p.tau)
    if p.rule != "printed" and not np.isfinite(out.parted[k]):
        changed = bool(out.changes[k] > tau)
    current.changed.append(changed)
    late = k - current.key >= p.longest and found.flow > tau and not np.isfinite(out.parted[k])
    return gric.wants_keyframe(current.changed, late, p)


def _seen(path: Path, track: Track) -> tuple[np.ndarray, np.ndarray]:
    """Map points (m,) that a frame sees, and where (m, 2): of the first frame, which rests on none, those it began."""
    if track.how != "first" or track.position == NONE:
        return track.ids, track.left
    frame = path.scene.frames[track.position]
    hit = np.flatnonzero(frame.ids != NONE)
    return frame.ids[hit], frame.features.left[hit]


def gaze_of_frames(path: Path, recording: HeadRecording, regards: Regards | None) -> tuple[np.ndarray, np.ndarray]:
    """For each frame the undistorted pixel (k, 2) and point (k, 3) of its gaze: medians of its samples.

    Without any gaze the head's own direction stands for it: the middle of the picture.
    """
    count = len(path.tracks)
    pixels, points = np.full((count, 2), np.nan), np.full((count, 3), np.nan)
    if regards is None:
        pixels[:] = path.rig.intrinsics[0, :2, 2]
        return pixels, points
    for k in np.unique(regards.frames[regards.frames >= 0]):
        mine = regards.frames == k
        seen = mine & np.isfinite(regards.points).all(axis=1)
        if seen.any():
            points[k] = np.median(regards.points[seen], axis=0)
        rays = regards.directions[mine & np.isfinite(regards.directions).all(axis=1)] @ path.tracks[k].pose[:3, :3].T
        if len(rays):
            pixels[k] = np.median(path.rig.intrinsics[0, :2, :2] @ (rays[:, :2] / rays[:, 2:]).T, axis=1)
            pixels[k] += path.rig.intrinsics[0, :2, 2]
    return pixels, points

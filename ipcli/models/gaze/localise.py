"""From a recording's frames to head poses and a map: online tracking, then the adjustment of everything."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from ipcli import threads
from ipcli.geometry.rig import Rig
from ipcli.measurements.recording import Frame, HeadRecording
from ipcli.models.gaze import adjustment, features, known_map, pose, retrieval
from ipcli.models.gaze.adjustment import Offset
from ipcli.models.gaze.parameters import Localisation
from ipcli.models.gaze.scene_map import NONE, SceneMap
from ipcli.models.gaze.tracking import Track, Tracker
from ipcli.progress import Progress, portion, silent
from ipcli.rng import stream

SAMPLED = 8  # frames whose descriptors the words of the album are learnt from

Look = Callable[[int, Frame, features.StereoFeatures, Track], None]


@dataclass(frozen=True, eq=False)
class Path:
    """The head's path with the map it was found in."""

    rig: Rig
    tracks: list[Track]
    scene: SceneMap
    online: np.ndarray  # (k, 4, 4) rig_from_world as it was known at each frame
    offset: Offset | None
    adjusted: bool


def rig_of(recording: HeadRecording) -> Rig:
    """The rig as geometry takes it."""
    cameras = recording.cameras
    return Rig(
        np.array([camera.size for camera in cameras]),
        np.stack([camera.intrinsics for camera in cameras]),
        tuple(camera.model for camera in cameras),
        tuple(camera.distortion for camera in cameras),
        np.stack([camera.cam_from_rig for camera in cameras]),
    )


def localise(
    recording: HeadRecording,
    p: Localisation,
    seed: int,
    tell: Progress = silent,
    look: Look | None = None,
    known: SceneMap | None = None,
) -> Path:
    """Poses of all frames. `look` sees every frame once, with its features and its track, while it is in memory.

    In a `known` map frames are localised one after the other, and it stays as it is.
    """
    rig = rig_of(recording)
    if known is not None:
        album = known_map.album_of(known, stream(seed, "gaze-sfm", "words"))
        return _tracked(recording, Tracker(rig, album, p, seed, known), tell, look)
    path = _pass(recording, rig, p, seed, portion(tell, 0.0, 0.9), look)
    if not p.global_ba or len(path.scene.frames) < 2:
        return path
    _adjust(path, p, tell)
    offset = None
    if rig.is_stereo and p.self_calibrate != "off":
        tell(0.94, "testing the disparities")
        offset = adjustment.estimate_offset(path.scene, rig, p.mapping)
        if np.isfinite(offset.value) and (p.self_calibrate == "on" or offset.is_certain):
            path = _pass(
                recording, replace(rig, offset=offset.value), p, seed, lambda share, what: tell(0.95, what), look
            )
            _adjust(path, p, tell)
    return _settle(path, p, offset, tell)


def _pass(recording: HeadRecording, rig: Rig, p: Localisation, seed: int, tell: Progress, look: Look | None) -> Path:
    return _tracked(recording, Tracker(rig, album_of(recording, rig, p, seed), p, seed), tell, look)


def _tracked(recording: HeadRecording, tracker: Tracker, tell: Progress, look: Look | None) -> Path:
    rig, p = tracker.rig, tracker.p
    count = len(recording.names)
    online = np.full((count, 4, 4), np.nan)
    for k, (frame, found) in enumerate(_features(recording, rig, p)):
        track = tracker.add(k, found)
        online[k] = track.pose
        if look:
            look(k, frame, found, track)
        tell((k + 1) / count, f"frame {k + 1} of {count}{' lost' if track.is_lost else ''}")
    return Path(rig, tracker.tracks, tracker.scene, online, None, False)


def _features(recording: HeadRecording, rig: Rig, p: Localisation) -> Iterator[tuple[Frame, features.StereoFeatures]]:
    """Frames with their features; with more than one thread the next one's are found while this one is localised."""

    def one(k: int) -> tuple[Frame, features.StereoFeatures]:
        frame = recording.load(k)
        return frame, features.extract(frame.left, frame.right, frame.depth, rig, p.detection)

    numbers = range(len(recording.names))
    return threads.ahead(one, numbers)


def album_of(recording: HeadRecording, rig: Rig, p: Localisation, seed: int) -> retrieval.Album:
    """An empty album whose words suit the recording."""
    sample = np.unique(np.linspace(0, len(recording.names) - 1, SAMPLED).astype(int))
    rng = stream(seed, "gaze-sfm", "words")
    return retrieval.Album(
        retrieval.learn_words([features.detect(recording.load(int(k)).left, p.detection)[2] for k in sample], rng)
    )


def _adjust(path: Path, p: Localisation, tell: Progress) -> None:
    """Everything together, points matched anew in between."""
    scene, rig = path.scene, path.rig
    tell(0.9, "adjusting everything")
    adjustment.everything(scene, rig, p.mapping)
    for _ in range(p.mapping.rounds):
        adjustment.drop_outliers(scene, rig, p.tracking.error)
        adjustment.match_anew(scene, rig)
        adjustment.everything(scene, rig, p.mapping)
    adjustment.drop_outliers(scene, rig, p.tracking.error)


def _settle(path: Path, p: Localisation, offset: Offset | None, tell: Progress) -> Path:
    """A last adjustment, for the covariances, and the frames that are no part of the map after it."""
    solution = adjustment.everything(path.scene, path.rig, p.mapping, with_covariance=True)
    tell(0.98, "placing the other frames")
    for track in path.tracks:
        _replace(track, path.scene, path.rig, p, solution.covariance)
    return Path(path.rig, path.tracks, path.scene, path.online, offset, True)


def _replace(track: Track, scene: SceneMap, rig: Rig, p: Localisation, covariance: np.ndarray | None) -> None:
    """A track's pose after everything moved: that of its map frame, or refined against the points it saw."""
    if track.is_lost:
        return
    if track.position != NONE:
        frame = scene.frames[track.position]
        track.pose = frame.pose
        if covariance is not None:
            track.covariance = covariance[track.position]
        return
    seen = pose.Sightings(scene.points[track.ids], track.left, track.right, track.sigma)
    again = pose.refine(rig, track.pose, seen, cut=p.tracking.error)
    track.pose, track.covariance, track.error = again.rig_from_world, again.covariance, again.error

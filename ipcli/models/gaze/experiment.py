"""All of gaze-sfm on arrays: from a recording to the experiment E of (3.34), as the fields of a `gaze-experiment`."""

from __future__ import annotations

from typing import Any

import numpy as np

from ipcli.errors import NoSolution
from ipcli.geometry import lie
from ipcli.geometry.rig import Rig
from ipcli.measurements.recording import Camera, Frame, Gaze, HeadRecording
from ipcli.models.gaze import attention, checks, evaluation, fixations, localise
from ipcli.models.gaze.features import StereoFeatures
from ipcli.models.gaze.known_map import KnownMap
from ipcli.models.gaze.localise import Path
from ipcli.models.gaze.parameters import Localisation
from ipcli.models.gaze.scene_map import NONE
from ipcli.models.gaze.tracking import Track
from ipcli.progress import Progress, portion, silent

PICTURES = 16  # frames kept to be shown
WIDTH = 360  # pixels of those
SHOWN = 15  # points of regard drawn in a frame, as the thesis has them
NO_GAZE = "no gaze is used: there are no points of regard, and the head's direction splits the subsequences"
COMMON = (
    0.5  # share of a gaze error that all samples of a fixation have in common (calibration), where none is measured
)

Arrays = dict[str, np.ndarray]


class KeptPictures:
    """What is kept of the pictures: some of them made small, and the grey of each map point."""

    def __init__(self, recording: HeadRecording, rig: Rig):
        count = len(recording.names)
        self.rig = rig
        self.wanted = set(np.unique(np.linspace(0, count - 1, PICTURES).astype(int)).tolist())
        self.pictures: dict[int, np.ndarray] = {}
        self.greys: dict[int, np.ndarray] = {}

    def look(self, k: int, frame: Frame, found: StereoFeatures, track: Track) -> None:
        """A frame passes by."""
        import cv2

        if k in self.wanted:
            image = frame.colour if frame.colour is not None else np.repeat(frame.left[..., None], 3, axis=2)
            height = max(1, round(image.shape[0] * WIDTH / image.shape[1]))
            self.pictures[k] = cv2.resize(image, (WIDTH, height), interpolation=cv2.INTER_AREA)
        if track.position != NONE:
            at = np.rint(self.rig.distorted(0, found.left)).astype(int)
            at = np.clip(at, 0, [frame.left.shape[1] - 1, frame.left.shape[0] - 1])
            self.greys[track.position] = frame.left[at[:, 1], at[:, 0]]

    def arrays(self) -> Arrays:
        """The pictures in order."""
        order = sorted(self.pictures)
        return {
            "pictures": np.stack([self.pictures[k] for k in order]),
            "picture_frames": np.array(order, np.int64),
        }


def experiment(
    recording: HeadRecording, p: Localisation, seed: int, tell: Progress = silent, known: KnownMap | None = None
) -> Arrays:
    """Localise, look for points of regard, split into subsequences. NoSolution when no frame has a pose.

    With a `known` map the world and the map are its.
    """
    rig = localise.rig_of(recording)
    album = KeptPictures(recording, rig)
    path = localise.localise(recording, p, seed, portion(tell, 0.0, 0.7), album.look, known.scene if known else None)
    if all(track.is_lost for track in path.tracks):
        raise NoSolution(
            f"no frame could be localised; the first: {path.tracks[0].reason}. 'gaze-sfm check' tells whether the "
            "calibration suits the pictures"
        )
    seen = scene(path, album) if known is None else scene_again(path, album, known)
    arrays = head_path(recording, path) | seen | rig_arrays(recording.cameras)
    regards = None
    if recording.gaze is not None and len(recording.gaze.times):
        regards = attention.regards_of(path, recording, p.looking, portion(tell, 0.7, 0.99))
        arrays |= gaze_arrays(recording.gaze) | looked_at(path, recording.gaze, regards, p)
    pixels, points = attention.gaze_of_frames(path, recording, regards)
    split = attention.subsequences(path, pixels, points, p.keyframes, np.radians(p.looking.sigma))
    arrays |= attended(split) | about(recording, path)
    return arrays | gathered(arrays) | judged(arrays)


def head_path(recording: HeadRecording, path: Path) -> Arrays:
    """Poses and what they rest on."""
    tracks = path.tracks
    poses = lie.se3_inverse(np.stack([track.pose for track in tracks]))
    lost = np.array([track.is_lost for track in tracks])
    poses[lost] = np.nan
    online = lie.se3_inverse(path.online)
    online[~np.isfinite(path.online).all(axis=(1, 2))] = np.nan
    return {
        "world_from_rig": poses,
        "online": online,
        "covariance": np.stack([track.covariance for track in tracks]),
        "lost": lost.astype(np.uint8),
        "how": np.array([track.how for track in tracks]),
        "reasons": np.array([track.reason for track in tracks]),
        "in_map": np.array([track.position != NONE for track in tracks]).astype(np.uint8),
        "matched": np.array([len(np.unique(track.ids)) for track in tracks], np.int64),
        "stereo": np.array([track.stereo for track in tracks], np.int64),
        "error": np.where(lost, np.nan, [track.error for track in tracks]),
        "vertical": np.array([track.vertical for track in tracks]),
    }


def scene(path: Path, album: KeptPictures) -> Arrays:
    """The map: points that fit, their grey, and their sightings."""
    used = np.array([point for point in range(path.scene.count) if len(path.scene.observers[point])], int)
    number = np.full(path.scene.count, NONE)
    number[used] = np.arange(len(used))
    grey, sightings, pixels = np.zeros(len(used), np.uint8), [], []
    for position, frame in enumerate(path.scene.frames):
        hit = np.flatnonzero(frame.ids != NONE)
        grey[number[frame.ids[hit]]] = album.greys[position][hit]
        for camera, image in enumerate((frame.features.left, frame.features.right)):
            seen = hit[np.isfinite(image[hit, 0])]
            columns = (np.full(len(seen), frame.number), np.full(len(seen), camera), number[frame.ids[seen]])
            sightings.append(np.stack(columns, axis=1))
            pixels.append(path.rig.distorted(camera, image[seen]) if len(seen) else image[seen])
    return {
        "map/points": path.scene.points[used],
        "map/grey": grey,
        "map/descriptors": path.scene.descriptors[used],
        "map/seen": np.array([len(path.scene.observers[point]) for point in used], np.int64),
        "map/sightings": np.concatenate(sightings).astype(np.int64),
        "map/pixels": np.concatenate(pixels),
    } | album.arrays()


def scene_again(path: Path, album: KeptPictures, known: KnownMap) -> Arrays:
    """The map of an earlier run, as this recording sees it."""
    sightings, pixels = [np.empty((0, 3), np.int64)], [np.empty((0, 2))]
    for track in path.tracks:
        for camera, image in enumerate((track.left, track.right)[: len(path.rig.models)]):
            hit = np.isfinite(image[:, 0])
            columns = (np.full(hit.sum(), track.number), np.full(hit.sum(), camera), track.ids[hit])
            sightings.append(np.stack(columns, axis=1))
            pixels.append(path.rig.distorted(camera, image[hit]) if hit.any() else image[hit])
    rows = np.concatenate(sightings).astype(np.int64)
    own = np.unique(rows[:, [0, 2]], axis=0)[:, 1]
    return {
        "map/points": known.scene.points,
        "map/grey": known.grey,
        "map/descriptors": known.scene.descriptors,
        "map/seen": np.bincount(own, minlength=known.scene.count).astype(np.int64),
        "map/sightings": rows,
        "map/pixels": np.concatenate(pixels),
    } | album.arrays()


def rig_arrays(cameras: tuple[Camera, ...]) -> Arrays:
    """The calibration."""
    distortion = np.full((len(cameras), 12), np.nan)
    for row, camera in zip(distortion, cameras, strict=True):
        row[: len(camera.distortion)] = camera.distortion
    return {
        "rig/sizes": np.array([camera.size for camera in cameras], np.int64),
        "rig/intrinsics": np.stack([camera.intrinsics for camera in cameras]).astype(np.float64),
        "rig/models": np.array([camera.model for camera in cameras]),
        "rig/distortion": distortion,
        "rig/cam_from_rig": np.stack([camera.cam_from_rig for camera in cameras]).astype(np.float64),
    }


def gaze_arrays(gaze: Gaze) -> Arrays:
    """The gaze as it was recorded."""
    arrays: Arrays = {
        "gaze/times": gaze.times.astype(np.float64),
        "gaze/pixels": gaze.pixels.astype(np.float64),
        "gaze/valid": gaze.valid.astype(np.uint8),
    }
    for name in ("directions", "origins", "labels"):
        value = getattr(gaze, name)
        if value is not None:
            arrays[f"gaze/{name}"] = value
    return arrays


def looked_at(path: Path, gaze: Gaze, regards: attention.Regards, p: Localisation) -> Arrays:
    """Points of regard, fixations, and up to `SHOWN` points drawn in each frame."""
    spans = fixations.find(gaze.times, regards.directions, p.looking.fixation, p.looking.shortest)
    found = fixations.summarise(spans, regards.points, regards.covariances, COMMON)
    return {
        "por/points": regards.points,
        "por/covariance": regards.covariances,
        "por/outcome": regards.outcomes,
        "por/frame": regards.frames.astype(np.int64),
        "por/origins": regards.origins,
        "por/directions": regards.directions,
        "por/fixation": found.of_sample.astype(np.int64),
        "fixations/span": found.spans.astype(np.int64),
        "fixations/points": found.points,
        "fixations/covariance": found.covariances,
    } | _shown(path, gaze, regards)


def _shown(path: Path, gaze: Gaze, regards: attention.Regards) -> Arrays:
    """R_POR: the points of regard nearest in time, in the pixels of each frame's picture."""
    hit = np.flatnonzero(np.isfinite(regards.points).all(axis=1))
    rows, size = [], path.rig.sizes[0]
    for k, track in enumerate(path.tracks):
        mine = np.flatnonzero(regards.frames == k)
        if track.is_lost or not len(mine) or not len(hit):
            continue
        middle = gaze.times[mine].mean()
        near = hit[np.argsort(np.abs(gaze.times[hit] - middle), kind="stable")[:SHOWN]]
        seen = path.rig.project(0, regards.points[near] @ track.pose[:3, :3].T + track.pose[:3, 3])
        drawn = path.rig.distorted(0, seen)
        inside = ((drawn >= 0) & (drawn <= size - 1)).all(axis=1)
        rows += [(k, sample, *pixel) for sample, pixel in zip(near[inside], drawn[inside], strict=True)]
    table = np.array(rows).reshape(-1, 4)
    return {
        "shown/frame": table[:, 0].astype(np.int64),
        "shown/sample": table[:, 1].astype(np.int64),
        "shown/pixels": np.ascontiguousarray(table[:, 2:]),
    }


def attended(split: attention.Subsequences) -> Arrays:
    """Subsequences and the curves they were decided by."""
    return {
        "subsequence": split.numbers.astype(np.int64),
        "keyframe": split.keyframes.astype(np.uint8),
        "gric_f": np.where(np.isfinite(split.score_f), split.score_f, np.nan),
        "gric_h": np.where(np.isfinite(split.score_h), split.score_h, np.nan),
        "change": np.where(np.isfinite(split.changes), split.changes, np.nan),
        "parted": split.parted,
    }


def about(recording: HeadRecording, path: Path) -> Arrays:
    """Names, times, truth, the offset, and what a reader must be told."""
    gaps = {"frame_gap": recording.times, "gaze_gap": recording.gaze.times if recording.gaze else np.empty(0)}
    middle = np.median(path.scene.points[: path.scene.count], axis=0)
    poses = np.stack([track.pose for track in path.tracks])
    offset = path.offset
    arrays: dict[str, Any] = {
        "names": np.array(recording.names),
        "times": recording.times.astype(np.float64),
        "observer": poses[:, :3, :3] @ middle + poses[:, :3, 3],
        "offset": np.float64(path.rig.offset),
        "offset_blocks": np.empty(0) if offset is None else offset.blocks,
        "offset_estimate": np.float64(np.nan if offset is None else offset.value),
        "offset_error": np.float64(np.nan if offset is None or not np.isfinite(offset.error) else offset.error),
        "notes": np.array(notes(recording, path), dtype=np.str_).reshape(-1),
        "source": np.array(recording.source),
    }
    for name, times in gaps.items():
        arrays[name] = np.float64(np.median(np.diff(times)) if len(times) > 1 else np.nan)
    for name in ("truth", "targets"):
        if getattr(recording, name) is not None:
            arrays[name] = np.asarray(getattr(recording, name), np.float64)
    if recording.targets is not None:
        arrays["target_names"] = np.array(recording.target_names)
    return arrays


def notes(recording: HeadRecording, path: Path) -> list[str]:
    """What was left out, and what looks wrong."""
    found = [*recording.dropped, *(recording.gaze.dropped if recording.gaze else ())]
    lost = [track for track in path.tracks if track.is_lost]
    if lost:
        found.append(f"{len(lost)} of {len(path.tracks)} frames are lost; the first: {lost[0].reason}")
    if recording.gaze is None:
        found.append(NO_GAZE)
    vertical = float(np.nanmedian([track.vertical for track in path.tracks])) if path.rig.is_stereo else 0.0
    if abs(vertical) > 1.0:
        found.append(f"rows of the two cameras differ by {vertical:.2f} px: the calibration may be of another rig")
    return found + checks.rig_words(path.rig) + checks.gaze_words(recording.gaze)


def gathered(a: Arrays) -> Arrays:
    """Coherent subsequences one by one: their frames and their points of regard."""
    count = int(a["subsequence"].max()) + 1
    table = {name: np.full(shape, np.nan) for name, shape in (("points", (count, 3)), ("extent", (count,)))}
    spans, regards = np.zeros((count, 2), np.int64), np.zeros(count, np.int64)
    for number in range(count):
        frames = np.flatnonzero(a["subsequence"] == number)
        spans[number] = frames[0], frames[-1] + 1
        if "por/points" not in a:
            continue
        mine = (a["por/outcome"] == "hit") & np.isin(a["por/frame"], frames)
        regards[number] = mine.sum()
        if mine.any():
            table["points"][number] = np.median(a["por/points"][mine], axis=0)
            off = a["por/points"][mine] - table["points"][number]
            table["extent"][number] = np.sqrt(np.square(off).sum(axis=1).mean())
    found = {"frames": spans, "regards": regards, **table}
    return {f"subsequences/{name}": value for name, value in found.items()}


def judged(a: Arrays) -> Arrays:
    """Errors against the truth, and for each label of the gaze the time on it and, with its place, the errors there."""
    found: Arrays = {}
    if "truth" in a:
        errors = evaluation.path_errors(a["world_from_rig"], a["truth"], a["online"])
        online = errors.online.rmse if errors.online else np.nan
        found["accuracy/path"] = np.array([errors.rigid.rmse, errors.similar.rmse, errors.similar.scale, online])
    if "gaze/labels" in a:
        labels = [label for label in np.unique(a["gaze/labels"]) if label]
        rows = [_at_label(a, label) for label in labels]
        found |= {
            "accuracy/labels": np.array(labels, dtype=np.str_).reshape(-1),
            "accuracy/regards": np.array([row[0] for row in rows], np.int64),
            "accuracy/dwell": np.array([row[1] for row in rows], np.float64),
            "accuracy/rms": np.array([row[2] for row in rows], np.float64),
            "accuracy/inside": np.array([row[3:] for row in rows], np.float64).reshape(-1, 2),
        }
    return found


def _at_label(a: Arrays, label: str) -> tuple[int, float, float, float, float]:
    """Points of regard, seconds, RMS error, shares of truth in the regions; NaN where the place is not known."""
    mine = a["gaze/labels"] == label
    hit = mine & (a["por/outcome"] == "hit")
    dwell = float(mine.sum() * a["gaze_gap"])
    known = label in a.get("target_names", ()) and "truth" in a
    if not known or not hit.any():
        return int(hit.sum()), dwell, np.nan, np.nan, np.nan
    place = a["targets"][list(a["target_names"]).index(label)]
    moved = evaluation.registration(a["world_from_rig"], a["truth"])
    places = np.broadcast_to(place, (int(hit.sum()), 3))
    errors, squares = evaluation.target_errors(a["por/points"][hit], a["por/covariance"][hit], places, moved)
    inside = evaluation.coverage(squares)
    return int(hit.sum()), dwell, float(np.sqrt(np.nanmean(errors**2))), inside[0.68], inside[0.95]

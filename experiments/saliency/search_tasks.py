"""Search tasks: a room with coloured parcels, some of them as wanted, and a searcher who looks from one to the next.

The searcher is drawn to parcels that look as the wanted one does (with what is near pulling a little more) and does not
go back at once to where they have been: inhibition of return. What they want is a hue; the rest of the room, and
parcels of other hues, are of no interest but for an occasional stray look.
"""

from __future__ import annotations

import colorsys
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from experiments.gaze import room
from ipcli.geometry import lens, lie
from ipcli.io.files import h5
from ipcli.measurements.recording import HeadRecording
from ipcli.models.gaze.experiment import rig_arrays

TASKS = {"red": 0.0, "yellow": 0.15, "blue": 0.62, "pink": 0.87}  # what is looked for, and its hue
WALLS = np.array([1.06, 1.0, 0.92])
PARCEL = 0.2  # metres: half a side
APART = 0.75  # metres between parcels
SHOTS = 3  # pictures of each subsequence
POINTS = 4_000  # of the map, seen in each subsequence
DISPARITY = 0.15  # pixels: their error


@dataclass(frozen=True)
class Searcher:
    """How attention moves."""

    likeness: float = 7.0  # how much a parcel of the wanted hue draws more than one of the opposite
    near: float = 0.25  # per metre: what is far away draws less
    inhibition: float = 4.0  # how little a parcel draws that was just looked at
    return_after: float = 3.0  # seconds in which that fades


def task(name: str, seed: int, parcels: int = 14, wanted: int = 6, searcher: Searcher | None = None) -> room.Place:
    """The room of a task: `wanted` of the parcels are of about its hue, all others of hues far from it."""
    rng = np.random.default_rng([seed, sorted(TASKS).index(name)])
    hue = TASKS[name]
    hues = np.concatenate([hue + rng.uniform(-0.03, 0.03, wanted), hue + rng.uniform(0.2, 0.8, parcels - wanted)]) % 1
    middles = _spread(rng, parcels)
    boxes = np.stack([middles - PARCEL, middles + PARCEL], axis=1)
    tint = np.array([WALLS, *(_colour(value, rng) for value in hues)])
    likeness = np.cos(2 * np.pi * (hues - hue))
    names = tuple(f"{'wanted' if k < wanted else 'other'} {k}" for k in range(parcels))
    turning = partial(search, middles=middles, likeness=likeness, searcher=searcher or Searcher())
    return room.Place(boxes, middles, names, turning, tint)


def _colour(hue: float, rng: np.random.Generator) -> np.ndarray:
    return 1.5 * np.array(colorsys.hsv_to_rgb(hue, rng.uniform(0.6, 0.9), rng.uniform(0.85, 1.0)))


def _spread(rng: np.random.Generator, count: int) -> np.ndarray:
    """Places (count, 3) on the walls before the wearer and at their sides, and on the floor, no two near each other."""
    low, high = room.ROOM + PARCEL * np.array([[1.0], [-1.0]])
    found: list[np.ndarray] = []
    while len(found) < count:
        at = rng.uniform(low, high)
        side = int(rng.integers(4))
        if side < 2:
            at[2] = high[2]
        elif side == 2:
            at[0] = high[0] if at[0] > 0 else low[0]
            at[2] = max(at[2], 0.3)
        else:
            at[1], at[2] = high[1], rng.uniform(1.2, high[2])
        if all(np.linalg.norm(at - other) > APART for other in found):
            found.append(at)
    return np.array(found)


def search(
    rng: np.random.Generator,
    end: float,
    dwell: tuple[float, float],
    *,
    middles: np.ndarray,
    likeness: np.ndarray,
    searcher: Searcher,
) -> tuple[np.ndarray, np.ndarray]:
    """Times at which attention turns (the first is 0) and the parcel that it turns to."""  # fmt: skip
    switches, order = [0.0], [int(likeness.argmax())]
    last = np.full(len(middles), -np.inf)
    while switches[-1] < end:
        now = switches[-1] + rng.uniform(*dwell)
        last[order[-1]] = now
        far = np.linalg.norm(middles - middles[order[-1]], axis=1)
        recent = np.exp(-(now - last) / searcher.return_after)
        pull = searcher.likeness * likeness - searcher.near * far - searcher.inhibition * recent
        pull[order[-1]] = -np.inf
        chance = np.exp(pull - pull.max())
        order.append(int(rng.choice(len(middles), p=chance / chance.sum())))
        switches.append(now)
    return np.array(switches), np.array(order)


def experiment(course: room.Course, seed: int, place: room.Place) -> dict[str, np.ndarray]:
    """A `gaze-experiment` as gaze-sfm would have found it: true poses, subsequences and points of regard of a noisy
    gaze, a map of points with the error that stereo has.
    """
    walk = room.walk(course, seed, place)
    recording, rng = walk.recording, np.random.default_rng([seed, 1])
    gaze, count = recording.gaze, len(recording.times)
    assert gaze is not None
    assert gaze.labels is not None
    starts = np.array([key for key in walk.keyframes if key < count], int)
    spans = np.stack([starts, np.append(starts[1:], count)], axis=1)
    regards = _regards(recording, place)
    frame = np.abs(gaze.times[:, None] - recording.times).argmin(axis=1)
    focus = np.searchsorted(starts, np.arange(count), side="right") - 1
    shots = np.unique(np.concatenate([np.linspace(first, stop - 1, SHOTS).astype(int) for first, stop in spans]))
    maps = [_mapped(walk, (first + stop - 1) // 2, rng) for first, stop in spans]
    counts = [len(points) for points in maps]
    seen = np.repeat([(first + stop - 1) // 2 for first, stop in spans], counts)
    medians = np.array([np.nanmedian(regards[(frame >= a) & (frame < b)], axis=0) for a, b in spans])
    arrays = {
        "names": np.array(recording.names), "times": recording.times, "world_from_rig": recording.truth,
        "subsequence": focus, "keyframe": np.isin(np.arange(count), starts).astype(np.uint8),
        "gaze/times": gaze.times, "gaze/pixels": gaze.pixels,
        "gaze/valid": gaze.valid.astype(np.uint8), "gaze/labels": gaze.labels,
        "por/points": regards, "por/frame": frame,
        "por/outcome": np.where(np.isfinite(regards).all(axis=1), "hit", "outside"),
        "map/points": np.concatenate(maps), "map/grey": np.full(len(seen), 128, np.uint8),
        "map/seen": np.ones(len(seen), np.int64),
        "map/sightings": np.stack([seen, np.zeros(len(seen), int), np.arange(len(seen))], axis=1),
        "map/pixels": np.zeros((len(seen), 2)),
        "pictures": np.stack([_colours(recording, int(k)) for k in shots]), "picture_frames": shots,
        "subsequences/frames": spans, "subsequences/points": medians,
        "subsequences/regards": np.array([((frame >= a) & (frame < b)).sum() for a, b in spans]),
        "subsequences/extent": np.zeros(len(spans)),
        "truth": recording.truth, "source": np.array("generated search task"), "notes": np.array([], dtype="U1"),
    }  # fmt: skip
    return arrays | _bookkeeping(recording, count)


def _colours(recording: HeadRecording, k: int) -> np.ndarray:
    colour = recording.load(k).colour
    assert colour is not None
    return colour


def _regards(recording: HeadRecording, place: room.Place) -> np.ndarray:
    """Where the rays of the gaze meet the scene (n, 3)."""
    camera, gaze, truth = recording.cameras[0], recording.gaze, recording.truth
    assert gaze is not None
    assert truth is not None
    ideal = lens.undistort(camera.model, camera.distortion, lens.normalised_of(gaze.pixels, camera.intrinsics))
    before = np.clip(np.searchsorted(recording.times, gaze.times, side="right") - 1, 0, len(recording.times) - 2)
    share = (gaze.times - recording.times[before]) / np.diff(recording.times)[before]
    poses = np.stack(
        [lie.se3_interpolate(truth[k], truth[k + 1], np.array(s)) for k, s in zip(before, share, strict=True)]
    )
    rays = np.einsum("nij,nj->ni", poses[:, :3, :3], np.concatenate([ideal, np.ones((len(ideal), 1))], axis=1))
    length, _ = room.meet(poses[:, :3, 3], rays, place.boxes)
    return poses[:, :3, 3] + length[:, None] * rays


def _mapped(walk: room.Walk, k: int, rng: np.random.Generator) -> np.ndarray:
    """Points (n, 3) that stereo would have found in a frame: some pixels, with an error of their disparity."""
    camera, depth = walk.recording.cameras[0], walk.depth(k)
    pixels = rng.uniform(0, np.array(camera.size) - 1, (POINTS, 2))
    near = np.rint(pixels).astype(int)
    z = depth[near[:, 1], near[:, 0]]
    ideal = lens.undistort(camera.model, camera.distortion, lens.normalised_of(near.astype(float), camera.intrinsics))
    base = camera.intrinsics[0, 0] * room.BASELINE
    z = base / (base / z + rng.normal(0, DISPARITY, POINTS))
    points = z[:, None] * np.concatenate([ideal, np.ones((POINTS, 1))], axis=1)
    truth = walk.recording.truth
    assert truth is not None
    pose = truth[k]
    return points @ pose[:3, :3].T + pose[:3, 3]


def _bookkeeping(recording: HeadRecording, count: int) -> dict[str, np.ndarray]:
    """What an experiment holds beside: as if every frame had been found without doubt."""
    assert recording.gaze is not None
    many = len(recording.gaze.times)
    unknown, zero, none = np.full(count, np.nan), np.zeros(count, np.int64), np.full(many, -1)
    arrays: dict[str, Any] = {
        "covariance": np.full((count, 6, 6), np.nan), "online": np.asarray(recording.truth),
        "lost": zero.astype(np.uint8),
        "how": np.full(count, "predicted"), "reasons": np.full(count, "", "U1"), "in_map": np.ones(count, np.uint8),
        "matched": zero, "stereo": zero, "error": unknown, "vertical": unknown, "gric_f": unknown, "gric_h": unknown,
        "change": unknown, "parted": unknown, "observer": np.full((count, 3), np.nan),
        "frame_gap": np.float64(np.median(np.diff(recording.times))),
        "gaze_gap": np.float64(np.median(np.diff(recording.gaze.times))),
        "offset": np.float64(0), "offset_blocks": np.empty(0), "offset_estimate": np.float64(np.nan),
        "offset_error": np.float64(np.nan), "por/covariance": np.full((many, 3, 3), np.nan),
        "por/origins": np.full((many, 3), np.nan), "por/directions": np.full((many, 3), np.nan),
        "por/fixation": none, "fixations/span": np.empty((0, 2), np.int64), "fixations/points": np.empty((0, 3)),
        "fixations/covariance": np.empty((0, 3, 3)),
        "shown/frame": np.empty(0, np.int64), "shown/sample": np.empty(0, np.int64), "shown/pixels": np.empty((0, 2)),
    }  # fmt: skip
    return arrays | rig_arrays(recording.cameras)


def main() -> None:
    """`python -m experiments.saliency.search_tasks red --seed 1 X.gaze.h5`, or a folder for the recording itself."""
    import argparse

    parser = argparse.ArgumentParser(description="Write a search task: an experiment X.h5, or a folder as of EuRoC.")
    parser.add_argument("task", choices=sorted(TASKS))
    parser.add_argument("output", type=Path)
    for name, default in (("seed", 1), ("frames", 450), ("width", 360), ("height", 270)):
        parser.add_argument(f"--{name}", type=int, default=default)
    given = parser.parse_args()
    course = room.Course(given.frames, width=given.width, height=given.height, dwell=(0.6, 1.2), noise=1.2)
    place = task(given.task, given.seed)
    if given.output.suffix == ".h5":
        about = {"command": f"search task {given.task}, seed {given.seed}", "params": {}, "inputs": [], "digest": ""}
        h5.write(given.output, "gaze-experiment", experiment(course, given.seed, place), about)
    else:
        room.write_euroc(room.walk(course, given.seed, place), given.output)


if __name__ == "__main__":
    main()

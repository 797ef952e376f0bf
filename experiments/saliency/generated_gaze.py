"""Gaze for a recording that has none: somebody who looks at a few real places of its scene, one after the other.

    python -m experiments.saliency.generated_gaze RECORDING gaze.csv

A place is a textured point found by stereo and put into the world by the recording's true poses. Attention stays on one
while it is in view, for some frames, and then turns to another in view, sooner to one not looked at lately. Each frame
gets some samples around its time, with an angular error. What hides a place in between is not known, so some looks
fall on what is before it.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from ipcli.geometry import lens, lie
from ipcli.io.files import atomic
from ipcli.io.gaze import layouts
from ipcli.measurements.recording import Camera, HeadRecording

PLACES, SAMPLES = 8, 9  # places looked at; gaze samples of a frame
SPREAD = 0.02  # seconds around a frame's time
DWELL = (3, 6)  # frames on a place
APART = 0.8  # metres between places
NEAR, FAR = 0.8, 6.0  # metres: a place that is looked at
MARGIN = 0.12  # of a picture's side: looks are nearer to its middle
EPIPOLAR = 0.003  # of a focal length: how far a match may be off its line
EVERY = 4  # frames that places are looked for in


def stereo_points(recording: HeadRecording, k: int) -> np.ndarray:
    """Points (n, 3) of frame k in the true world, by matching key points of its two pictures."""
    import cv2

    frame, truth = recording.load(k), recording.truth
    assert frame.right is not None
    assert truth is not None
    finder = cv2.SIFT.create(800)
    (one, first), (two, second) = (finder.detectAndCompute(image, None) for image in (frame.left, frame.right))
    pairs = cv2.BFMatcher(cv2.NORM_L2, crossCheck=True).match(first, second)
    left = _rays(recording.cameras[0], np.array([one[m.queryIdx].pt for m in pairs]))
    right = _rays(recording.cameras[1], np.array([two[m.trainIdx].pt for m in pairs]))
    pose = recording.cameras[1].cam_from_rig
    essential = lie.hat(pose[:3, 3]) @ pose[:3, :3]
    line = left @ essential.T
    good = np.abs((right * line).sum(axis=1)) < EPIPOLAR * np.hypot(line[:, 0], line[:, 1])
    solid = cv2.triangulatePoints(np.eye(3, 4), pose[:3], left[good, :2].T.copy(), right[good, :2].T.copy())
    points = (solid[:3] / solid[3]).T
    points = points[(points[:, 2] > NEAR) & (points[:, 2] < FAR)]
    return points @ truth[k][:3, :3].T + truth[k][:3, 3]


def _rays(camera: Camera, pixels: np.ndarray) -> np.ndarray:
    """Directions (n, 3) with z = 1 of pixels (n, 2)."""
    ideal = lens.undistort(camera.model, camera.distortion, lens.normalised_of(pixels, camera.intrinsics))
    return np.concatenate([ideal, np.ones((len(ideal), 1))], axis=1)


def views_of(recording: HeadRecording, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pixels (k, p, 2) of places (p, 3) in each frame, and whether they are well inside of it and near enough."""
    camera, truth = recording.cameras[0], recording.truth
    assert truth is not None
    inside = np.swapaxes(truth[:, :3, :3], 1, 2)
    local = np.einsum("kij,kpj->kpi", inside, places[None] - truth[:, None, :3, 3])
    z = local[..., 2]
    ideal = local[..., :2] / np.where(z > 0.1, z, np.nan)[..., None]
    pixels = lens.pixels_of(lens.distort(camera.model, camera.distortion, ideal), camera.intrinsics)
    size = np.array(camera.size)
    seen = ((pixels > MARGIN * size) & (pixels < (1 - MARGIN) * size)).all(axis=-1) & (z > NEAR) & (z < FAR)
    return pixels, seen & (np.abs(ideal) < 0.8).all(axis=-1)


def places_of(recording: HeadRecording) -> np.ndarray:
    """The places (p, 3) that are in view most often, none near another."""
    count = len(recording.names)
    points = np.concatenate([stereo_points(recording, k) for k in range(0, count, EVERY)])
    left, chosen = views_of(recording, points)[1], list[int]()
    fresh = np.ones(len(points), bool)
    while len(chosen) < PLACES and fresh.any():
        best = int(np.where(fresh, left.sum(axis=0), -1).argmax())
        chosen.append(best)
        fresh &= np.linalg.norm(points - points[best], axis=1) > APART
        left = left & ~(left[:, best : best + 1] & (np.arange(count) % 2 == 0)[:, None])  # half of what it explains
    return points[chosen]


def attention(seen: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """The place looked at in each frame (k,), -1 where none of those in view (k, p)."""
    looked, last = np.full(len(seen), -1), np.full(seen.shape[1], -np.inf)
    now, until = -1, 0
    for k, view in enumerate(seen):
        if now < 0 or k >= until or not view[now]:
            others = np.flatnonzero(view & (np.arange(len(view)) != now))
            stays = now >= 0 and bool(view[now])
            now = (
                int(others[np.lexsort((rng.random(len(others)), last[others]))[0]])
                if len(others)
                else now
                if stays
                else -1
            )
            until = k + int(rng.integers(*DWELL, endpoint=True))
        looked[k] = now
        if now >= 0:
            last[now] = k
    return looked


def gaze_lines(recording: HeadRecording, places: np.ndarray, noise: float, seed: int) -> list[str]:
    """Lines of a gaze.csv; noise is the root mean square angle of its error, in degrees."""
    rng = np.random.default_rng(seed)
    pixels, seen = views_of(recording, places)
    looked = attention(seen, rng)
    sigma = np.radians(noise) / np.sqrt(2) * recording.cameras[0].intrinsics[0, 0]
    lines = ["time [s],x [px],y [px],valid,label"]
    for k in np.flatnonzero(looked >= 0):
        for shift in np.linspace(-SPREAD, SPREAD, SAMPLES):
            x, y = pixels[k, looked[k]] + rng.normal(0, sigma, 2)
            lines.append(f"{recording.times[k] + shift:.6f},{x:.3f},{y:.3f},1,place {looked[k]}")
    return lines


def main() -> None:
    """Write the gaze, and the places beside it."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("recording", type=Path)
    parser.add_argument("output", type=Path)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--noise", type=float, default=1.0, help="degrees")
    given = parser.parse_args()
    recording = layouts.open_recording(given.recording)
    places = places_of(recording)
    atomic.write_text(given.output, "\n".join(gaze_lines(recording, places, given.noise, given.seed)) + "\n")
    lines = [f"place {n},{x:.4f},{y:.4f},{z:.4f}" for n, (x, y, z) in enumerate(places)]
    atomic.write_text(given.output.with_name("targets.csv"), "\n".join(["name,x [m],y [m],z [m]", *lines]) + "\n")


if __name__ == "__main__":
    main()

"""Features of a stereo frame: SIFT in both pictures, matched along the epipolar lines, triangulated."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ipcli import threads
from ipcli.geometry.rig import Rig
from ipcli.kernels import matching
from ipcli.models.gaze.parameters import Detection

WORST = 80000  # largest squared distance of two matching descriptors (262144 = 1)
FLAT = 2.0  # grey levels: standard deviation of a picture that shows nothing


@dataclass(frozen=True, eq=False)
class StereoFeatures:
    """Features of the left picture of a frame, with their partners in the right one."""

    left: np.ndarray  # (n, 2) float64 undistorted pixels
    right: np.ndarray  # (n, 2), NaN without a partner
    points: np.ndarray  # (n, 3) metres in the rig's frame, NaN without a partner
    sigma: np.ndarray  # (n,) pixels: standard deviation of the place
    descriptors: np.ndarray  # (n, 128) uint8
    rows: np.ndarray  # (n,) the order of the left features by row
    vertical: float = np.nan  # median vertical disparity, pixels
    usable: bool = True  # False for a dark or empty picture

    def __len__(self) -> int:
        return len(self.left)


def extract(
    left: np.ndarray, right: np.ndarray | None, depth: np.ndarray | None, rig: Rig, p: Detection
) -> StereoFeatures:
    """Features of pictures (h, w) uint8; of one camera alone they have no points, unless there is depth (metres)."""
    images = [image for image in (left, right) if image is not None]
    found = threads.each(lambda image: detect(image, p), images)
    seen = [rig.undistorted(camera, pixels) for camera, (pixels, _, _) in enumerate(found)]
    known = np.isfinite(seen[0]).all(axis=1)
    pixels, sizes, descriptors = (part[known] for part in found[0])
    undistorted = seen[0][known]
    rows = np.argsort(undistorted[:, 1], kind="stable")
    usable = left.std() > FLAT
    sigma = np.maximum(1.0, sizes / 4.0)
    partner, points, vertical = np.full((len(pixels), 2), np.nan), np.full((len(pixels), 3), np.nan), np.nan
    if right is not None and len(pixels) and len(seen[1]):
        partner, points, vertical = _stereo(undistorted, descriptors, seen[1], found[1][2], rig, p)
    elif depth is not None:
        points = _measured(pixels, undistorted, depth, rig)
    return StereoFeatures(undistorted, partner, points, sigma, descriptors, rows, vertical, bool(usable))


def detect(image: np.ndarray, p: Detection) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """SIFT: pixels (n, 2) with centres at integers, sizes (n,), RootSIFT descriptors (n, 128) uint8."""
    import cv2

    sift = cv2.SIFT.create(nfeatures=p.count, contrastThreshold=p.contrast, edgeThreshold=10, sigma=1.6)
    keypoints, descriptors = sift.detectAndCompute(image, None)
    if not keypoints:
        return np.empty((0, 2)), np.empty(0), np.empty((0, 128), np.uint8)
    pixels = np.array([keypoint.pt for keypoint in keypoints])
    sizes = np.array([keypoint.size for keypoint in keypoints])
    return pixels, sizes, root(descriptors)


def root(descriptors: np.ndarray) -> np.ndarray:
    """RootSIFT (Arandjelovic 2012) in bytes: the square root of each share, 255 for 1."""
    total = np.maximum(descriptors.sum(axis=1, keepdims=True), 1e-9)
    return np.minimum(np.rint(512 * np.sqrt(descriptors / total)), 255).astype(np.uint8)


def _stereo(left, left_descriptors, right, right_descriptors, rig: Rig, p: Detection):
    """Partners in the right picture, points, and the median vertical disparity. Both ways must agree."""
    flat_left, flat_right = rig.rectified(0, left), rig.rectified(1, right)
    flat_right = np.where(np.isfinite(flat_right).all(axis=1, keepdims=True), flat_right, np.inf)
    order = np.argsort(flat_right[:, 1], kind="stable")
    most = rig.focal * rig.baseline / p.nearest
    match, _ = matching.in_band(
        flat_left, flat_right, left_descriptors, right_descriptors, order, p.band, 0.05, most, p.ratio**2, WORST
    )
    match = _mutual(match, flat_left, flat_right, left_descriptors, right_descriptors, p, most)
    hit = np.flatnonzero(match >= 0)
    partner, points = np.full((len(left), 2), np.nan), np.full((len(left), 3), np.nan)
    if not hit.size:
        return partner, points, np.nan
    partner[hit] = right[match[hit]]
    points[hit] = rig.triangulated(flat_left[hit], flat_right[match[hit]])
    return partner, points, float(np.median(flat_left[hit, 1] - flat_right[match[hit], 1]))


def _mutual(match, flat_left, flat_right, left_descriptors, right_descriptors, p: Detection, most: float):
    """Keep a match only if it is also the best the other way round."""
    order = np.argsort(flat_left[:, 1], kind="stable")
    back, _ = matching.in_band(
        np.where(np.isfinite(flat_right), flat_right, np.nan), flat_left, right_descriptors, left_descriptors, order,
        p.band, -most, -0.05, 1.0, WORST,
    )  # fmt: skip
    hit = match >= 0
    hit[hit] = back[match[hit]] == np.flatnonzero(hit)
    return np.where(hit, match, -1)


def _measured(pixels: np.ndarray, undistorted: np.ndarray, depth: np.ndarray, rig: Rig) -> np.ndarray:
    """Points of a depth map at the nearest pixels."""
    at = np.rint(pixels).astype(int)
    at = np.clip(at, 0, [depth.shape[1] - 1, depth.shape[0] - 1])
    return depth[at[:, 1], at[:, 0], None].astype(np.float64) * rig.rays(0, undistorted)

"""Boolean maps: what is surrounded stands out (Zhang and Sclaroff, Saliency Detection: A Boolean Map Approach)."""

from __future__ import annotations

import numpy as np

STEP = 8  # of 256 levels between thresholds
OPENING = 3  # pixels: smaller specks are no figures
DILATION = 9  # pixels by which a figure grows before maps are added, at 200 pixels along


def boolean_map_saliency(features: np.ndarray, step: int = STEP, dilation: int = DILATION) -> np.ndarray:
    """Attention map (h, w) float32 of feature channels (h, w, c) uint8: the mean over thresholds of the figures that
    do not touch the border, each map scaled to the same L2 norm so that small figures count more.
    """
    import cv2

    features = np.asarray(features)
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (dilation, dilation))
    total = np.zeros(features.shape[:2], np.float32)
    for channel in np.moveaxis(features, 2, 0):
        for threshold in range(int(channel.min()) + step // 2, int(channel.max()), step):
            above = (channel > threshold).astype(np.uint8)
            for figure in (above, 1 - above):
                total += _attention(figure, kernel)
    return total


def _attention(figure: np.ndarray, kernel: np.ndarray) -> np.ndarray:
    """One Boolean map (h, w) uint8: its surrounded regions, grown, with unit L2 norm; zeros if there are none."""
    import cv2

    figure = cv2.morphologyEx(figure, cv2.MORPH_OPEN, np.ones((OPENING, OPENING), np.uint8))
    found = surrounded(figure)
    if not found.any():
        return np.zeros(figure.shape, np.float32)
    grown = cv2.dilate(found, kernel).astype(np.float32)
    return grown / np.linalg.norm(grown)


def surrounded(figure: np.ndarray) -> np.ndarray:
    """Pixels (h, w) uint8 of the regions of a 0/1 map whose 8-neighbourhoods do not reach the border."""
    import cv2

    count, labels = cv2.connectedComponents(figure, connectivity=8, ltype=cv2.CV_32S)
    inside = np.ones(count, np.uint8)
    inside[0] = 0
    for rim in (labels[0], labels[-1], labels[:, 0], labels[:, -1]):
        inside[rim] = 0
    return inside[labels]


def whitened(lab: np.ndarray) -> np.ndarray:
    """Colours (h, w, 3) decorrelated over the picture and stretched to 0..255, as uint8."""
    flat = lab.reshape(-1, lab.shape[2]).astype(np.float64)
    flat = flat - flat.mean(axis=0)
    values, vectors = np.linalg.eigh(np.cov(flat.T) + 1e-3 * np.eye(flat.shape[1]))
    white = flat @ (vectors / np.sqrt(values)) @ vectors.T
    low, high = white.min(axis=0), white.max(axis=0)
    return (255 * (white - low) / np.maximum(high - low, 1e-9)).reshape(lab.shape).astype(np.uint8)

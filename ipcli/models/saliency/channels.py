"""Channels of a picture that predict where people look, each a map on a grid 200 pixels along.

Every channel is named, so that its worth can be told. `curvature` and the three of colour are the thesis' F6 and F5.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ipcli.models.saliency.boolean_maps import boolean_map_saliency, whitened

LONGEST = 200  # pixels of the longer side of the grid
FINE = 400  # of the picture that key points and lines are found in
SCALES = (2.0, 5.0, 12.0)  # pixels of the grid
SURROUND = 3.0  # times a scale


@dataclass(frozen=True, eq=False)
class ShrunkPicture:
    """A picture (h, w, 3) uint8 RGB, shrunk, in the colour spaces that the channels share."""

    fine: np.ndarray  # (h', w', 3) uint8 RGB, FINE pixels along at most
    small: np.ndarray  # (a, b, 3) uint8 RGB, the grid

    @classmethod
    def of(cls, rgb: np.ndarray) -> ShrunkPicture:
        """The picture at the two sizes."""
        return cls(shrunk(rgb, FINE), shrunk(rgb, LONGEST))

    @cached_property
    def lab(self) -> np.ndarray:
        """Lab (a, b, 3) uint8 of the grid."""
        import cv2

        return cv2.cvtColor(self.small, cv2.COLOR_RGB2LAB)

    @cached_property
    def opponents(self) -> np.ndarray:
        """Lab (a, b, 3) float32 in 0..1."""
        return self.lab.astype(np.float32) / 255

    @cached_property
    def grey(self) -> np.ndarray:
        """Luminance (h', w') uint8 of the finer picture."""
        import cv2

        return cv2.cvtColor(self.fine, cv2.COLOR_RGB2GRAY)

    @cached_property
    def orientations(self) -> np.ndarray:
        """Gradient energy (8, a, b) in eight orientations on the grid."""
        import cv2

        grey = self.grey.astype(np.float32) / 255
        dx, dy = cv2.Sobel(grey, cv2.CV_32F, 1, 0), cv2.Sobel(grey, cv2.CV_32F, 0, 1)
        size, angle = np.hypot(dx, dy), np.arctan2(dy, dx)
        bins = [size * np.clip(np.cos(angle - np.pi * k / 8) ** 2 * 4 - 3, 0, 1) for k in range(8)]
        return np.stack([cv2.resize(part, self.size, interpolation=cv2.INTER_AREA) for part in bins])

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the grid."""
        return self.small.shape[0], self.small.shape[1]

    @property
    def size(self) -> tuple[int, int]:
        """Columns and rows, as OpenCV wants them."""
        return self.shape[::-1]


def shrunk(rgb: np.ndarray, longest: int) -> np.ndarray:
    """A picture averaged down so that its longer side is `longest` pixels; enlarged if it is smaller."""
    import cv2

    factor = longest / max(rgb.shape[:2])
    size = (max(8, round(rgb.shape[1] * factor)), max(8, round(rgb.shape[0] * factor)))
    way = cv2.INTER_AREA if factor < 1 else cv2.INTER_LINEAR
    return np.ascontiguousarray(cv2.resize(rgb, size, interpolation=way))


def blurred(image: np.ndarray, sigma: float) -> np.ndarray:
    """An image float32 under a Gaussian of `sigma` pixels."""
    import cv2

    return cv2.GaussianBlur(np.asarray(image, np.float32), (0, 0), sigma, borderType=cv2.BORDER_REFLECT)


def channels(rgb: np.ndarray) -> dict[str, np.ndarray]:
    """All channels of a picture (h, w, 3) uint8 by name: maps (a, b) float32."""
    glance = ShrunkPicture.of(rgb)
    found: dict[str, np.ndarray] = {}
    for family in (_global, _figures, _keys, _contrasts, _orientation, _colour, _thesis, _place):
        found |= family(glance)
    return {name: np.ascontiguousarray(part, dtype=np.float32) for name, part in found.items()}


def _global(glance: ShrunkPicture) -> dict[str, np.ndarray]:
    """What is rare in the whole picture: spectral residual at two widths, unlikely filter answers, rare colours."""
    residuals = {f"spectral residual {width}": spectral_residual(glance.opponents, width) for width in (64, 128)}
    return residuals | {"rare answers": rare_answers(glance), "rare colours": rare_colours(glance.opponents)}


def spectral_residual(opponents: np.ndarray, width: int) -> np.ndarray:
    """Hou and Zhang's spectral residual (2007), summed over the opponent channels (a, b, 3), `width` columns wide."""
    import cv2

    rows, columns = opponents.shape[:2]
    size = (width, max(8, round(width * rows / columns)))
    total = np.zeros(size[::-1], np.float32)
    for channel in np.moveaxis(cv2.resize(opponents, size, interpolation=cv2.INTER_AREA), 2, 0):
        spectrum = np.fft.fft2(channel)
        log = np.log(np.abs(spectrum) + 1e-9).astype(np.float32)
        residual = log - cv2.blur(log, (3, 3))
        total += np.abs(np.fft.ifft2(np.exp(residual + 1j * np.angle(spectrum)))) ** 2 * channel.std()
    return cv2.resize(blurred(total, width / 25), (columns, rows), interpolation=cv2.INTER_LINEAR)


def rare_answers(glance: ShrunkPicture) -> np.ndarray:
    """Mahalanobis distance of centre-surround and orientation answers from their mean over the picture, after
    whitening saliency (Garcia-Diaz et al. 2012).
    """
    answers = [part for part in glance.orientations]
    answers += [blurred(glance.opponents[..., k], 1) - blurred(glance.opponents[..., k], 6) for k in range(3)]
    answers += [glance.opponents[..., k] for k in range(3)]
    flat = np.stack(answers, axis=-1).reshape(-1, len(answers)).astype(np.float64)
    flat -= flat.mean(axis=0)
    covariance = flat.T @ flat / len(flat)
    ridge = 1e-4 * np.trace(covariance) / len(answers) + 1e-9
    inverse = np.linalg.inv(covariance + ridge * np.eye(len(answers)))
    return blurred(np.sqrt(((flat @ inverse) * flat).sum(axis=1)).reshape(glance.shape), 3)


def rare_colours(opponents: np.ndarray) -> np.ndarray:
    """Negative logarithm of the frequency of a pixel's colour in the picture, 12 levels a channel."""
    levels = np.minimum((opponents * 12).astype(np.int64), 11)
    code = (levels[..., 0] * 12 + levels[..., 1]) * 12 + levels[..., 2]
    share = np.bincount(code.ravel(), minlength=12**3).reshape(12, 12, 12).astype(np.float32)
    share = blurred(np.moveaxis(blurred(share, 0.7), 0, -1), 0.7)
    return blurred(-np.log(np.moveaxis(share, -1, 0).ravel()[code] + 1), 3)


def _figures(glance: ShrunkPicture) -> dict[str, np.ndarray]:
    """Boolean maps, blurred at two scales, and their square root."""
    figures = boolean_map_saliency(whitened(glance.lab))
    figures /= max(float(figures.max()), 1e-9)
    return {
        "Boolean maps": blurred(figures, 4),
        "Boolean maps, wide": blurred(figures, 12),
        "Boolean maps, root": blurred(np.sqrt(figures), 4),
    }


def _keys(glance: ShrunkPicture) -> dict[str, np.ndarray]:
    """Density of SIFT key points and of corners."""
    import cv2

    points = cv2.SIFT_create(contrastThreshold=0.03).detect(glance.grey, None)  # type: ignore[attr-defined]
    counts = np.zeros(glance.shape, np.float32)
    scale = glance.shape[1] / glance.grey.shape[1]
    place = np.array([point.pt for point in points]).reshape(-1, 2) * scale
    place = np.clip(place.astype(np.int64), 0, np.array(glance.size) - 1)
    np.add.at(counts, (place[:, 1], place[:, 0]), 1.0)
    corners = cv2.cornerMinEigenVal(glance.grey, 5)
    corners = cv2.resize(np.sqrt(np.maximum(corners, 0)), glance.size, interpolation=cv2.INTER_AREA)
    return {
        "SIFT density": np.sqrt(blurred(counts, 8)),
        "SIFT density, wide": np.sqrt(blurred(counts, 16)),
        "corners": blurred(corners, 4),
    }


def _contrasts(glance: ShrunkPicture) -> dict[str, np.ndarray]:
    """Centre against surround of each opponent channel at each scale, and their local spread."""
    found = {}
    for k, colour in enumerate(("intensity", "red-green", "blue-yellow")):
        channel = glance.opponents[..., k]
        for scale in SCALES:
            difference = np.abs(blurred(channel, scale) - blurred(channel, SURROUND * scale))
            found[f"{colour} contrast {scale:g}"] = blurred(difference, scale)
        spread = blurred(channel**2, 8) - blurred(channel, 8) ** 2
        found[f"{colour} spread"] = np.sqrt(np.maximum(spread, 0))
    return found


def _orientation(glance: ShrunkPicture) -> dict[str, np.ndarray]:
    """Edges, how mixed their directions are, and how they differ from those around."""
    smooth = np.stack([blurred(part, 4) for part in glance.orientations])
    total = smooth.sum(axis=0) + 1e-6
    share = smooth / total
    around = np.stack([blurred(part, 16) for part in glance.orientations])
    unlike = np.abs(smooth - around).sum(axis=0)
    return {
        "edges": total,
        "edges, wide": around.sum(axis=0),
        "mixed directions": -(share * np.log(share + 1e-6)).sum(axis=0),
        "orientation contrast": blurred(unlike, 4),
        "upright edges": smooth[[7, 0, 1]].sum(axis=0),
        "level edges": smooth[[3, 4, 5]].sum(axis=0),
    }


def _colour(glance: ShrunkPicture) -> dict[str, np.ndarray]:
    """Skin, vividness, and the distance of a colour from the mean and from that of the border."""
    lab = glance.opponents
    flat = lab.reshape(-1, 3)
    rim = np.concatenate(
        [lab[:6].reshape(-1, 3), lab[-6:].reshape(-1, 3), lab[:, :6].reshape(-1, 3), lab[:, -6:].reshape(-1, 3)]
    )
    return {
        "skin": blurred(skin(glance.small), 3),
        "vividness": blurred(np.linalg.norm(lab[..., 1:] - 128 / 255, axis=-1), 3),
        "unlike the mean": blurred(np.linalg.norm(lab - flat.mean(axis=0), axis=-1), 3),
        "unlike the border": blurred(_mahalanobis(lab, rim), 3),
    }


def _mahalanobis(lab: np.ndarray, sample: np.ndarray) -> np.ndarray:
    inverse = np.linalg.inv(np.cov(sample.T) + 1e-3 * np.eye(3))
    away = lab - sample.mean(axis=0)
    return np.sqrt(((away @ inverse) * away).sum(axis=-1))


def skin(rgb: np.ndarray) -> np.ndarray:
    """How like skin a colour is (a, b): a Gaussian in Cr and Cb, dimmed where it is dark."""
    import cv2

    luma, red, blue = np.moveaxis(cv2.cvtColor(rgb, cv2.COLOR_RGB2YCrCb).astype(np.float32), 2, 0)
    return np.exp(-(((red - 150) / 10) ** 2 + ((blue - 108) / 12) ** 2) / 2) * np.clip(luma / 90, 0, 1)


def _thesis(glance: ShrunkPicture) -> dict[str, np.ndarray]:
    """F5, the colours themselves, and F6, the Gaussian curvature of the intensity as a surface (3.16)."""
    found = {name: blurred(glance.small[..., k] / 255, 3) for k, name in enumerate(("red", "green", "blue"))}
    return found | {"curvature": gaussian_curvature(blurred(glance.opponents[..., 0] * 20, 2))}


def gaussian_curvature(height: np.ndarray) -> np.ndarray:
    """Gaussian curvature (3.14) of the graph of a map (a, b) over its pixels."""
    dy, dx = np.gradient(height)
    dyy, dyx = np.gradient(dy)
    _, dxx = np.gradient(dx)
    return (dxx * dyy - dyx**2) / (1 + dx**2 + dy**2) ** 2


def _place(glance: ShrunkPicture) -> dict[str, np.ndarray]:
    """Where in the picture: the centre prior, distances from the middle along both axes, and height."""
    x, y = places(glance.shape)
    return {"centre": centre_prior(glance.shape), "aside": np.abs(x), "above or below": np.abs(y), "height": -y}


def places(shape: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Columns and rows of each pixel (a, b), from -1/2 to 1/2."""
    y, x = np.mgrid[0 : shape[0], 0 : shape[1]]
    return (x + 0.5) / shape[1] - 0.5, (y + 0.5) / shape[0] - 0.5


def centre_prior(shape: tuple[int, int], spread: float = 0.25) -> np.ndarray:
    """A Gaussian about the middle, its spread a share of either side."""
    x, y = places(shape)
    return np.exp(-(x**2 + y**2) / (2 * spread**2))

"""Lenses: from directions to pixels of a real camera and back.

Models and their coefficients, as the calibration files have them: `pinhole` (none), `radtan` (OpenCV's k1 k2 p1 p2 and
up to k3...k6), `equidistant` (OpenCV's fisheye, k1...k4), `fisheye624` (Project Aria: k0...k5, p0 p1, s0...s3).
Normalised coordinates are x / z, y / z of a direction; pixels have their centres at integers.
"""

from __future__ import annotations

import numpy as np

from ipcli.errors import ParameterError

MODELS = {"pinhole": (0,), "radtan": (4, 5, 8), "equidistant": (4,), "fisheye624": (12,)}
WIDEST = np.radians(80.0)  # of the optical axis: beyond, normalised coordinates explode
NEWTON = 20


def distort(model: str, coefficients: np.ndarray, normalised: np.ndarray) -> np.ndarray:
    """Normalised coordinates (..., 2) of an ideal camera to those behind the lens. ParameterError: unknown model."""
    if model not in MODELS or len(coefficients) not in MODELS[model]:
        raise ParameterError(f"lens model '{model}' with {len(coefficients)} coefficients: expected one of {MODELS}")
    x, y = normalised[..., 0], normalised[..., 1]
    if model == "pinhole":
        return np.asarray(normalised, np.float64)
    if model == "radtan":
        return _radtan(np.asarray(coefficients, np.float64), x, y)
    return _fisheye(model, np.asarray(coefficients, np.float64), x, y)


def _radtan(k: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    k1, k2, p1, p2, k3, k4, k5, k6 = np.pad(k, (0, 8 - len(k)))
    r2 = x * x + y * y
    radial = (1 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1 + r2 * (k4 + r2 * (k5 + r2 * k6)))
    return np.stack(
        [
            x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
            y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y,
        ],
        axis=-1,
    )


def _fisheye(model: str, k: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Angle theta off the axis is drawn at theta (1 + k0 theta^2 + ...); fisheye624 adds tangential and prism terms."""
    r = np.hypot(x, y)
    theta = np.arctan(r)
    radial = k[:4] if model == "equidistant" else k[:6]
    powers = sum(c * theta ** (2 * n + 2) for n, c in enumerate(radial))
    scale = np.where(r > 1e-12, theta * (1 + powers) / np.maximum(r, 1e-12), 1.0)
    u, v = x * scale, y * scale
    if model == "equidistant":
        return np.stack([u, v], axis=-1)
    p0, p1, s0, s1, s2, s3 = k[6:]
    r2 = u * u + v * v
    du = (2 * u * u + r2) * p0 + 2 * u * v * p1 + r2 * (s0 + r2 * s1)
    dv = (2 * v * v + r2) * p1 + 2 * u * v * p0 + r2 * (s2 + r2 * s3)
    return np.stack([u + du, v + dv], axis=-1)


def undistort(model: str, coefficients: np.ndarray, distorted: np.ndarray) -> np.ndarray:
    """The inverse of `distort` by Newton's method; NaN where it does not get there or lies beyond `WIDEST`."""
    target = np.asarray(distorted, np.float64)
    if model == "pinhole":
        return target
    found = _start(model, target)
    with np.errstate(all="ignore"):
        for _ in range(NEWTON):
            error = distort(model, coefficients, found) - target
            (a, b), (c, d) = np.moveaxis(_jacobian(model, coefficients, found), (-2, -1), (0, 1))
            step = np.stack([d * error[..., 0] - b * error[..., 1], a * error[..., 1] - c * error[..., 0]], axis=-1)
            step /= (a * d - b * c)[..., None]
            found = found - np.clip(np.nan_to_num(step), -0.5, 0.5)
            if np.abs(np.nan_to_num(step)).max(initial=0.0) < 1e-13:
                break
        missed = np.abs(distort(model, coefficients, found) - target).max(axis=-1) > 1e-9
        missed |= ~(np.hypot(found[..., 0], found[..., 1]) < _reach(model, coefficients))
    return np.where(missed[..., None], np.nan, found)


def _reach(model: str, coefficients: np.ndarray) -> float:
    """Distance from the axis up to which a larger one is drawn farther out; beyond, two rays share one place."""
    r = np.linspace(0.0, float(np.tan(WIDEST)), 2000)
    drawn = distort(model, coefficients, np.stack([r, np.zeros_like(r)], axis=-1))[:, 0]
    falls = np.flatnonzero(np.diff(drawn) <= 0)
    return float(r[falls[0]]) if len(falls) else float(r[-1])


def _start(model: str, target: np.ndarray) -> np.ndarray:
    """Where Newton's method begins: at the pixel itself, or for a fisheye at the angle it would have undistorted."""
    if model == "radtan":
        return target.copy()
    r = np.linalg.norm(target, axis=-1, keepdims=True)
    theta = np.minimum(r, np.radians(75.0))
    return np.where(r > 1e-9, target / np.maximum(r, 1e-9) * np.tan(theta), target)


def _jacobian(model: str, coefficients: np.ndarray, at: np.ndarray, h: float = 1e-6) -> np.ndarray:
    """(..., 2, 2) by central differences, which is enough for Newton's method to converge; never singular."""
    columns = [
        (distort(model, coefficients, at + step) - distort(model, coefficients, at - step)) / (2 * h)
        for step in (np.array([h, 0.0]), np.array([0.0, h]))
    ]
    jacobian = np.nan_to_num(np.stack(columns, axis=-1))
    flat = np.abs(np.linalg.det(jacobian)) < 1e-9
    jacobian[flat] = np.eye(2)
    return jacobian


def pixels_of(normalised: np.ndarray, intrinsics: np.ndarray) -> np.ndarray:
    """Pixels (..., 2) of normalised coordinates."""
    return normalised @ intrinsics[:2, :2].T + intrinsics[:2, 2]


def normalised_of(pixels: np.ndarray, intrinsics: np.ndarray) -> np.ndarray:
    """Normalised coordinates (..., 2) of pixels."""
    return (np.asarray(pixels, np.float64) - intrinsics[:2, 2]) @ np.linalg.inv(intrinsics[:2, :2]).T

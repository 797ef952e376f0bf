"""A small synthetic "fused-depth" artefact, complete and valid, from which the tests take parts away."""

from __future__ import annotations

import numpy as np
import pytest

HOSTILE = "<script>alert('&')</script>"


def texts(*values: str) -> np.ndarray:
    return np.array(values, dtype=str)


def scene(height: int, width: int) -> tuple[np.ndarray, np.ndarray]:
    """True depth (h, w) of a bump on a slanted plane, and the intrinsics."""
    v, u = np.indices((height, width))
    x, y = (u - width / 2) / width, (v - height / 2) / width
    bump = 0.6 * np.exp(-40 * (x**2 + y**2))
    intrinsics = np.array([[width, 0, width / 2], [0, width, height / 2], [0, 0, 1.0]])
    return (2.5 / (1 + 0.3 * x) - bump).astype(np.float32), intrinsics


def fused_artefact(height: int = 48, width: int = 64, k: int = 5) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(4)
    truth, intrinsics = scene(height, width)
    observed = (truth + rng.laplace(0, 0.03, (k, height, width))).astype(np.float32)
    observed[rng.random(observed.shape) < 0.1] = np.nan
    observed[:, 3:8, 3:9] = np.nan
    hidden = np.isnan(observed).all(axis=0)
    mean, median = (
        np.where(hidden, np.nan, middle(np.where(hidden, 0, observed), axis=0)) for middle in (np.nanmean, np.nanmedian)
    )
    seen = np.isfinite(observed).mean(axis=(1, 2))
    errors = [np.nanmean(np.abs(candidate - truth)) for candidate in (median, truth + 0.002)]
    return {
        "depth": truth + np.float32(0.002),
        "mean": mean.astype(np.float32),
        "median": median.astype(np.float32),
        "reference": observed[k // 2],
        "confidence": rng.uniform(0.5, 40, truth.shape).astype(np.float32),
        "normals": np.tile(np.float32([0, 0, -1]), (height, width, 1)),
        "observations": np.isfinite(observed).sum(axis=0).astype(np.uint16),
        "intrinsics": intrinsics,
        "cam_from_world": np.eye(4),
        "image": np.stack([truth * 60, truth * 30 + 90, 220 - truth * 50], axis=-1).clip(0, 255).astype(np.uint8),
        "truth": truth.copy(),
        "noise_scale": np.array(0.03),
        "views": texts(HOSTILE, *(f"{i:06d}" for i in range(1, k))),
        "view_valid": seen,
        "view_residual": np.full(k, 0.021),
        "view_overlap": np.append(0.03, seen[1:]),
        "thumbnails": observed[:, ::2, ::2].copy(),
        "unit": np.array("m"),
        "domain": np.array("depth"),
        "history": np.array(
            [[r, 10 * i, 900 / (r + i), 0.5 / i**2, 500 / (r + 1)] for r in range(3) for i in range(1, 5)], float
        ),
        "method": np.array("ACS with TGV²"),
        "lambda": np.array(0.6),
        "metrics": np.array([[errors[0], 90.0], [errors[1], 100.0]]),
        "metric_rows": texts("median", "fused"),
        "metric_columns": texts("MAE, m", "density, %"),
    }


@pytest.fixture
def artefact() -> dict[str, np.ndarray]:
    return fused_artefact()


@pytest.fixture
def large() -> dict[str, np.ndarray]:
    return fused_artefact(480, 640, 11)


@pytest.fixture
def provenance() -> dict[str, object]:
    return {
        "command": "fuse-depth",
        "ipcli": "0.1.0",
        "params": {"solver": {"gap": 0.001}, "reference": HOSTILE},
        "seed": 0,
        "inputs": [{"name": "a&b.h5", "sha256": "ab" * 32}],
        "digest": "cd" * 32,
    }


@pytest.fixture
def views_artefact() -> dict[str, np.ndarray]:
    arrays: dict[str, np.ndarray] = {"unit": np.array("m"), "measured": np.array("depth")}
    for index, name in enumerate(("b", "a", HOSTILE.replace("/", ""))):
        depth, intrinsics = scene(24, 32 + 4 * index)
        pose = np.eye(4)
        pose[0, 3] = -0.1 * index
        fields = {
            "depth": depth,
            "intrinsics": intrinsics,
            "cam_from_world": pose,
            "truth": depth,
            "image": np.full((*depth.shape, 3), 90, np.uint8),
        }
        arrays |= {f"views/{name}/{field}": array for field, array in fields.items()}
    return arrays

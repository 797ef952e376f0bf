"""Write docs/pictures/fuse-depth.jpg from the demo's fused map: `make demo`, then `python tools/make_pictures.py`."""

import sys
from pathlib import Path

import cv2
import numpy as np

from ipcli.geometry.surface import normals
from ipcli.io import atomic, h5
from ipcli.report import pictures, surface

ROOT = Path(__file__).resolve().parent.parent
DEMO = ROOT / "build" / "demo" / "shapes.fused.h5"


def coloured(values: np.ndarray, scale: pictures.Scale) -> np.ndarray:
    """A map (h, w) as RGB (h, w, 3)."""
    return pictures.palette(scale.palette)[scale.indices(values)]


def montage(arrays: dict[str, np.ndarray]) -> np.ndarray:
    """Above: reference, median and fused depth. Below: confidence, median and fused surface in light."""
    depth = pictures.robust([arrays["depth"]], "turbo")
    lit = [surface.shade(normals(arrays[name], arrays["intrinsics"]), arrays["intrinsics"]) for name in ("median", "depth")]
    above = [coloured(arrays[name], depth) for name in ("reference", "median", "depth")]
    below = [coloured(arrays["confidence"], pictures.robust([arrays["confidence"]], "viridis"))]
    below += [coloured(light, surface.SHADE) for light in lit]
    return np.vstack([np.hstack(above), np.hstack(below)])


if __name__ == "__main__":
    if not DEMO.is_file():
        sys.exit(f"{DEMO}: not there. Run `make demo` first")
    picture = montage(h5.read(DEMO, "depth").arrays)
    _, data = cv2.imencode(".jpg", picture[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 88])
    atomic.write_bytes(ROOT / "docs" / "pictures" / "fuse-depth.jpg", data.tobytes())

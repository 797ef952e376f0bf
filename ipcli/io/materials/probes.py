"""Light probes: equirectangular images of radiance, Radiance HDR, EXR (with the package OpenEXR), or NPY."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ipcli.errors import FormatError
from ipcli.io.files import images

SUFFIXES = (".hdr", ".exr", ".npy", ".pic")


def read(path: Path) -> np.ndarray:
    """Linear radiance (h, w, 3) float64, row 0 up. Raises FormatError for another shape or radiance that is not
    finite.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise FormatError(path, "not a light probe", expected=" ".join(SUFFIXES), got=suffix or "no suffix")
    image = (
        images.read_npy(path)
        if suffix == ".npy"
        else _exr(path)
        if suffix == ".exr"
        else images.read_stored(path)[..., ::-1]
    )
    if image.ndim != 3 or image.shape[2] != 3 or image.dtype.kind != "f" or image.shape[1] != 2 * image.shape[0]:
        raise FormatError(
            path, "not an equirectangular probe", expected="floats (h, 2 h, 3)", got=f"{image.dtype} {image.shape}"
        )
    if not np.isfinite(image).all() or not (image >= 0).all() or not image.any():
        raise FormatError(path, "radiance that is negative, not finite or zero everywhere")
    return image.astype(np.float64)


def _exr(path: Path) -> np.ndarray:
    try:
        import OpenEXR
    except ImportError as error:
        fix = "pip install OpenEXR, or turn the probe into .hdr"
        raise FormatError(path, "EXR needs the package OpenEXR", fix=fix) from error
    try:
        with OpenEXR.File(str(path)) as file:
            channels = file.channels()
            return np.asarray(channels.get("RGB", channels.get("RGBA")).pixels, np.float32)[..., :3]
    except Exception as error:  # the package lets out whatever its decoder meets
        raise FormatError(path, f"not a readable EXR: {' '.join(str(error).split())}") from error

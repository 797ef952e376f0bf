"""A COLMAP model with its pictures, to localise in: text or binary, whoever made it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ipcli.errors import FormatError
from ipcli.io.files.colmap import read_model
from ipcli.io.files.images import read_image
from ipcli.io.files.text import IMAGES, require_folder
from ipcli.io.gaze.pictures import grey
from ipcli.measurements.recording import PictureModel

if TYPE_CHECKING:
    import pycolmap


def read_picture_model(folder: Path, pictures: Path) -> PictureModel:
    """A model's points and those of its posed pictures that are in the folder `pictures` by their name in the model.

    A name without a file gets the suffix of a picture. FormatError for no model, or when no picture is found.
    """
    model = read_model(require_folder(folder), "Give the folder of cameras, images and points3D")
    numbers = {number: order for order, number in enumerate(sorted(model.points3D))}
    points = [model.points3D[number] for number in numbers]
    poses, shown, pixels, files = [], [], [], []
    for _, image in sorted(model.images.items()):
        path = _picture(require_folder(pictures), image.name)
        seen = image.get_observation_points2D() if image.has_pose else []
        if path is None or not seen:
            continue
        files.append(path)
        poses.append(np.vstack([image.cam_from_world().matrix(), [0, 0, 0, 1]]))
        shown.append(np.array([numbers[point.point3D_id] for point in seen]))
        pixels.append(np.array([point.xy for point in seen]) - 0.5)
    if not files:
        raise FormatError(
            pictures, "none of the model's pictures is there", expected=", ".join(_names(model)[:3]) or "pictures",
            fix="Give the folder that its names start from",
        )  # fmt: skip
    return PictureModel(
        np.array([point.xyz for point in points]).reshape(-1, 3),
        np.array([np.mean(point.color) for point in points]).astype(np.uint8),
        np.stack(poses),
        tuple(shown),
        tuple(pixels),
        lambda k: grey(read_image(files[k])),
        (*sorted(path for path in folder.iterdir() if path.is_file()), *files),
    )


def _names(model: pycolmap.Reconstruction) -> list[str]:
    return [image.name for _, image in sorted(model.images.items())]


def _picture(folder: Path, name: str) -> Path | None:
    """The file of a picture; None where there is none inside the folder."""
    if Path(name).is_absolute() or ".." in Path(name).parts:
        return None
    return next((path for end in ("", *IMAGES) if (path := folder / f"{name}{end}").is_file()), None)

"""A COLMAP model with its pictures, to localise in: text or binary, whoever made it."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from ipcli.errors import FormatError
from ipcli.io.files.colmap import parsed
from ipcli.io.files.images import read_image
from ipcli.io.files.text import IMAGES, require_folder
from ipcli.io.gaze.pictures import grey
from ipcli.measurements.recording import PictureModel


def read_picture_model(folder: Path, pictures: Path) -> PictureModel:
    """A model's points and those of its posed pictures that are in the folder `pictures` by their name in the model.

    A name without a file gets the suffix of a picture. FormatError for no model, or when no picture is found.
    """
    points, colors, images = parsed(
        observed_points, require_folder(folder), "Give the folder of cameras, images and points3D"
    )
    paths = [_picture(require_folder(pictures), name) for name, *_ in images]
    there = [(path, image) for path, image in zip(paths, images, strict=True) if path is not None and len(image[2])]
    if not there:
        some = ", ".join(name for name, *_ in images[:3])
        fix = "Give the folder that its names start from"
        raise FormatError(pictures, "none of the model's pictures is there", expected=some or "pictures", fix=fix)
    files, (_, poses, shown, pixels) = [path for path, _ in there], zip(*(image for _, image in there), strict=True)
    return PictureModel(
        points,
        colors,
        np.stack(poses),
        tuple(shown),
        tuple(pixels),
        lambda k: grey(read_image(files[k])),
        (*sorted(path for path in folder.iterdir() if path.is_file()), *files),
    )


def observed_points(folder: str) -> tuple[np.ndarray, np.ndarray, list[tuple[str, np.ndarray, np.ndarray, np.ndarray]]]:
    """Points (p, 3) of a model with their grey (p,), and of each posed picture its name, cam_from_world (4, 4), which
    points (s,) it shows, and where (s, 2), pixel centres at integers.
    """
    import pycolmap

    model = pycolmap.Reconstruction(folder)
    numbers = {number: order for order, number in enumerate(sorted(model.points3D))}
    points = [model.points3D[number] for number in numbers]
    images = []
    for _, image in sorted(model.images.items()):
        if image.has_pose:
            seen = image.get_observation_points2D()
            shown = np.array([numbers[point.point3D_id] for point in seen], np.int64)
            pixels = np.array([point.xy for point in seen]).reshape(-1, 2) - 0.5
            images.append((image.name, np.vstack([image.cam_from_world().matrix(), [0, 0, 0, 1]]), shown, pixels))
    places = np.array([point.xyz for point in points]).reshape(-1, 3)
    return places, np.array([np.mean(point.color) for point in points]).astype(np.uint8), images


def _picture(folder: Path, name: str) -> Path | None:
    """The file of a picture; None where there is none inside the folder."""
    if Path(name).is_absolute() or ".." in Path(name).parts:
        return None
    paths = (folder / f"{name}{end}" for end in ("", *IMAGES))
    return next((path for path in paths if os.path.isfile(path)), None)  # no error for a name that no file can have

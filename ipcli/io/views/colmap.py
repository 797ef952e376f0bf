"""A dense COLMAP workspace: ``images/``, ``sparse/`` (the undistorted model) and ``stereo/depth_maps/``.

COLMAP puts the centre of the first pixel at (0.5, 0.5) and we at (0, 0): principal points move by half a pixel. The
scale of a reconstruction from images is arbitrary, so the unit is "colmap unit".
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ipcli.errors import FormatError
from ipcli.io.files import text
from ipcli.io.files.colmap import parsed
from ipcli.measurements.names import natural
from ipcli.measurements.views import View, Views, check_view

DEPTH_KINDS = ("geometric", "photometric")  # the consistent maps first: they hold fewer outliers


@dataclass(frozen=True, eq=False)
class _Picture:
    image: Path
    depth: Path
    intrinsics: np.ndarray  # at the size of the undistorted image, COLMAP's pixel centres
    size: tuple[int, int]  # width, height of it
    cam_from_world: np.ndarray


def is_colmap(folder: Path) -> bool:
    """Whether the folder is a dense workspace (or will be, once its depth maps are computed)."""
    return (folder / "sparse").is_dir() and (folder / "stereo").is_dir()


def open_colmap(folder: Path, *, depth: str | None = None) -> Views:
    """Every registered image that has a depth map: ``depth`` geometric or photometric, geometric if there are any.

    A view is named after its image file, with ``_`` for ``/``. Depth maps made at a reduced size get scaled intrinsics.
    """
    kind = depth or _kind(folder)
    found: dict[str, _Picture] = {}
    pictures, unposed = _pictures(folder, kind)
    for name, picture in pictures.items():
        flat = name.replace("/", "_")
        if flat in found:
            raise FormatError(folder / "images", f"two images would be named '{flat}'", fix="Rename one of them")
        if os.path.isfile(picture.depth):  # no error, as Path's has, for a name that no file can have
            found[flat] = picture
    if not found:
        raise FormatError(
            folder / "stereo" / "depth_maps",
            f"no {kind} depth map of a registered image",
            expected=f"NAME.{kind}.bin",
            fix="Check that sparse/ is the model the depth maps were made with",
        )

    def load(name: str, pictures: bool = True) -> View:
        return check_view(_view(name, found[name], pictures), found[name].depth)

    def files(name: str) -> tuple[Path, ...]:
        picture = found[name]
        seen = (picture.image,) if os.path.isfile(picture.image) else ()
        return (picture.depth, *seen, *_model_files(folder))

    notes = _left_out(folder, kind, pictures, found, unposed)
    return Views(tuple(sorted(found, key=natural)), "colmap unit", "depth", None, load, files, notes)


def _left_out(
    folder: Path, kind: str, pictures: Mapping[str, _Picture], found: Mapping[str, _Picture], unposed: int
) -> tuple[str, ...]:
    """In words how many images have no depth map, and how many depth maps no pose."""
    maps = folder / "stereo" / "depth_maps"
    taken = {picture.depth for picture in found.values()}
    strange = sum(path not in taken for path in maps.rglob(f"*.{kind}.bin"))
    blind = len(pictures) - len(found)
    notes = [f"{blind} of {len(pictures)} registered images left out: no {kind} depth map"] if blind else []
    notes += [f"{unposed} images of the model left out: no pose"] if unposed else []
    return (
        *notes,
        *([f"{strange} {kind} depth maps left out: their image is not registered in sparse/"] * (strange > 0)),
    )


def read_depth_map(path: Path) -> np.ndarray:
    """Depth (h, w) float32, NaN where none, from ``width&height&1&`` in ASCII and float32 row by row.

    FormatError when the header is something else or the numbers are fewer or more than it says.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise FormatError(path, f"cannot be read: {error.strerror}", fix="Check the path") from None
    header = content[:64].split(b"&", 3)
    if len(header) != 4 or not all(part.isdigit() for part in header[:3]) or int(header[2]) != 1:
        raise FormatError(
            path,
            "not a COLMAP depth map",
            expected="header width&height&1&",
            got=content[:16],
            fix="Run patch_match_stereo again",
        )
    width, height = int(header[0]), int(header[1])
    start = sum(len(part) + 1 for part in header[:3])
    if len(content) - start != 4 * width * height:
        raise FormatError(
            path,
            "depth map is cut or too long",
            expected=f"{4 * width * height} bytes of data",
            got=len(content) - start,
            fix="Run patch_match_stereo again",
        )
    depth = np.frombuffer(content, "<f4", offset=start).reshape(height, width)
    return np.where(depth > 0, depth, np.nan).astype(np.float32)


def _kind(folder: Path) -> str:
    maps = folder / "stereo" / "depth_maps"
    for kind in DEPTH_KINDS:
        if any(maps.rglob(f"*.{kind}.bin")):
            return kind
    raise FormatError(
        maps,
        "no depth maps",
        expected="*.geometric.bin or *.photometric.bin",
        got="an empty or absent folder",
        fix="Run `colmap patch_match_stereo` on this workspace first, or make a plain folder of other depth maps",
    )


def _model_files(folder: Path) -> tuple[Path, ...]:
    return tuple(
        sorted(
            path for stem in ("cameras", "images", "frames", "rigs") for path in model_folder(folder).glob(f"{stem}.*")
        )
    )


def model_folder(folder: Path) -> Path:
    """sparse/ itself, or the one numbered model in it, as `colmap mapper` writes; FormatError for more."""
    sparse = folder / "sparse"
    if any(sparse.glob("cameras.*")):
        return sparse
    models = [path for path in sorted(sparse.iterdir()) if any(path.glob("cameras.*"))]
    if len(models) > 1:
        fix = "Put the files of the one that the depth maps were made with into sparse/ itself"
        raise FormatError(sparse, f"{len(models)} models: {', '.join(path.name for path in models)}", fix=fix)
    return models[0] if models else sparse


def _pictures(folder: Path, kind: str) -> tuple[dict[str, _Picture], int]:
    """Registered images by name, and how many have no pose."""
    sparse = model_folder(folder)
    pictures, unposed = {}, 0
    for name, camera in parsed(model_cameras, sparse, "Run `colmap image_undistorter` again"):
        if camera is None:
            unposed += 1
            continue
        model, size, intrinsics, cam_from_world = camera
        if model not in ("PINHOLE", "SIMPLE_PINHOLE"):
            raise FormatError(
                sparse,
                f"camera of {name!r} has lens distortion",
                expected="PINHOLE",
                got=model,
                fix="Give the output folder of `colmap image_undistorter`",
            )
        if min(size) < 1:
            raise FormatError(sparse, f"camera of {name!r} has no size", got=f"{size[0]} x {size[1]}")
        depth = folder / "stereo" / "depth_maps" / f"{name}.{kind}.bin"
        pictures[name] = _Picture(folder / "images" / name, depth, intrinsics, size, cam_from_world)
    return pictures, unposed


Camera = tuple[str, tuple[int, int], np.ndarray, np.ndarray]  # COLMAP's model, width and height, intrinsics, pose


def model_cameras(sparse: str) -> list[tuple[str, Camera | None]]:
    """The images of a model by name, in order of their numbers, None for the camera of one without a pose."""
    import pycolmap

    model = pycolmap.Reconstruction(sparse)
    return [(image.name, _camera(image)) for _, image in sorted(model.images.items())]


def _camera(image: Any) -> Camera | None:
    if not image.has_pose:
        return None
    camera, pose = image.camera, np.vstack([image.cam_from_world().matrix(), [0, 0, 0, 1]])
    return camera.model.name, (int(camera.width), int(camera.height)), np.array(camera.calibration_matrix()), pose


def _view(name: str, picture: _Picture, with_image: bool) -> View:
    depth = read_depth_map(picture.depth)
    image = text.image_at(picture.image if with_image and os.path.isfile(picture.image) else None, depth.shape)
    return View(
        name, depth, _scaled(picture.intrinsics, picture.size, depth.shape), picture.cam_from_world, image=image
    )


def _scaled(intrinsics: np.ndarray, size: tuple[int, int], shape: tuple[int, int]) -> np.ndarray:
    """Intrinsics for a depth map of ``shape``. Corner-based coordinates scale plainly; then the half pixel goes."""
    (width, height), (rows, columns) = size, shape
    scaled = np.diag([columns / width, rows / height, 1.0]) @ intrinsics
    scaled[:2, 2] -= 0.5
    return scaled

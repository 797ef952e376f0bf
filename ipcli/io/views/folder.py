"""A plain folder of depth maps, for data of any origin.

    depth/NAME.png | .pfm | .npy | .tif | .tiff | .exr      one file a view, any size
    confidence/ image/ truth/       optional, by the same stem
    intrinsics.txt                  a 3 x 3 matrix, or ``fx fy cx cy``, or one line a view ``NAME fx fy cx cy``
    poses.txt                       one line a view: ``NAME`` and 12 or 16 numbers, row by row
    views.toml                      optional: unit, depth_scale, pose, measured, baseline_focal, doffs, missing
    calib.txt                       optional, Middlebury's: doffs, and baseline times focal length

Views come in the order of their names, 2 before 10. The direction of the poses has no default, since a wrong guess
gives a plausible but false result: ``pose = "world_from_cam"`` or ``"cam_from_world"`` stands in views.toml, or as a
comment in poses.txt, or comes as a hint.
"""

from __future__ import annotations

from collections.abc import Sequence as Ordered
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from ipcli.errors import FormatError, ParameterError, nearest
from ipcli.inputs import read_toml
from ipcli.io.files import text
from ipcli.io.files.images import read_depth, read_image
from ipcli.measurements.views import View, Views, check_view

DEPTHS = (".png", ".pfm", ".npy", ".tif", ".tiff", ".exr")
DIRECTIONS = ("cam_from_world", "world_from_cam")
QUANTITIES = ("depth", "disparity", "distance")


@dataclass(frozen=True)
class Manifest:
    """What the files of a folder cannot say themselves (views.toml)."""

    unit: str = "unit"
    depth_scale: float | None = None  # stored value = depth_scale * depth, in depth/ and truth/; 16-bit images need it
    pose: str | None = None
    measured: str = "depth"  # "disparity": the files hold disparities in pixels; "distance": along the ray of a pixel
    baseline_focal: float | None = None
    doffs: float = 0.0  # px, added to disparities: cx of the right camera less that of the left one (Middlebury)
    missing: float | None = None  # the stored value that means "no data", besides 0 and NaN


def is_folder(folder: Path) -> bool:
    """Whether the folder has depth maps and poses in the plain layout."""
    return (folder / "depth").is_dir() and (folder / "poses.txt").is_file()


def open_folder(
    folder: Path,
    *,
    unit: str | None = None,
    depth_scale: float | None = None,
    pose: str | None = None,
    measured: str | None = None,
    baseline_focal: float | None = None,
    doffs: float | None = None,
    missing: float | None = None,
    intrinsics: Ordered[float] | None = None,
) -> Views:
    """The views of a plain folder (see the module); what is given here goes before views.toml."""
    given: dict[str, Any] = {
        "unit": unit,
        "depth_scale": depth_scale,
        "pose": pose,
        "measured": measured,
        "baseline_focal": baseline_focal,
        "doffs": doffs,
        "missing": missing,
    }
    manifest = replace(
        _manifest(folder / "views.toml", middlebury(folder / "calib.txt")),
        **{key: value for key, value in given.items() if value is not None},
    )
    _check_manifest(folder, manifest)
    depths = text.by_stem(folder / "depth", DEPTHS)
    if not depths:
        raise FormatError(
            folder / "depth",
            "no depth maps",
            expected=f"files {', '.join(DEPTHS)}",
            fix="Check the layout of the folder",
        )
    cameras = _intrinsics(folder / "intrinsics.txt", tuple(depths), intrinsics)
    poses = _poses(folder / "poses.txt", tuple(depths), manifest.pose)
    beside = {
        kind: text.by_stem(folder / kind, text.IMAGES if kind == "image" else DEPTHS)
        for kind in ("confidence", "image", "truth")
    }

    def load(name: str, pictures: bool = True) -> View:
        wanted = beside if pictures else {"confidence": beside["confidence"]}
        files = {kind: found[name] for kind, found in wanted.items() if name in found}
        return check_view(_view(name, depths[name], files, cameras[name], poses[name], manifest), folder)

    def files(name: str) -> tuple[Path, ...]:
        shared = (folder / name for name in ("intrinsics.txt", "poses.txt", "views.toml", "calib.txt"))
        own = (found[name] for found in beside.values() if name in found)
        return (depths[name], *own, *(path for path in shared if path.is_file()))

    measures = "disparity" if manifest.measured == "disparity" else "depth"
    return Views(tuple(depths), manifest.unit, measures, manifest.baseline_focal, load, files)


def _view(
    name: str, depth: Path, files: dict[str, Path], intrinsics: np.ndarray, pose: np.ndarray, manifest: Manifest
) -> View:
    def metric(path: Path) -> np.ndarray:
        return _metric(path, manifest, intrinsics)

    values = metric(depth)
    confidence = _confidence(files["confidence"]) if "confidence" in files else None
    truth = metric(files["truth"]) if "truth" in files else None
    return View(name, values, intrinsics, pose, confidence, text.image_at(files.get("image"), values.shape), truth)


def _metric(path: Path, manifest: Manifest, intrinsics: np.ndarray) -> np.ndarray:
    """Depth (h, w) in the unit of the scene, from a file of depth, disparity or distance."""
    values = read_depth(path, manifest.depth_scale, manifest.missing)
    if manifest.measured == "disparity":
        assert manifest.baseline_focal is not None  # checked with the manifest
        shifted = values + np.float32(manifest.doffs)
        return (manifest.baseline_focal / np.where(shifted > 0, shifted, np.nan)).astype(np.float32)
    if manifest.measured == "distance":
        rows, columns = np.indices(values.shape)
        x = (columns - intrinsics[0, 2]) / intrinsics[0, 0]
        y = (rows - intrinsics[1, 2]) / intrinsics[1, 1]
        return (values / np.sqrt(x**2 + y**2 + 1)).astype(np.float32)
    return values


def _confidence(path: Path) -> np.ndarray:
    """Confidence (h, w) in [0, inf): integers of an image span [0, 1], and what is missing counts as 0."""
    if path.suffix.lower() == ".png":
        return read_image(path)[..., 0].astype(np.float32) / 255
    return np.nan_to_num(read_depth(path, None, what="confidence"), nan=0.0)


def middlebury(path: Path) -> dict[str, float]:
    """What Middlebury's calib.txt says of disparities: doffs, and baseline times focal length; nothing without one.

    Lines are ``key=value``, the cameras ``cam0=[f 0 cx; 0 f cy; 0 0 1]``; the baseline is in millimetres there, and so
    is what this gives.
    """
    if not path.is_file():
        return {}
    table: dict[str, tuple[int, str]] = {}
    for line, content in text.comment_free(path):
        key, equals, value = content.partition("=")
        if not equals:
            raise FormatError(path, f"line {line} is no key=value", fix="Give Middlebury's calib.txt, or remove it")
        table[key.strip()] = (line, value.strip())
    found = {}
    if "doffs" in table:
        found["doffs"] = float(text.numbers(path, table["doffs"][0], [table["doffs"][1]], [1])[0])
    if "baseline" in table and "cam0" in table:
        focal = text.numbers(path, table["cam0"][0], text.words(table["cam0"][1].strip("[]")), [9])[0]
        baseline = text.numbers(path, table["baseline"][0], [table["baseline"][1]], [1])[0]
        found["baseline_focal"] = float(focal * baseline)
    return found


def _manifest(path: Path, calibration: dict[str, float]) -> Manifest:
    """The manifest at `path`; a disparity's calibration fills in what it does not say."""
    if not path.is_file():
        return Manifest(**calibration)  # type: ignore[arg-type]
    table = read_toml(path, fix="Correct that line")
    known = [field.name for field in fields(Manifest)]
    for key in table:
        if key not in known:
            raise FormatError(path, f"unknown key '{key}'{nearest(key, known)}", expected=", ".join(known))
    return Manifest(**(calibration | table))


def _check_manifest(folder: Path, manifest: Manifest) -> None:
    choices = {"pose": (manifest.pose, (None, *DIRECTIONS)), "measured": (manifest.measured, QUANTITIES)}
    for key, (value, allowed) in choices.items():
        if value not in allowed:
            raise ParameterError(f"{folder}: {key} = {value!r}: expected {' or '.join(filter(None, allowed))}")
    for key in ("depth_scale", "baseline_focal"):
        value = getattr(manifest, key)
        if value is not None and not (isinstance(value, (int, float)) and 0 < value < np.inf):
            raise ParameterError(f"{folder}: {key} = {value!r}: expected a number > 0")
    for key in ("doffs", "missing"):
        value = getattr(manifest, key)
        if value is not None and not (isinstance(value, (int, float)) and np.isfinite(value)):
            raise ParameterError(f"{folder}: {key} = {value!r}: expected a number")
    if manifest.measured == "disparity" and manifest.baseline_focal is None:
        raise ParameterError(
            f"{folder}: disparities need baseline_focal (pixels * unit) to become depth: put it into views.toml"
        )


def _intrinsics(path: Path, names: Ordered[str], given: Ordered[float] | None) -> dict[str, np.ndarray]:
    if given is not None:
        return dict.fromkeys(names, text.camera_matrix(given))
    lines = [(number, text.words(line)) for number, line in text.comment_free(path)]
    if lines and _named(lines[0][1], names, [4]) is not None:
        return {name: text.camera_matrix(values) for name, values in _by_name(path, names, [4]).items()}
    if len(lines) == 1:
        line, tokens = lines[0]
        return dict.fromkeys(names, text.camera_matrix(text.numbers(path, line, tokens, [4, 9])))
    return dict.fromkeys(names, text.read_camera_matrix(path))


def _poses(path: Path, names: Ordered[str], stated: str | None) -> dict[str, np.ndarray]:
    """cam_from_world (4, 4) by view."""
    direction = _direction(path, stated)
    poses = {}
    for name, values in _by_name(path, names, [12, 16]).items():
        matrix = values.reshape(-1, 4) if values.size == 16 else np.vstack([values.reshape(3, 4), [0, 0, 0, 1]])
        poses[name] = matrix if direction == "cam_from_world" else text.inverse(path, matrix)
    return poses


def _direction(path: Path, stated: str | None) -> str:
    """The direction of the poses, as stated by views.toml or a hint, or by a comment in the file itself."""
    comments = " ".join(line.partition("#")[2] for line in text.read_text(path).splitlines())
    commented = [direction for direction in DIRECTIONS if direction in comments]
    choices = {*commented, *filter(None, [stated])}
    if len(choices) == 1:
        return choices.pop()
    what = (
        "the direction of the poses is stated twice, differently"
        if choices
        else "the direction of the poses is not stated"
    )
    raise FormatError(
        path,
        what,
        expected=" or ".join(DIRECTIONS),
        fix='Put a first line "# world_from_cam" (camera to world) or "# cam_from_world"',
    )


def _named(tokens: Ordered[str], names: Ordered[str], counts: Ordered[int]) -> tuple[str, list[str]] | None:
    """A known name that begins a line, and the numbers after it; None when no known name does."""
    for count in counts:
        given = " ".join(tokens[:-count])
        bare = Path(given).name
        for name in (given, bare, bare if " " in Path(bare).suffix else Path(bare).stem):
            if name in names:
                return name, list(tokens[-count:])
    return None


def _by_name(path: Path, names: Ordered[str], counts: Ordered[int]) -> dict[str, np.ndarray]:
    """The numbers of each view, from lines that begin with its name; lines of other views are passed over.

    A name may hold spaces, and stand with the folder and suffix of its file.
    """
    rows: dict[str, np.ndarray] = {}
    for line, content in text.comment_free(path):
        tokens = text.words(content)
        name, tokens = _named(tokens, names, counts) or (tokens[0], tokens[1:]) if tokens else (content, [])
        if name in rows:
            raise FormatError(
                path,
                f"line {line} is the second of view {name!r}",
                expected="one line a view",
                fix="Remove one of them",
            )
        rows[name] = text.numbers(path, line, tokens, counts)
    if missing := [name for name in names if name not in rows]:
        raise FormatError(
            path,
            f"no line of {len(missing)} of {len(names)} views, the first is {missing[0]!r}",
            expected="one line a depth map",
            fix="Add its line, or remove its depth map",
        )
    return {name: rows[name] for name in names}

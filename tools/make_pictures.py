"""Write docs/pictures/*.jpg from what the demo made: `make demo`, then `python tools/make_pictures.py`."""

import sys
from pathlib import Path

import cv2
import numpy as np

from ipcli.geometry.surface import normals
from ipcli.io.files import atomic, h5
from ipcli.report.animal import surfaces
from ipcli.report.brdf import relief
from ipcli.report.gaze.panorama import panorama
from ipcli.report.kit import pictures, surface
from ipcli.report.saliency.saliency import SALIENCY, marked

ROOT = Path(__file__).resolve().parent.parent
DEMO = ROOT / "build" / "demo"
SHOWN = {
    "kick": ("right_leg", 2),
    "squat": ("left_leg", 2),
    "walk": ("right_leg", 2),
    "wave": ("right_arm", 0),
}  # of an action: group, axis across
COLUMNS, CELL, FINE = (
    6,
    (104, 150),
    8,
)  # behaviours of each, pixels (width, height) of one, parts of a pixel that lines are drawn to
PAPER, REST, GROUP = (250, 252, 252), (170, 165, 160), (30, 80, 200)  # BGR


def coloured(values: np.ndarray, scale: pictures.Scale) -> np.ndarray:
    """A map (h, w) as RGB (h, w, 3)."""
    return pictures.palette(scale.palette)[scale.indices(values)]


def montage(arrays: dict[str, np.ndarray]) -> np.ndarray:
    """Above: reference, median and fused depth. Below: confidence, median and fused surface in light."""
    depth = pictures.robust([arrays["depth"]], "turbo")
    lit = [
        surface.shade(normals(arrays[name], arrays["intrinsics"]), arrays["intrinsics"]) for name in ("median", "depth")
    ]
    above = [coloured(arrays[name], depth) for name in ("reference", "median", "depth")]
    below = [coloured(arrays["confidence"], pictures.robust([arrays["confidence"]], "viridis"))]
    below += [coloured(light, surface.SHADE) for light in lit]
    return np.vstack([np.hstack(above), np.hstack(below)])


def behaviours(arrays: dict[str, np.ndarray]) -> np.ndarray:
    """A row an action, BGR: the most frequent behaviours of one of its groups, the group picked out."""
    poses = arrays["behaviour_poses"]
    low, high = np.nanmin(poses, axis=(0, 1, 2)), np.nanmax(poses, axis=(0, 1, 2))
    rows = []
    for action, (group, across) in SHOWN.items():
        numbers = [list(arrays[key]).index(name) for key, name in (("actions", action), ("groups", group))]
        mine = np.flatnonzero((arrays["behaviour_action"] == numbers[0]) & (arrays["behaviour_group"] == numbers[1]))
        best = mine[np.argsort(-arrays["behaviour_share"][mine], kind="stable")][:COLUMNS]
        members = arrays["group_members"]
        picked = members[members[:, 0] == numbers[1], 1]
        cells = [drawn(poses[index], arrays["parents"], picked, across, low, high) for index in best]
        rows.append(np.hstack(cells + [np.full_like(cells[0], PAPER)] * (COLUMNS - len(cells))))
    return np.vstack([np.hstack(rows[:2]), np.hstack(rows[2:])])


def drawn(
    poses: np.ndarray, parents: np.ndarray, picked: np.ndarray, across: int, low: np.ndarray, high: np.ndarray
) -> np.ndarray:
    """Poses (p, j, 3) over each other, the first in full and of the others the group alone, faint."""
    width, height = CELL
    image = np.full((height, width, 3), PAPER, np.uint8)
    scale = 0.9 * height / (high[1] - low[1])
    middle = (low[across] + high[across]) / 2
    for index, pose in list(enumerate(poses))[::-1]:
        flat = np.stack(
            [width / 2 + scale * (pose[:, across] - middle), 0.95 * height - scale * (pose[:, 1] - low[1])], axis=1
        )
        for joint, parent in enumerate(parents):
            mine = joint in picked
            if parent >= 0 and (mine or index == 0):
                colour = (
                    REST
                    if not mine
                    else GROUP
                    if index == 0
                    else tuple((2 * p + g) // 3 for p, g in zip(PAPER, GROUP, strict=True))
                )
                ends = (tuple(int(x) for x in (FINE * flat[end]).round()) for end in (parent, joint))
                cv2.line(image, *ends, colour, 3 if mine and index == 0 else 2, cv2.LINE_AA, int(np.log2(FINE)))
    return image


def object_in_a_photograph(arrays: dict[str, np.ndarray]) -> np.ndarray:
    """The photograph, its normals as colours, and the relief under two lamps, RGB."""
    mask = arrays["mask"] > 0
    rows, columns = (np.flatnonzero(mask.any(axis=axis)) for axis in (1, 0))
    box = slice(rows[0] - 4, rows[-1] + 5), slice(columns[0] - 4, columns[-1] + 5)
    found = arrays["normals"][box].astype(np.float64)
    lamps = np.array([[-0.6, 0.4, 0.7], [0.6, 0.4, 0.7]]) / np.linalg.norm([0.6, 0.4, 0.7])
    cells = [arrays["picture"][box], relief.as_colours(found), *(relief.lit(found, lamp) for lamp in lamps)]
    return np.hstack([enlarged(cell, 300) for cell in cells])


def animal(arrays: dict[str, np.ndarray]) -> np.ndarray:
    """The model from around, its parts in colours, RGB."""
    colours = surfaces.colours_of(arrays["face_part"])
    shots = surfaces.turntable(arrays["vertices"].astype(np.float64), arrays["faces"], colours, 4, 260)
    return np.hstack(shots)


def attention(arrays: dict[str, np.ndarray], count: int = 3) -> np.ndarray:
    """Above: pictures with points of regard (red) and proto-objects (green). Below: their saliency, RGB."""
    regards, images = arrays["regards/picture"], arrays["pictures/images"]
    looked = np.bincount(regards, minlength=len(images)) + 100 * np.isin(
        np.arange(len(images)), arrays["outlines/picture"]
    )
    groups = np.array_split(np.arange(len(images)), min(count, len(images)))
    shown = [int(group[looked[group].argmax()]) for group in groups]
    above = [marked(arrays, n) for n in shown]
    size = above[0].shape[1::-1]
    below = [cv2.resize(coloured(arrays["pictures/maps"][n], SALIENCY), size) for n in shown]
    return np.vstack([np.hstack(above), np.hstack(below)])


def materials(arrays: dict[str, np.ndarray], lights: int = 6, size: int = 110) -> np.ndarray:
    """A ball of each material under some lights, RGB: a row a material."""
    rows = []
    for index in range(len(arrays["materials"])):
        mine = np.flatnonzero(arrays["chart_material"] == index)
        some = mine[np.linspace(0, len(mine) - 1, lights).round().astype(int)]
        rows.append(np.hstack([relief.ball(arrays["charts"][j].astype(np.float64), size) for j in some]))
    return np.vstack(rows)


def enlarged(picture: np.ndarray, height: int) -> np.ndarray:
    """A picture of that height."""
    width = round(picture.shape[1] * height / picture.shape[0])
    return cv2.resize(picture, (width, height), interpolation=cv2.INTER_AREA)


def write(name: str, picture: np.ndarray) -> None:
    """A BGR picture as docs/pictures/NAME.jpg."""
    _, data = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, 88])
    atomic.write_bytes(ROOT / "docs" / "pictures" / f"{name}.jpg", data.tobytes())


if __name__ == "__main__":
    if not (DEMO / "motions.model.h5").is_file():
        sys.exit(f"{DEMO}: not there. Run `make demo` first")
    write("fuse-depth", montage(h5.read(DEMO / "shapes.fused.h5", "fused-depth").arrays)[..., ::-1])
    gaze = panorama(h5.read(DEMO / "room.gaze.h5", "gaze-experiment").arrays)
    write("gaze-sfm", enlarged(gaze, 320)[..., ::-1])
    looked_at = attention(h5.read(DEMO / "room.saliency.h5", "saliency").arrays)
    write("saliency", enlarged(looked_at, 440)[..., ::-1])
    write("model-animal", animal(h5.read(DEMO / "animal.h5", "animal-model").arrays)[..., ::-1])
    write("brdf-model", object_in_a_photograph(h5.read(DEMO / "vase.h5", "brdf-object").arrays)[..., ::-1])
    write("mocap-train", behaviours(h5.read(DEMO / "motions.model.h5", "behaviours").arrays))

"""Small generated recordings in the layouts of the real ones, for a quick look where no data set is at hand.

python recordings.py room FOLDER     noise-free depth along a path through a room, as ICL-NUIM comes (Open3D's layout)
python recordings.py street FOLDER   stereo pairs of textured streets, as KITTI stereo 2012 comes, with poses/
"""

import sys
from pathlib import Path

import numpy as np

from experiments.fusion.solids import room, street
from ipcli.geometry.cameras import rays
from ipcli.geometry.raycast import Caster, Mesh
from ipcli.io.files import atomic, images

ROOM_SHAPE, ROOM_CAMERA = (120, 160), np.array([[131.25, 0, 79.875], [0, 131.25, 59.875], [0, 0, 1]])
STREET_SHAPE, STREET_CAMERA = (188, 620), np.array([[360.0, 0, 309.5], [0, 360.0, 86.0], [0, 0, 1]])
FRAMES, STEP, BASELINE = 12, 0.8, 0.54  # the street: frames from 0, metres a frame, metres between the cameras
SCENES = ("000000", "000001", "000002")


def make_room(folder: Path) -> None:
    """21 views of an arc, depth in millimetres."""
    caster, lines = Caster(_mesh(room())), []
    for index, turn in enumerate(np.linspace(-0.35, 0.35, 21)):
        pose = pose_at((-1.6 * np.sin(turn), -0.25 + 0.02 * np.sin(3 * index), 0.1), turn)
        depth, image = caster.view(ROOM_SHAPE, ROOM_CAMERA, pose)
        images.write_depth_png16(folder / "depth" / f"{index:05d}.png", depth, 1000.0)
        images.write_png(folder / "image" / f"{index:05d}.png", image)
        lines += [
            f"{index} {index} {index + 1}",
            *(" ".join(f"{value:.9f}" for value in row) for row in np.linalg.inv(pose)),
        ]
    atomic.write_text(folder / "trajectory.log", "\n".join(lines) + "\n")


def make_street(folder: Path) -> None:
    """The frames 10 and 11 of both cameras, the disparities that both see in frame 10, calibration and poses."""
    shift = np.zeros((3, 4))
    shift[0, 3] = -STREET_CAMERA[0, 0] * BASELINE
    projections = [np.hstack([STREET_CAMERA, np.zeros((3, 1))]) + right * shift for right in (0, 1)]
    calibration = "".join(
        f"P{right}: {' '.join(f'{v:.9e}' for v in matrix.ravel())}\n" for right, matrix in enumerate(projections)
    )
    for seed, scene in enumerate(SCENES):
        caster, poses = (
            Caster(_mesh(street(seed))),
            [pose_at((0.1 * k, 0, STEP * k), 0.004 * k) for k in range(-10, FRAMES - 10)],
        )
        atomic.write_text(folder / "calib" / f"{scene}.txt", calibration)
        rows = (np.linalg.inv(pose)[:3].ravel() for pose in poses)
        atomic.write_text(
            folder / "poses" / f"{scene}.txt", "".join(" ".join(f"{v:.9e}" for v in row) + "\n" for row in rows)
        )
        for frame in (10, 11):
            left, right = (_look(caster, poses[frame], offset, seed) for offset in (0.0, BASELINE))
            for side, (_, image) in enumerate((left, right)):
                images.write_png(folder / f"image_{side}" / f"{scene}_{frame}.png", image)
            if frame == 10:
                images.write_depth_png16(
                    folder / "disp_noc" / f"{scene}_10.png", visible(disparity(left[0]), disparity(right[0])), 256.0
                )


def pose_at(centre: tuple[float, float, float], turn: float) -> np.ndarray:
    """cam_from_world (4, 4) of a camera at a point, turned about the vertical axis (radians)."""
    c, s = np.cos(turn), np.sin(turn)
    pose = np.eye(4)
    pose[:3, :3] = [[c, 0, -s], [0, 1, 0], [s, 0, c]]
    pose[:3, 3] = -pose[:3, :3] @ centre
    return pose


def disparity(depth: np.ndarray) -> np.ndarray:
    """Of the street's cameras."""
    return STREET_CAMERA[0, 0] * BASELINE / depth


def visible(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """The left disparity (h, w), NaN where the right camera does not see the point."""
    rows, columns = np.indices(left.shape)
    there = np.nan_to_num(np.round(columns - left), nan=-1).astype(int)
    seen = (there >= 0) & (np.abs(right[rows, np.maximum(there, 0)] - left) < 1)
    return np.where(seen, left, np.nan).astype(np.float32)


def _look(caster: Caster, cam_from_world: np.ndarray, offset: float, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Depth and textured grey image (h, w) of a camera moved to its right by `offset`."""
    pose = cam_from_world.copy()
    pose[0, 3] -= offset
    depth, shaded = caster.view(STREET_SHAPE, STREET_CAMERA, pose)
    points = (depth[..., None] * rays(STREET_SHAPE, STREET_CAMERA) - pose[:3, 3]) @ pose[:3, :3]
    grey = shaded[..., 0] * (0.55 + 0.45 * texture(points, seed))
    return depth, np.clip(np.where(np.isfinite(depth), grey, 250), 0, 255).astype(np.uint8)


def texture(points: np.ndarray, seed: int) -> np.ndarray:
    """A solid texture in [-1, 1] at points (..., 3): waves of many lengths, from 10 cm to 3 m, in all directions."""
    rng = np.random.default_rng(seed)
    waves = rng.normal(size=(48, 3))
    waves *= (2 * np.pi / np.geomspace(0.1, 3.0, 48) / np.linalg.norm(waves, axis=1))[:, None]
    total = np.sin(np.nan_to_num(points) @ waves.T + rng.uniform(0, 2 * np.pi, 48)).sum(axis=-1)
    return np.tanh(total / 4)


def _mesh(solid) -> Mesh:
    return Mesh(np.asarray(solid.vertices), np.asarray(solid.faces))


if __name__ == "__main__":
    {"room": make_room, "street": make_street}[sys.argv[1]](Path(sys.argv[2]))

"""Make sample_data/motions: three people of different build walk, kick, squat and wave, as BVH files
ACTION/ACTOR/TAKE.bvh at 30 Hz.

Everything is computed from formulas and a fixed seed, so that the files come out byte for byte the same. A take differs
from the next in tempo, reach, heading and start, and all angles and places carry noise.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path

import numpy as np

from ipcli.io.files.atomic import write_text
from ipcli.rng import stream

SEED, RATE, SECONDS, TAKES = 11, 30.0, 2.0, 3
ANGLE_NOISE, PLACE_NOISE = 0.8, 0.3  # degrees, centimetres; standard deviations
ACTORS = {"ann": (0.92, 0.95, 0.94), "bob": (1.08, 1.0, 1.06), "eve": (1.0, 1.1, 0.98)}  # scale of legs, trunk, arms
PARTS = ("leg", "trunk", "arm")
SIDES = {"Left": 1.0, "Right": -1.0}  # sign of x: the body faces +z
Angles = dict[str, np.ndarray]  # joint -> degrees about x, y, z, (f, 3)

JOINTS = {  # depth first: parent, offset in centimetres, what scales it, order of its angles
    "Hips": ("", (0, 0, 0), "leg", "YXZ"),
    "Spine": ("Hips", (0, 12, 0), "trunk", "ZXY"),
    "Spine1": ("Spine", (0, 18, 0), "trunk", "ZXY"),
    "Neck": ("Spine1", (0, 22, 0), "trunk", "ZXY"),
    "Head": ("Neck", (0, 9, 1), "trunk", "ZXY"),
}
for _side, _sign in SIDES.items():
    JOINTS |= {
        f"{_side}Arm": ("Spine1", (17 * _sign, 17, 0), "trunk", "XZY"),
        f"{_side}ForeArm": (f"{_side}Arm", (28 * _sign, 0, 0), "arm", "YZX"),
        f"{_side}Hand": (f"{_side}ForeArm", (25 * _sign, 0, 0), "arm", "YZX"),
    }
for _side, _sign in SIDES.items():
    JOINTS |= {
        f"{_side}UpLeg": ("Hips", (9 * _sign, -4, 0), "leg", "XYZ"),
        f"{_side}Leg": (f"{_side}UpLeg", (0, -43, 0), "leg", "XYZ"),
        f"{_side}Foot": (f"{_side}Leg", (0, -42, 0), "leg", "XYZ"),
    }
ENDS = {
    "Head": (0, 18, 0),
    "LeftHand": (9, 0, 0),
    "RightHand": (-9, 0, 0),
    "LeftFoot": (0, -7, 14),
    "RightFoot": (0, -7, 14),
}
LEGS = 43 + 42 + 4 + 7  # centimetres from the hips to the sole


def standing(times: np.ndarray) -> Angles:
    """Arms down, all else as in the T-pose of the offsets."""
    angles = {joint: np.zeros((len(times), 3)) for joint in JOINTS}
    for side, sign in SIDES.items():
        angles[f"{side}Arm"][:, 2] = -78 * sign
        angles[f"{side}ForeArm"][:, 1] = -12 * sign
    return angles


def walk(times: np.ndarray, reach: float) -> tuple[Angles, np.ndarray]:
    """Legs and arms swing against each other; the hips go forward and bob twice a step."""
    angles, phase = standing(times), 2 * np.pi * times
    for side, sign in SIDES.items():
        angles[f"{side}UpLeg"][:, 0] = -27 * reach * np.sin(sign * np.pi / 2 + phase) - 4
        angles[f"{side}Leg"][:, 0] = 8 + 42 * reach * np.clip(np.cos(sign * np.pi / 2 + phase), 0, 1) ** 2
        angles[f"{side}Arm"][:, 0] = 20 * reach * np.sin(sign * np.pi / 2 + phase)
    moved = np.stack([0 * times, 2 * np.cos(2 * phase) - 3, 125 * reach * times], axis=-1)
    return angles, moved


def kick(times: np.ndarray, reach: float) -> tuple[Angles, np.ndarray]:
    """The right leg goes back, then up in front; trunk and arms balance it."""
    angles = standing(times)
    back, up = bump(times, 0.35, 0.12), bump(times, 0.62, 0.14)
    angles["RightUpLeg"][:, 0] = 25 * back - 88 * reach * up
    angles["RightLeg"][:, 0] = 70 * back + 12 * up
    angles["Spine"][:, 0] = 6 * back - 16 * up
    for side, sign in SIDES.items():
        angles[f"{side}Arm"][:, 2] += 38 * sign * up
    return angles, np.zeros((len(times), 3))


def squat(times: np.ndarray, reach: float) -> tuple[Angles, np.ndarray]:
    """Hips and knees bend so that the feet stay; the arms come forward."""
    angles, bend = standing(times), 72 * reach * bump(times, 0.5, 0.2)
    for side in SIDES:
        angles[f"{side}UpLeg"][:, 0] = -bend
        angles[f"{side}Leg"][:, 0] = 2 * bend
        angles[f"{side}Foot"][:, 0] = -bend
        angles[f"{side}Arm"][:, 0] = -1.1 * bend
    angles["Spine"][:, 0] = 0.35 * bend
    drop = -(43 + 42) * (1 - np.cos(np.deg2rad(bend)))
    return angles, np.stack([0 * times, drop, 0 * times], axis=-1)


def wave(times: np.ndarray, reach: float) -> tuple[Angles, np.ndarray]:
    """The right arm is raised and its forearm swings."""
    angles, up = standing(times), np.clip(np.minimum(times, 1 - times) / 0.18, 0, 1)
    angles["RightArm"][:, 2] -= 100 * up
    angles["RightForeArm"][:, 2] = -up * (50 + 32 * reach * np.sin(2 * np.pi * 3.5 * times))
    angles["Head"][:, 1] = -8 * up
    return angles, np.zeros((len(times), 3))


def bump(times: np.ndarray, centre: float, width: float) -> np.ndarray:
    """A smooth rise to 1 and fall."""
    return np.exp(-0.5 * ((times - centre) / width) ** 2)


ACTIONS: dict[str, Callable[[np.ndarray, float], tuple[Angles, np.ndarray]]] = {
    "walk": walk,
    "kick": kick,
    "squat": squat,
    "wave": wave,
}


def take(action: str, actor: str, number: int) -> str:
    """The BVH file of one take."""
    rng = stream(SEED, "motions", f"{action}/{actor}/{number}")
    tempo, reach, late = rng.uniform(0.85, 1.15), rng.uniform(0.85, 1.1), rng.uniform(-0.05, 0.05)
    count = round(SECONDS * RATE / tempo)
    angles, moved = ACTIONS[action](np.arange(count) / count + late, reach)
    scale = dict(zip(PARTS, ACTORS[actor], strict=True))
    turn = np.deg2rad(heading := rng.uniform(-180, 180))
    angles["Hips"][:, 1] += heading
    about_y = np.array([[np.cos(turn), 0, np.sin(turn)], [0, 1, 0], [-np.sin(turn), 0, np.cos(turn)]])
    place = (scale["leg"] * (moved + [0, LEGS, 0])) @ about_y.T + rng.normal(scale=PLACE_NOISE, size=(count, 3))
    columns = [place]
    for joint, (_, _, _, order) in JOINTS.items():
        noisy = angles[joint] + rng.normal(scale=ANGLE_NOISE, size=(count, 3))
        columns.append(noisy[:, ["XYZ".index(axis) for axis in order]])
    rows = (" ".join(f"{value:.1f}" for value in row) for row in np.concatenate(columns, axis=1))
    return "\n".join([*hierarchy(scale, "", 0), "MOTION", f"Frames: {count}", f"Frame Time: {1 / RATE:.7f}", *rows, ""])


def hierarchy(scale: dict[str, float], parent: str, depth: int) -> list[str]:
    """The blocks of the children of a joint, the whole skeleton for ""; depth first, in the order of the channels."""
    lines, pad = ["HIERARCHY"] if not parent else [], "  " * depth
    for joint, (above, offset, part, order) in JOINTS.items():
        if above != parent:
            continue
        places = "Xposition Yposition Zposition " if not parent else ""
        turns = " ".join(f"{axis}rotation" for axis in order)
        lines += [
            f"{pad}{'JOINT' if parent else 'ROOT'} {joint}",
            pad + "{",
            f"{pad}  OFFSET {_place(offset, scale[part])}",
        ]
        lines += [f"{pad}  CHANNELS {3 + len(places.split())} {places}{turns}", *hierarchy(scale, joint, depth + 1)]
        if joint in ENDS:
            lines += [
                f"{pad}  End Site",
                pad + "  {",
                f"{pad}    OFFSET {_place(ENDS[joint], scale[part])}",
                pad + "  }",
            ]
        lines.append(pad + "}")
    return lines


def _place(offset: tuple[float, ...], scale: float) -> str:
    return " ".join(f"{scale * value:.2f}" for value in offset)


def main() -> None:
    """Write the whole folder."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", type=Path, default=Path(__file__).parents[1] / "sample_data" / "motions")
    folder = parser.parse_args().folder
    for action in ACTIONS:
        for actor in ACTORS:
            for number in range(1, TAKES + 1):
                write_text(folder / action / actor / f"{number}.bvh", take(action, actor, number))


if __name__ == "__main__":
    main()

"""Long takes with a label for every frame, strung from clips: `python -m experiments.mocap.takes IN.clips.h5
OUT.clips.h5 ACTOR...`.

Each actor's clips follow one another in an order drawn once. A clip starts where the one before ended and faces the
same way; between them the pose jumps, as it does nowhere in life, so what happens at the joins is not to be taken for
segmentation of real takes.
"""

import sys
from pathlib import Path

import numpy as np

from ipcli.geometry.motion import heading
from ipcli.geometry.skeleton import Groups
from ipcli.io.files import h5
from ipcli.io.motion import artefact
from ipcli.io.motion.groups import find
from ipcli.measurements.motions import Clip, Motion
from ipcli.rng import stream


def strung(parts: list[Clip], groups: Groups, actor: str) -> Clip:
    """One take of all parts, in this order."""
    root = parts[0].motion.skeleton.indices([groups.root])[0]
    positions: list[np.ndarray] = []
    rotations: list[np.ndarray] = []
    for clip in parts:
        motion = clip.motion
        turn, move = np.eye(3), np.zeros(3)
        if positions:
            before = Motion(motion.skeleton, positions[-1], motion.rate)
            turn = (
                heading(before.skeleton, before.positions, groups)[-1]
                @ heading(motion.skeleton, motion.positions, groups)[0].T
            )
            level = np.array([1.0, 0.0, 1.0])  # heights stay as they are
            move = level * (positions[-1][-1, root] - turn @ motion.positions[0, root])
        positions.append(motion.positions @ turn.T + move)
        if motion.rotations is not None:
            rotations.append(turn @ motion.rotations)
    whole = np.concatenate(rotations) if len(rotations) == len(parts) else None
    labels = np.repeat([clip.label for clip in parts], [len(clip.motion.positions) for clip in parts])
    return Clip(
        f"take of {actor}",
        Motion(parts[0].motion.skeleton, np.concatenate(positions), parts[0].motion.rate, whole),
        "",
        actor,
        labels,
    )


def takes(path: Path, actors: list[str], seed: int = 0) -> list[Clip]:
    """A take of each actor; ends with a word when one has no clips."""
    found = artefact.read_clips(path)
    if unknown := [actor for actor in actors if actor not in found.actors]:
        raise SystemExit(f"{path}: no clip of {unknown[0]}. There are clips of {', '.join(sorted(set(found.actors)))}")
    groups = find("auto", found.skeleton)
    made = []
    for actor in actors:
        mine = [name for name, other in zip(found.names, found.actors, strict=True) if other == actor]
        order = stream(seed, "mocap-takes", actor).permutation(len(mine))
        made.append(strung([found.load(mine[index]) for index in order], groups, actor))
    return made


if __name__ == "__main__":
    source, target, *actors = sys.argv[1:]
    h5.write(Path(target), "clips", artefact.clips_arrays(takes(Path(source), actors), {}), {})

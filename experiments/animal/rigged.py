"""Rigged animals (GLB with a skin and clips) in any pose of a clip, with the part of each face from the names of bones.

Only what these files use is read: one binary chunk, linear blend skinning, clips with linear keys.
"""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

TYPES = {5121: np.uint8, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
HEAD = ("ear", "head", "jaw", "horn", "antler")


class Rig:
    """One GLB file."""

    def __init__(self, path: Path) -> None:
        data = path.read_bytes()
        length = struct.unpack_from("<I", data, 12)[0]
        self.about: dict[str, Any] = json.loads(data[20 : 20 + length])
        self.binary = data[20 + length + 8 :]
        self.nodes = self.about["nodes"]
        self.parents = {child: k for k, node in enumerate(self.nodes) for child in node.get("children", ())}

    def array(self, index: int) -> np.ndarray:
        """An accessor as an array (count, width)."""
        accessor = self.about["accessors"][index]
        view = self.about["bufferViews"][accessor["bufferView"]]
        kind, width = np.dtype(TYPES[accessor["componentType"]]), WIDTHS[accessor["type"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        stride = view.get("byteStride", kind.itemsize * width)
        rows = np.ndarray((accessor["count"], width), kind, self.binary, start, (stride, kind.itemsize))
        return rows.astype(np.float64) / (float(2 ** (8 * kind.itemsize) - 1) if accessor.get("normalized") else 1.0)

    def pose(self, clip: str | None, share: float) -> list[np.ndarray]:
        """World matrices (4, 4) of all nodes at a share in [0, 1] of a clip; None: as modelled."""
        local = [
            {"translation": node.get("translation", [0, 0, 0]), "rotation": node.get("rotation", [0, 0, 0, 1]),
             "scale": node.get("scale", [1, 1, 1])}
            for node in self.nodes
        ]  # fmt: skip
        if clip is not None:
            animation = next(a for a in self.about["animations"] if a["name"].split("|")[-1] == clip)
            for channel in animation["channels"]:
                sampler = animation["samplers"][channel["sampler"]]
                value = _between(self.array(sampler["input"])[:, 0], self.array(sampler["output"]), share)
                local[channel["target"]["node"]][channel["target"]["path"]] = value
        worlds: dict[int, np.ndarray] = {}

        def world(k: int) -> np.ndarray:
            if k not in worlds:
                own = np.array(self.nodes[k].get("matrix", np.eye(4).T.ravel())).reshape(4, 4).T
                if "matrix" not in self.nodes[k]:
                    own = np.eye(4)
                    own[:3, :3] = Rotation.from_quat(local[k]["rotation"]).as_matrix() * np.array(local[k]["scale"])
                    own[:3, 3] = local[k]["translation"]
                worlds[k] = world(self.parents[k]) @ own if k in self.parents else own
            return worlds[k]

        return [world(k) for k in range(len(self.nodes))]

    def posed(self, clip: str | None = None, share: float = 0.0) -> tuple[np.ndarray, np.ndarray, list[str]]:
        """Vertices (n, 3), faces (m, 3) and the name of the part of each face."""
        worlds = self.pose(clip, share)
        vertices: list[np.ndarray] = []
        faces: list[np.ndarray] = []
        parts: list[str] = []
        for node in self.nodes:
            if "mesh" not in node or "skin" not in node:
                continue
            skin = self.about["skins"][node["skin"]]
            inverse = self.array(skin["inverseBindMatrices"]).reshape(-1, 4, 4).transpose(0, 2, 1)
            bones = np.array([worlds[joint] @ inverse[k] for k, joint in enumerate(skin["joints"])])
            named = np.array([part_of(self.nodes[joint]["name"]) for joint in skin["joints"]])
            for primitive in self.about["meshes"][node["mesh"]]["primitives"]:
                own = {key: self.array(index) for key, index in primitive["attributes"].items()}
                joints, weights = own["JOINTS_0"].astype(int), own["WEIGHTS_0"]
                weights = weights / weights.sum(axis=1, keepdims=True)
                blended = np.einsum("vk,vkab->vab", weights, bones[joints])
                corners = self.array(primitive["indices"])[:, 0].astype(int).reshape(-1, 3)
                at = np.concatenate([own["POSITION"], np.ones((len(joints), 1))], axis=1)
                names = np.unique(named)
                shares = np.stack([(weights * (named[joints] == name)).sum(axis=1) for name in names], axis=1)
                parts += names[shares[corners].sum(axis=1).argmax(axis=1)].tolist()
                faces.append(corners + sum(len(block) for block in vertices))
                vertices.append(np.einsum("vab,vb->va", blended, at)[:, :3])
        return np.concatenate(vertices), np.concatenate(faces), parts


def _between(times: np.ndarray, values: np.ndarray, share: float) -> np.ndarray:
    """The value at a share of the last time, linear between keys; quaternions on the shorter way."""
    if len(times) < 2:
        return values[0]
    at = np.clip(share * times[-1], times[0], times[-1])
    k = int(np.clip(np.searchsorted(times, at, side="right") - 1, 0, len(times) - 2))
    after = values[k + 1] * (-1 if values.shape[1] == 4 and values[k] @ values[k + 1] < 0 else 1)
    weight = (at - times[k]) / (times[k + 1] - times[k])
    return (1 - weight) * values[k] + weight * after


def part_of(bone: str) -> str:
    """The part that a bone of these rigs moves."""
    name = bone.lower()
    side = {"l": "L", "r": "R"}.get(name.rsplit(".", 1)[-1], "")
    if any(word in name for word in HEAD):
        return "head"
    if "neck" in name:
        return "neck"
    if "tail" in name:
        return "tail"
    if name.startswith(("front", "ff.")) or "ikfront" in name:
        return f"front_leg_{side}"
    if (
        (name.startswith("back") and ("leg" in name or "shoulder" in name))
        or name.startswith("ffb")
        or "ikback" in name
    ):
        return f"back_leg_{side}"
    return "torso"

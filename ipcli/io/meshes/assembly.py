"""One closed surface with named parts, for other programs: GLB, OBJ, STL and PLY.

Vertices are float32 in every format and written once and unrounded, so that what was closed is closed after it is read:
OBJ and PLY share them between the parts; GLB repeats those on a border, bit for bit, in the node of each part; STL
knows no vertices, and readers join equal ones.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from ipcli.errors import ParameterError
from ipcli.io.files import atomic, ply
from ipcli.io.meshes import turntable

SUFFIXES = (".glb", ".ply", ".obj", ".stl")
COLOURS = (  # of the parts in turn, RGB: Kelly's contrasts, muted for pictures
    (222, 165, 92), (94, 140, 190), (196, 94, 88), (110, 168, 120), (150, 120, 180), (216, 190, 92), (104, 176, 176),
    (206, 130, 168), (150, 150, 110), (120, 110, 100), (170, 200, 110), (90, 110, 150),
)  # fmt: skip


def colour(part: int) -> tuple[int, int, int]:
    """RGB of a part by its number."""
    return COLOURS[part % len(COLOURS)]


def write(
    path: Path,
    vertices: np.ndarray,
    faces: np.ndarray,
    face_part: np.ndarray,
    names: Sequence[str],
    *,
    name: str = "model",
    extra: Mapping[str, np.ndarray] | None = None,
    comment: str = "",
    suffix: str | None = None,
) -> None:
    """Write vertices (n, 3) float32, faces (m, 3) and the part (m,) of each face, in the format of the suffix.

    `extra`, scalars (n,) of the vertices, go into a PLY. Raises ParameterError for another suffix.
    """
    suffix = (suffix or Path(path).suffix).lower()
    vertices = np.ascontiguousarray(vertices, np.float32)
    if suffix == ".glb":
        atomic.write_bytes(path, glb(vertices, faces, face_part, names, name))
    elif suffix == ".obj":
        atomic.write_text(path, obj(vertices, faces, face_part, names, comment))
    elif suffix == ".stl":
        atomic.write_bytes(path, stl(vertices, faces))
    elif suffix == ".ply":
        columns = {"part": vertex_part(len(vertices), faces, face_part).astype(np.uint8)} | dict(extra or {})
        palette = np.array([colour(k) for k in range(256)], np.uint8)
        colours = palette[columns["part"]]
        listed = [f"part {number} {part}" for number, part in enumerate(names) if part.isascii()]
        comments = [*filter(None, [comment]), *listed]
        ply.write(path, vertices, faces=faces.astype(np.int32), colors=colours, extra=columns, comments=comments)
    else:
        raise ParameterError(f"{path}: a model is written as {', '.join(SUFFIXES)}; got '{suffix}'")


def vertex_part(count: int, faces: np.ndarray, face_part: np.ndarray) -> np.ndarray:
    """For each of `count` vertices the part of its last face."""
    parts = np.zeros(count, np.int64)
    parts[faces.ravel()] = np.repeat(face_part, 3)
    return parts


def glb(vertices: np.ndarray, faces: np.ndarray, face_part: np.ndarray, names: Sequence[str], name: str) -> bytes:
    """A binary glTF with one node a part below a node of the whole."""
    return scene_of(vertices, faces, face_part, names, name).export(file_type="glb")


def turnable(
    title: str, vertices: np.ndarray, faces: np.ndarray, face_part: np.ndarray, names: Sequence[str], most_faces: int
) -> str:
    """A page that needs nothing else, in which the model, x forward and z up, can be turned, first seen from its left
    and a little from the front; made lighter where it has more faces.
    """
    if len(faces) > most_faces:
        vertices, faces, face_part = lighter(vertices, faces, face_part, most_faces)
    upright = np.ascontiguousarray(vertices[:, [1, 2, 0]])  # y up, as viewers have it
    legend = {name: colour(part) for part, name in enumerate(names) if part in face_part}
    start = turntable.looking_from(upright, np.array([1.0, 0.35, 0.7]))
    scene = scene_of(upright, faces, face_part, names, "model")
    return turntable.turning_page(scene, title, "The model by its parts:", legend, from_camera=start)


def lighter(
    vertices: np.ndarray, faces: np.ndarray, face_part: np.ndarray, most_faces: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A mesh of about so many faces; each takes the part of the nearest face it had."""
    from scipy.spatial import cKDTree

    from ipcli.geometry import open3d

    o3d = open3d.load()
    mesh = o3d.geometry.TriangleMesh(
        o3d.utility.Vector3dVector(vertices.astype(np.float64)), o3d.utility.Vector3iVector(faces.astype(np.int32))
    ).simplify_quadric_decimation(most_faces)
    light, corners = np.asarray(mesh.vertices), np.asarray(mesh.triangles)
    _, nearest = cKDTree(vertices[faces].mean(axis=1)).query(light[corners].mean(axis=1))
    return light.astype(np.float32), corners, face_part[nearest]


def scene_of(vertices: np.ndarray, faces: np.ndarray, face_part: np.ndarray, names: Sequence[str], name: str):
    """The trimesh scene with one node a part below a node of the whole."""
    import trimesh

    scene = trimesh.Scene(base_frame=name)
    for part, title in enumerate(names):
        own = faces[face_part == part]
        if not len(own):
            continue
        used, packed = np.unique(own, return_inverse=True)
        material = trimesh.visual.material.PBRMaterial(
            name=title, baseColorFactor=[*colour(part), 255], metallicFactor=0.0, roughnessFactor=0.8
        )
        visual = trimesh.visual.TextureVisuals(material=material)
        mesh = trimesh.Trimesh(vertices[used], packed.reshape(-1, 3), visual=visual, process=False)
        scene.add_geometry(mesh, node_name=title, geom_name=title)
    return scene


def obj(vertices: np.ndarray, faces: np.ndarray, face_part: np.ndarray, names: Sequence[str], comment: str) -> str:
    """Wavefront OBJ with one group a part over shared vertices."""
    lines = [f"# {comment}"] if comment else []
    lines += [f"v {x} {y} {z}" for x, y, z in vertices.tolist()]  # the shortest text that reads back the same float32
    for part, title in enumerate(names):
        own = faces[face_part == part] + 1
        if len(own):
            lines.append(f"g {'_'.join(title.split())}")
            lines += [f"f {a} {b} {c}" for a, b, c in own.tolist()]
    return "\n".join(lines) + "\n"


def stl(vertices: np.ndarray, faces: np.ndarray) -> bytes:
    """Binary STL, for printers."""
    corners = vertices[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
    table = np.zeros(len(faces), np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("bits", "<u2")]))
    table["normal"], table["corners"] = normals, corners
    return b"ipcli model".ljust(80, b" ") + np.uint32(len(faces)).tobytes() + table.tobytes()

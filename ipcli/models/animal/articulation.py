"""A body that bends: a model of an animal cut into rigid segments at its joints, posed, and skinned.

The thesis (6.3) lets aspects come from images of another pose.

Each part is a segment, or a chain of them where it is long; the torso is two. A pose turns every segment about the
joint to its parent. Skinning blends the turns of neighbouring segments, so that the surface stays whole.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ipcli.geometry import lie, meshes
from ipcli.measurements.part_images import NONE, PartTree

ELONGATED = 5.0  # lengths of a leaf part over its radius, from which on it bends within
LIMB, TORSO = 3, 2  # segments of a long leaf part and of the root
BLEND = 0.6  # radii of a joint over which the turns of its two segments are blended


@dataclass(frozen=True, eq=False)
class JointedBody:
    """A closed mesh, vertices (n, 3) and faces (m, 3), with the part of each face (m,), cut into s segments.

    `segment` (n,) is that of each vertex; `part` (s,) the part that a segment belongs to; `parent` (s,) the segment it
    hangs on, NONE for the root, always listed before it; `joint` (s, 3) where; `weights` (n, s) of skinning.
    """

    vertices: np.ndarray
    faces: np.ndarray
    face_part: np.ndarray
    segment: np.ndarray
    part: np.ndarray
    parent: np.ndarray
    joint: np.ndarray
    weights: np.ndarray

    def __len__(self) -> int:
        return len(self.part)

    @property
    def size(self) -> float:
        """Diagonal of the box around it."""
        return float(np.linalg.norm(np.ptp(self.vertices, axis=0)))

    @cached_property
    def below(self) -> np.ndarray:
        """(s, s) bool: whether turning the first segment moves the second."""
        moved = np.eye(len(self), dtype=bool)
        for segment, parent in enumerate(self.parent):
            if parent != NONE:
                moved[:, segment] |= moved[:, parent]
        return moved


@dataclass(frozen=True, eq=False)
class Posture:
    """Turn (s, 3, 3) of each segment against its parent (of the root against the world), place (3,) of the root's joint
    in the world, and scale.
    """

    turns: np.ndarray
    place: np.ndarray
    scale: float = 1.0

    @classmethod
    def rest(cls, body: JointedBody) -> Posture:
        """As the body was modelled."""
        return cls(np.tile(np.eye(3), (len(body), 1, 1)), body.joint[0].copy())

    def motions(self, body: JointedBody) -> tuple[np.ndarray, np.ndarray]:
        """Rotation (s, 3, 3) and new joint (s, 3) of each segment in the world."""
        rotations, joints = np.empty_like(self.turns), np.empty((len(body), 3))
        for k, parent in enumerate(body.parent):
            if parent == NONE:
                rotations[k], joints[k] = self.turns[k], self.place
            else:
                rotations[k] = rotations[parent] @ self.turns[k]
                arm = body.joint[k] - body.joint[parent]
                joints[k] = joints[parent] + self.scale * rotations[parent] @ arm
        return rotations, joints

    def turned(self, body: JointedBody, vectors: np.ndarray, shift: np.ndarray, log_scale: float) -> Posture:
        """The pose after small turns (s, 3), about world axes, of every segment with all that hangs on it."""
        rotations, _ = self.motions(body)
        above = [np.eye(3) if parent == NONE else rotations[parent] for parent in body.parent]
        local = np.einsum("sba,sb->sa", np.array(above), vectors)
        return Posture(lie.exp(local) @ self.turns, self.place + shift, self.scale * float(np.exp(log_scale)))

    def rigid(self, body: JointedBody, points: np.ndarray, segment: np.ndarray) -> np.ndarray:
        """Where points (n, 3) of the body go that move with one segment (n,) each."""
        rotations, joints = self.motions(body)
        arms = points - body.joint[segment]
        return joints[segment] + self.scale * np.einsum("nab,nb->na", rotations[segment], arms)

    def skinned(self, body: JointedBody) -> np.ndarray:
        """All vertices (n, 3), blended over the joints."""
        rotations, joints = self.motions(body)
        moved = np.zeros_like(body.vertices)
        for k in range(len(body)):
            weight = body.weights[:, k : k + 1]
            moved += weight * (joints[k] + self.scale * (body.vertices - body.joint[k]) @ rotations[k].T)
        return moved


def jointed(vertices: np.ndarray, faces: np.ndarray, face_part: np.ndarray, tree: PartTree) -> JointedBody:
    """Cut a labelled closed mesh into segments. Parts that have no face get none, what hangs on them hangs on the next.

    The joint of two parts is the middle of the line along which they meet, or of their nearest points.
    """
    vertices = vertices.astype(np.float64)
    graph = edge_graph(vertices, faces)
    part = in_one_piece(vertex_parts(len(vertices), faces, face_part, len(tree)), graph)
    face_part = part[faces[:, 0]]
    areas = meshes.areas(vertices, faces)
    order = [k for k in tree.downwards() if (part == k).sum() > 3]
    segment = np.full(len(vertices), NONE)
    parts: list[int] = []
    parents: list[int] = []
    joints: list[np.ndarray] = []
    for k in order:
        own = np.flatnonzero(part == k)
        ancestor = _ancestor(k, order, tree)
        if ancestor == NONE:
            joint, start = _middle_cut(vertices[own])
        else:
            joint, start = _meeting(vertices, graph, own, np.flatnonzero(part == ancestor))
        most = TORSO if ancestor == NONE else LIMB if _is_leaf(k, tree) else 1
        pieces = _pieces(graph, own, start, most, float(areas[face_part == k].sum()))
        hangs = NONE if ancestor == NONE else _nearest_segment(vertices, segment, part == ancestor, joint)
        for number in range(pieces.max() + 1):
            mine = own[pieces == number]
            at = joint if number == 0 else _seam(vertices, own, pieces, number)
            segment[mine] = len(parts)
            parents.append(hangs if number == 0 else len(parts) - 1)
            parts.append(k)
            joints.append(at)
    segment = _filled(vertices, segment)
    body = JointedBody(
        vertices, faces, face_part, segment, np.array(parts), np.array(parents), np.array(joints), np.empty(0)
    )
    return replace(body, weights=skin_weights(body))


def vertex_parts(count: int, faces: np.ndarray, face_part: np.ndarray, parts: int) -> np.ndarray:
    """The part (count,) of each vertex: that of most of its faces."""
    votes = np.zeros((count, parts))
    np.add.at(votes, (faces.ravel(), np.repeat(face_part, 3)), 1.0)
    return votes.argmax(axis=1)


def in_one_piece(part: np.ndarray, graph) -> np.ndarray:
    """Parts (n,) of vertices without islands: each keeps its largest blob, the rest takes the nearest part."""
    from scipy.sparse.csgraph import connected_components, dijkstra

    kept = np.zeros(len(part), bool)
    for k in np.unique(part):
        own = np.flatnonzero(part == k)
        _, blob = connected_components(graph[own][:, own], directed=False)
        kept[own[blob == np.argmax(np.bincount(blob))]] = True
    if kept.all():
        return part
    start = np.flatnonzero(kept)
    _, _, source = dijkstra(graph, indices=start, min_only=True, return_predecessors=True)
    return np.where(source >= 0, part[np.maximum(source, 0)], part)


def edge_graph(vertices: np.ndarray, faces: np.ndarray):
    """Sparse (n, n) lengths of the edges of a mesh."""
    from scipy.sparse import coo_array

    ends = np.unique(meshes.edges(faces), axis=0)
    lengths = np.linalg.norm(vertices[ends[:, 0]] - vertices[ends[:, 1]], axis=1)
    half = coo_array((lengths, ends.T), shape=(len(vertices),) * 2)
    return (half + half.T).tocsr()


def _ancestor(part: int, present: list[int], tree: PartTree) -> int:
    parent = tree.parents[part]
    while parent != NONE and parent not in present:
        parent = tree.parents[parent]
    return parent


def _is_leaf(part: int, tree: PartTree) -> bool:
    return part not in tree.parents


def _middle_cut(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The middle of the root, and indices of the points at one end of its longest axis."""
    middle = points.mean(axis=0)
    axis = np.linalg.svd(points - middle, full_matrices=False)[2][0]
    along = (points - middle) @ axis
    return middle, np.flatnonzero(along >= np.quantile(along, 0.98))


def _meeting(vertices: np.ndarray, graph, own: np.ndarray, other: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Middle (3,) of the line along which two sets of vertices meet, and indices into `own` of those on it."""
    from scipy.spatial import cKDTree

    touching = graph[own][:, other].tocoo()
    if touching.nnz:
        line = np.unique(touching.row)
        return vertices[own[line]].mean(axis=0), line
    away, nearest = cKDTree(vertices[other]).query(vertices[own])
    first = int(np.argmin(away))
    return (vertices[own[first]] + vertices[other[nearest[first]]]) / 2, np.array([first])


def _pieces(graph, own: np.ndarray, start: np.ndarray, most: int, area: float) -> np.ndarray:
    """The piece (len(own),) of each vertex of a part: slices of equal length along the surface from `start`.

    A part that is not long compared with its radius is one piece.
    """
    from scipy.sparse.csgraph import dijkstra

    if most == 1:
        return np.zeros(len(own), int)
    away = dijkstra(graph[own][:, own], indices=start, min_only=True)
    reached = np.isfinite(away)
    length = float(away[reached].max())
    away[~reached] = length / 2
    if length == 0 or (most == LIMB and length < ELONGATED * area / (2 * np.pi * length)):  # a tube's radius
        return np.zeros(len(own), int)
    return np.minimum((most * away / max(length, 1e-12)).astype(int), most - 1)


def _seam(vertices: np.ndarray, own: np.ndarray, pieces: np.ndarray, number: int) -> np.ndarray:
    """The middle (3,) between a piece and the one before it: of those of their vertices that are nearest."""
    from scipy.spatial import cKDTree

    before, after = vertices[own[pieces == number - 1]], vertices[own[pieces == number]]
    if not len(before) or not len(after):
        return vertices[own].mean(axis=0)
    away, _ = cKDTree(before).query(after)
    return after[away <= np.quantile(away, 0.15)].mean(axis=0)


def _nearest_segment(vertices: np.ndarray, segment: np.ndarray, among: np.ndarray, point: np.ndarray) -> int:
    own = np.flatnonzero(among & (segment != NONE))
    return int(segment[own[np.argmin(np.linalg.norm(vertices[own] - point, axis=1))]])


def _filled(vertices: np.ndarray, segment: np.ndarray) -> np.ndarray:
    """Vertices of parts too small for a segment move with the nearest one that has one."""
    from scipy.spatial import cKDTree

    lost = segment == NONE
    if lost.any():
        segment = segment.copy()
        segment[lost] = segment[~lost][cKDTree(vertices[~lost]).query(vertices[lost])[1]]
    return segment


def skin_weights(body: JointedBody) -> np.ndarray:
    """(n, s): one-hot segments diffused over the surface as far as joints are wide (one implicit step of heat flow)."""
    import igl
    from scipy.sparse import csc_array
    from scipy.sparse.linalg import splu

    faces = np.ascontiguousarray(body.faces, np.int64)
    stiffness = -igl.cotmatrix(body.vertices, faces)
    mass = igl.massmatrix(body.vertices, faces, igl.MASSMATRIX_TYPE_VORONOI)
    reach = (BLEND * _joint_radius(body)) ** 2
    hot = np.eye(len(body))[body.segment]
    weights = splu(csc_array(mass + reach * stiffness)).solve(mass @ hot)
    weights = np.clip(weights, 0.0, None)
    return weights / weights.sum(axis=1, keepdims=True)


def _joint_radius(body: JointedBody) -> float:
    """Median distance of the vertices beside a seam from its joint."""
    ends = meshes.edges(body.faces)
    first, second = body.segment[ends[:, 0]], body.segment[ends[:, 1]]
    across = ends[first != second]
    if not len(across):
        return 0.02 * body.size
    lower = np.maximum(first, second)[first != second]
    return float(np.median(np.linalg.norm(body.vertices[across[:, 0]] - body.joint[lower], axis=1)))

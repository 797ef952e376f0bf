"""The thesis' search for the view of one part: the contour generator energy of two points (6.10) and its least values.

Two points y1, y2 on a part's outline are looked for on its surface: Y1, Y2 must lie on one contour generator. Corrected
against the print: at a hyperbolic point the outline's curvature is at most the surface's least one (proposition 6.1
says at least); the cost of an angle is tan |d / 2|, since tan |d| is negative beyond 90 degrees; and (6.15) compares
the distance that the view leaves of Y1 Y2, since |Y1 - Y2| has a depth that no image shows. Lengths are over the size
of the part, the scale of the image is known.

The energy has four unknowns and three equations: its least value does not fix the view.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ipcli.geometry.meshes import vertex_normals
from ipcli.geometry.raycast import Caster, Mesh
from ipcli.geometry.triangulation import contour, resample
from ipcli.measurements.part_images import BACKGROUND, PartImage

# weights of the terms: by the size of their noise on masks, not fitted to anything
CURVATURE, SIGN = 0.05, 0.3  # of (6.13)
NORMALS, BASE = 1.0, 1.0  # of (6.14)
DISTANCE = 10.0  # of (6.15)
PENETRATION = 2.0  # of E_cg

FLAT = 0.02  # product of Gaussian and outline curvature, over sizes, that has no sign: one of both is flat
CROSSED = 0.5  # least sine between the normals of both points: of others v = n1 x n2 is all noise
CHUNK = 2000  # pairs whose rays are cast at once
OFF = 1e-3  # of the size: rays pass that far outside the surface, not through its vertex
STEP = 1.5  # pixels between points of an outline
SMOOTHED = 3.0  # points: deviation of the Gaussian that an outline's derivatives are taken with
CLEAR = 5  # points beside a cut, or a place where another part begins, that tell nothing
BESIDE = 2.5  # pixels outside an outline where the background must be
ADMISSIBLE = 0.01  # share of the surface that a point's curvature must allow: corners and spikes allow none
TINY = 1e-12  # length of a vector without a direction
RINGS = 3  # of triangles around a vertex that its curvature is fitted to


@dataclass(frozen=True, eq=False)
class SurfaceSamples:
    """Points (n, 3) of a part's surface, outward unit normals (n, 3), and principal curvatures (n,), least and
    largest, of which convex ones are positive; `size` is the diagonal of the part's box.
    """

    points: np.ndarray
    normals: np.ndarray
    least: np.ndarray
    largest: np.ndarray
    size: float

    @classmethod
    def of(cls, vertices: np.ndarray, faces: np.ndarray) -> SurfaceSamples:
        """All vertices of a closed mesh."""
        import igl

        corners = np.ascontiguousarray(vertices, np.float64)
        _, _, largest, least, _ = igl.principal_curvature(corners, faces.astype(np.int64), radius=RINGS)
        size = float(np.linalg.norm(np.ptp(corners, axis=0)))
        return cls(corners, vertex_normals(corners, faces), least, largest, size)

    def chosen(self, keep: np.ndarray) -> SurfaceSamples:
        """Those of a mask or of indices."""
        return SurfaceSamples(self.points[keep], self.normals[keep], self.least[keep], self.largest[keep], self.size)


@dataclass(frozen=True, eq=False)
class OutlinePoints:
    """Points (m, 2) of a part's outline in units of the world, outward normals (m, 2) and curvature (m,), positive
    where convex.
    """

    points: np.ndarray
    normals: np.ndarray
    curvature: np.ndarray

    @classmethod
    def of(cls, image: PartImage, part: int, scale: float) -> OutlinePoints:
        """Those beside the background, away from other parts; `scale` is in pixels a unit of the world."""
        from scipy.ndimage import binary_dilation, gaussian_filter1d

        closed = resample(contour(image.mask(part)), STEP)
        u, v = closed.T
        if (u * np.roll(v, -1) - v * np.roll(u, -1)).sum() < 0:
            closed = closed[::-1]
        smooth, first, second = (gaussian_filter1d(closed, SMOOTHED, 0, order=k, mode="wrap") for k in range(3))
        speed = np.maximum(np.linalg.norm(first, axis=1), TINY)
        normals = np.stack([first[:, 1], -first[:, 0]], axis=1) / speed[:, None]
        curvature = (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]) / speed**3
        out = np.rint(closed + BESIDE * normals).astype(int)
        column, row = (np.clip(out[:, k], 0, image.labels.shape[1 - k] - 1) for k in range(2))
        hidden = np.tile(image.labels[row, column] != BACKGROUND, 3)
        clear = ~binary_dilation(hidden, iterations=CLEAR)[len(closed) : 2 * len(closed)]
        return cls(smooth[clear] / scale, normals[clear], curvature[clear] * scale)

    def pair(self, surface: SurfaceSamples) -> OutlinePoints | None:
        """The two points that fewest samples of the surface admit, with normals that cross; None without such."""
        share = np.array([(curvature_cost(surface, k) == 0).mean() for k in self.curvature])
        order = np.argsort(share, kind="stable")
        order = order[share[order] >= ADMISSIBLE]
        crossed = np.abs(_cross(self.normals[order[:1]], self.normals[order])) > CROSSED
        if not crossed.any():
            return None
        both = order[[0, int(np.argmax(crossed))]]
        return OutlinePoints(self.points[both], self.normals[both], self.curvature[both])


def _cross(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """The third component of the cross products of plane vectors (..., 2)."""
    return first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0]


def curvature_cost(surface: SurfaceSamples, curvature: float) -> np.ndarray:
    """E_curv (n,) of (6.13) of all samples for an outline's curvature.

    Koenderink: it is K / II(v, v). So it lies in [k1, k2] where it is positive, and in (-inf, k1] where it is negative.
    """
    least = surface.least if curvature > 0 else -np.inf
    most = surface.largest if curvature > 0 else surface.least
    away = np.maximum(np.maximum(least - curvature, curvature - most), 0.0) * surface.size
    signs = surface.least * surface.largest * curvature * surface.size**3
    return CURVATURE * away + SIGN * (signs < -FLAT)


def pair_costs(surface: SurfaceSamples, pair: OutlinePoints) -> np.ndarray:
    """All of (6.10) but E_cg, (n, n) for Y1 by row and Y2 by column; inf where the normals hardly cross."""
    alone = [curvature_cost(surface, k) for k in pair.curvature]
    return np.stack([_row(surface, pair, i) + alone[0][i] + alone[1] for i in range(len(surface.points))])


def _row(surface: SurfaceSamples, pair: OutlinePoints, i: int) -> np.ndarray:
    """E_ang + E_dist (n,) of one sample as Y1 with all others as Y2."""
    sine, views = view_directions(surface, pair, np.array([i]), np.arange(len(surface.points)))
    between = np.arctan2(sine, surface.normals @ surface.normals[i])
    base, flat = surface.points - surface.points[i], pair.points[1] - pair.points[0]
    along = (base * views).sum(axis=1)
    turn = np.arctan2((np.cross(surface.normals[i], base) * views).sum(axis=1), base @ surface.normals[i])
    wanted = np.arctan2(_cross(pair.normals[0], flat), pair.normals[0] @ flat)
    asked = np.arctan2(np.abs(_cross(*pair.normals)), pair.normals[0] @ pair.normals[1])
    angles = NORMALS * _angle_cost(between - asked) + BASE * _angle_cost(turn - wanted)
    seen = np.sqrt(np.maximum((base**2).sum(axis=1) - along**2, 0.0))
    apart = DISTANCE * ((seen - np.linalg.norm(flat)) / surface.size) ** 2
    return np.where(sine > CROSSED, angles + apart, np.inf)


def _angle_cost(difference: np.ndarray) -> np.ndarray:
    """c of (6.14) as tan |d / 2|."""
    wrapped = np.abs((difference + np.pi) % (2 * np.pi) - np.pi)
    return np.tan(np.minimum(wrapped, np.pi - 1e-6) / 2)


def view_directions(
    surface: SurfaceSamples, pair: OutlinePoints, first: np.ndarray, second: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Sine (k,) between the normals of samples and the direction of view (k, 3), v = n1 x n2 with the sign that the
    outline's normals have.
    """
    crossed = np.cross(surface.normals[first], surface.normals[second])
    sine = np.linalg.norm(crossed, axis=1)
    return sine, np.sign(_cross(*pair.normals)) * crossed / np.maximum(sine, TINY)[:, None]


def least_sums(
    known: np.ndarray, penalty: Callable[[np.ndarray], np.ndarray], count: int, chunk: int = CHUNK
) -> tuple[np.ndarray, np.ndarray]:
    """Indices (k,) and values (k,) of the least known + penalty over numbers (n,), best first, exactly.

    `penalty` takes indices and is never negative, so `known` is a bound from below: it is asked for in the order of
    that bound and until the bound passes the last of the `count` best.
    """
    order = np.argsort(known, kind="stable")
    order = order[np.isfinite(known[order])]
    best, values = np.empty(0, np.int64), np.empty(0)
    for start in range(0, len(order), chunk):
        some = order[start : start + chunk]
        if len(best) == count and known[some[0]] >= values[-1]:
            break
        values = np.concatenate([values, known[some] + penalty(some)])
        best = np.concatenate([best, some])
        kept = np.argsort(values, kind="stable")[:count]
        best, values = best[kept], values[kept]
    return best, values


def views(
    surface: SurfaceSamples, pair: OutlinePoints, body: Mesh, count: int, chunk: int = CHUNK
) -> tuple[np.ndarray, np.ndarray]:
    """Rotations cam_from_world (k, 3, 3) of the `count` pairs of samples with the least energy (6.10), and it (k,).

    `body` is the closed mesh that E_cg, the longest stretch of a view ray inside of it, is taken of.
    """
    middle = (body.vertices.min(axis=0) + body.vertices.max(axis=0)) / 2
    caster = Caster(Mesh((body.vertices - middle) / surface.size, body.faces))
    outside = (surface.points - middle) / surface.size + OFF * surface.normals
    number = len(surface.points)

    def penetration(pairs: np.ndarray) -> np.ndarray:
        both = pairs // number, pairs % number
        _, along = view_directions(surface, pair, *both)
        return PENETRATION * np.sum([caster.deepest(outside[own], along) for own in both], axis=0)

    found, energies = least_sums(pair_costs(surface, pair).ravel(), penetration, count, chunk)
    return rotations_of(surface, pair, found // number, found % number), energies


def rotations_of(surface: SurfaceSamples, pair: OutlinePoints, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Rotations (k, 3, 3) cam_from_world that lay the normals and the base of pairs of samples on the outline's, as
    well as a turn about the direction of view can.
    """
    _, view = view_directions(surface, pair, first, second)
    right = surface.normals[first]
    down = np.cross(view, right)
    bases = surface.points[second] - surface.points[first]
    asked = [*pair.normals, pair.points[1] - pair.points[0]]
    phase = np.zeros(len(first), complex)
    for vectors, flat in zip((right, surface.normals[second], bases), asked, strict=True):
        seen = (vectors * right).sum(axis=1) + 1j * (vectors * down).sum(axis=1)
        phase += (
            np.conj(seen / np.maximum(np.abs(seen), TINY)) * complex(*flat) / max(float(np.linalg.norm(flat)), TINY)
        )
    turn = np.angle(phase)[:, None]
    c, s = np.cos(turn), np.sin(turn)
    return np.stack([c * right - s * down, s * right + c * down, view], axis=1)

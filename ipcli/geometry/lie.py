"""SO(3) and SE(3): log and exp, means, the product metric, the smallest rotation between directions (thesis 2.4 and
5.2).

Rotations are matrices (..., 3, 3), tangent vectors are rotation vectors (..., 3) in radians, twists are (..., 6) =
(omega, v). All functions work on any leading shape at once. SE(3) has no bi-invariant metric: here it carries the
product metric of SO(3) x R^3, whose geodesics are (5.5). A rotation or translation with NaN is one that is not known;
means leave it out.
"""

from __future__ import annotations

import numpy as np

X_AXIS = np.array([1.0, 0.0, 0.0])


def log(rotations: np.ndarray) -> np.ndarray:
    """Rotation vectors (..., 3) of rotations (..., 3, 3), of length at most pi; NaN where a rotation has NaN."""
    return _known_only(_log, rotations, (3, 3), (3,))


def exp(vectors: np.ndarray) -> np.ndarray:
    """Rotations (..., 3, 3) of rotation vectors (..., 3); NaN where a vector has NaN."""
    return _known_only(_exp, vectors, (3,), (3, 3))


def angle(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Geodesic distance (...) in radians between rotations (..., 3, 3), exact for close ones too."""
    return np.linalg.norm(log(np.swapaxes(first, -1, -2) @ second), axis=-1)


def chordal_mean(rotations: np.ndarray) -> np.ndarray:
    """The rotations (..., 3, 3) nearest to the arithmetic means of sets (..., n, 3, 3) in the Frobenius norm.

    Moakher 2002: the projection of the mean onto SO(3). NaN where a set has nothing known.
    """
    known, filled = _split(rotations)
    total = filled.sum(axis=-3)
    u, _, vt = np.linalg.svd(total)
    sign = np.ones(total.shape[:-1])
    sign[..., 2] = np.linalg.det(u @ vt)
    mean = (u * sign[..., None, :]) @ vt
    mean[~known.any(axis=-1)] = np.nan
    return mean


def karcher_mean(rotations: np.ndarray, *, tolerance: float = 1e-12, iterations: int = 200) -> np.ndarray:
    """Means (..., 3, 3) of sets of rotations (..., n, 3, 3) in the bi-invariant metric: where the logarithms sum to
    zero.

    The fixed point R <- R exp(mean log(R^T R_i)) from the chordal mean, until it turns by less than `tolerance`
    radians; only the sets that still turn are iterated. Unique when a set lies in a ball of radius below pi/2 (Karcher
    1977; Manton 2004); of a wider one this is a stationary point, as good as `iterations` steps make it. NaN where a
    set has nothing known.
    """
    known, filled = (part.reshape(-1, *part.shape[rotations.ndim - 3 :]) for part in _split(rotations))
    mean = chordal_mean(rotations).reshape(-1, 3, 3)
    active = np.flatnonzero(known.any(axis=-1))
    share = known / np.maximum(known.sum(axis=-1, keepdims=True), 1)
    for _ in range(iterations):
        if not active.size:
            break
        tangents = log(np.swapaxes(mean[active], -1, -2)[:, None] @ filled[active])
        steps = (share[active][..., None] * np.nan_to_num(tangents)).sum(axis=-2)
        mean[active] = mean[active] @ exp(steps)
        active = active[np.linalg.norm(steps, axis=-1) > tolerance]
    return mean.reshape(*rotations.shape[:-3], 3, 3)


def product_mean(rotations: np.ndarray, translations: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mean (R, d) of sets of rigid motions in the product metric: Karcher mean and arithmetic mean (Algorithm 5.1, line
    1).

    `rotations` (..., n, 3, 3), `translations` (..., n, 3); a motion counts only if both parts are known.
    """
    known = np.isfinite(rotations).all(axis=(-2, -1)) & np.isfinite(translations).all(axis=-1)
    rotations = np.where(known[..., None, None], rotations, np.nan)
    share = known / np.where(known.any(axis=-1, keepdims=True), known.sum(axis=-1, keepdims=True), np.nan)
    return karcher_mean(rotations), (share[..., None] * np.where(known[..., None], translations, 0.0)).sum(axis=-2)


def product_log(
    rotation: np.ndarray, translation: np.ndarray, rotations: np.ndarray, translations: np.ndarray
) -> np.ndarray:
    """Twists (..., 6) = (log(R^T R_i), R^T (d_i - d)) of the geodesics (5.5) from (R, d) to (R_i, d_i), at their start.

    This is the tangent of the product metric at (R, d) in its own frame. Line 3 of Algorithm 5.1 leaves t open, and its
    linear part turns with t; t = 0 is the point where the mean is.
    """
    back = np.swapaxes(rotation, -1, -2)
    return np.concatenate(
        [log(back @ rotations), np.einsum("...ij,...j->...i", back, translations - translation)], axis=-1
    )


def product_exp(rotation: np.ndarray, translation: np.ndarray, twists: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """End (R_i, d_i) at t = 1 of the geodesics (5.5) that leave (R, d) with the twists (..., 6); inverse of
    `product_log`.
    """
    return rotation @ exp(twists[..., :3]), translation + np.einsum("...ij,...j->...i", rotation, twists[..., 3:])


def screw_exp(twists: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Matrix exponential of twists (..., 6): rotations (..., 3, 3) and translations (..., 3) (line 2 of Algorithm 5.2).

    The one-parameter subgroups of SE(3) are screws, not geodesics of the product metric: exp(omega, v) moves by
    V(omega) v, `product_exp` at the identity by v.
    """
    from scipy.spatial.transform import RigidTransform

    flat = np.asarray(twists, np.float64).reshape(-1, 6)
    known = np.isfinite(flat).all(axis=-1)
    matrices = np.full((len(flat), 4, 4), np.nan)
    if known.any():
        matrices[known] = RigidTransform.from_exp_coords(flat[known]).as_matrix()
    shaped = matrices.reshape(*twists.shape[:-1], 4, 4)
    return shaped[..., :3, :3], shaped[..., :3, 3]


def minimal_rotation(directions: np.ndarray) -> np.ndarray:
    """Smallest rotations (..., 3, 3) that carry the x axis onto directions (..., 3) of any length (thesis 5.1).

    I + [w] + [w]^2 / (1 + c) with w = x cross b and c = x . b, which has no square root and no angle. Opposite to x
    there are many: then half a turn about z. NaN for a direction that is zero or unknown.
    """
    directions = np.asarray(directions, np.float64)
    length = np.linalg.norm(directions, axis=-1, keepdims=True)
    with np.errstate(invalid="ignore", divide="ignore"):
        b = np.where(length > 0, directions / length, np.nan)
    return _from_x(b[..., 0], b[..., 1], b[..., 2])


def _from_x(c: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
    """The closed form for unit (c, y, z). 1 / (1 + c) comes from y^2 + z^2 = (1 - c)(1 + c) where 1 + c would lose its
    digits.
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        across = y * y + z * z
        k = np.where(c > 0, 1 / (1 + c), (1 - c) / across)
    opposite = (c < 0) & (across == 0)
    k = np.where(opposite, 0.0, k)
    rows = ((c, -y, -z), (y, 1 - k * y * y, -k * y * z), (z, -k * y * z, 1 - k * z * z))
    rotation = np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
    rotation[opposite] = np.diag([-1.0, -1.0, 1.0])
    return rotation


def hat(vectors: np.ndarray) -> np.ndarray:
    """Skew matrices (..., 3, 3) of vectors (..., 3): hat(a) b = a x b (2.57)."""
    x, y, z = np.moveaxis(np.asarray(vectors, np.float64), -1, 0)
    zero = np.zeros_like(x)
    rows = ((zero, -z, y), (z, zero, -x), (-y, x, zero))
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def vee(matrices: np.ndarray) -> np.ndarray:
    """Vectors (..., 3) of skew matrices (2.59); of any other matrix, those of its skew part."""
    m = np.asarray(matrices, np.float64)
    parts = (m[..., 2, 1] - m[..., 1, 2], m[..., 0, 2] - m[..., 2, 0], m[..., 1, 0] - m[..., 0, 1])
    return 0.5 * np.stack(parts, axis=-1)


def left_jacobian(vectors: np.ndarray) -> np.ndarray:
    """J_l (..., 3, 3) of SO(3): exp(v + dv) = exp(J_l dv) exp(v) to first order. It is V of the screw motion too."""
    a, b = _coefficients(vectors)
    skew = hat(vectors)
    return np.eye(3) + a[..., None, None] * skew + b[..., None, None] * (skew @ skew)


def left_jacobian_inverse(vectors: np.ndarray) -> np.ndarray:
    """Inverse of `left_jacobian`, for angles below 2 pi."""
    angle = np.linalg.norm(np.asarray(vectors, np.float64), axis=-1)
    half = np.where(angle > 1e-4, angle, 1.0) / 2
    c = np.where(angle > 1e-4, (1 - half / np.tan(half)) / (4 * half**2), 1 / 12 + angle**2 / 720)
    skew = hat(vectors)
    return np.eye(3) - 0.5 * skew + c[..., None, None] * (skew @ skew)


def _coefficients(vectors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(1 - cos a) / a^2 and (a - sin a) / a^3, by their series where a is small."""
    angle = np.linalg.norm(np.asarray(vectors, np.float64), axis=-1)
    small = angle < 1e-2
    a = np.where(small, 1.0, angle)
    square = angle**2
    first = np.where(small, 0.5 - square / 24 + square**2 / 720, (1 - np.cos(a)) / a**2)
    second = np.where(small, 1 / 6 - square / 120 + square**2 / 5040, (a - np.sin(a)) / a**3)
    return first, second


def se3_exp(twists: np.ndarray) -> np.ndarray:
    """Rigid motions (..., 4, 4) of twists (..., 6) = (omega, v): the matrix exponential (2.62) in closed form."""
    twists = np.asarray(twists, np.float64)
    motion = np.zeros((*twists.shape[:-1], 4, 4))
    motion[..., :3, :3] = exp(twists[..., :3])
    motion[..., :3, 3] = np.einsum("...ij,...j->...i", left_jacobian(twists[..., :3]), twists[..., 3:])
    motion[..., 3, 3] = 1.0
    return motion


def se3_log(motions: np.ndarray) -> np.ndarray:
    """Twists (..., 6) of rigid motions (..., 4, 4); inverse of `se3_exp` for rotations below pi (2.66)."""
    omega = log(motions[..., :3, :3])
    v = np.einsum("...ij,...j->...i", left_jacobian_inverse(omega), motions[..., :3, 3])
    return np.concatenate([omega, v], axis=-1)


def se3_inverse(motions: np.ndarray) -> np.ndarray:
    """Inverse rigid motions (..., 4, 4), without a solver."""
    back = np.zeros_like(np.asarray(motions, np.float64))
    back[..., :3, :3] = np.swapaxes(motions[..., :3, :3], -1, -2)
    back[..., :3, 3] = -np.einsum("...ji,...j->...i", motions[..., :3, :3], motions[..., :3, 3])
    back[..., 3, 3] = 1.0
    return back


def se3_adjoint(motions: np.ndarray) -> np.ndarray:
    """Ad (..., 6, 6): T exp(xi) T^-1 = exp(Ad xi) for twists (omega, v)."""
    turn = np.asarray(motions, np.float64)[..., :3, :3]
    adjoint = np.zeros((*turn.shape[:-2], 6, 6))
    adjoint[..., :3, :3] = adjoint[..., 3:, 3:] = turn
    adjoint[..., 3:, :3] = hat(motions[..., :3, 3]) @ turn
    return adjoint


def se3_interpolate(first: np.ndarray, second: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Motions (..., 4, 4) along the screw from `first` (share 0) to `second` (share 1)."""
    return first @ se3_exp(np.asarray(share)[..., None] * se3_log(se3_inverse(first) @ second))


def se3_karcher_mean(motions: np.ndarray, *, tolerance: float = 1e-12, iterations: int = 100) -> np.ndarray:
    """The motion (..., 4, 4) where the screw logarithms of a set (..., n, 4, 4) sum to zero.

    The group mean of Pennec and Arsigny (2012), equivariant under motions from both sides, unlike `product_mean`, which
    is what a metric gives. Rotations must lie within a ball of radius below pi/2.
    """
    mean = np.array(motions[..., 0, :, :], np.float64)
    for _ in range(iterations):
        step = se3_log(se3_inverse(mean)[..., None, :, :] @ motions).mean(axis=-2)
        mean = mean @ se3_exp(step)
        if np.abs(step).max(initial=0.0) < tolerance:
            break
    return mean


def sim3_exp(twists: np.ndarray) -> np.ndarray:
    """Similarities (..., 4, 4) of (omega, v, sigma) (..., 7), the scale being exp(sigma)."""
    return _expm(_sim3_algebra(np.asarray(twists, np.float64)))


def sim3_log(similarities: np.ndarray) -> np.ndarray:
    """(omega, v, sigma) (..., 7) of similarities (..., 4, 4); inverse of `sim3_exp` for rotations below pi."""
    m = np.asarray(similarities, np.float64)
    sigma = np.log(np.linalg.det(m[..., :3, :3])) / 3
    omega = log(m[..., :3, :3] / np.exp(sigma)[..., None, None])
    algebra = sigma[..., None, None] * np.eye(3) + hat(omega)
    v = np.linalg.solve(_phi(algebra), m[..., :3, 3, None])[..., 0]
    return np.concatenate([omega, v, sigma[..., None]], axis=-1)


def _sim3_algebra(twists: np.ndarray) -> np.ndarray:
    algebra = np.zeros((*twists.shape[:-1], 4, 4))
    algebra[..., :3, :3] = hat(twists[..., :3]) + twists[..., 6, None, None] * np.eye(3)
    algebra[..., :3, 3] = twists[..., 3:6]
    return algebra


def _phi(algebra: np.ndarray) -> np.ndarray:
    """The integral of exp(s A) over s from 0 to 1, read off the exponential of [A I; 0 0]."""
    doubled = np.zeros((*algebra.shape[:-2], 6, 6))
    doubled[..., :3, :3], doubled[..., :3, 3:] = algebra, np.eye(3)
    return _expm(doubled)[..., :3, 3:]


def affine_exp(algebra: np.ndarray) -> np.ndarray:
    """Affine maps (..., n + 1, n + 1) of their algebra: any matrix whose last row is zero."""
    return _expm(np.asarray(algebra, np.float64))


def affine_log(maps: np.ndarray) -> np.ndarray:
    """Inverse of `affine_exp`: the principal logarithm. NaN for maps that have none that is real (negative
    eigenvalues).
    """
    from scipy.linalg import logm

    maps = np.asarray(maps, np.float64)
    flat = maps.reshape(-1, *maps.shape[-2:])
    logs = np.full(flat.shape, np.nan)
    for index, matrix in enumerate(flat):
        values = np.linalg.eigvals(matrix) if np.isfinite(matrix).all() else np.array([-1.0])
        if not ((np.abs(values.imag) < 1e-12) & (values.real <= 0)).any():
            logs[index] = np.real(logm(matrix))
    return logs.reshape(maps.shape)


def _expm(matrices: np.ndarray) -> np.ndarray:
    from scipy.linalg import expm

    return expm(matrices)


def _log(rotations: np.ndarray) -> np.ndarray:
    from scipy.spatial.transform import Rotation

    return Rotation.from_matrix(rotations, assume_valid=True).as_rotvec()


def _exp(vectors: np.ndarray) -> np.ndarray:
    from scipy.spatial.transform import Rotation

    return Rotation.from_rotvec(vectors).as_matrix()


def _known_only(function, values: np.ndarray, inner: tuple[int, ...], outer: tuple[int, ...]) -> np.ndarray:
    """`function` of the finite items among values (..., *inner), as (..., *outer) with NaN for the others."""
    values = np.asarray(values, np.float64)
    flat = values.reshape(-1, *inner)
    known = np.isfinite(flat).all(axis=tuple(range(1, flat.ndim)))
    if known.all() and len(flat):
        result = function(flat)
    else:
        result = np.full((len(flat), *outer), np.nan)
        if known.any():
            result[known] = function(flat[known])
    return result.reshape(*values.shape[: values.ndim - len(inner)], *outer)


def _split(rotations: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Which rotations of the sets (..., n, 3, 3) are known, and all with 0 in place of the others."""
    rotations = np.asarray(rotations, np.float64)
    known = np.isfinite(rotations).all(axis=(-2, -1))
    return known, np.where(known[..., None, None], rotations, 0.0)

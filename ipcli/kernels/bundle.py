"""Normal equations of bundle adjustment over a rig of fixed cameras, points eliminated (Schur complement).

Observations are sorted by point and, within a point, by frame. A frame's unknowns are a twist (omega, v) on the left of
its pose, rig_from_world <- exp(twist) rig_from_world. One more unknown, the last, moves the principal point of camera 1
along x. Single threaded: the same numbers give the same bits.
"""

from __future__ import annotations

import numpy as np
from numba import njit

NEAREST = 1e-6  # depth below which an observation is taken to be behind its camera


@njit(cache=True, nogil=True)
def _predict(rotation, translation, cam_rotation, cam_translation, intrinsics, point, in_rig, in_cam):
    """The point in the rig's and in the camera's frame; pixel coordinates, NaN behind the camera."""
    for a in range(3):
        in_rig[a] = translation[a]
        for b in range(3):
            in_rig[a] += rotation[a, b] * point[b]
    for a in range(3):
        in_cam[a] = cam_translation[a]
        for b in range(3):
            in_cam[a] += cam_rotation[a, b] * in_rig[b]
    if in_cam[2] <= NEAREST:
        return np.nan, np.nan
    u = intrinsics[0] * in_cam[0] / in_cam[2] + intrinsics[2]
    v = intrinsics[1] * in_cam[1] / in_cam[2] + intrinsics[3]
    return u, v


@njit(cache=True, nogil=True)
def residuals(rotations, translations, cam_rotations, cam_translations, intrinsics, offset, points, seen, pixels):
    """Predicted minus measured pixels (m, 2); NaN where a point is behind the camera. `seen` (m, 3): frame, camera,
    point.
    """
    out = np.empty((len(seen), 2))
    in_rig, in_cam = np.empty(3), np.empty(3)
    for i in range(len(seen)):
        f, c, p = seen[i]
        u, v = _predict(
            rotations[f], translations[f], cam_rotations[c], cam_translations[c], intrinsics[c], points[p], in_rig,
            in_cam,
        )  # fmt: skip
        out[i, 0] = u + (offset if c == 1 else 0.0) - pixels[i, 0]
        out[i, 1] = v - pixels[i, 1]
    return out


@njit(cache=True, nogil=True)
def _jacobians(rotation, cam_rotation, intrinsics, in_rig, in_cam, scale, by_point, by_frame):
    """Derivatives of the scaled residual by the point (2, 3) and by the twist of the frame (2, 6)."""
    z = in_cam[2]
    for row in range(2):
        focal = intrinsics[row] * scale / z
        for b in range(3):  # by the point in the rig's frame
            by_frame[row, 3 + b] = focal * (cam_rotation[row, b] - in_cam[row] / z * cam_rotation[2, b])
        g0, g1, g2 = by_frame[row, 3], by_frame[row, 4], by_frame[row, 5]
        by_frame[row, 0] = in_rig[1] * g2 - in_rig[2] * g1  # x cross g
        by_frame[row, 1] = in_rig[2] * g0 - in_rig[0] * g2
        by_frame[row, 2] = in_rig[0] * g1 - in_rig[1] * g0
        for b in range(3):
            by_point[row, b] = g0 * rotation[0, b] + g1 * rotation[1, b] + g2 * rotation[2, b]


@njit(cache=True, nogil=True)
def _inverse3(a, out):
    """Inverse of a symmetric positive definite 3 x 3 matrix; False when it is singular."""
    c00 = a[1, 1] * a[2, 2] - a[1, 2] * a[1, 2]
    c01 = a[0, 2] * a[1, 2] - a[0, 1] * a[2, 2]
    c02 = a[0, 1] * a[1, 2] - a[0, 2] * a[1, 1]
    det = a[0, 0] * c00 + a[0, 1] * c01 + a[0, 2] * c02
    if not det > 0.0:
        return False
    out[0, 0], out[0, 1], out[0, 2] = c00 / det, c01 / det, c02 / det
    out[1, 1] = (a[0, 0] * a[2, 2] - a[0, 2] * a[0, 2]) / det
    out[1, 2] = (a[0, 1] * a[0, 2] - a[0, 0] * a[1, 2]) / det
    out[2, 2] = (a[0, 0] * a[1, 1] - a[0, 1] * a[0, 1]) / det
    out[1, 0], out[2, 0], out[2, 1] = out[0, 1], out[0, 2], out[1, 2]
    return True


@njit(cache=True, nogil=True)
def _add_frame(matrix, vector, block, column, weight, by_point, by_frame, error):
    """One observation's share of its frame's gradient, Hessian block and cross block (6, 3)."""
    for row in range(2):
        for a in range(6):
            vector[6 * column + a] -= weight * by_frame[row, a] * error[row]
            for b in range(a, 6):
                matrix[6 * column + a, 6 * column + b] += weight * by_frame[row, a] * by_frame[row, b]
            for b in range(3):
                block[a, b] += weight * by_frame[row, a] * by_point[row, b]


@njit(cache=True, nogil=True)
def _add_offset(matrix, vector, by_offset, column, weight, scale, by_point, by_frame, error):
    """The same of the offset, which moves u of camera 1 alone."""
    last = len(vector) - 1
    vector[last] -= weight * scale * error[0]
    matrix[last, last] += weight * scale * scale
    for b in range(3):
        by_offset[b] += weight * scale * by_point[0, b]
    if column >= 0:
        for a in range(6):
            matrix[6 * column + a, last] += weight * scale * by_frame[0, a]


@njit(cache=True, nogil=True)
def _eliminate(matrix, vector, inverse, gradient, blocks, block_columns, by_offset, with_offset, product):
    """Take one point out of the system: subtract W V^-1 W^T for all pairs of its frames, and for the offset."""
    last = len(vector) - 1
    for i in range(len(blocks)):
        column = block_columns[i]
        if column < 0:
            continue
        for a in range(6):
            for b in range(3):
                product[a, b] = 0.0
                for c in range(3):
                    product[a, b] += blocks[i, a, c] * inverse[c, b]
        for a in range(6):
            for b in range(3):
                vector[6 * column + a] -= product[a, b] * gradient[b]
                if with_offset:
                    matrix[6 * column + a, last] -= product[a, b] * by_offset[b]
        for j in range(len(blocks)):
            other = block_columns[j]
            if other < column:
                continue
            for a in range(6):
                for b in range(6):
                    matrix[6 * column + a, 6 * other + b] -= (
                        product[a, 0] * blocks[j, b, 0]
                        + product[a, 1] * blocks[j, b, 1]
                        + product[a, 2] * blocks[j, b, 2]
                    )
    if with_offset:
        for a in range(3):
            for b in range(3):
                share = by_offset[a] * inverse[a, b]
                vector[last] -= share * gradient[b]
                matrix[last, last] -= share * by_offset[b]


@njit(cache=True, nogil=True)
def reduced_system(
    rotations, translations, cam_rotations, cam_translations, intrinsics, offset, points, seen, pixels, scales, starts,
    columns, loss, damping, with_offset, matrix, vector, point_inverse, point_gradient, blocks, block_columns,
    by_offset,
):  # fmt: skip
    """Fill the reduced system `matrix` x = `vector` of frames (6 each, by `columns`; -1: held fixed) and offset.

    `starts` (p + 1): where each point's observations begin. `scales` (m): 1 / sigma in pixels. `loss`: Cauchy scale in
    sigmas. `damping` multiplies the diagonals (Levenberg-Marquardt). Only the upper triangle is filled. Kept for
    `back_substitute`: the inverse Hessian of each point, its gradient, and per observation the cross block (6, 3) of
    its frame (in the first observation of a frame; column -1 elsewhere). Returns the robust cost.
    """
    cost = 0.0
    in_rig, in_cam, error = np.empty(3), np.empty(3), np.empty(2)
    by_point, by_frame = np.empty((2, 3)), np.empty((2, 6))
    hessian, product = np.empty((3, 3)), np.empty((6, 3))
    for p in range(len(points)):
        hessian[:] = 0.0
        point_gradient[p] = 0.0
        by_offset[p] = 0.0
        first = starts[p]
        for i in range(starts[p], starts[p + 1]):
            f, c = seen[i, 0], seen[i, 1]
            blocks[i] = 0.0
            block_columns[i] = -1
            if i == starts[p] or seen[i - 1, 0] != f:
                first = i
                block_columns[i] = columns[f]
            u, v = _predict(
                rotations[f], translations[f], cam_rotations[c], cam_translations[c], intrinsics[c], points[p], in_rig,
                in_cam,
            )  # fmt: skip
            if np.isnan(u):
                continue
            error[0] = (u + (offset if c == 1 else 0.0) - pixels[i, 0]) * scales[i]
            error[1] = (v - pixels[i, 1]) * scales[i]
            square = (error[0] ** 2 + error[1] ** 2) / (loss * loss)
            cost += 0.5 * loss * loss * np.log1p(square)
            weight = 1.0 / (1.0 + square)
            _jacobians(rotations[f], cam_rotations[c], intrinsics[c], in_rig, in_cam, scales[i], by_point, by_frame)
            for row in range(2):
                for a in range(3):
                    point_gradient[p, a] -= weight * by_point[row, a] * error[row]
                    for b in range(3):
                        hessian[a, b] += weight * by_point[row, a] * by_point[row, b]
            if columns[f] >= 0:
                _add_frame(matrix, vector, blocks[first], columns[f], weight, by_point, by_frame, error)
            if with_offset and c == 1:
                _add_offset(matrix, vector, by_offset[p], columns[f], weight, scales[i], by_point, by_frame, error)
        for a in range(3):
            hessian[a, a] *= 1.0 + damping
        if not _inverse3(hessian, point_inverse[p]):
            point_inverse[p] = 0.0
    for k in range(len(vector)):
        matrix[k, k] *= 1.0 + damping
    for p in range(len(points)):
        part = slice(starts[p], starts[p + 1])
        _eliminate(
            matrix, vector, point_inverse[p], point_gradient[p], blocks[part], block_columns[part], by_offset[p],
            with_offset, product,
        )  # fmt: skip
    return cost


@njit(cache=True, nogil=True)
def back_substitute(solution, starts, point_inverse, point_gradient, blocks, block_columns, by_offset, with_offset):
    """Steps (p, 3) of the points, given those of the frames and the offset."""
    steps = np.empty_like(point_gradient)
    rest = np.empty(3)
    for p in range(len(point_gradient)):
        for b in range(3):
            rest[b] = point_gradient[p, b]
            if with_offset:
                rest[b] -= by_offset[p, b] * solution[-1]
        for i in range(starts[p], starts[p + 1]):
            column = block_columns[i]
            if column >= 0:
                for b in range(3):
                    for a in range(6):
                        rest[b] -= blocks[i, a, b] * solution[6 * column + a]
        for a in range(3):
            steps[p, a] = (
                point_inverse[p, a, 0] * rest[0] + point_inverse[p, a, 1] * rest[1] + point_inverse[p, a, 2] * rest[2]
            )
    return steps

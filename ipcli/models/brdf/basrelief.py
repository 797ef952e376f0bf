"""The bas-relief of 7.5 by finite elements: a plate that bends and stretches, drawn to given normals (7.3), (7.4).

With x = u and y = v the constraint n . w_u = n . w_v = 0 reads n_z z_u = -n_x, n_z z_v = -n_y: linear in the degrees
of freedom of the Bogner-Fox-Schmit element, which has z, z_u, z_v and z_uv at each node and is C1, unlike the element
of nine of the thesis. Minimised is

    1/2 U' K U + 1/2 (D U - C)' G (D U - C),     K = membrane * (S x M + M x S) + plate * (B x M + 2 S x S + M x B)

on elements of one pixel; the thesis lacks the factor 1/2 and has C = 0, for which any constant is a solution. Edges
are free. The external force q is left out: the constraint alone gives the relief.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ipcli.models.brdf.energy import factor
from ipcli.models.brdf.parameters import Plate

DOFS = 4  # z, z_u, z_v, z_uv


def line_matrices(h: float = 1.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Mass, stiffness and bending (4, 4) of a cubic Hermite element of length h; order: value, slope at 0, then at
    h.
    """
    mass = np.array(
        [
            [156, 22 * h, 54, -13 * h],
            [22 * h, 4 * h * h, 13 * h, -3 * h * h],
            [54, 13 * h, 156, -22 * h],
            [-13 * h, -3 * h * h, -22 * h, 4 * h * h],
        ]
    )
    stiff = np.array(
        [
            [36, 3 * h, -36, 3 * h],
            [3 * h, 4 * h * h, -3 * h, -h * h],
            [-36, -3 * h, 36, -3 * h],
            [3 * h, -h * h, -3 * h, 4 * h * h],
        ]
    )
    bend = np.array(
        [
            [12, 6 * h, -12, 6 * h],
            [6 * h, 4 * h * h, -6 * h, 2 * h * h],
            [-12, -6 * h, 12, -6 * h],
            [6 * h, 2 * h * h, -6 * h, 4 * h * h],
        ]
    )
    return mass * h / 420, stiff / (30 * h), bend / h**3


def stiffness(mask: np.ndarray, membrane: float, plate: float) -> Any:
    """K (4 n, 4 n) sparse over the n pixels of a mask: elements are its 2 x 2 cells; dof d of pixel i is 4 i + d, v
    up.
    """
    from scipy.sparse import coo_matrix

    m, s, b = line_matrices()
    # np.kron(along v, along u): entry (4 a + b) is node and derivative a along v, b along u
    element = membrane * (np.kron(m, s) + np.kron(s, m)) + plate * (np.kron(m, b) + 2 * np.kron(s, s) + np.kron(b, m))
    dofs = _element_dofs(mask)
    rows, columns = np.repeat(dofs, 16, axis=1), np.tile(dofs, (1, 16))
    data = np.broadcast_to(element.ravel(), (len(dofs), 256))
    size = DOFS * int(mask.sum())
    return coo_matrix((data.ravel(), (rows.ravel(), columns.ravel())), shape=(size, size)).tocsr()


def _element_dofs(mask: np.ndarray) -> np.ndarray:
    """Global dof (e, 16) of each local one, (node and derivative along v) x (node and derivative along u)."""
    number = np.full(mask.shape, -1)
    number[mask] = np.arange(mask.sum())
    upper = number[:-1, :-1], number[:-1, 1:]
    lower = number[1:, :-1], number[1:, 1:]
    whole = np.stack([*upper, *lower]).min(axis=0) >= 0
    nodes = {(0, 0): lower[0], (0, 1): lower[1], (1, 0): upper[0], (1, 1): upper[1]}  # (along v, along u)
    columns = []
    for a in range(4):
        for b in range(4):
            (node_v, d_v), (node_u, d_u) = divmod(a, 2), divmod(b, 2)
            columns.append(DOFS * nodes[node_v, node_u][whole] + d_u + 2 * d_v)
    return np.stack(columns, axis=-1)


def bas_relief(
    normals: np.ndarray, mask: np.ndarray, params: Plate, confidence: np.ndarray | None = None
) -> np.ndarray:
    """Height (h, w) of mean 0 of the plate drawn to unit normals (h, w, 3) with weights (h, w); NaN outside the mask.

    Where a normal is not known its weight is 0, and the plate bridges the gap.
    """
    from scipy.sparse import diags, identity

    n = normals[mask]
    known = np.isfinite(n).all(axis=1)
    n = np.where(known[:, None], n, [0, 0, 1.0])
    gamma = params.constraint * known * (1.0 if confidence is None else np.nan_to_num(confidence[mask]))
    weight, pull = np.zeros((len(n), DOFS)), np.zeros((len(n), DOFS))
    for dof, axis in ((1, 0), (2, 1)):  # z_u from n_x, z_v from n_y
        weight[:, dof] = gamma * n[:, 2] ** 2
        pull[:, dof] = -gamma * n[:, 2] * n[:, axis]
    k = stiffness(mask, params.membrane, params.plate)
    system = k + diags(weight.ravel()) + 1e-9 * identity(k.shape[0])
    z = factor(system).solve(pull.ravel())[::DOFS]
    return np.where(mask, _placed(z - z.mean(), mask), np.nan)


def _placed(values: np.ndarray, mask: np.ndarray) -> np.ndarray:
    image = np.zeros(mask.shape)
    image[mask] = values
    return image

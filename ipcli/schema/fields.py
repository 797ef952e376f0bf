"""What a kind of artefact is made of: fields with dtype, symbolic dims, units, meaning, and the values they
may take.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ipcli.errors import IpcliError, nearest

ITEM = r"(?P<item>[^/.][^/]*)"


class SchemaError(IpcliError):
    """Arrays that do not make up an artefact of their kind."""


class Domain(NamedTuple):
    """Finite values above `low` (or from it, when `closed`), and NaN if `nan`."""

    text: str
    low: float = -np.inf
    closed: bool = True
    nan: bool = False

    def holds(self, values: np.ndarray) -> np.ndarray:
        above = values >= self.low if self.closed else values > self.low
        inside = above & np.isfinite(values)
        return inside | np.isnan(values) if self.nan else inside


FINITE = Domain("finite")
DISTANCE = Domain("> 0, or NaN where unknown", 0.0, closed=False, nan=True)
WEIGHT = Domain("finite, >= 0", 0.0)


class Form(NamedTuple):
    """What values are only as a whole; `holds` says it for each value of an array."""

    text: str
    holds: Callable[[np.ndarray], np.ndarray]


def _matrices(are_so: Callable[[np.ndarray], np.ndarray], nan: bool = False) -> Callable[[np.ndarray], np.ndarray]:
    """`are_so` of matrices (m, n, n), for each value of arrays (..., n, n); those of NaN alone are so if `nan`."""

    def holds(values: np.ndarray) -> np.ndarray:
        matrices = values.reshape(-1, *values.shape[-2:])
        with np.errstate(all="ignore"):
            sound = are_so(matrices) | (nan & np.isnan(matrices).all(axis=(1, 2)))
        return np.broadcast_to(sound.reshape(*values.shape[:-2], 1, 1), values.shape)

    return holds


def _are_rotations(matrices: np.ndarray) -> np.ndarray:
    product = np.swapaxes(matrices, 1, 2) @ matrices
    return (np.abs(product - np.eye(3)) <= RIGID_TOLERANCE).all(axis=(1, 2)) & (np.linalg.det(matrices) > 0)


def _are_poses(matrices: np.ndarray) -> np.ndarray:
    last = np.isclose(matrices[:, 3], (0, 0, 0, 1)).all(axis=1)
    return _are_rotations(matrices[:, :3, :3]) & last & np.isfinite(matrices).all(axis=(1, 2))


def _are_cameras(matrices: np.ndarray) -> np.ndarray:
    below = np.isclose(matrices[:, [1, 2, 2, 2], [0, 0, 1, 2]], (0, 0, 0, 1)).all(axis=1)
    focal = (matrices[:, 0, 0] > 0) & (matrices[:, 1, 1] > 0)
    return below & focal & np.isfinite(matrices).all(axis=(1, 2))


def _ascend(values: np.ndarray) -> np.ndarray:
    return np.isfinite(values) & (np.diff(values, prepend=-np.inf) > 0)


RIGID_TOLERANCE = 1e-3  # of each value of R^T R
ROTATION = Form("a rotation", _matrices(_are_rotations))
POSE = Form("a rigid pose", _matrices(_are_poses))
KNOWN_POSE = Form("a rigid pose, or NaN where unknown", _matrices(_are_poses, nan=True))
CAMERA = Form("[fx s cx; 0 fy cy; 0 0 1], fx, fy > 0", _matrices(_are_cameras))
ASCENDING = Form("finite, each larger than the one before", _ascend)


class Ref(NamedTuple):
    """What the values of a field refer to: whole numbers are indices of the first axis of dataset `to` (its item where
    the name holds a "*"), from `base` on; texts are texts that stand in it.

    `none`: the number before the first index, or an empty text, refers to nothing. `end`: the index after the last is
    allowed too, as the end of a span. `also`: texts that need not stand there.
    """

    to: str
    none: bool = False
    base: int = 0
    end: bool = False
    also: tuple[str, ...] = ()

    def holds(self, values: np.ndarray, target: np.ndarray) -> np.ndarray:
        """Which values (any shape) refer to something in the target, or are allowed to refer to nothing."""
        if values.dtype.kind == "U":
            known = [*target.ravel().tolist(), *self.also, *([""] if self.none else [])]
            return np.isin(values, np.array(known, np.str_))
        wide = values.astype(np.int64)
        return (wide >= self.base - self.none) & (wide < self.base + len(target) + self.end)

    @property
    def text(self) -> str:
        """The rule in words."""
        also = f", or one of {', '.join(self.also)}" if self.also else ""
        more = [
            *(["-1 none" if self.base == 0 else "0 none"] if self.none else []),
            *(["or its end"] if self.end else []),
        ]
        return f"refers to `{self.to}`{also}" + (f" ({', '.join(more)})" if more else "")


@dataclass(frozen=True)
class Field:
    """One dataset. `name` may hold one "*" for the item of a collection; dtype "str" is Unicode text of any length."""

    name: str
    dtype: str
    dims: tuple[str | int, ...]
    units: str
    doc: str
    optional: bool = False
    domain: Domain | Form | None = None
    choices: tuple[str, ...] = ()
    refers: Ref | tuple[Ref, ...] | None = None  # of all values, or of each column of the last axis

    def match(self, name: str) -> str | None:
        """The item that `name` belongs to ("" outside a collection), or None when it is not of this field."""
        found = re.fullmatch(re.escape(self.name).replace(r"\*", ITEM), name)
        return None if found is None else found.groupdict().get("item", "")


@dataclass(frozen=True)
class Kind:
    """A registered layout. `version` grows whenever a reader of the old one would be misled.

    Of optional fields that say something only as a whole, `together` lists each group of which a file holds all or
    none, and `needs` each pair of which the first makes no sense without the second. What refers to a field needs it.
    """

    name: str
    version: int
    doc: str
    fields: tuple[Field, ...]
    together: tuple[tuple[str, ...], ...] = ()
    needs: tuple[tuple[str, str], ...] = ()

    def required(self, present: Collection[str]) -> Iterator[tuple[str, str]]:
        """(a field that the `present` ones of one item ask for, the one that asks)."""
        for group in self.together:
            asking = next((name for name in group if name in present), None)
            yield from ((name, asking) for name in group if asking is not None)
        yield from ((needed, name) for name, needed in self.needs if name in present)
        for field in self.fields:
            refs = [field.refers] if isinstance(field.refers, Ref) else [*(field.refers or ())]
            yield from ((ref.to, field.name) for ref in refs if field.name in present)

    def field(self, name: str) -> tuple[Field, str]:
        """The field that describes dataset `name`, and its item; SchemaError if there is none."""
        for field in self.fields:
            item = field.match(name)
            if item is not None:
                return field, item
        raise SchemaError(f"{name}: not a field of '{self.name}'{nearest(name, (f.name for f in self.fields))}")

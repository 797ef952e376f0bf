"""What a kind of artefact is made of: fields with dtype, symbolic dims, units, meaning, and the values they
may take.
"""

from __future__ import annotations

import re
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


@dataclass(frozen=True)
class Field:
    """One dataset. `name` may hold one "*" for the item of a collection; dtype "str" is Unicode text of any length."""

    name: str
    dtype: str
    dims: tuple[str | int, ...]
    units: str
    doc: str
    optional: bool = False
    domain: Domain | None = None
    choices: tuple[str, ...] = ()

    def match(self, name: str) -> str | None:
        """The item that `name` belongs to ("" outside a collection), or None when it is not of this field."""
        found = re.fullmatch(re.escape(self.name).replace(r"\*", ITEM), name)
        return None if found is None else found.groupdict().get("item", "")


@dataclass(frozen=True)
class Kind:
    """A registered layout. `version` grows whenever a reader of the old one would be misled."""

    name: str
    version: int
    doc: str
    fields: tuple[Field, ...]

    def field(self, name: str) -> tuple[Field, str]:
        """The field that describes dataset `name`, and its item; SchemaError if there is none."""
        for field in self.fields:
            item = field.match(name)
            if item is not None:
                return field, item
        raise SchemaError(f"{name}: not a field of '{self.name}'{nearest(name, (f.name for f in self.fields))}")

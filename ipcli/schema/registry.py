"""All kinds of HDF5 artefacts by name, and what it takes to be one of a kind.

A symbol in `dims` (h, w, k) must stand for one length throughout an artefact; in a field of a collection
("views/*/depth") it is bound anew for each item. `Ref` says where the indices or names of a field have to be, `Domain`
which values a number may take, `Kind.together` and `Kind.needs` which optional fields go with which. docs/formats.md is
`markdown()`.

Each module of this folder with a tuple `KINDS` is a chapter; it is found by being there.
"""

from __future__ import annotations

import pkgutil
from collections.abc import Iterable, Mapping
from importlib import import_module

import numpy as np

from ipcli.errors import nearest
from ipcli.schema.fields import Field, Kind, Ref, SchemaError

GENERAL = ("fields", "registry")  # modules of this folder that are no chapters


def _found() -> dict[str, tuple[Kind, ...]]:
    folder = [str(path) for path in import_module("ipcli.schema").__path__]
    names = sorted(module.name for module in pkgutil.iter_modules(folder) if module.name not in GENERAL)
    return {name: import_module(f"ipcli.schema.{name}").KINDS for name in names}


CHAPTERS: dict[str, tuple[Kind, ...]] = _found()
KINDS: dict[str, Kind] = {kind.name: kind for kinds in CHAPTERS.values() for kind in kinds}


def chapter(name: str) -> str:
    """The chapter that a registered kind belongs to."""
    return next(chapter for chapter, kinds in CHAPTERS.items() if any(kind.name == name for kind in kinds))


def kind(name: str) -> Kind:
    """The registered kind, or SchemaError with the nearest name."""
    if name not in KINDS:
        raise SchemaError(f"unknown kind of artefact '{name}'{nearest(name, KINDS)}")
    return KINDS[name]


def validate(kind: Kind, arrays: Mapping[str, np.ndarray]) -> None:
    """Raise SchemaError unless `arrays` is a whole, consistent artefact of this kind."""
    check_names(kind, arrays)
    check_arrays(kind, arrays)


def check_names(kind: Kind, names: Iterable[str]) -> None:
    """Nothing unknown, nothing missing; every item of a collection has all that an item needs, and what goes together
    is there as a whole.
    """
    found: dict[str, set[str]] = {"": set()}
    for name in names:
        field, item = kind.field(name)
        found.setdefault(item, set()).add(field.name)
    for item, present in found.items():
        for field in kind.fields:
            if bool(item) == ("*" in field.name) and not field.optional and field.name not in present:
                raise SchemaError(f"{field.name.replace('*', item)}: missing from '{kind.name}'")
        for needed, name in kind.required(present):
            if needed not in (present if "*" in needed else found[""]):
                needed, name = needed.replace("*", item), name.replace("*", item)
                raise SchemaError(f"{needed}: missing, and {name} makes no sense without it")


def check_arrays(kind: Kind, arrays: Mapping[str, np.ndarray]) -> None:
    """Dtype, shape and values of each array given, and the lengths they share; some may be left out."""
    bound: dict[tuple[str, str], tuple[int, str]] = {}
    for name, array in arrays.items():
        field, item = kind.field(name)
        _check_dtype(name, field, array)
        _check_shape(name, field, array.shape, item, bound)
        _check_values(name, field, array)
    for name, array in arrays.items():
        field, item = kind.field(name)
        _check_references(name, field, item, array, arrays)


def _check_references(name: str, field: Field, item: str, array: np.ndarray, arrays: Mapping[str, np.ndarray]) -> None:
    """Each value refers to something that is there, in datasets that are given."""
    if field.refers is None:
        return
    columns = [array] if isinstance(field.refers, Ref) else [array[..., n] for n in range(len(field.refers))]
    refs = [field.refers] if isinstance(field.refers, Ref) else field.refers
    for ref, values in zip(refs, columns, strict=True):
        target = ref.to.replace("*", item)
        if target in arrays and not (right := ref.holds(values, arrays[target])).all():
            got = values[~right].ravel()[0]
            raise SchemaError(f"{name}: refers to what is not in {target} (got {got!s}, {len(arrays[target])} there)")


def _check_dtype(name: str, field: Field, array: np.ndarray) -> None:
    got = getattr(array, "dtype", None)
    right = got is not None and (got.kind == "U" if field.dtype == "str" else got == np.dtype(field.dtype))
    if not right:
        raise SchemaError(f"{name}: wrong dtype (expected {field.dtype}, got {got or type(array).__name__})")


def _check_shape(name: str, field: Field, got: tuple[int, ...], item: str, bound: dict) -> None:
    if len(got) != len(field.dims):
        raise SchemaError(f"{name}: wrong shape (expected {_dims(field)}, got {got})")
    for dim, length in zip(field.dims, got, strict=True):
        want, where = (dim, "the schema") if isinstance(dim, int) else bound.setdefault((item, dim), (length, name))
        if want != length:
            raise SchemaError(
                f"{name}: wrong shape (expected {_dims(field)} with {dim} = {want} as in {where}, got {got})"
            )


def _check_values(name: str, field: Field, array: np.ndarray) -> None:
    if field.domain is not None:
        outside = ~field.domain.holds(array)
        if outside.any():
            first = tuple(int(index) for index in np.argwhere(outside)[0])
            got = f"{array[first]} at {first}, {int(outside.sum())} of {array.size} in all"
            raise SchemaError(f"{name}: value not allowed (expected {field.domain.text}, got {got})")
    for text in array.flat if field.dtype == "str" else ():
        if "\0" in text or not _encodes(text):
            raise SchemaError(f"{name}: text {text!r} holds characters that UTF-8 files cannot")
        if field.choices and text not in field.choices:
            raise SchemaError(f"{name}: value not allowed (expected one of {', '.join(field.choices)}, got '{text}')")


def _encodes(text: str) -> bool:
    try:
        text.encode("utf-8")
    except UnicodeEncodeError:
        return False
    return True


def _dims(field: Field) -> str:
    return f"({', '.join(map(str, field.dims))}{',' if len(field.dims) == 1 else ''})"


def markdown() -> str:
    """The whole of docs/formats.md."""
    lines = [
        "# Formats of the artefacts",
        "",
        "Generated from `ipcli/schema/` by `python tools/make_formats.py`; do not edit by hand.",
        "",
        "Every artefact is an HDF5 file with the root attributes `ipcli_kind`, `ipcli_version` (integer), "
        "`provenance` (JSON) and `ipcli_complete` = 1. Each dataset carries `units`, `dims`, `description` and "
        "`crc32` (of its bytes in C order; of text, of its UTF-8 strings each followed by a zero byte). A file of a "
        "newer version, with unknown datasets, or with a dataset that breaks a rule below is refused. A letter in a "
        "shape stands for the same length throughout (within one item where the name holds a `*`). Text is UTF-8 of "
        "fixed length, padded with zeros. `cam_from_world` maps world points to camera points; cameras look along +z, "
        "x right, y down.",
    ]
    for kind in KINDS.values():
        lines += ["", f"## `{kind.name}`, version {kind.version}", "", kind.doc, ""]
        lines += ["| dataset | dtype | shape | units | meaning |", "|---|---|---|---|---|"]
        lines += [_row(field) for field in kind.fields]
        lines += ["", *_going_together(kind)] if kind.together or kind.needs else []
    return "\n".join(lines) + "\n"


def _going_together(kind: Kind) -> list[str]:
    """In words which optional fields ask for others."""
    groups = [f"- all or none of {', '.join(f'`{name}`' for name in group)}" for group in kind.together]
    return ["Optional fields that go together:", "", *groups, *(f"- `{a}` only with `{b}`" for a, b in kind.needs)]


def _row(field: Field) -> str:
    rules = [field.domain.text] if field.domain else []
    rules += [f"one of {', '.join(field.choices)}"] if field.choices else []
    refs = [field.refers] if isinstance(field.refers, Ref) else [*(field.refers or ())]
    rules += [", ".join(ref.text for ref in refs)] if refs else []
    rules += ["optional"] if field.optional else []
    meaning = field.doc + (f" ({'; '.join(rules)})" if rules else "")
    return (
        f"| `{field.name}` | {field.dtype} | {_dims(field)} | {field.units or '-'} | "
        f"{meaning.replace('|', chr(92) + '|')} |"
    )

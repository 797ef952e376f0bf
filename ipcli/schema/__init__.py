"""Every kind of HDF5 artefact: its fields with dtype, symbolic dims, units and meaning. Checked when written and when
read.

A symbol in `dims` (h, w, k) must stand for one length throughout an artefact; in a field of a collection
("views/*/depth") it is bound anew for each item. `Domain` says which values a number may take. docs/formats.md is
`markdown()`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from ipcli.errors import nearest
from ipcli.schema.fields import DISTANCE, FINITE, WEIGHT, Domain, Field, Kind, SchemaError
from ipcli.schema.mocap import BEHAVIOURS, CLIPS, EVALUATION, RECOGNITION


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
    """Nothing unknown, nothing missing; every item of a collection has all that an item needs."""
    found: dict[str, set[str]] = {"": set()}
    for name in names:
        field, item = kind.field(name)
        found.setdefault(item, set()).add(field.name)
    for item, present in found.items():
        for field in kind.fields:
            if bool(item) == ("*" in field.name) and not field.optional and field.name not in present:
                raise SchemaError(f"{field.name.replace('*', item)}: missing from '{kind.name}'")


def check_arrays(kind: Kind, arrays: Mapping[str, np.ndarray]) -> None:
    """Dtype, shape and values of each array given, and the lengths they share; some may be left out."""
    bound: dict[tuple[str, str], tuple[int, str]] = {}
    for name, array in arrays.items():
        field, item = kind.field(name)
        _check_dtype(name, field, array)
        _check_shape(name, field, array.shape, item, bound)
        _check_values(name, field, array)


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
        "`provenance` (JSON) and",
        "`ipcli_complete` = 1. Each dataset carries `units`, `dims`, `description` and `crc32` (of its bytes in C "
        "order; of text, of its",
        "UTF-8 strings each followed by a zero byte). A file of a newer version, with unknown datasets, or with a "
        "dataset that breaks a",
        "rule below is refused. A letter in a shape stands for the same length throughout (within one item where the "
        "name holds a `*`).",
        "Text is UTF-8 of fixed length, padded with zeros. `cam_from_world` maps world points to camera points; "
        "cameras look along +z, x right, y down.",
    ]
    for kind in KINDS.values():
        lines += ["", f"## `{kind.name}`, version {kind.version}", "", kind.doc, ""]
        lines += ["| dataset | dtype | shape | units | meaning |", "|---|---|---|---|---|"]
        lines += [_row(field) for field in kind.fields]
    return "\n".join(lines) + "\n"


def _row(field: Field) -> str:
    rules = [field.domain.text] if field.domain else []
    rules += [f"one of {', '.join(field.choices)}"] if field.choices else []
    rules += ["optional"] if field.optional else []
    meaning = field.doc + (f" ({'; '.join(rules)})" if rules else "")
    return (
        f"| `{field.name}` | {field.dtype} | {_dims(field)} | {field.units or '-'} | "
        f"{meaning.replace('|', chr(92) + '|')} |"
    )


VIEWS = Kind(
    "views",
    1,
    "Depth maps with cameras, each of its own size. The items in order of their names are the sequence.",
    (
        Field("views/*/depth", "float32", ("h", "w"), "unit", "Depth along the optical axis", domain=DISTANCE),
        Field(
            "views/*/intrinsics", "float64", (3, 3), "px", "K; pixel centres at integers, as in OpenCV", domain=FINITE
        ),
        Field("views/*/cam_from_world", "float64", (4, 4), "unit", "Rigid pose, dst_from_src", domain=FINITE),
        Field("views/*/confidence", "float32", ("h", "w"), "1", "Weight of each depth", optional=True, domain=WEIGHT),
        Field("views/*/image", "uint8", ("h", "w", 3), "", "RGB", optional=True),
        Field("views/*/truth", "float32", ("h", "w"), "unit", "True depth", optional=True, domain=DISTANCE),
        Field("unit", "str", (), "", "Unit of length of the scene, such as `m`"),
        Field("measured", "str", (), "", "Quantity whose noise is homogeneous", choices=("depth", "disparity")),
        Field(
            "baseline_focal",
            "float64",
            (),
            "px*unit",
            "disparity = baseline_focal / depth",
            optional=True,
            domain=Domain("finite, > 0", 0.0, closed=False),
        ),
    ),
)

DEPTH = Kind(
    "depth",
    1,
    "The fused depth map of one camera, with what is needed to judge it.",
    (
        Field("depth", "float32", ("h", "w"), "unit", "Fused depth along the optical axis", domain=DISTANCE),
        Field("confidence", "float32", ("h", "w"), "1", "Lambda of (4.3), relative to the noise scale", domain=WEIGHT),
        Field(
            "uncertainty",
            "float32",
            ("h", "w"),
            "unit",
            "Error to expect, up to a factor: orders pixels",
            True,
            DISTANCE,
        ),
        Field(
            "normals", "float32", ("h", "w", 3), "1", "Unit normals in the camera frame, facing the camera; NaN unknown"
        ),
        Field("observations", "uint16", ("h", "w"), "1", "Observations per pixel; 0: in-painted"),
        Field(
            "mean",
            "float32",
            ("h", "w"),
            "unit",
            "Mean of the forward projected observations, a baseline",
            domain=DISTANCE,
        ),
        Field(
            "median",
            "float32",
            ("h", "w"),
            "unit",
            "Median of the forward projected observations, a baseline",
            domain=DISTANCE,
        ),
        Field("reference", "float32", ("h", "w"), "unit", "Depth of the reference view as given", domain=DISTANCE),
        Field("intrinsics", "float64", (3, 3), "px", "K; pixel centres at integers, as in OpenCV", domain=FINITE),
        Field("cam_from_world", "float64", (4, 4), "unit", "Rigid pose, dst_from_src", domain=FINITE),
        Field("image", "uint8", ("h", "w", 3), "", "RGB of the reference view", optional=True),
        Field("truth", "float32", ("h", "w"), "unit", "True depth", optional=True, domain=DISTANCE),
        Field(
            "noise_scale",
            "float64",
            (),
            "unit, px or 1/unit",
            "Robust scale of the noise, in the domain",
            domain=WEIGHT,
        ),
        Field("views", "str", ("k",), "", "Names of the fused views"),
        Field("view_valid", "float64", ("k",), "1", "Share of the view's pixels that hold data"),
        Field("view_overlap", "float64", ("k",), "1", "Share of the reference pixels that the view hits"),
        Field("view_residual", "float64", ("k",), "unit", "Median of abs(d_k - fused); NaN without overlap"),
        Field("thumbnails", "float32", ("k", "th", "tw"), "unit", "Observations of each view, made small; NaN none"),
        Field(
            "history",
            "float64",
            ("n", 5),
            "1",
            "Columns: ACS round, iteration, energy, restricted gap (relative), merit",
        ),
        Field("unit", "str", (), "", "Unit of length of the scene, such as `m`"),
        Field(
            "domain", "str", (), "", "Quantity that was regularised", choices=("depth", "disparity", "inverse depth")
        ),
        Field("method", "str", (), "", "Algorithm and regulariser"),
        Field("lambda", "float64", (), "1", "Weight of the data", domain=WEIGHT),
        Field("metrics", "float64", ("m", "c"), "", "Error measures against `truth`; NaN undefined", optional=True),
        Field("metric_rows", "str", ("m",), "", "Result that each row measures", optional=True),
        Field("metric_columns", "str", ("c",), "", "Measure and unit of each column", optional=True),
        Field(
            "ause",
            "float64",
            (),
            "1",
            "Area under the sparsification error of `confidence`, in mean errors",
            optional=True,
        ),
        Field("ause_uncertainty", "float64", (), "1", "The same of `uncertainty`", optional=True),
        Field("ause_angle", "float64", (), "1", "The same of the angle of view (4.35) as a confidence", optional=True),
    ),
)

COMPARISON = Kind(
    "comparison",
    1,
    "Error measures of several methods on several scenes.",
    (
        Field("scenes", "str", ("s",), "", "Name of each scene"),
        Field("methods", "str", ("m",), "", "Name of each method"),
        Field("columns", "str", ("c",), "", "Measure and unit of each column"),
        Field("values", "float64", ("s", "m", "c"), "", "Measures; NaN undefined, or not run"),
    ),
)

TUNING = Kind(
    "tuning",
    1,
    "Errors of several methods over a grid of lambda, on scenes of known truth.",
    (
        Field("scenes", "str", ("s",), "", "Name of each scene"),
        Field("methods", "str", ("m",), "", "Name of each method"),
        Field("lambdas", "float64", ("n",), "1", "Weights of the data that were tried, in order", domain=WEIGHT),
        Field("columns", "str", ("c",), "", "Measure and unit of each column"),
        Field("values", "float64", ("s", "m", "n", "c"), "", "Measures; NaN undefined"),
        Field("automatic_lambda", "float64", ("s", "m"), "1", "Weight that is taken if none is given", domain=WEIGHT),
        Field("automatic", "float64", ("s", "m", "c"), "", "Measures at that weight"),
        Field("measure", "str", (), "", "Column whose mean over the scenes `best` makes least"),
        Field("best", "float64", ("m",), "1", "Best of `lambdas` for each method", domain=WEIGHT),
    ),
)

TRIALS = Kind(
    "trials",
    1,
    "Error measures of several methods on one scene of known truth, each at one or two lambdas, and some of the maps.",
    (
        Field("methods", "str", ("m",), "", "Name of the method of each row"),
        Field("rules", "str", ("m",), "", "Where its lambda is from", choices=("none", "automatic", "tuned")),
        Field(
            "lambdas",
            "float64",
            ("m",),
            "1",
            "Weight of the data; NaN without",
            domain=Domain(">= 0, or NaN", 0.0, nan=True),
        ),
        Field("columns", "str", ("c",), "", "Measure and unit of each column"),
        Field("values", "float64", ("m", "c"), "", "Measures; NaN undefined"),
        Field(
            "kept_error",
            "float64",
            ("m", "k"),
            "mean error",
            "Mean error of the k/K most confident pixels; NaN without confidence",
        ),
        Field(
            "kept_error_uncertainty",
            "float64",
            ("m", "k"),
            "mean error",
            "The same by `uncertainty` of fuse-depth",
            optional=True,
        ),
        Field(
            "kept_error_angle",
            "float64",
            ("m", "k"),
            "mean error",
            "The same by the angle of view (4.35)",
            optional=True,
        ),
        Field("least_error", "float64", ("m", "k"), "mean error", "The same of the pixels that err least"),
        Field("maps", "str", ("n",), "", "Method of each map kept, at the automatic lambda"),
        Field(
            "depth", "float32", ("n", "h", "w"), "unit", "Fused depth; NaN where nothing was observed", domain=DISTANCE
        ),
        Field(
            "confidence",
            "float32",
            ("n", "h", "w"),
            "1",
            "Lambda of (4.3), relative to the noise scale; 0 without",
            domain=WEIGHT,
        ),
        Field("truth", "float32", ("h", "w"), "unit", "True depth", domain=DISTANCE),
        Field("intrinsics", "float64", (3, 3), "px", "K; pixel centres at integers, as in OpenCV", domain=FINITE),
        Field("unit", "str", (), "", "Unit of length of the scene, such as `m`"),
    ),
)

CLOUD = Kind(
    "cloud",
    1,
    "One cloud of points from several fused maps, in world coordinates.",
    (
        Field("points", "float32", ("n", 3), "unit", "Mean of what the maps saw", domain=FINITE),
        Field("normals", "float32", ("n", 3), "1", "Unit length, facing the cameras", domain=FINITE),
        Field("colors", "uint8", ("n", 3), "", "RGB", optional=True),
        Field("confidence", "float32", ("n",), "1", "Sum of the confidences of the maps that agree", domain=WEIGHT),
        Field("views", "uint16", ("n",), "1", "Maps that agree on the point"),
        Field("spacing", "float64", (), "unit", "Side of the cells within which points were merged", domain=WEIGHT),
        Field("maps", "str", ("m",), "", "File of each fused map"),
        Field("cam_from_world", "float64", ("m", 4, 4), "unit", "Rigid pose of each map, dst_from_src", domain=FINITE),
        Field("map_points", "int64", ("m",), "1", "Points of the map: pixels that were observed"),
        Field("map_confirmed", "int64", ("m",), "1", "Those confirmed by enough other maps"),
        Field("map_contradicted", "int64", ("m",), "1", "Those that more maps look through than confirm"),
        Field("unit", "str", (), "", "Unit of length of the scene, such as `m`"),
    ),
)

FUSION = (VIEWS, DEPTH, COMPARISON, TUNING, TRIALS, CLOUD)
MOCAP = (CLIPS, BEHAVIOURS, RECOGNITION, EVALUATION)
KINDS: dict[str, Kind] = {kind.name: kind for kind in (*FUSION, *MOCAP)}

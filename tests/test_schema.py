"""Each rule of the schema, broken one at a time on an artefact generated from the schema."""

import re

import numpy as np
import pytest
from hypothesis import given

from ipcli import schema
from ipcli.schema import fields
from ipcli.schema.fields import Form
from tests.fixtures.artefacts import artefacts, of_form, refs_of

KINDS = list(schema.KINDS.values())


def example(kind):
    """A sound artefact with every optional field."""
    lengths = {"w": 3, "th": 1, "tw": 1, "n": 4, "c": 3}
    arrays = {}
    for field in kind.fields:
        shape = tuple(dim if isinstance(dim, int) else lengths.get(dim, 2) for dim in field.dims)
        one = np.array((field.choices or ("text",))[0]) if field.dtype == "str" else np.ones((), field.dtype)
        array = of_form(shape).astype(field.dtype) if isinstance(field.domain, Form) else np.full(shape, one)
        arrays[field.name.replace("*", "a")] = array
    return arrays


each_kind = pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)


@each_kind
def test_every_generated_artefact_is_valid(kind):
    @given(artefacts(kind))
    def valid(arrays):
        schema.validate(kind, arrays)

    valid()


@each_kind
def test_a_missing_field_is_named_unless_optional(kind):
    for name in example(kind):
        arrays = example(kind)
        del arrays[name]
        needed = {one for one, _ in kind.required({kind.field(left)[0].name for left in arrays})}
        if kind.field(name)[0].optional and kind.field(name)[0].name not in needed:
            schema.validate(kind, arrays)
        else:
            with pytest.raises(schema.SchemaError, match=f"^{re.escape(name)}: missing"):
                schema.validate(kind, arrays)


GROUPS = [(kind, group) for kind in KINDS for group in kind.together]


@pytest.mark.parametrize(("kind", "group"), GROUPS, ids=lambda value: getattr(value, "name", ""))
def test_fields_that_go_together_may_all_be_missing_but_none_alone(kind, group):
    assert all(kind.field(name)[0].optional for name in group)
    asking = {name for name, needed in kind.needs if needed in group} | {
        field.name for field in kind.fields if any(ref and ref.to in group for ref in refs_of(field))
    }
    arrays = {name: array for name, array in example(kind).items() if kind.field(name)[0].name not in {*group, *asking}}
    dangling = {needed for needed, _ in kind.required({kind.field(name)[0].name for name in arrays})}
    if dangling <= {kind.field(name)[0].name for name in arrays}:
        schema.check_names(kind, arrays)
    one = group[-1].replace("*", "a")
    with pytest.raises(schema.SchemaError, match=rf"missing, and {re.escape(one)} makes no sense without it"):
        schema.check_names(kind, {**arrays, one: example(kind)[one]})


@pytest.mark.parametrize(
    ("kind", "gone", "asking"),
    [
        ("gaze-experiment", "gaze/labels", "accuracy/labels"),
        ("recording", "targets", "target_names"),
        ("animal-model", "pictures/a/labels", "pictures/a/rendered"),
        ("fused-depth", "metric_columns", "metrics"),
    ],
)
def test_what_makes_no_sense_alone_is_named_with_what_it_lacks(kind, gone, asking):
    arrays = example(schema.kind(kind))
    del arrays[gone]
    with pytest.raises(schema.SchemaError, match=f"^{gone}: missing, and {asking} makes no sense without it"):
        schema.check_names(schema.kind(kind), arrays)


@each_kind
def test_a_wrong_dtype_is_named_with_the_right_one(kind):
    for name, array in example(kind).items():
        arrays = example(kind) | {name: np.zeros(array.shape, np.complex64)}
        right = kind.field(name)[0].dtype
        with pytest.raises(schema.SchemaError, match=f"{name}: wrong dtype .expected {right}, got complex64"):
            schema.validate(kind, arrays)


@each_kind
def test_one_dimension_more_is_refused(kind):
    for name, array in example(kind).items():
        with pytest.raises(schema.SchemaError, match=f"^{name}: wrong shape"):
            schema.validate(kind, example(kind) | {name: array[None]})


def shared_lengths(kind):
    """(name, axis, dim, name of the first field that has this dim) wherever a field repeats the length of another."""
    first = {}
    for name in example(kind):
        field, item = kind.field(name)
        for axis, dim in enumerate(field.dims):
            if isinstance(dim, str) and first.setdefault((item, dim), name) != name:
                yield name, axis, dim, first[item, dim]


@each_kind
def test_lengths_that_disagree_name_the_other_field(kind):
    for name, axis, dim, other in shared_lengths(kind):
        arrays = example(kind)
        length = arrays[name].shape[axis]
        arrays[name] = np.repeat(arrays[name], 2, axis=axis)
        with pytest.raises(schema.SchemaError, match=f"{name}: wrong shape .*{dim} = {length} as in {other}, got "):
            schema.validate(kind, arrays)


def test_lengths_are_shared_in_the_kinds_that_are_known_to():
    shared = {(kind.name, dim) for kind in KINDS for _, _, dim, _ in shared_lengths(kind)}
    assert {("views", "w"), ("fusion-cloud", "m"), ("clips", "c"), ("action-evaluation", "c")} <= shared


def test_items_of_a_collection_have_sizes_of_their_own():
    arrays = example(schema.kind("views"))
    arrays |= {name.replace("/a/", "/b/"): array for name, array in arrays.items() if "/a/" in name}
    for field in ("depth", "confidence", "truth"):
        arrays[f"views/b/{field}"] = np.ones((5, 7), np.float32)
    arrays["views/b/image"] = np.ones((5, 7, 3), np.uint8)
    schema.validate(schema.kind("views"), arrays)
    del arrays["views/b/intrinsics"]
    with pytest.raises(schema.SchemaError, match="^views/b/intrinsics: missing"):
        schema.validate(schema.kind("views"), arrays)


@pytest.mark.parametrize("value", [0.0, -1.0, np.inf, -np.inf])
def test_depth_is_positive_or_unknown(value):
    arrays = example(schema.kind("views"))
    arrays["views/a/depth"][1, 0] = np.nan
    schema.validate(schema.kind("views"), arrays)
    arrays["views/a/depth"][1, 2] = value
    with pytest.raises(schema.SchemaError, match=r"views/a/depth: value not allowed .*at \(1, 2\), 1 of 6"):
        schema.validate(schema.kind("views"), arrays)


TURN = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
MIRROR = np.diag([1.0, 1, -1])
SKEW = np.array([[500.0, 2, 320], [0, 400, 240], [0, 0, 1]])


def pose(rotation, last=(0, 0, 0, 1)):
    return np.vstack([np.column_stack([rotation, [1, 2, 3]]), last])


@pytest.mark.parametrize(
    ("form", "sound", "unsound"),
    [
        ("ROTATION", [TURN], [MIRROR, 1.01 * TURN, np.full((3, 3), np.nan), np.zeros((3, 3))]),
        ("POSE", [pose(TURN)], [pose(MIRROR), pose(2 * TURN), pose(TURN, (0, 0, 0, 2)), pose(TURN * np.nan)]),
        ("KNOWN_POSE", [pose(TURN), np.full((4, 4), np.nan)], [pose(TURN, (0, 0, 0, np.nan)), pose(MIRROR)]),
        ("CAMERA", [SKEW], [SKEW.T, np.zeros((3, 3)), -SKEW, 2 * SKEW, np.full((3, 3), np.inf)]),
    ],
)
def test_matrices_are_of_their_form_each_by_itself(form, sound, unsound):
    matrices = np.stack([*sound, *unsound])
    held = getattr(fields, form).holds(matrices)
    assert held.shape == matrices.shape
    assert held.all(axis=(1, 2)).tolist() == [True] * len(sound) + [False] * len(unsound)
    assert fields.POSE.holds(np.zeros((0, 4, 4))).shape == (0, 4, 4)


def test_times_that_run_backwards_are_refused():
    kind = schema.kind("recording")
    arrays = example(kind)
    schema.validate(kind, arrays)
    for times in ([0.0, 0.0], [1.0, 0.0], [0.0, np.nan]):
        with pytest.raises(schema.SchemaError, match="each larger than the one before"):
            schema.validate(kind, arrays | {"times": np.array(times)})


def test_confidence_may_be_zero_but_not_unknown():
    arrays = example(schema.kind("views"))
    arrays["views/a/confidence"][:] = 0
    schema.validate(schema.kind("views"), arrays)
    arrays["views/a/confidence"][0, 0] = np.nan
    with pytest.raises(schema.SchemaError, match="confidence: value not allowed"):
        schema.validate(schema.kind("views"), arrays)


@pytest.mark.parametrize(
    ("text", "message"), [("distance", "one of depth, disparity"), ("a\0b", "UTF-8"), ("\ud800", "UTF-8")]
)
def test_text_is_one_of_the_choices_and_can_be_stored(text, message):
    with pytest.raises(schema.SchemaError, match=message):
        schema.validate(schema.kind("views"), example(schema.kind("views")) | {"measured": np.array(text)})


@pytest.mark.parametrize("name", ["dept", "views/a/deph", "views//depth", "views/.a/depth", "views/a/b/depth", "extra"])
def test_an_unknown_field_is_refused_with_a_suggestion(name):
    with pytest.raises(schema.SchemaError, match="not a field of 'views'; did you mean '"):
        schema.validate(schema.kind("views"), example(schema.kind("views")) | {name: np.zeros(1)})


def test_an_unknown_kind_names_the_nearest():
    with pytest.raises(schema.SchemaError, match="'fused-deth'; did you mean 'fused-depth'"):
        schema.kind("fused-deth")


@each_kind
def test_no_dataset_name_fits_two_fields(kind):
    for name in example(kind):
        assert sum(field.match(name) is not None for field in kind.fields) == 1


def referring():
    """(kind, dataset, column, reference, dataset referred to) wherever a field refers to another."""
    for kind in KINDS:
        for name in example(kind):
            field, item = kind.field(name)
            for column, ref in enumerate(refs_of(field)):
                if ref:
                    yield pytest.param(
                        kind, name, column, ref, ref.to.replace("*", item), id=f"{kind.name} {name} {column}"
                    )


@pytest.mark.parametrize(("kind", "name", "column", "ref", "target"), list(referring()))
def test_what_refers_to_nothing_is_refused_when_written_and_read(kind, name, column, ref, target):
    arrays = example(kind)
    schema.validate(kind, arrays)
    is_text = arrays[name].dtype.kind == "U"
    last = ref.base + len(arrays[target]) - 1 + ref.end
    bad = ["nobody"] if is_text else [last + 1, ref.base - ref.none - 1]
    good = ["text", *ref.also, *([""] if ref.none else [])] if is_text else [last, ref.base - ref.none]
    for value in good:
        schema.validate(kind, arrays | {name: placed(arrays[name], column, value, kind.field(name)[0])})
    for value in bad:
        with pytest.raises(
            schema.SchemaError, match=f"^{name}: (refers to what is not in {target} .got {value}|value)"
        ):
            schema.validate(kind, arrays | {name: placed(arrays[name], column, value, kind.field(name)[0])})
    assert ref.to in schema.markdown()


def placed(array, column, value, field):
    """The array with one value replaced, in a column of the last axis where there are several."""
    changed = array.astype(f"U{max(len(str(value)), 4)}") if array.dtype.kind == "U" else array.copy()
    changed[(0,) * (array.ndim - 1) + (column,) if len(refs_of(field)) > 1 else (0,) * array.ndim] = value
    return changed


def test_references_are_checked_among_what_is_given():
    kind = schema.kind("behaviours")
    schema.check_arrays(kind, {"component_action": np.array([77])})
    with pytest.raises(schema.SchemaError, match="component_action: refers to what is not in actions .got 77, 2 there"):
        schema.check_arrays(kind, {"actions": np.array(["a", "b"]), "component_action": np.array([77])})

"""hypothesis strategies for whole artefacts, generated from the schema so that a new kind is tested without a
new test.
"""

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra import numpy as nps

NAMES = st.text("ab01_-é ", min_size=1, max_size=4)
TEXT = st.text(st.characters(exclude_characters="\0", codec="utf-8"), max_size=5)
LENGTH = st.integers(0, 3)


@st.composite
def artefacts(draw, kind):
    """`{name: array}` that the schema of `kind` accepts, optional fields present or not, lengths drawn per item."""
    items = draw(st.lists(NAMES, unique=True, max_size=3)) if any("*" in field.name for field in kind.fields) else []
    arrays = {}
    for item in [None, *items]:
        lengths = {dim: draw(LENGTH) for field in kind.fields for dim in field.dims if isinstance(dim, str)}
        for field in kind.fields:
            if ("*" in field.name) == (item is not None) and not (field.optional and draw(st.booleans())):
                shape = tuple(dim if isinstance(dim, int) else lengths[dim] for dim in field.dims)
                arrays[field.name.replace("*", item or "")] = draw(values(field, shape))
    return arrays


def values(field, shape):
    """Arrays of one field: text, any integers, or floats of its domain with NaN and infinity where these are
    allowed.
    """
    if field.dtype == "str":
        text = st.sampled_from(field.choices) if field.choices else TEXT
        return nps.arrays(object, shape, elements=text).map(lambda array: np.array(array, dtype=np.str_))
    return nps.arrays(field.dtype, shape, elements=elements(field))


def elements(field):
    if np.dtype(field.dtype).kind != "f":
        return None if field.domain is None else st.integers(int(field.domain.low), np.iinfo(field.dtype).max)
    width = 8 * np.dtype(field.dtype).itemsize
    domain = field.domain
    if domain is None:
        return st.floats(width=width)
    low = None if np.isinf(domain.low) else domain.low
    numbers = st.floats(low, width=width, exclude_min=not domain.closed, allow_nan=False, allow_infinity=False)
    return numbers | st.just(np.nan) if domain.nan else numbers

"""Windows and places of items by their names."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ipcli.errors import ParameterError
from ipcli.measurements.names import natural, position, window


@given(st.integers(1, 30), st.data())
def test_window_holds_k_neighbours_with_the_reference_as_central_as_the_ends_allow(count, data):
    names = tuple(f"{index:02d}" for index in range(count))
    at, k = data.draw(st.integers(0, count - 1)), data.draw(st.integers(1, 40))
    found = window(names, names[at], k)
    first = names.index(found[0])
    assert found == names[first : first + min(k, count)]
    assert names[at] in found
    before, after = at - first, first + len(found) - 1 - at
    touches_an_end = first == 0 or first + len(found) == count
    assert touches_an_end or after - before in (0, 1)


def test_window_of_an_unknown_reference_names_the_nearest():
    with pytest.raises(ParameterError, match="'frame_03'.*2 there are.*'frame_3'"):
        window(("frame_3", "other"), "frame_03", 3)
    with pytest.raises(ParameterError, match="at least 1"):
        window(("a",), "a", 0)


def test_the_position_of_a_name_is_its_index_and_a_missing_one_is_told_by_kind():
    assert position(("a", "b", "c"), "b") == 1
    with pytest.raises(ParameterError, match="no scene 'd' among the 1 there are"):
        position(("c",), "d", "scene")


def test_numbers_in_names_count_as_numbers():
    names = ["b2", "a10", "10", "2", "a9", "a9b10", "a9b2", "02"]
    assert sorted(names, key=natural) == ["02", "2", "10", "a9", "a9b2", "a9b10", "a10", "b2"]

"""Names that are there twice are told apart, whatever names there are."""

from hypothesis import given
from hypothesis import strategies as st

from ipcli.io.motion.names import numbered


def test_the_second_of_a_name_gets_a_number_and_a_note():
    assert numbered(["a", "b", "a", "a_2"]) == (("a", "b", "a_3", "a_2"), numbered(["a", "b", "a", "a_2"])[1])
    assert numbered(["a", "a"]) == (("a", "a_2"), ("several joints are named a: told apart by numbers",))
    assert numbered(["a", "b"]) == (("a", "b"), ())


@given(st.lists(st.sampled_from(["a", "a_2", "a_3", "b", ""]), max_size=12))
def test_all_are_different_and_single_ones_stay(names):
    found, notes = numbered(names)
    assert len(set(found)) == len(names)
    assert bool(notes) == (len(set(names)) < len(names))
    assert all(new == old for new, old in zip(found, names, strict=True) if names.count(old) == 1)

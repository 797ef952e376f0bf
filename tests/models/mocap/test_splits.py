"""Both sides of a split are disjoint, actors are on one side alone where that is promised, and nothing is lost."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ipcli.errors import ParameterError
from ipcli.models.mocap import splits

COUNTS = np.array([5, 3, 8, 2, 9, 4, 6, 7])
FRAMES = splits.Frames(
    np.repeat(np.arange(8), COUNTS), np.array(list("aabbaabb")), np.array(["x", "y", "x", "y", "z", "z", "z", "x"])
)
PUBLISHED = {"01": np.array([1, 2, 1, 2, 0, 1, 2, 1]), "02": np.array([2, 1, 2, 1, 1, 2, 1, 0])}


def make(kind, seed=0):
    return splits.make(kind, FRAMES, np.random.default_rng(seed), test=("y", "z"), published=PUBLISHED)


def actors_of(rows):
    return set(FRAMES.actor[FRAMES.clip[rows]])


@pytest.mark.parametrize("kind", splits.KINDS)
def test_both_sides_are_disjoint_and_never_empty(kind):
    for split in make(kind):
        assert not (split.train & split.test).any()
        assert split.train.any()
        assert split.test.any()
        if kind != "published":
            assert (split.train | split.test).all()


@pytest.mark.parametrize("kind", ["subjects", "leave-one-out", "one-to-rest"])
def test_no_actor_is_on_both_sides(kind):
    for split in make(kind):
        assert not actors_of(split.train) & actors_of(split.test)


@pytest.mark.parametrize("kind", [kind for kind in splits.KINDS if kind != "frames"])
def test_no_clip_is_on_both_sides(kind):
    for split in make(kind):
        assert not set(FRAMES.clip[split.train]) & set(FRAMES.clip[split.test])


def test_who_is_left_out_and_who_is_alone():
    assert [actors_of(s.test) for s in make("leave-one-out")] == [{"x"}, {"y"}, {"z"}]
    assert [actors_of(s.train) for s in make("one-to-rest")] == [{"x"}, {"y"}, {"z"}]
    assert actors_of(make("subjects")[0].test) == {"y", "z"}


@given(st.integers(0, 2**31))
def test_random_frames_leave_half_of_each_action(seed):
    (split,) = make("frames", seed)
    action = FRAMES.label[FRAMES.clip]
    for name in "ab":
        assert split.train[action == name].sum() == (action == name).sum() // 2


def test_random_frames_take_no_more_than_the_thesis():
    long = splits.Frames(np.zeros(5000, int), np.array(["a"]), np.array(["x"]))
    assert splits.random_frames(long, np.random.default_rng(0)).train.sum() == splits.MOST_FRAMES


@given(st.integers(0, 2**31))
def test_random_clips_halve_each_action(seed):
    (split,) = make("clips", seed)
    for name in "ab":
        clips = np.flatnonzero(FRAMES.label == name)
        assert len(set(FRAMES.clip[split.train]) & set(clips)) == len(clips) // 2


def test_published_splits_are_as_published():
    for split, (name, entries) in zip(make("published"), PUBLISHED.items(), strict=True):
        assert split.name == name
        assert set(FRAMES.clip[split.train]) == set(np.flatnonzero(entries == 1))
        assert set(FRAMES.clip[split.test]) == set(np.flatnonzero(entries == 2))


def test_a_split_is_a_function_of_its_seed():
    for kind in ("frames", "clips"):
        assert (make(kind, 3)[0].train == make(kind, 3)[0].train).all()
        assert any((make(kind, 3)[0].train != make(kind, seed)[0].train).any() for seed in range(4, 9))


def test_what_cannot_be_split_is_refused():
    with pytest.raises(ParameterError, match="subjects"):
        splits.make("subject", FRAMES, np.random.default_rng(0))
    with pytest.raises(ParameterError, match="no actor 'q'"):
        splits.make("subjects", FRAMES, np.random.default_rng(0), test=("q",))
    with pytest.raises(ParameterError, match="no published splits"):
        splits.make("published", FRAMES, np.random.default_rng(0))
    alone = splits.Frames(np.zeros(4, int), np.array(["a"]), np.array(["x"]))
    for kind in splits.PARTING:
        with pytest.raises(ParameterError, match="all clips are of 'x'.*--split clips"):
            splits.make(kind, alone, np.random.default_rng(0))
    with pytest.raises(ParameterError, match="nothing to train on"):
        splits.make("subjects", FRAMES, np.random.default_rng(0), test=("x", "y", "z"))


def test_random_frames_of_a_take_are_drawn_of_each_of_its_actions():
    action = np.repeat(["", "a", "b"], [100, 6, 50])
    take = splits.Frames(np.zeros(156, int), np.array([""]), np.array(["x"]), action)
    found = splits.make("frames", take, np.random.default_rng(0))[0]
    assert {name: int(found.train[action == name].sum()) for name in ("a", "b")} == {"a": 3, "b": 25}

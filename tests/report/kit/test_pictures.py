from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from ipcli.report.kit import pictures
from ipcli.report.kit.pictures import (
    HATCH,
    MISSING,
    Scale,
    draw,
    from_zero,
    palette,
    photograph,
    robust,
    strip,
    symmetric,
    thin,
)

PALETTES = ("turbo", "viridis", "magma", "sea", "signed", "clay")
values = hnp.arrays(
    np.float32,
    hnp.array_shapes(min_dims=2, max_dims=2, max_side=9),
    elements=st.floats(-100, 100, width=32) | st.just(np.nan),
)


def decoded(picture: pictures.Picture) -> np.ndarray:
    return cv2.imdecode(np.frombuffer(picture.data, np.uint8), cv2.IMREAD_COLOR)[..., ::-1]


def luminance(name: str) -> np.ndarray:
    return palette(name)[2:] @ np.array([0.2126, 0.7152, 0.0722])


@given(values, st.sampled_from(PALETTES))
def test_another_decoder_sees_the_colours_that_were_meant(array, name):
    scale = Scale(-50.0, 50.0, name)
    picture = draw(array, scale)
    assert (picture.height, picture.width) == array.shape
    shown = decoded(picture)
    missing = ~np.isfinite(array)
    level = np.floor(np.clip((np.nan_to_num(array).astype(float) + 50) / 100, 0, 1) * 253 + 0.5).astype(int)
    apart = np.abs(shown[~missing].astype(int) - palette(name)[2 + level][~missing])
    assert apart.max(initial=0) <= 12  # a float32 rounding may move a value to the next of 254 colours
    grey = np.array([MISSING, HATCH])
    assert (shown[missing][:, None] == grey).all(axis=2).any(axis=1).all()


@pytest.mark.parametrize("name", PALETTES)
def test_no_palette_holds_the_colours_of_missing_data(name):
    known = palette(name)[2:].tolist()
    assert list(MISSING) not in known
    assert list(HATCH) not in known
    assert len({tuple(colour) for colour in known}) > 200


@pytest.mark.parametrize("name", ["viridis", "magma", "sea", "clay"])
def test_brighter_means_more(name):
    assert (np.diff(luminance(name)) > -0.6).all()  # rounding to 8 bits may lose half a level
    assert luminance(name)[-1] - luminance(name)[0] > 150


def test_signed_differences_are_white_at_zero_and_darken_to_both_sides():
    bright = luminance("signed")
    assert 120 < bright.argmax() < 134
    assert (np.diff(bright[:127]) >= -0.6).all()
    assert (np.diff(bright[127:]) <= 0.6).all()


@given(hnp.arrays(np.float32, 30, elements=st.floats(-10, 10, width=32)), st.booleans())
def test_the_order_of_values_is_the_order_of_colours(array, log):
    scale = Scale(0.25, 8.0, "turbo", log=log)
    ordered = np.sort(np.maximum(array, 0.01))[None]
    assert (np.diff(scale.indices(ordered).astype(int)) >= 0).all()


def test_both_ends_of_the_scale_take_the_ends_of_the_palette():
    for log in (False, True):
        ends = Scale(0.5, 4.0, "viridis", log=log).indices(np.array([[0.1, 0.5, 4.0, 9.0]]))
        assert ends.tolist() == [[2, 2, 255, 255]]


def test_the_unit_of_length_does_not_change_the_picture():
    metres = np.random.default_rng(0).gamma(4, 1, (40, 40)).astype(np.float32)
    scales = robust([metres], "turbo"), robust([metres * 1000], "turbo")
    assert np.abs(scales[0].indices(metres).astype(int) - scales[1].indices(metres * 1000)).max() <= 1


def test_limits_ignore_outliers_and_contain_the_rest():
    depth = np.linspace(2, 4, 10_000, dtype=np.float32).reshape(100, 100)
    depth[0, :20] = 1e6
    scale = robust([depth], "turbo", "m")
    assert 1.9 < scale.low <= 2.03
    assert 3.97 <= scale.high < 4.2


def test_labels_of_the_bar_start_and_end_at_the_limits():
    for scale in (Scale(1.5, 4.9, "turbo"), Scale(0.02, 37.0, "viridis", log=True), Scale(0.0, 3.0, "sea", whole=True)):
        labels = scale.ticks()
        assert (labels[0], labels[-1]) == (scale.low, scale.high)
        assert labels == sorted(set(labels))
        assert not scale.whole or all(label == int(label) for label in labels)


def test_the_bar_is_the_palette():
    assert (decoded(strip(Scale(0, 1, "magma")))[0] == palette("magma")[2:]).all()


@pytest.mark.parametrize(
    "array", [np.full((3, 3), np.nan), np.zeros((3, 3)), np.full((3, 3), 7.0), np.array([[np.inf, -np.inf]])]
)
def test_scales_of_empty_and_constant_maps_have_a_range(array):
    for scale in (
        robust([array], "turbo"),
        robust([array], "viridis", log=True),
        from_zero([array], "magma"),
        symmetric([array]),
    ):
        assert np.isfinite([scale.low, scale.high]).all()
        assert scale.high > scale.low
        draw(array, scale)


def test_wide_pictures_are_thinned_not_averaged():
    noise = np.random.default_rng(1).normal(size=(100, 2000)).astype(np.float32)
    small = thin(noise, 900)
    assert small.shape == (45, 900)
    assert np.isin(small, noise).all()
    assert draw(noise, robust([noise], "turbo")).width == pictures.WIDEST


def test_photographs_keep_their_look_and_shrink():
    rgb = np.zeros((50, 2000, 3), np.uint8) + np.uint8([200, 90, 30])
    picture = photograph(rgb)
    assert (picture.width, picture.media) == (900, "image/jpeg")
    assert np.abs(decoded(picture).astype(int) - [200, 90, 30]).max() < 8

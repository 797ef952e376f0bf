"""What is measured of chapter 7: rows of sound numbers, and an order that factors the same matrix."""

from benchmarks.brdf import speed


def test_the_coder_is_timed_on_as_many_patches_as_are_asked_for():
    row = speed.coder(300)
    assert (row["patches"], row["numbers each"]) == (300, 243)
    assert row["seconds"] > 0


def test_factorisations_are_of_the_disc_of_that_side():
    row = speed.order(20)
    assert 250 < row["unknowns"] < 320  # pi / 4 of the square
    assert row["times"] == row["default [ms]"] / row["ours [ms]"]

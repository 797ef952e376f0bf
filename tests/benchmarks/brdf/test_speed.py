"""What is measured of chapter 7: rows of sound numbers, and an order that factors the same matrix."""

from benchmarks.brdf import speed


def test_the_coder_is_timed_on_as_many_patches_as_are_asked_for():
    row = speed.coder(300)
    assert (row["patches"], row["numbers each"]) == (300, 243)
    assert row["seconds"] > 0


def test_a_whole_material_is_foretold_from_its_tenth_and_says_so():
    tenth = {"patches": speed.WHOLE // 10, "numbers each": 243, "seconds": 2.0, "CPU s": 3.0, "peak MB": 4.0}
    told = speed.foretold(tenth)
    assert told["patches"] == "200000, foretold"
    assert (told["numbers each"], told["seconds"], told["CPU s"], told["peak MB"]) == (243, 20.0, 30.0, 40.0)


def test_factorisations_are_of_the_disc_of_that_side():
    row = speed.order(20)
    assert 250 < row["unknowns"] < 320  # pi / 4 of the square
    assert row["times"] == row["default [ms]"] / row["ours [ms]"]

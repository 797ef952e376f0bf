"""Methods by their names: what `--methods` stands for."""

import pytest

from ipcli.errors import ParameterError
from ipcli.models.fusion.alternation import ALGORITHMS as IMPLEMENTED
from ipcli.models.fusion.parameters import ALGORITHMS, METHODS, Fusion, Variant, parse_variants, select_variants


def test_all_stands_for_every_method_once_and_adaptive_ones_by_each_algorithm():
    variants = parse_variants("all")
    assert len(set(variants)) == len(variants) == sum(3 if method.adaptive else 1 for method in METHODS.values())
    assert parse_variants("l1-adapt") == [Variant("l1-adapt", "acs")]
    assert Variant("l1-adapt", "acs").label == "l1-adapt (acs)"


def test_the_algorithms_that_can_be_named_are_those_there_are():
    assert set(ALGORITHMS) == set(IMPLEMENTED)


def test_a_variant_named_twice_is_tried_once_and_keeps_its_place():
    found = select_variants(["tv-l1", "l1-adapt:ama", "tv-l1", "mean"], Fusion())
    assert [variant.label for variant in found] == ["tv-l1", "l1-adapt (ama)", "mean"]
    assert [variant.is_regularised for variant in found] == [True, True, False]


def test_a_variant_changes_method_algorithm_and_lambda_of_the_settings_alone():
    settings = Variant("l1-adapt", "ama").settings(Fusion(rounds=7), 0.3)
    assert settings == Fusion(method="l1-adapt", algorithm="ama", lam=0.3, rounds=7)
    assert Variant("mean", None).settings(Fusion(lam=0.3), None) == Fusion(method="mean")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("tgv", "unknown method 'tgv'; did you mean 'tgv-l1'"),
        ("tgv-l1:ama", "it estimates no confidence"),
        ("l1-adapt:amma", "expected one of acs, ama, biconvex"),
    ],
)
def test_what_is_no_method_is_refused(text, message):
    with pytest.raises(ParameterError, match=message):
        parse_variants(text)


def test_a_method_in_the_settings_beside_others_is_refused():
    with pytest.raises(ParameterError, match="name them by --methods"):
        select_variants(["all"], Fusion(method="rof"))

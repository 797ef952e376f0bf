"""The origin of a page: every parameter and input once, whatever they are called."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from ipcli.report.kit import provenance
from tests.fixtures.pages import ESCAPED, HOSTILE, Balance

NAMES = st.text("abcz", min_size=1, max_size=3)
PARAMS = st.recursive(
    st.integers() | st.text("xy<", max_size=3) | st.none(),
    lambda inner: st.dictionaries(NAMES, inner, max_size=3),
    max_leaves=8,
)


@given(st.dictionaries(NAMES, PARAMS, max_size=4))
def test_leaves_put_together_again_are_the_parameters(params):
    again: dict = {}
    for name, value in provenance.leaves(params):
        *sections, last = name.split(".")
        place = again
        for part in sections:
            place = place.setdefault(part, {})
        place[last] = value

    def without_empty(tree):
        kept = {name: without_empty(value) if isinstance(value, dict) else value for name, value in tree.items()}
        return {name: value for name, value in kept.items() if value != {}}

    assert again == without_empty(params)


@given(st.dictionaries(NAMES, PARAMS, max_size=4))
def test_the_order_of_the_keys_means_nothing(params):
    record = {"command": "fuse-depth", "params": params}
    backwards = record | {"params": dict(reversed(params.items()))}
    assert provenance.origin(record) == provenance.origin(backwards)


def test_everything_is_said_and_nothing_escapes():
    record = {
        "command": HOSTILE,
        "ipcli": "1.2.3",
        "seed": 7,
        "digest": "abc",
        "params": {"fusion": {"lam": None, "on": True, "name": HOSTILE}, "window": 3},
        "inputs": [{"name": HOSTILE, "sha256": "f00"}, {"name": "b.png", "sha256": "ba4"}],
    }
    html = provenance.origin(record)
    Balance(html)
    assert "<script>" not in html
    assert html.count(ESCAPED) == 3
    for words in ("ipcli 1.2.3, seed 7", "Parameters (4)", "Inputs (2)", "fusion.lam", "null", "true", "f00", "ba4"):
        assert html.count(words) == 1, words


def test_without_a_record_the_page_says_so_and_what_is_missing_in_one_is_unknown():
    assert "no record" in provenance.origin({})
    html = provenance.origin({"seed": 1})
    assert html.count("unknown") == 3
    assert "Parameters (0)" in html
    assert "Inputs (0)" in html

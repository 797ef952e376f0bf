"""Tables as JSON and Markdown, and the options that benchmarks share."""

import json

import pytest

from benchmarks.kit.arguments import add_generated, parser_of, size_of
from benchmarks.kit.publish import save, table


def test_a_table_has_a_column_for_every_key_and_a_dash_where_a_row_has_none():
    text = table([{"method": "a", "s": 0.12345}, {"method": "b", "MB": 123.4, "n": 1234567}])
    assert text.splitlines() == [
        "| method | s | MB | n |",
        "| --- | --- | --- | --- |",
        "| a | 0.123 | - | - |",
        "| b | - | 123 | 1234567 |",
    ]


def test_what_is_saved_is_the_tables_and_what_they_were_measured_on(tmp_path):
    text = save("x", "Title", {"Cases": [{"n": 1}]}, {"scene": "small"}, tmp_path / "new")
    found = json.loads((tmp_path / "new" / "x.json").read_text())
    assert found["tables"] == {"Cases": [{"n": 1}]}
    assert found["facts"]["scene"] == "small"
    assert "processor" in found["facts"]
    assert (tmp_path / "new" / "x.md").read_text() == text + "\n"
    assert text.startswith("# Title\n")
    assert "## Cases\n\n| n |" in text


@pytest.mark.parametrize(
    ("line", "size"), [([], (640, 480)), (["--quick"], (320, 240)), (["--quick", "--size", "64", "48"], (64, 48))]
)
def test_a_quick_look_is_small_unless_a_size_is_given(line, size):
    parser = parser_of("What it measures.", "a quarter")
    add_generated(parser)
    assert size_of(parser.parse_args(line)) == size

"""Tables that experiments read and leave: those of the thesis, credits, CSV and JSON."""

import csv
import json
from pathlib import Path

import pytest

from experiments.kit.credits import Credit, credits_section, read_credits
from experiments.kit.printed import read_printed
from experiments.kit.tables import read_rows, write_table

EXPERIMENTS = Path(__file__).resolve().parents[3] / "experiments"


def test_a_printed_table_is_its_title_its_columns_and_its_rows_as_printed(tmp_path):
    (tmp_path / "9.9.csv").write_text('# Table 9.9: errors, of all\nmethod,a\n"X, new",0.50\n')
    table = read_printed(tmp_path / "9.9.csv")
    assert (table.title, table.columns, table.rows) == (
        "Table 9.9: errors, of all",
        ("method", "a"),
        (("X, new", "0.50"),),
    )
    assert (table.number, table.words) == ("Table 9.9", "Errors, of all")


def test_a_printed_row_that_is_too_short_is_refused(tmp_path):
    (tmp_path / "9.9.csv").write_text("# T\nmethod,a\nX\n")
    with pytest.raises(ValueError, match="1 cells in the row of X, 2 in the head"):
        read_printed(tmp_path / "9.9.csv")


def test_what_is_written_is_the_same_as_csv_and_json_but_for_what_is_not_known(tmp_path):
    rows = [{"method": "a", "x": 0.1}, {"method": "b", "x": float("nan")}]
    write_table(tmp_path / "index.html", rows, title="Ä")
    assert (tmp_path / "index.csv").read_text() == "method,x\na,0.1\nb,nan\n"
    found = json.loads((tmp_path / "index.json").read_text(), parse_constant=pytest.fail)
    assert found == {"title": "Ä", "rows": [{"method": "a", "x": 0.1}, {"method": "b", "x": None}]}


def test_comments_are_no_rows(tmp_path):
    (tmp_path / "x.csv").write_text("# why\na,b\n# more\n\n1,2\n")
    assert read_rows(tmp_path / "x.csv") == [{"a": "1", "b": "2"}]


def test_data_sets_are_credited_where_they_are_shown(tmp_path):
    (tmp_path / "data.csv").write_text("experiments,name,authors,licence\none two,D<,A,L\ntwo,E,B,M\n")
    assert read_credits(tmp_path / "data.csv", "one") == [Credit("D<", "A", "L")]
    assert [credit.name for credit in read_credits(tmp_path / "data.csv", "two")] == ["D<", "E"]
    assert "D&lt;" in str(credits_section(read_credits(tmp_path / "data.csv", "one")))
    assert credits_section([]) is None


@pytest.mark.parametrize(
    "path", sorted(EXPERIMENTS.glob("*/*.csv")), ids=lambda path: f"{path.parent.name}/{path.name}"
)
def test_every_table_of_a_chapter_has_whole_rows(path):
    lines = [line for line in path.read_text(encoding="utf-8").splitlines() if line[0] != "#"]
    head, *rows = csv.reader(lines)
    assert rows
    assert {len(row) for row in rows} == {len(head)}

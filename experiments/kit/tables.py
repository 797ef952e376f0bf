"""Tables of an experiment in files: the ones it reads, with comments, and the one that it leaves as CSV and JSON."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Mapping, Sequence
from pathlib import Path

from ipcli.io.files import atomic


def read_rows(path: Path) -> list[dict[str, str]]:
    """The rows of a CSV file by the names in its head; lines that begin with # are comments."""
    lines = path.read_text(encoding="utf-8").splitlines()
    return list(csv.DictReader(line for line in lines if line and line[0] != "#"))


def write_table(out: Path, rows: Sequence[Mapping[str, object]], **about: object) -> None:
    """Write X.csv, and X.json with what is said `about` the table before its `rows`; NaN is null in JSON."""
    text = io.StringIO()
    writer = csv.DictWriter(text, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    atomic.write_text(out.with_suffix(".csv"), text.getvalue())
    known = [{key: None if value != value else value for key, value in row.items()} for row in rows]
    document = json.dumps({**about, "rows": known}, indent=1, ensure_ascii=False)
    atomic.write_text(out.with_suffix(".json"), document + "\n")

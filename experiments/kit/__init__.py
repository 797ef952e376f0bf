"""What the experiments of all chapters share; docs/experiments.md shows how a chapter uses it.

Read `run` first: it takes the argument line and leaves the page, the table and the figures. `bars`, `printed` and
`credits` read the tables beside a chapter's code, `charts` is what a page and its `figures` draw, `tables` writes.
"""

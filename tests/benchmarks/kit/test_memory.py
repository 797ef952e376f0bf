"""What a long benchmark measured before a kill is not measured again."""

import json

from benchmarks.kit.memory import Memory


def test_what_is_known_is_not_measured_again_and_a_cut_line_is(tmp_path):
    path, asked = tmp_path / "x" / "kept.jsonl", []

    def work(value):
        return lambda: asked.append(value) or {"share": value}

    first = Memory(path)
    assert first.recall(["a", {"k": 1}], work(0.5)) == {"share": 0.5}
    assert first.recall(["b", {"k": 1}], work(0.25)) == {"share": 0.25}
    path.write_text(path.read_text()[:-3])
    later = Memory(path)
    assert later.recall(["a", {"k": 1}], work(1.0)) == {"share": 0.5}
    assert later.recall(["b", {"k": 1}], work(0.125)) == {"share": 0.125}
    assert asked == [0.5, 0.25, 0.125]
    assert [json.loads(line)[1]["share"] for line in path.read_text().splitlines()] == [0.5, 0.125]

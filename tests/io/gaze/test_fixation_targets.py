"""Tables of fixation targets, with and without an end."""

import numpy as np
import pytest

from ipcli.errors import FormatError
from ipcli.io.gaze.fixation_targets import read_fixation_targets


def test_spans_and_places(tmp_path):
    table = tmp_path / "targets.csv"
    table.write_text("time [s],x [px],y [px]\n2,10,20\n5,30,40.5\n")
    found = read_fixation_targets(table)
    np.testing.assert_allclose(found.spans, [[1.85, 2.15], [4.85, 5.15]])
    np.testing.assert_allclose(found.pixels, [[10, 20], [30, 40.5]])
    table.write_text("time [s],until [s],x [px],y [px]\n2,3.5,10,20\n")
    np.testing.assert_allclose(read_fixation_targets(table).spans, [[2, 3.5]])


@pytest.mark.parametrize(
    "text", ["time [s],x [px]\n1,2\n", "time [s],x [px],y [px]\n1,,3\n", "time [s],x [px],y [px]\n1,a,3\n"]
)
def test_other_tables_are_refused(tmp_path, text):
    table = tmp_path / "targets.csv"
    table.write_text(text)
    with pytest.raises(FormatError, match="fixation target"):
        read_fixation_targets(table)

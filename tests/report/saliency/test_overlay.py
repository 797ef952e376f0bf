import numpy as np

from ipcli.report.kit.pictures import from_zero
from ipcli.report.saliency import overlay


def test_a_picture_glows_where_its_map_is_high_and_keeps_some_light_elsewhere():
    lit = overlay.glow(np.full((20, 40, 3), 200, np.uint8), np.array([[0.0, 4.0]]))
    assert lit[10, 0, 0] == int(200 * overlay.DARKEST)
    assert lit[10, -1, 0] >= 198


def test_fixations_are_red_dots_at_their_places():
    drawn = overlay.dotted(np.zeros((100, 200, 3), np.uint8), np.array([[0.5, 0.25]]))
    assert tuple(drawn[25, 100]) == overlay.DOT
    assert not drawn[75].any()


def test_a_surface_turned_about_shows_its_other_side():
    rng = np.random.default_rng(0)
    normals = rng.normal(size=(4000, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    values = (normals[:, 2] > 0).astype(float)
    scale = from_zero([values], "magma")
    front, back = (overlay.around(normals, normals, values, scale, turn) for turn in (0, 180))
    middle = overlay.SIDE // 2
    assert front[middle, middle].sum() > back[middle, middle].sum()
    assert (front[0] == overlay.BEHIND).all()


def test_items_are_named_in_order():
    assert overlay.items({"a/2/x": 0, "a/1/x": 0, "b/0/x": 0}, "a") == ["1", "2"]


def test_single_pixels_between_points_are_closed_and_wider_gaps_are_not():
    drawn = np.full((12, 12, 3), overlay.BEHIND, np.uint8)
    drawn[1:11, 1:11] = (40, 50, 60)
    drawn[3, 3] = overlay.BEHIND
    drawn[6:10, 6:10] = overlay.BEHIND
    closed = overlay._closed(drawn)
    assert closed[3, 3].tolist() == [40, 50, 60]
    assert (closed[0] == overlay.BEHIND).all()
    assert (closed[7:9, 7:9] == overlay.BEHIND).all()


def test_a_map_without_a_peak_lights_nothing_up():
    lit = overlay.glow(np.full((20, 40, 3), 200, np.uint8), np.ones((2, 4), np.float32))
    assert lit.min() > overlay.DARKEST * 200
    assert lit.max() < 0.8 * 200

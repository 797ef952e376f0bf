import numpy as np
import pytest

from ipcli.geometry import lie
from ipcli.models.animal import articulation
from ipcli.models.animal.articulation import Posture, jointed
from ipcli.models.animal.limbs import TREE, four_legged


@pytest.fixture(scope="module")
def body():
    vertices, faces, labels, tree = four_legged(spacing=0.06)
    return jointed(vertices, faces, labels - 1, tree)


def turned(body, part, vector):
    pose = Posture.rest(body)
    turns = pose.turns.copy()
    turns[np.flatnonzero(body.part == part)[0]] = lie.exp(np.asarray(vector))
    return Posture(turns, pose.place)


def test_segments_follow_the_tree_and_weights_add_up(body):
    assert set(body.part) == set(range(len(TREE)))
    assert (body.parent[1:] >= 0).all()
    assert (body.parent[1:] < np.arange(1, len(body))).all()  # listed after what it hangs on
    for segment in range(1, len(body)):
        own, above = body.part[segment], body.part[body.parent[segment]]
        assert above in (own, TREE.parents[own])
    np.testing.assert_allclose(body.weights.sum(axis=1), 1.0)
    assert body.weights.min() >= 0


def test_the_rest_pose_moves_nothing_and_a_similarity_moves_all_alike(body):
    np.testing.assert_allclose(Posture.rest(body).skinned(body), body.vertices, atol=1e-12)
    rotation = lie.exp(np.array([0.2, -0.4, 0.3]))
    pose = Posture.rest(body)
    turns = pose.turns.copy()
    turns[0] = rotation
    moved = Posture(turns, np.array([1.0, 2.0, 3.0]), 1.5).skinned(body)
    expected = [1.0, 2.0, 3.0] + 1.5 * (body.vertices - body.joint[0]) @ rotation.T
    np.testing.assert_allclose(moved, expected, atol=1e-12)


def test_a_turned_leg_takes_its_foot_along_and_leaves_the_other_parts(body):
    leg = TREE.names.index("front_leg_L")
    moved = turned(body, leg, [0.0, 0.6, 0.0]).skinned(body)
    first = np.flatnonzero(body.part == leg)[0]
    own = np.isin(body.segment, np.flatnonzero(body.part == leg))
    far = own & (np.linalg.norm(body.vertices - body.joint[first], axis=1) > 0.7)
    arms = body.vertices[far] - body.joint[first]
    np.testing.assert_allclose(moved[far] - body.joint[first], arms @ lie.exp(np.array([0, 0.6, 0])).T, atol=0.03)
    tail = body.segment == np.flatnonzero(body.part == TREE.names.index("tail"))[-1]
    np.testing.assert_allclose(moved[tail], body.vertices[tail], atol=1e-3)


def test_small_turns_are_about_world_axes_and_move_what_hangs_on_a_segment(body):
    pose = turned(body, TREE.names.index("neck"), [0.1, 0.3, -0.2])
    head = np.flatnonzero(body.part == TREE.names.index("head"))[0]
    neck = body.parent[head]
    vectors = np.zeros((len(body), 3))
    vectors[neck] = [0.02, -0.01, 0.03]
    again = pose.turned(body, vectors, np.zeros(3), 0.0)
    before, after = pose.motions(body), again.motions(body)
    np.testing.assert_allclose(after[0][head], lie.exp(vectors[neck]) @ before[0][head], atol=1e-12)
    arm = before[1][head] - before[1][neck]
    np.testing.assert_allclose(after[1][head] - after[1][neck], lie.exp(vectors[neck]) @ arm, atol=1e-12)


def test_islands_of_a_part_take_the_part_around_them(body):
    graph = articulation.edge_graph(body.vertices, body.faces)
    part = body.part[body.segment]
    torso = np.flatnonzero(part == 0)
    spoilt = part.copy()
    spoilt[torso[len(torso) // 2]] = 3  # a single vertex of the torso named tail
    np.testing.assert_array_equal(articulation.in_one_piece(spoilt, graph), articulation.in_one_piece(part, graph))

import numpy as np

from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.graph.labels import Labels, Trail, best_labels, join_labels, placed, poses_after, start_labels


def labels_at(pose, worth):
    count = len(pose)
    return Labels(
        np.array(pose, float),
        np.array(worth, float),
        np.zeros(count, np.int64),
        np.arange(count),
        np.arange(count) + 10,
    )


def test_poses_move_points_as_matrices_do():
    random = np.random.default_rng(0)
    poses, points, motion = random.normal(size=(5, 3)), random.normal(size=(7, 2)), PlanarRigid(2.9, -1.0, 0.3)
    moved, after = placed(poses, points), poses_after(poses, motion)
    for pose, shown, then in zip(poses, moved, after, strict=True):
        matrix = PlanarRigid(*pose).matrix()
        flat = np.column_stack([points, np.zeros(7), np.ones(7)])
        np.testing.assert_allclose(shown, (flat @ matrix.T)[:, :2])
        np.testing.assert_allclose(PlanarRigid(*then).matrix(), matrix @ motion.matrix(), atol=1e-12)
        assert -np.pi < then[0] <= np.pi


def test_the_best_of_each_cell_are_kept_best_first():
    labels = labels_at([[0, 0, 0], [0, 0, 0.001], [0, 1, 0], [0, 0, 0], [1, 0, 0]], [[3], [2], [5], [1], [4]])
    group = np.array([0, 0, 0, 1, 0])
    assert best_labels(labels, labels.worth, group, 10).tolist() == [3, 1, 4, 2]
    assert best_labels(labels, labels.worth, group, 2).tolist() == [3, 1]


def test_the_first_column_counts_before_the_second():
    labels = labels_at([[0, 0, 0], [0, 1, 0], [0, 2, 0]], [[1, 0], [0, 9], [0, 8]])
    assert best_labels(labels, labels.worth, np.zeros(3), 3).tolist() == [2, 1, 0]


def test_the_trail_leads_back_to_the_start():
    trail = Trail()
    start = trail.add(start_labels(np.zeros((2, 3)), 1))
    first = Labels(np.zeros((2, 3)), np.zeros((2, 1)), np.ones(2, np.int64), start[[1, 0]], np.array([7, 8]))
    second_parent = trail.add(first)[1]
    assert trail.arcs(int(second_parent), 9) == [8, 9]
    assert trail.arcs(-1, 3) == [3]
    joined = join_labels([first, first])
    assert joined.arc.tolist() == [7, 8, 7, 8] and len(joined.take(np.array([2]))) == 1

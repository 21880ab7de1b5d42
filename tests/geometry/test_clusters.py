import numpy as np
import trimesh

from unstructured_mg.geometry.clusters import cluster_vertices


def test_clusters_are_small_and_never_join_what_only_space_brings_together():
    sphere = trimesh.creation.icosphere(subdivisions=4)
    vertices = np.concatenate([sphere.vertices, sphere.vertices * 0.99])
    faces = np.concatenate([sphere.faces, sphere.faces + len(sphere.vertices)]).astype(np.int32)
    labels = cluster_vertices(vertices, faces, 0.25)
    outer, inner = labels[: len(sphere.vertices)], labels[len(sphere.vertices) :]
    assert not set(outer) & set(inner)
    for label in range(labels.max() + 1):
        assert np.ptp(vertices[labels == label], axis=0).max() <= 0.25
    # About the area over the cell's, in pieces.
    assert 2 * 4 * np.pi / 0.25**2 < labels.max() + 1 < 2 * 3 * 4 * np.pi / 0.25**2

import numpy as np
import trimesh
from textured_pairs import tube

from unstructured_mg.synthesis.atlas import build_atlas
from unstructured_mg.synthesis.texels import cover_texels, to_pixels


def covered(atlas):
    return cover_texels(to_pixels(atlas.uv[atlas.face_uv], atlas.height, atlas.width), atlas.height, atlas.width)


def test_a_sound_atlas_is_kept_to_the_bit():
    vertices, faces, uv, face_uv = tube(16, 10)
    atlas = build_atlas(vertices, faces, uv, face_uv, None, [(512, 256)])
    assert atlas.captured and (atlas.height, atlas.width) == (512, 256)
    np.testing.assert_array_equal(atlas.uv, uv)
    np.testing.assert_array_equal(atlas.face_uv, face_uv)


def test_texture_size_limits_the_longest_side():
    vertices, faces, uv, face_uv = tube(16, 10)
    atlas = build_atlas(vertices, faces, uv, face_uv, None, [(512, 256)], texture_size=128)
    assert (atlas.height, atlas.width) == (128, 64)


def test_materials_are_put_side_by_side():
    vertices, faces, uv, face_uv = tube(16, 10)
    material = (np.arange(len(faces)) % 3).astype(np.int32)
    atlas = build_atlas(vertices, faces, uv, face_uv, material, [(64, 64)] * 3)
    assert atlas.captured and (atlas.height, atlas.width) == (128, 128)
    owner, _, twice = covered(atlas)
    assert twice == 0
    cell = np.floor(atlas.uv[atlas.face_uv].mean(axis=1) * 2).astype(int)
    assert len(np.unique(np.column_stack([cell, material]), axis=0)) == 3


def test_overlapping_charts_get_an_atlas_of_their_own_at_the_captured_resolution():
    vertices, faces, uv, face_uv = tube(16, 10)
    both = np.concatenate([faces, faces + len(vertices)])
    atlas = build_atlas(
        np.concatenate([vertices, vertices + 1]),
        both,
        np.concatenate([uv, uv]),
        np.concatenate([face_uv, face_uv + len(uv)]),
        None,
        [(200, 200)],
    )
    owner, _, twice = covered(atlas)
    assert not atlas.captured and twice == 0
    assert (owner >= 0).sum() == 2 * 180 * 180
    # Triangles keep their shape in pixels.
    before = uv[face_uv] * 200
    after = atlas.uv[atlas.face_uv[: len(faces)]] * atlas.width
    np.testing.assert_allclose(
        np.linalg.norm(after - np.roll(after, 1, 1), axis=2), np.linalg.norm(before - np.roll(before, 1, 1), axis=2)
    )


def test_repeating_uvs_and_charts_that_overlap_themselves_are_taken_apart():
    vertices, faces, uv, face_uv = tube(16, 10)
    # Mirrored halves, as painted textures often have them, and twice around the image besides.
    mirrored = uv.copy()
    mirrored[:, 0] = 2 * np.abs(uv[:, 0] - 0.5) + 1
    atlas = build_atlas(vertices, faces, mirrored, face_uv, None, [(128, 128)])
    owner, _, twice = covered(atlas)
    assert not atlas.captured and twice == 0
    assert len(np.unique(owner)) > 0.99 * len(faces)


def test_a_template_without_uvs_gets_an_atlas():
    mesh = trimesh.creation.icosphere(subdivisions=3)
    faces = mesh.faces.astype(np.int32)
    atlas = build_atlas(
        np.asarray(mesh.vertices), faces, np.zeros((0, 2)), np.zeros((0, 3), np.int32), None, [(256, 256)]
    )
    owner, _, twice = covered(atlas)
    assert twice == 0 and len(np.unique(owner)) == len(faces) + 1

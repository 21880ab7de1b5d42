import dataclasses
import io

import numpy as np
import pytest
import scipy.ndimage as nd
from PIL import Image as PillowImage
from textured_pairs import ArrayCapture, ArrayTexture, grid, pattern, psnr, tracked_pair, tube

from unstructured_mg.capture.mesh import TexturedMesh
from unstructured_mg.synthesis.texels import cover_texels, to_pixels
from unstructured_mg.synthesis.texture import (
    build_texture_surface,
    encode_jpeg,
    gradient_energy,
    synthesize_textures,
)
from unstructured_mg.synthesis.texture_options import TextureOptions

SIZE = 192


def painted_tube(around, along, turn, colors=None, mirror=False):
    """A tube whose pattern is turned about its axis by ``turn``, with an atlas of its own."""
    vertices, faces, uv, face_uv = tube(around, along)
    if mirror:
        uv = 1 - uv
    column, row = np.meshgrid(np.arange(SIZE) + 0.5, np.arange(SIZE) + 0.5)
    u, v = column / SIZE, 1 - row / SIZE
    u, v = (1 - u, 1 - v) if mirror else (u, v)
    angle, height = 2 * np.pi * (u - 0.05) / 0.9 - turn, (v - 0.05) / 0.9
    place = np.stack([np.cos(angle), np.sin(angle), 4 * height], axis=-1)
    inside = (np.abs(u - 0.5) < 0.45) & (np.abs(v - 0.5) < 0.45)
    pixels = np.where(inside[:, :, None], pattern(place, finest=30), 0)
    texture = ArrayTexture((pixels + 0.5).astype(np.uint8))
    if colors is None:
        return TexturedMesh(vertices, faces, uv, face_uv, None, (texture,), None)
    angle = np.arctan2(vertices[:, 1], vertices[:, 0]) - turn
    place = np.stack([np.cos(angle), np.sin(angle), 4 * vertices[:, 2]], axis=-1)
    return TexturedMesh(vertices, faces, colors=pattern(place, finest=8).astype(np.uint8))


def pixels_of(data):
    return np.asarray(PillowImage.open(io.BytesIO(data)).convert("RGB")).astype(float)


TURN = 0.4
OPTIONS = TextureOptions(edge_length=0.02, quality=95)


@pytest.fixture(scope="module")
def turning():
    """Frame 1 has other connectivity, another atlas, and a pattern turned by TURN."""
    meshes = [painted_tube(48, 40, 0.0), painted_tube(52, 37, TURN, mirror=True)]
    first = meshes[0]
    pair = tracked_pair(np.stack([first.vertices] * 2), first.faces, first.uv, first.face_uv)
    return ArrayCapture(meshes), pair


def inside_charts():
    place = (np.arange(SIZE) + 0.5) / SIZE
    good = np.abs(place - 0.5) < 0.44
    return good[:, None] & good[None, :]


def test_every_step_shows_the_pattern_on_its_way(turning):
    capture, pair = turning
    blend = synthesize_textures(capture, pair, 0, 1, 9, OPTIONS)
    assert len(blend.textures) == 9 and blend.texture_suffix == ".jpg" and blend.colors is None
    np.testing.assert_array_equal(blend.uv, pair.uv)
    inside = inside_charts()
    for i in (1, 5, 9):
        truth = painted_tube(8, 8, TURN * i / 10).textures[0].array
        assert psnr(pixels_of(blend.textures[i - 1])[inside], truth[inside]) > 45
    fade = synthesize_textures(capture, pair, 0, 1, 9, dataclasses.replace(OPTIONS, method="crossfade"))
    truth = painted_tube(8, 8, TURN / 2).textures[0].array
    assert psnr(pixels_of(fade.textures[4])[inside], truth[inside]) < 27
    measures = blend.measures
    assert measures["flow_residual_after"] < 0.2 * measures["flow_residual_before"]
    assert measures["holes_start"] == 0 and measures["holes_end"] < 1e-3
    assert measures["seam_color_start"] < 0.5 and measures["seam_color_end"] < 1.5
    assert 0.9 < measures["sharpness"] < 1.1 and fade.measures["sharpness"] < 0.9


def warped_by_a_player(blend, faces, share):
    """What a shader shows at ``share`` of the way: both end textures, looked up at uvs moved along the flow."""
    flow = blend.flow
    owner, weights, _ = cover_texels(to_pixels(blend.uv[blend.face_uv], SIZE, SIZE), SIZE, SIZE)
    covered = owner >= 0
    corners = blend.face_uv[owner[covered]]
    second, third = weights[covered].T.astype(float)
    corner_weights = np.stack([1 - second - third, second, third], axis=1)[:, :, None]
    shown = np.zeros((SIZE, SIZE, 3))
    for image, time, part in zip(flow.textures, (-share, 1 - share), (1 - share, share), strict=True):
        place = ((blend.uv + time * flow.uv_flow)[corners] * corner_weights).sum(axis=1)
        column, row = place[:, 0] * SIZE - 0.5, (1 - place[:, 1]) * SIZE - 0.5
        pixels = pixels_of(image)
        for c in range(3):
            shown[covered, c] += part * nd.map_coordinates(pixels[:, :, c], [row, column], order=1, mode="nearest")
    return shown


def test_a_player_can_warp_both_ends_itself(turning):
    capture, pair = turning
    blend = synthesize_textures(capture, pair, 0, 1, 9, OPTIONS)
    flow, inside = blend.flow, inside_charts()
    truth = pixels_of(synthesize_textures(capture, pair, 1, 1, 1, OPTIONS).textures[0])
    assert psnr(pixels_of(flow.textures[0])[inside], capture.meshes[0].textures[0].array[inside]) > 45
    assert psnr(pixels_of(flow.textures[1])[inside], truth[inside]) > 45
    # Beyond the atlas's own seam a lookup needs the other chart's rim: players see the margin only.
    inner = np.abs((np.arange(SIZE) + 0.5) / SIZE - 0.5) < 0.37
    inner = inner[:, None] & inner[None, :]
    for step in (2, 5, 8):
        assert (
            psnr(warped_by_a_player(blend, pair.faces, step / 10)[inner], pixels_of(blend.textures[step - 1])[inner])
            > 42
        )
    # The flow turns the tube by TURN about its axis, and says so in metres on the template and in its atlas.
    vertices = pair.vertices[0]
    np.testing.assert_allclose(flow.reference, vertices, atol=1e-6)
    around = TURN * np.stack([-vertices[:, 1], vertices[:, 0], np.zeros(len(vertices))], axis=1)
    middle = np.abs(vertices[:, 2] - 0.5) < 0.3
    assert np.linalg.norm(flow.displacement - around, axis=1)[middle].mean() < 0.03 * 0.15 * TURN
    middle = np.abs(blend.uv[:, 1] - 0.5) < 0.3
    expected = [0.9 * TURN / (2 * np.pi), 0]
    assert np.abs(flow.uv_flow[middle] - expected).mean() < 0.03 * expected[0]


def test_a_cross_fade_has_no_flow_but_both_ends(turning):
    blend = synthesize_textures(*turning, 0, 1, 1, dataclasses.replace(OPTIONS, method="crossfade"))
    assert not blend.flow.displacement.any() and not blend.flow.uv_flow.any()
    assert len(blend.flow.textures) == 2 and blend.flow.colors is None


def test_a_frame_projected_onto_itself_stays_as_it_is(turning):
    capture, pair = turning
    blend = synthesize_textures(capture, pair, 0, 0, 1, dataclasses.replace(OPTIONS, quality=100))
    inside = inside_charts()
    assert psnr(pixels_of(blend.textures[0])[inside], capture.meshes[0].textures[0].array[inside]) > 45
    assert blend.measures["seam_color_start"] < 0.5


def test_swapping_ends_reverses_the_sequence_and_repeats_to_the_byte(turning):
    capture, pair = turning
    prepared = build_texture_surface(capture, pair, OPTIONS)
    there = synthesize_textures(capture, pair, 0, 1, 3, OPTIONS, prepared)
    back = synthesize_textures(capture, pair, 1, 0, 3, OPTIONS, prepared)
    again = synthesize_textures(capture, pair, 0, 1, 3, OPTIONS)
    assert there.textures == again.textures and there.measures == again.measures
    for one, other in zip(there.textures, back.textures[::-1], strict=True):
        assert psnr(pixels_of(one), pixels_of(other)) > 50


def test_what_a_frame_does_not_show_is_filled_in_smoothly(turning):
    capture, pair = turning
    mesh = capture.meshes[0]
    middle = mesh.vertices[mesh.faces].mean(axis=1)
    shown = ~((middle[:, 0] > 0) & (np.abs(middle[:, 1]) < 0.05) & (np.abs(middle[:, 2] - 0.5) < 0.1))
    holed = TexturedMesh(mesh.vertices, mesh.faces[shown], mesh.uv, mesh.face_uv[shown], None, mesh.textures, None)
    options = dataclasses.replace(OPTIONS, projection_reach=0.005)
    blend = synthesize_textures(ArrayCapture([mesh, holed]), pair, 1, 1, 1, options)
    assert 0.005 < blend.measures["holes_start"] < 0.05
    filled, truth = pixels_of(blend.textures[0]), mesh.textures[0].array.astype(float)
    inside = inside_charts()
    changed = np.abs(filled - truth).max(axis=2) > 25
    assert (changed & inside).mean() < 0.04
    # Nothing black or glaring has come in.
    assert filled[inside].min() > truth[inside].min() - 10 and filled[inside].max() < truth[inside].max() + 10


def test_odd_atlases_and_other_sizes_make_no_difference(turning):
    """The end's image is half as large and its uvs lie two images to the left; some faces have no area in it."""
    capture, pair = turning
    first, second = capture.meshes
    small = second.textures[0].array.reshape(SIZE // 2, 2, SIZE // 2, 2, 3).mean(axis=(1, 3))
    face_uv = second.face_uv.copy()
    face_uv[::200] = face_uv[::200, :1]
    odd = TexturedMesh(
        second.vertices, second.faces, second.uv - [2, 0], face_uv, None,
        (ArrayTexture(small.round().astype(np.uint8)),), None,
    )  # fmt: skip
    plain = synthesize_textures(capture, pair, 0, 1, 3, OPTIONS)
    found = synthesize_textures(ArrayCapture([first, odd]), pair, 0, 1, 3, OPTIONS)
    inside = inside_charts()
    for one, other in zip(found.textures, plain.textures, strict=True):
        assert psnr(pixels_of(one)[inside], pixels_of(other)[inside]) > 30
    # A template whose uvs leave the image gets an atlas of its own, with every face in it.
    back = synthesize_textures(
        ArrayCapture([odd, first]),
        tracked_pair(np.stack([odd.vertices] * 2), odd.faces, odd.uv, odd.face_uv),
        0, 1, 1, OPTIONS,
    )  # fmt: skip
    assert back.uv.min() >= 0 and back.uv.max() <= 1 and back.face_uv.shape == odd.faces.shape
    assert np.isfinite(back.flow.uv_flow).all() and back.measures["seam_color_start"] < 3


def test_vertex_colours_are_moved_where_there_are_no_images():
    meshes = [painted_tube(96, 80, turn, colors=True) for turn in (0.0, TURN)]
    pair = tracked_pair(
        np.stack([meshes[0].vertices] * 2), meshes[0].faces, np.zeros((0, 2)), np.zeros((0, 3), np.int32)
    )
    blend = synthesize_textures(ArrayCapture(meshes), pair, 0, 1, 3, OPTIONS)
    assert blend.textures == () and blend.colors.shape == (3, len(meshes[0].vertices), 3)
    assert blend.colors.dtype == np.uint8 and blend.uv.shape == (0, 2)
    rim = np.abs(meshes[0].vertices[:, 2] - 0.5) > 0.45
    for i in (1, 2, 3):
        truth = painted_tube(96, 80, TURN * i / 4, colors=True).colors
        assert psnr(blend.colors[i - 1][~rim], truth[~rim]) > 35
    assert blend.flow.textures == () and blend.flow.uv_flow.shape == (0, 2)
    for found, mesh in zip(blend.flow.colors, (meshes[0], painted_tube(96, 80, TURN, colors=True)), strict=True):
        assert psnr(found[~rim], mesh.colors[~rim]) > 50


def test_without_any_colour_the_blend_is_empty():
    vertices, faces = grid(4, 4)
    pair = tracked_pair(np.stack([vertices] * 2), faces, np.zeros((0, 2)), np.zeros((0, 3), np.int32))
    blend = synthesize_textures(ArrayCapture([TexturedMesh(vertices, faces)] * 2), pair, 0, 1, 3, TextureOptions())
    assert blend.textures == () and blend.colors is None and blend.measures == {} and len(blend.uv) == 0
    assert blend.flow is None


@pytest.mark.parametrize("start, end, steps, name", [(-1, 1, 3, "start"), (0, 2, 3, "end"), (0, 1, 0, "steps")])
def test_windows_that_do_not_exist_are_refused(turning, start, end, steps, name):
    with pytest.raises(ValueError, match=name):
        synthesize_textures(*turning, start, end, steps, TextureOptions())


def test_gradient_energy_counts_only_pairs_inside():
    image = np.zeros((4, 6, 3))
    image[:, 3:] = 10
    inside = np.ones((4, 6), bool)
    pairs = 4 * 5 + 3 * 6
    np.testing.assert_allclose(gradient_energy(image, inside), 4 * 100 / pairs)
    inside[:, 3] = False
    assert gradient_energy(image, inside) == 0


def test_jpeg_keeps_colour_at_full_resolution():
    image = np.zeros((32, 32, 3), np.uint8)
    image[:, ::2, 0] = 255
    assert psnr(pixels_of(encode_jpeg(image, 95)), image) > 30

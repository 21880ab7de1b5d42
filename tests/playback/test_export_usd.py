import builtins
import re

import numpy as np
import pytest
from export_frames import FACE_UV, FACES, UV, VERTICES, decoded, export_frame, picture, write
from PIL import Image
from pxr import Usd, UsdGeom, UsdShade, UsdValidation

from unstructured_mg.errors import UserError
from unstructured_mg.playback import export_usd
from unstructured_mg.playback.export import find_format
from unstructured_mg.playback.export_options import ExportOptions
from unstructured_mg.playback.export_usd import USD

PLAIN = {"uv": np.zeros((0, 2)), "face_uv": np.zeros((0, 3), np.int32), "textures": ()}


def turned(angle, x):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0, x], [s, c, 0, 2 * x], [0, 0, 1, 0], [0, 0, 0, 1]])


def opened(folder, frames, **options):
    assert write(USD, folder, frames, **options) == ["walk.usdc"] * len(frames)
    return Usd.Stage.Open(str(folder / "walk.usdc"))


def seen(stage, time):
    """The one mesh that is visible: the mesh, and its corners in the world."""
    (mesh,) = [
        mesh for mesh in map(UsdGeom.Mesh, stage.Traverse())
        if mesh and mesh.ComputeVisibility(time) != UsdGeom.Tokens.invisible
    ]  # fmt: skip
    points = np.array(mesh.GetPointsAttr().Get(time), float)
    matrix = np.array(mesh.ComputeLocalToWorldTransform(time))
    low, high = np.array(mesh.GetExtentAttr().Get(time))
    np.testing.assert_allclose([low, high], [points.min(axis=0), points.max(axis=0)], atol=1e-6)
    assert set(mesh.GetFaceVertexCountsAttr().Get()) == {3}
    faces = np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3)
    return mesh, (points @ matrix[:3, :3] + matrix[3, :3])[faces]


def texture_of(prim, folder):
    material, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()
    surface, _, _ = material.ComputeSurfaceSource()
    (connection,), _ = surface.GetInput("diffuseColor").GetConnectedSources()
    with Image.open(connection.source.GetPrim().GetAttribute("inputs:file").Get().resolvedPath) as image:
        return np.asarray(image.convert("RGB"))


def assert_shows(stage, frames, first_number=1):
    for frame in frames:
        time = first_number + frame.number
        _, corners = seen(stage, time)
        np.testing.assert_allclose(corners, frame.vertices()[frame.faces], atol=2e-6)


def assert_valid(stage):
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    assert len(validators) > 20
    errors = UsdValidation.ValidationContext(validators).Validate(stage)
    assert not errors, [error.GetErrorAsString() for error in errors]


def test_every_frame_is_seen_at_its_time_in_its_place_with_its_picture(tmp_path):
    frames = [export_frame(i, world=turned(0.3 * i, 0.5 * i)) for i in range(5)]
    stage = opened(tmp_path, frames, fps=12.5, first_number=101, up="z", unit=0.01)
    assert UsdGeom.GetStageUpAxis(stage) == "Z" and UsdGeom.GetStageMetersPerUnit(stage) == 0.01
    assert (stage.GetTimeCodesPerSecond(), stage.GetFramesPerSecond()) == (12.5, 12.5)
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (101, 105)
    assert_shows(stage, frames, 101)
    for frame in frames:
        mesh, _ = seen(stage, 101 + frame.number)
        np.testing.assert_allclose(UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st").ComputeFlattened(),
                                   UV[FACE_UV].reshape(-1, 2))  # fmt: skip
        assert mesh.GetSubdivisionSchemeAttr().Get() == "none"
        np.testing.assert_array_equal(texture_of(mesh.GetPrim(), tmp_path), decoded(frame.textures[0]))
    assert_valid(stage)


def test_what_comes_again_is_stored_once_and_moved(tmp_path):
    order = [0, 1, 0, 1, 0, 0]
    frames = [
        export_frame(
            n, key=(k,), own_vertices=VERTICES + k, world=turned(0.5 * min(n, 4), n // 2), textures=(picture(50 * k),)
        )  # fmt: skip
        for n, k in enumerate(order)
    ]
    stage = opened(tmp_path, frames)
    assert_shows(stage, frames)
    meshes = [prim for prim in stage.Traverse() if UsdGeom.Mesh(prim)]
    assert len(meshes) == 2 and len(list(tmp_path.glob("*.png"))) == 2
    # What is visible does not start to move towards where it is next time.
    for frame in frames[:4]:
        np.testing.assert_allclose(seen(stage, frame.number + 1.9)[1], frame.vertices()[FACES], atol=2e-6)
    assert_valid(stage)


@pytest.mark.parametrize("changed", [PLAIN, {"textures": (picture(7),)}])
def test_where_nothing_but_the_points_changes_one_mesh_moves(tmp_path, changed):
    order = [0, 1, 2, 3, 4, 3, 2, 2, 0]
    frames = [export_frame(n, key=(k,), own_vertices=VERTICES * (1 + 0.1 * k), **changed) for n, k in enumerate(order)]
    stage = opened(tmp_path, frames)
    assert_shows(stage, frames)
    (mesh,) = [UsdGeom.Mesh(prim) for prim in stage.Traverse() if UsdGeom.Mesh(prim)]
    assert mesh.GetFaceVertexIndicesAttr().GetNumTimeSamples() == 0
    # Between two frames the points are between; while a frame is held they rest.
    np.testing.assert_allclose(seen(stage, 1.5)[1], (VERTICES * 1.05)[FACES], atol=1e-6)
    np.testing.assert_allclose(seen(stage, 7.5)[1], (VERTICES * 1.2)[FACES], atol=1e-6)
    assert_valid(stage)


def test_a_moving_mesh_that_is_hidden_for_a_while_does_not_creep(tmp_path):
    """Shapes 0 1 of one mesh, another mesh for a time, then shape 0 again."""
    plain = [export_frame(n, key=(k,), own_vertices=VERTICES * (1 + k), **PLAIN) for n, k in ((0, 0), (1, 1), (4, 0))]
    other = [export_frame(n, (picture(5),), key=(9,), own_vertices=VERTICES) for n in (2, 3)]
    frames = [*plain[:2], *other, plain[2]]
    stage = opened(tmp_path, frames)
    assert_shows(stage, frames)
    np.testing.assert_allclose(seen(stage, 2.9)[1], frames[1].vertices()[FACES], atol=1e-6)


def test_materials_are_subsets(tmp_path):
    two = (picture((1, 2, 3), ".jpg"), picture((40, 50, 60)))
    stage = opened(tmp_path, [export_frame(0, two, face_material=np.array([1, 0], np.int32))])
    mesh, _ = seen(stage, 1)
    found = {
        tuple(each.GetIndicesAttr().Get()): texture_of(each.GetPrim(), tmp_path)
        for each in UsdGeom.Subset.GetAllGeomSubsets(mesh)
    }
    np.testing.assert_array_equal(found[(1,)], decoded(two[0]))
    np.testing.assert_array_equal(found[(0,)], decoded(two[1]))
    assert_valid(stage)


def test_colours_are_stored_as_light(tmp_path):
    colors = np.array([[0, 10, 11], [255, 128, 3], [9, 188, 9], [60, 70, 80]], np.uint8)
    stage = opened(tmp_path, [export_frame(0, **PLAIN, colors=colors)])
    light = np.array(seen(stage, 1)[0].GetDisplayColorPrimvar().Get())
    back = np.where(light <= 0.0031308, light * 12.92, 1.055 * np.maximum(light, 1e-9) ** (1 / 2.4) - 0.055)
    np.testing.assert_allclose(back * 255, colors, atol=0.01)
    assert_valid(stage)


def test_saving_on_the_way_changes_nothing(tmp_path, monkeypatch):
    order = [0, 1, 2, 0, 1, 2, 0, 1]
    frames = [export_frame(n, (picture(k),), key=(k,), own_vertices=VERTICES + k, world=turned(0.2 * n, n))
              for n, k in enumerate(order)]  # fmt: skip
    monkeypatch.setattr(export_usd, "SAVED", 2)
    stage = opened(tmp_path, frames)
    assert_shows(stage, frames)


def test_a_missing_package_is_named(monkeypatch):
    original = builtins.__import__

    def absent(name, *rest):
        if name.startswith("pxr"):
            raise ImportError(name)
        return original(name, *rest)

    monkeypatch.setattr(builtins, "__import__", absent)
    with pytest.raises(UserError, match=re.escape("usd-core: pip install 'unstructured_mg[usd]'")):
        find_format(ExportOptions(format="usd"))


def test_an_axis_that_usd_does_not_know_is_refused():
    with pytest.raises(UserError, match="--up -y: the format usd knows y and z only"):
        find_format(ExportOptions(format="usd", up="-y"))


def test_all_that_is_written_counts_as_an_export(tmp_path):
    write(USD, tmp_path, [export_frame(0), export_frame(1, (picture(1), picture(2)), face_material=np.array([0, 1]))])
    assert len(list(tmp_path.iterdir())) == 4
    assert all(re.fullmatch(USD.files, path.name) for path in tmp_path.iterdir())

"""One USD stage with its textures beside it: a mesh for each distinct surface, shown and moved by time samples."""

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from unstructured_mg.errors import UserError
from unstructured_mg.playback.export_format import ExportFrame, Format, Target
from unstructured_mg.playback.stream import EncodedImage

FILE = "walk.usdc"
PLAIN = (0.6, 0.6, 0.6)
SAVED = 16  # frames between two times of writing what there is: it need not stay in memory


@dataclass(frozen=True)
class Piece:
    """A frame as USD stores it. ``surface`` is equal where all but the points is."""

    key: tuple[int, ...]
    number: int
    world: np.ndarray
    points: np.ndarray
    faces: np.ndarray
    uv: np.ndarray
    face_uv: np.ndarray
    face_material: np.ndarray | None
    colors: np.ndarray | None
    textures: tuple[EncodedImage, ...]
    hashes: tuple[bytes, ...]
    surface: bytes


@dataclass
class Prim:
    """A mesh on the stage, and how it was shown last."""

    surface: bytes
    mesh: Any
    move: Any  # its transform
    key: tuple[int, ...]  # the shape it shows
    world: np.ndarray
    last: int  # frame
    held: dict[str, int] = field(default_factory=dict)  # time-sampled attributes, and the time of their last sample


def require_usd() -> None:
    """UserError where the package ``usd-core`` is not there."""
    try:
        import pxr.Usd  # noqa: F401
    except ImportError:
        raise UserError("--format usd needs the package usd-core: pip install 'unstructured_mg[usd]'.") from None


def prepare(frame: ExportFrame, target: Target) -> Piece:
    textured = len(frame.textures) > 0
    face_uv = frame.face_uv if textured else frame.face_uv[:0]
    uv = frame.uv.astype(np.float32) if textured else np.zeros((0, 2), np.float32)
    colors = None if frame.colors is None or textured else _linear(frame.colors)
    hashes = tuple(hashlib.blake2b(texture.data, digest_size=16).digest() for texture in frame.textures)
    surface = hashlib.blake2b(digest_size=16)
    for array in (frame.faces, uv, face_uv, frame.face_material, colors):
        surface.update(b"-" if array is None else repr(array.shape).encode() + array.tobytes())
    for each in hashes:
        surface.update(each)
    return Piece(
        frame.key,
        frame.number,
        frame.world,
        frame.own_vertices.astype(np.float32),
        frame.faces,
        uv,
        face_uv,
        frame.face_material,
        colors,
        frame.textures,
        hashes,
        surface.digest(),
    )


def collect(pieces: Iterator[Piece], target: Target) -> list[str]:
    """Write ``walk.usdc`` and its textures.

    A mesh's connectivity, ``st`` and material are static, so that viewers need no more than visible and invisible
    meshes, moving transforms and, where nothing but the points changes, moving points. What is shown again is stored
    once.
    """
    from pxr import Kind, Usd, UsdGeom

    stage = Usd.Stage.CreateNew(str(target.folder / FILE))
    UsdGeom.SetStageUpAxis(stage, target.space.up.upper())
    UsdGeom.SetStageMetersPerUnit(stage, target.space.unit)
    stage.SetTimeCodesPerSecond(target.fps)
    stage.SetFramesPerSecond(target.fps)
    stage.SetStartTimeCode(target.first_number)
    stage.SetEndTimeCode(target.first_number + target.count - 1)
    root = UsdGeom.Xform.Define(stage, "/walk").GetPrim()
    Usd.ModelAPI(root).SetKind(Kind.Tokens.component)
    stage.SetDefaultPrim(root)
    writer = _Writer(stage, target)
    for count, piece in enumerate(pieces, start=1):
        writer.show(piece)
        if count % SAVED == 0:
            stage.Save()
    stage.Save()
    return [FILE] * target.count


class _Writer:
    def __init__(self, stage: Any, target: Target):
        self.stage, self.target = stage, target
        self.prims: dict[tuple[int, ...], Prim] = {}
        self.visible: Prim | None = None
        self.newest: Prim | None = None
        self.materials: dict[bytes, Any] = {}

    def show(self, piece: Piece) -> None:
        from pxr import UsdGeom

        time = self.target.first_number + piece.number
        prim = self.prims.get(piece.key)
        if prim is None and self.newest is not None and self.newest.surface == piece.surface:
            prim = self.newest
        if prim is None:
            prim = self.newest = self._define(piece)
            if piece.number > 0:
                prim.mesh.CreateVisibilityAttr().Set(UsdGeom.Tokens.invisible, self.target.first_number)
        self.prims[piece.key] = prim
        if prim is not self.visible:
            if self.visible is not None:
                self.visible.mesh.GetVisibilityAttr().Set(UsdGeom.Tokens.invisible, time)
            if piece.number > 0:
                prim.mesh.GetVisibilityAttr().Set(UsdGeom.Tokens.inherited, time)
            else:
                prim.mesh.CreateVisibilityAttr().Set(UsdGeom.Tokens.inherited, time)
            self.visible = prim
        if piece.key != prim.key:
            self._sample(prim, prim.mesh.GetPointsAttr(), _points(piece), time)
            self._sample(prim, prim.mesh.GetExtentAttr(), _extent(piece), time)
            prim.key = piece.key
        if not np.array_equal(piece.world, prim.world):
            self._sample(prim, prim.move.GetAttr(), _matrix(piece.world), time)
            prim.world = piece.world
        prim.last = piece.number

    def _sample(self, prim: Prim, attribute: Any, value: Any, time: int) -> None:
        """A new value from ``time`` on; the one before holds until then where the mesh was hidden or stood still."""
        shown_until = self.target.first_number + prim.last
        until = shown_until if shown_until + 1 == time else shown_until + 1
        sampled = prim.held.get(attribute.GetName())
        if sampled is None or sampled < until:
            attribute.Set(attribute.Get() if sampled is None else attribute.Get(sampled), until)
        attribute.Set(value, time)
        prim.held[attribute.GetName()] = time

    def _define(self, piece: Piece) -> Prim:
        from pxr import Gf, Sdf, UsdGeom, Vt

        mesh = UsdGeom.Mesh.Define(self.stage, f"/walk/{self.target.stem(piece.number)}")
        mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
        mesh.CreateDoubleSidedAttr(True)
        mesh.CreatePointsAttr(_points(piece))
        mesh.CreateExtentAttr(_extent(piece))
        mesh.CreateFaceVertexCountsAttr(Vt.IntArray(len(piece.faces), 3))
        mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(piece.faces.ravel()))
        move = mesh.AddTransformOp()
        move.Set(_matrix(piece.world))
        variables = UsdGeom.PrimvarsAPI(mesh)
        if piece.textures:
            coordinates = variables.CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, UsdGeom.Tokens.faceVarying)
            coordinates.Set(Vt.Vec2fArray.FromNumpy(piece.uv))
            coordinates.SetIndices(Vt.IntArray.FromNumpy(piece.face_uv.ravel()))
            self._bind(mesh, piece)
        elif piece.colors is not None:
            mesh.CreateDisplayColorPrimvar(UsdGeom.Tokens.vertex).Set(Vt.Vec3fArray.FromNumpy(piece.colors))
        else:
            mesh.CreateDisplayColorPrimvar(UsdGeom.Tokens.constant).Set([Gf.Vec3f(*PLAIN)])
        return Prim(piece.surface, mesh, move, piece.key, piece.world, piece.number)

    def _bind(self, mesh: Any, piece: Piece) -> None:
        from pxr import UsdGeom, UsdShade, Vt

        if piece.face_material is None:
            UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(self._material(piece, 0))
            return
        for index in range(len(piece.textures)):
            faces = np.flatnonzero(piece.face_material == index).astype(np.int32)
            if len(faces):
                part = UsdGeom.Subset.CreateGeomSubset(
                    mesh, f"part_{index + 1}", UsdGeom.Tokens.face, Vt.IntArray.FromNumpy(faces),
                    UsdShade.Tokens.materialBind, UsdGeom.Tokens.nonOverlapping,
                )  # fmt: skip
                UsdShade.MaterialBindingAPI.Apply(part.GetPrim()).Bind(self._material(piece, index))

    def _material(self, piece: Piece, index: int) -> Any:
        from pxr import Sdf, UsdShade

        name = piece.hashes[index]
        if name in self.materials:
            return self.materials[name]
        texture, kinds = piece.textures[index], Sdf.ValueTypeNames
        ending = "" if len(piece.textures) == 1 else f"_{index + 1}"
        file = f"{self.target.stem(piece.number)}{ending}{texture.suffix}"
        (self.target.folder / file).write_bytes(texture.data)
        material = UsdShade.Material.Define(self.stage, f"/walk/materials/{self.target.stem(piece.number)}{ending}")
        path = material.GetPath()
        reader = UsdShade.Shader.Define(self.stage, path.AppendChild("uv"))
        reader.CreateIdAttr("UsdPrimvarReader_float2")
        reader.CreateInput("varname", kinds.String).Set("st")
        coordinates = reader.CreateOutput("result", kinds.Float2)
        picture = UsdShade.Shader.Define(self.stage, path.AppendChild("picture"))
        picture.CreateIdAttr("UsdUVTexture")
        picture.CreateInput("file", kinds.Asset).Set(f"./{file}")
        picture.CreateInput("sourceColorSpace", kinds.Token).Set("sRGB")
        for axis in ("wrapS", "wrapT"):
            picture.CreateInput(axis, kinds.Token).Set("repeat")
        picture.CreateInput("st", kinds.Float2).ConnectToSource(coordinates)
        surface = UsdShade.Shader.Define(self.stage, path.AppendChild("surface"))
        surface.CreateIdAttr("UsdPreviewSurface")
        surface.CreateInput("roughness", kinds.Float).Set(1.0)
        surface.CreateInput("diffuseColor", kinds.Color3f).ConnectToSource(picture.CreateOutput("rgb", kinds.Float3))
        material.CreateSurfaceOutput().ConnectToSource(surface.CreateOutput("surface", kinds.Token))
        self.materials[name] = material
        return material


def _points(piece: Piece) -> Any:
    from pxr import Vt

    return Vt.Vec3fArray.FromNumpy(piece.points)


def _extent(piece: Piece) -> Any:
    from pxr import Vt

    return Vt.Vec3fArray.FromNumpy(np.stack([piece.points.min(axis=0), piece.points.max(axis=0)]))


def _matrix(world: np.ndarray) -> Any:
    from pxr import Gf

    return Gf.Matrix4d(world.T.tolist())  # USD's matrices act on row vectors


def _linear(colors: np.ndarray) -> np.ndarray:
    """sRGB bytes to linear light, which displayColor holds."""
    s = np.arange(256) / 255
    light = np.where(s <= 0.04045, s / 12.92, ((s + 0.055) / 1.055) ** 2.4)
    return light.astype(np.float32)[colors]


USD = Format("usd", r"walk\.usdc|frame_\d{5,}(_\d+)?\.\w+", prepare, collect, require=require_usd, axes=("y", "z"))

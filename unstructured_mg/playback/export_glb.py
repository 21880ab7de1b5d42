"""One GLB: a node for every distinct frame, shown and placed by an animation in steps."""

import hashlib
import io
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from PIL import Image
from scipy.spatial.transform import Rotation

from unstructured_mg.geometry.split_seams import split_seams
from unstructured_mg.playback.export_format import ExportFrame, Format, Target
from unstructured_mg.playback.glb_file import INDICES, VERTICES, GlbFile
from unstructured_mg.playback.stream import EncodedImage

FILE = "walk.glb"
MOST_SHAPES = 64  # frames that one mesh holds: its own shape and its morph targets
# Captured colours carry their own light; what has none is lit.
UNLIT: dict[str, Any] = {"extensions": {"KHR_materials_unlit": {}}}
PLAIN = {"baseColorFactor": [0.6, 0.6, 0.6, 1.0], "metallicFactor": 0.0, "roughnessFactor": 1.0}


@dataclass(frozen=True)
class Piece:
    """A frame as glTF stores it: one uv a vertex, v downwards, indices by material, images as JPEG or PNG.

    ``connectivity`` is equal where indices, uvs, colours and textures are.
    """

    key: tuple[int, ...]
    number: int
    world: np.ndarray
    positions: np.ndarray
    indices: tuple[np.ndarray, ...]
    uv: np.ndarray
    colors: np.ndarray | None
    images: tuple[tuple[bytes, bytes, str], ...]  # hash, data, media type
    surface: bytes
    connectivity: bytes


@dataclass
class Node:
    """A mesh under way: its shapes' accessors, and when and where each is shown."""

    connectivity: bytes
    base: np.ndarray
    primitives: list[dict[str, Any]]
    targets: list[int] = field(default_factory=list)
    shown: list[tuple[int, int, np.ndarray]] = field(default_factory=list)  # frame, shape, world


def prepare(frame: ExportFrame, target: Target) -> Piece:
    vertex_index, uv_index, faces = split_seams(frame.faces, frame.face_uv if frame.textures else frame.face_uv[:0])
    uv = frame.uv[uv_index].astype(np.float32)
    uv[:, 1] = 1 - uv[:, 1]
    kind = np.uint16 if len(vertex_index) < 65535 else np.uint32
    groups = [faces]
    if frame.face_material is not None:
        groups = [faces[frame.face_material == material] for material in range(len(frame.textures))]
    colors = None if frame.colors is None or frame.textures else _linear(frame.colors[vertex_index])
    images = tuple(_image(texture) for texture in frame.textures)
    surface, connectivity = hashlib.blake2b(digest_size=16), hashlib.blake2b(digest_size=16)
    indices = tuple(np.ascontiguousarray(group.ravel().astype(kind)) for group in groups)
    for array in (*indices, uv):
        surface.update(repr(array.shape).encode() + array.tobytes())
    connectivity.update(surface.digest())
    for data in (b"" if colors is None else colors.tobytes(), *(image[0] for image in images)):
        connectivity.update(data)
    return Piece(
        frame.key,
        frame.number,
        frame.world,
        frame.own_vertices[vertex_index].astype(np.float32),
        indices,
        uv,
        colors,
        images,
        surface.digest(),
        connectivity.digest(),
    )


def collect(pieces: Iterator[Piece], target: Target) -> list[str]:
    """Write ``walk.glb``.

    Frames of the same content are one shape, wherever and however often they are shown: nodes move, vertices do not.
    Frames that follow each other with the same connectivity and textures are morph targets of one mesh; where only the
    textures change, as in a transition, meshes share their indices and uvs.
    """
    with GlbFile(target.folder / FILE) as glb:
        writer = _Writer(glb, target.fps)
        count = 0
        for piece in pieces:
            writer.show(piece)
            count += 1
        writer.finish(count)
    return [FILE] * count


class _Writer:
    def __init__(self, glb: GlbFile, fps: float):
        self.glb, self.fps = glb, fps
        self.nodes: list[Node] = []
        self.shapes: dict[tuple[int, ...], tuple[int, int]] = {}
        self.surfaces: dict[bytes, tuple[tuple[int, ...], int | None]] = {}
        self.materials: dict[bytes, int] = {}
        self.used_unlit = False

    def show(self, piece: Piece) -> None:
        node, shape = self.shapes.get(piece.key) or self._store(piece)
        self.shapes[piece.key] = node, shape
        self.nodes[node].shown.append((piece.number, shape, piece.world))

    def _store(self, piece: Piece) -> tuple[int, int]:
        last = self.nodes[-1] if self.nodes else None
        if last and last.connectivity == piece.connectivity and len(last.targets) < MOST_SHAPES - 1:
            last.targets.append(self.glb.add_array(piece.positions - last.base, VERTICES, bounds=True))
            return len(self.nodes) - 1, len(last.targets)
        if last:
            last.base = np.zeros((0, 3), np.float32)  # no more shapes will come
        attributes = {"POSITION": self.glb.add_array(piece.positions, VERTICES, bounds=True)}
        if piece.surface not in self.surfaces:
            indices = tuple(self.glb.add_array(each, INDICES) if len(each) else -1 for each in piece.indices)
            uv = self.glb.add_array(piece.uv, VERTICES) if len(piece.uv) else None
            self.surfaces[piece.surface] = indices, uv
        indices, shared_uv = self.surfaces[piece.surface]
        if shared_uv is not None:
            attributes["TEXCOORD_0"] = shared_uv
        if piece.colors is not None:
            attributes["COLOR_0"] = self.glb.add_array(piece.colors, VERTICES, normalized=True)
        primitives = [
            {"attributes": attributes, "indices": each, "material": self._material(piece, number)}
            for number, each in enumerate(indices)
            if each >= 0
        ]
        self.nodes.append(Node(piece.connectivity, piece.positions, primitives))
        return len(self.nodes) - 1, 0

    def _material(self, piece: Piece, number: int) -> int:
        if piece.images:
            name, data, media = piece.images[number]
        else:
            name = b"plain" if piece.colors is None else b"colours"
        if name not in self.materials:
            material: dict[str, Any] = {"doubleSided": True}
            if piece.images:
                view = self.glb.add_bytes(data)
                image = self.glb.add("images", {"bufferView": view, "mimeType": media})
                texture = self.glb.add("textures", {"source": image})
                surface = {"baseColorTexture": {"index": texture}, "metallicFactor": 0.0, "roughnessFactor": 1.0}
                material |= {**UNLIT, "pbrMetallicRoughness": surface}
            elif piece.colors is not None:
                material |= {**UNLIT, "pbrMetallicRoughness": {"metallicFactor": 0.0, "roughnessFactor": 1.0}}
            else:
                material["pbrMetallicRoughness"] = PLAIN
            self.used_unlit |= "extensions" in material
            self.materials[name] = self.glb.add("materials", material)
        return self.materials[name]

    def finish(self, count: int) -> None:
        self.samplers: list[dict[str, Any]] = []
        self.channels: list[dict[str, Any]] = []
        children = [self._node(index, node, count) for index, node in enumerate(self.nodes)]
        root = self.glb.add("nodes", {"name": "walk", "children": children})
        self.glb.add("scenes", {"nodes": [root]})
        if self.channels:
            self.glb.add("animations", {"name": "walk", "samplers": self.samplers, "channels": self.channels})
        used = {"extensionsUsed": ["KHR_materials_unlit"]} if self.used_unlit else {}
        self.glb.finish(asset={"version": "2.0", "generator": "unstructured_mg"}, scene=0, **used)

    def _node(self, index: int, node: Node, count: int) -> int:
        mesh: dict[str, Any] = {"primitives": node.primitives}
        if node.targets:
            for primitive in node.primitives:
                primitive["targets"] = [{"POSITION": each} for each in node.targets]
            mesh["weights"] = [0.0] * len(node.targets)
        frames = np.array([frame for frame, _, _ in node.shown])
        shown_first = frames[0] == 0
        first, *_ = node.shown
        place = {"mesh": self.glb.add("meshes", mesh), "name": f"frame_{first[0] + 1:05d}"}
        place |= _placed(first[2], shown_first)
        node_index = self.glb.add("nodes", place)
        # Visible from each run of frames' first to the first after it.
        starts = frames[np.flatnonzero(np.diff(frames, prepend=-2) > 1)]
        ends = frames[np.flatnonzero(np.diff(frames, append=count + 1) > 1)] + 1
        switches = [(0, 0.0)] if not shown_first else []
        for start, end in zip(starts.tolist(), ends.tolist(), strict=True):
            switches += [(start, 1.0), (end, 1.0 if end == count else 0.0)]
        if len({value for _, value in switches}) > 1 or count > 1:
            self._channel(node_index, "scale", [at for at, _ in switches], [[value] * 3 for _, value in switches])
        changes = [shown for last, shown in zip([None, *node.shown[:-1]], node.shown, strict=True)
                   if last is None or shown[1] != last[1]]  # fmt: skip
        if node.targets:
            rows = np.eye(len(node.targets) + 1, dtype=np.float32)[[shape for _, shape, _ in changes]][:, 1:]
            self._channel(node_index, "weights", [frame for frame, _, _ in changes], rows)
        moves = [shown for last, shown in zip([None, *node.shown[:-1]], node.shown, strict=True)
                 if last is None or (shown[2] != last[2]).any()]  # fmt: skip
        if len(moves) > 1:
            worlds = np.stack([world for _, _, world in moves])
            times = [frame for frame, _, _ in moves]
            self._channel(node_index, "translation", times, worlds[:, :3, 3])
            self._channel(node_index, "rotation", times, Rotation.from_matrix(worlds[:, :3, :3]).as_quat())
        return node_index

    def _channel(self, node: int, path: str, frames: list[int], values: Any) -> None:
        times = self.glb.add_array(np.array(frames, np.float32) / np.float32(self.fps), bounds=True)
        rows = np.asarray(values, np.float32)
        output = self.glb.add_array(rows.ravel() if path == "weights" else rows)
        self.samplers.append({"input": times, "output": output, "interpolation": "STEP"})
        self.channels.append({"sampler": len(self.samplers) - 1, "target": {"node": node, "path": path}})


def _placed(world: np.ndarray, visible: bool) -> dict[str, Any]:
    place: dict[str, Any] = {} if visible else {"scale": [0.0, 0.0, 0.0]}
    if not np.array_equal(world, np.eye(4)):
        place["translation"] = world[:3, 3].tolist()
        place["rotation"] = Rotation.from_matrix(world[:3, :3]).as_quat().tolist()
    return place


def _linear(colors: np.ndarray) -> np.ndarray:
    """sRGB bytes to what glTF's COLOR_0 holds: linear light with alpha, here as (n, 4) uint16."""
    s = np.arange(256) / 255
    light = np.where(s <= 0.04045, s / 12.92, ((s + 0.055) / 1.055) ** 2.4)
    table = np.round(light * 65535).astype(np.uint16)
    return np.column_stack([table[colors], np.full(len(colors), 65535, np.uint16)])


def _image(texture: EncodedImage) -> tuple[bytes, bytes, str]:
    """Hash, data and media type; what is neither JPEG nor PNG becomes PNG."""
    data = texture.data
    if not data.startswith((b"\xff\xd8\xff", b"\x89PNG\r\n\x1a\n")):
        encoded = io.BytesIO()
        with Image.open(io.BytesIO(data)) as image:
            image.convert("RGB").save(encoded, "PNG")
        data = encoded.getvalue()
    media = "image/jpeg" if data.startswith(b"\xff\xd8\xff") else "image/png"
    return hashlib.blake2b(data, digest_size=16).digest(), data, media


GLB = Format(
    "glb", r"walk\.glb", prepare, collect, unused={"first_number": "its frames have no numbers"}, space=("y", 1.0)
)

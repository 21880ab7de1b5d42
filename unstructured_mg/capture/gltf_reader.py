"""glTF 2 scenes to meshes: one frame a file, or many in one as animated, hidden, bent or numbered meshes."""

from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np

from unstructured_mg.capture.draco import decode_draco
from unstructured_mg.capture.frame_error import FrameError
from unstructured_mg.capture.gltf_animation import Channel, frame_times, read_channels, state_at
from unstructured_mg.capture.gltf_file import (
    REMEDY,
    Gltf,
    is_index,
    open_gltf,
    read_accessor,
    read_view,
    view_stretch,
)
from unstructured_mg.capture.numbering import frame_numbers
from unstructured_mg.capture.paths import capture_roots, find_named
from unstructured_mg.capture.raw_mesh import RawMesh
from unstructured_mg.capture.texture import Texture

_DEEPEST = 256
_ENDINGS = {"image/png": ".png", "image/jpeg": ".jpg", "image/webp": ".webp"}
_TRIANGLES, _STRIP, _FAN = 4, 5, 6


@dataclass(frozen=True)
class GltfFrames:
    """The frames in one file: their numbers and rate, seconds between them, and, for each, its moment or its node."""

    numbers: tuple[int, ...]
    fps: float | None
    step: float = 0.0
    times: tuple[float, ...] = ()
    nodes: tuple[int, ...] = ()


@dataclass
class _Pieces:
    """What is gathered of a frame, piece by piece."""

    vertices: list[np.ndarray] = field(default_factory=list)
    faces: list[np.ndarray] = field(default_factory=list)
    uv: list[np.ndarray | None] = field(default_factory=list)
    colors: list[np.ndarray | None] = field(default_factory=list)
    images: list[Texture | None] = field(default_factory=list)
    files: list[Path] = field(default_factory=list)


def list_gltf(path: Path, folder: Path) -> GltfFrames | None:
    """The frames of a file that holds several: moments of its animation, else meshes with numbers in their names.

    None where it is a single frame. Raises FrameError as ``open_gltf``.
    """
    gltf = open_gltf(path, folder)
    return _frames(gltf)


@lru_cache(maxsize=4)
def _frames(gltf: Gltf) -> GltfFrames | None:
    channels = _channels(gltf)
    times = frame_times(gltf, channels)
    if len(times) > 1:
        step = (times[-1] - times[0]) / (len(times) - 1)
        if not _visible(gltf, state_at(channels, float(times[-1]), step / 100)):
            times = times[:-1]  # it only hides the frame before it
        # key frames have single precision: a rate that is within that of a whole number, or of 1/100, is meant to be it
        fps = round(1 / step, 2) if abs(step * round(1 / step, 2) - 1) < 1e-3 else 1 / step
        return GltfFrames(tuple(range(len(times))), fps, step, times=tuple(times.tolist()))
    nodes = [(index, str(node.get("name", ""))) for index, node in _mesh_nodes(gltf)]
    numbers = frame_numbers([name + "." for _, name in nodes])
    values = [numbers.get(name + ".") for _, name in nodes]
    if len(nodes) > 1 and None not in values and len(set(values)) == len(nodes) and _one_pattern(nodes):
        ordered = sorted((value, index) for value, (index, _) in zip(values, nodes, strict=True) if value is not None)
        return GltfFrames(tuple(value for value, _ in ordered), None, nodes=tuple(index for _, index in ordered))
    return None


def _one_pattern(nodes: list[tuple[int, str]]) -> bool:
    return len({"".join(letter for letter in name if not letter.isdigit()) for _, name in nodes}) == 1


@lru_cache(maxsize=4)
def _channels(gltf: Gltf) -> tuple[Channel, ...]:
    return read_channels(gltf)


def read_gltf(path: Path, folder: Path, part: int | None = None) -> RawMesh:
    """Read frame ``part`` of a file that holds several, or the whole scene; y up, v turned upwards.

    Understood: nodes with transforms and visibility, several meshes and primitives (joined), morph targets, animations
    (STEP and LINEAR), uvs, vertex colours, base colour textures (inside or beside the file; PNG, JPEG, WebP, KTX2),
    texture transforms, quantised and sparse accessors, Draco. Skins are not.

    Raises
    ------
    FrameError : as ``open_gltf``; also where the frame holds no triangles, an index is out of range, an image is not
        there, or something needed is not understood
    """
    gltf = open_gltf(path, folder)
    frames = _frames(gltf) if part is not None else None
    channels = _channels(gltf)
    state: dict[tuple[int, str], np.ndarray] = {}
    only = None
    if frames is not None and part is not None and part < len(frames.numbers):
        if frames.times:
            state = state_at(channels, frames.times[part], frames.step / 100)
        else:
            only = frames.nodes[part]
    elif part is not None:
        raise FrameError(path, f"it has no frame {part} any more", "inspect the capture again")
    elif channels:
        state = state_at(channels, min(channel.times[0] for channel in channels), 0.0)
    pieces = _Pieces()
    for index, world in _visible(gltf, state):
        if only is None or index == only:
            _add_mesh(gltf, folder, gltf.item("nodes", index), world, state.get((index, "weights")), pieces)
    if not pieces.faces:
        raise FrameError(path, "it holds no triangles" + ("" if part is None else f" at frame {part}"), REMEDY)
    return _joined(gltf, pieces)


def _joined(gltf: Gltf, pieces: _Pieces) -> RawMesh:
    counts = [len(vertices) for vertices in pieces.vertices]
    starts = np.cumsum([0, *counts[:-1]])
    faces = np.concatenate([part + start for part, start in zip(pieces.faces, starts, strict=True)]).astype(np.int32)
    uv = np.concatenate([np.zeros((n, 2)) if part is None else part for part, n in zip(pieces.uv, counts, strict=True)])
    lacking = np.repeat([part is None for part in pieces.uv], [len(part) for part in pieces.faces])
    colors = None
    if any(part is not None for part in pieces.colors):
        colors = np.concatenate(
            [
                np.full((n, 3), 255, np.uint8) if part is None else part
                for part, n in zip(pieces.colors, counts, strict=True)
            ]
        )
    images = tuple(dict.fromkeys(image for image in pieces.images if image is not None))
    image_of = [-1 if image is None else images.index(image) for image in pieces.images]
    return RawMesh(
        vertices=np.concatenate(pieces.vertices),
        faces=faces,
        uv=uv,
        face_uv=np.where(lacking[:, None], -1, faces).astype(np.int32),
        colors=colors,
        images=images,
        face_image=np.repeat(image_of, [len(part) for part in pieces.faces]).astype(np.int32),
        files=tuple(dict.fromkeys([*gltf.files(), *pieces.files, *(image.path for image in images)])),
    )


def _mesh_nodes(gltf: Gltf) -> list[tuple[int, dict[str, Any]]]:
    """Every node of the scene that has a mesh, in order."""
    found = []
    for index, _ in _walk(gltf, {}):
        node = gltf.item("nodes", index)
        if "mesh" in node:
            found.append((index, node))
    return found


def _visible(gltf: Gltf, state: dict[tuple[int, str], np.ndarray]) -> list[tuple[int, np.ndarray]]:
    """Nodes with a mesh that are shown, and their transforms."""
    found = []
    for index, world in _walk(gltf, state):
        if "mesh" in gltf.item("nodes", index) and abs(np.linalg.det(world[:3, :3])) > 1e-12:
            found.append((index, world))
    return found


def _walk(gltf: Gltf, state: dict[tuple[int, str], np.ndarray]) -> list[tuple[int, np.ndarray]]:
    """The scene's nodes in order, those below a hidden one left out, with their transforms to the world."""
    scenes = gltf.data.get("scenes")
    if isinstance(scenes, list) and scenes:
        roots = gltf.item("scenes", gltf.data.get("scene", 0)).get("nodes", [])
    else:
        roots = list(range(len(gltf.data.get("nodes", []))))
    walked: list[tuple[int, np.ndarray]] = []
    seen: set[int] = set()
    waiting = [(root, np.eye(4), 0) for root in reversed(roots if isinstance(roots, list) else [])]
    while waiting:
        index, above, depth = waiting.pop()
        node = gltf.item("nodes", index)
        if index in seen or depth > _DEEPEST:
            raise FrameError(gltf.path, f"nodes[{index}] stands below itself, or twice in the scene", REMEDY)
        seen.add(index)
        extension = node.get("extensions", {})
        shown = extension.get("KHR_node_visibility", {}).get("visible", True) if isinstance(extension, dict) else True
        if not state.get((index, "visible"), np.array([shown]))[0]:
            continue
        if (index, "scale") in state and not state[index, "scale"].any():
            continue
        world = above @ _local(gltf, index, node, state)
        walked.append((index, world))
        children = node.get("children", [])
        waiting += [(child, world, depth + 1) for child in reversed(children if isinstance(children, list) else [])]
    return walked


def _local(gltf: Gltf, index: int, node: dict[str, Any], state: dict[tuple[int, str], np.ndarray]) -> np.ndarray:
    def vector(name: str, default: list[float]) -> np.ndarray:
        value = state.get((index, name), node.get(name, default))
        try:
            array = np.asarray(value, np.float64).ravel()
        except (TypeError, ValueError):
            array = np.zeros(0)
        if len(array) != len(default) or not np.isfinite(array).all():
            raise FrameError(gltf.path, f"nodes[{index}]: expected {len(default)} numbers for its {name}", REMEDY)
        return array

    if "matrix" in node:
        return vector("matrix", np.eye(4).ravel().tolist()).reshape(4, 4).T
    x, y, z, w = vector("rotation", [0, 0, 0, 1])
    local = np.eye(4)
    local[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    local[:3, :3] *= vector("scale", [1, 1, 1])
    local[:3, 3] = vector("translation", [0, 0, 0])
    return local


def _add_mesh(
    gltf: Gltf,
    folder: Path,
    node: dict[str, Any],
    world: np.ndarray,
    weights: np.ndarray | None,
    pieces: _Pieces,
) -> None:
    if "skin" in node:
        raise FrameError(
            gltf.path, "it bends its mesh by a skin, which is not supported", "export the frames as meshes"
        )
    mesh = gltf.item("meshes", node["mesh"])
    if weights is None:
        weights = np.asarray(node.get("weights", mesh.get("weights", [])), np.float64).ravel()
    primitives = mesh.get("primitives", [])
    for number, primitive in enumerate(primitives if isinstance(primitives, list) else []):
        where = f"meshes[{node['mesh']}].primitives[{number}]"
        if not isinstance(primitive, dict) or not isinstance(primitive.get("attributes"), dict):
            raise FrameError(gltf.path, f"{where} has no attributes", REMEDY)
        if primitive.get("mode", _TRIANGLES) not in (_TRIANGLES, _STRIP, _FAN):
            continue
        arrays = _Arrays.of(gltf, primitive)
        points, faces = arrays.points("POSITION"), arrays.faces(where)
        points = _bent(gltf, primitive, points, weights, where)
        if len(faces) == 0:
            continue
        if faces.max() >= len(points):
            raise FrameError(gltf.path, f"{where} names vertex {faces.max()}, but has {len(points)}", REMEDY)
        if np.linalg.det(world[:3, :3]) < 0:
            faces = faces[:, ::-1]
        image, transform, uv_set = _material(gltf, folder, primitive.get("material"))
        uv = arrays.optional(f"TEXCOORD_{uv_set}", ("VEC2",))
        colors = arrays.optional("COLOR_0", ("VEC3", "VEC4"))
        for name, values in (("TEXCOORD", uv), ("COLOR", colors)):
            if values is not None and len(values) != len(points):
                raise FrameError(gltf.path, f"{where} has {len(values)} {name} for {len(points)} positions", REMEDY)
        if uv is not None:
            uv = (np.column_stack([uv, np.ones(len(uv))]) @ transform.T)[:, :2] * [1, -1] + [0, 1]
        pieces.vertices.append(points @ world[:3, :3].T + world[:3, 3])
        pieces.faces.append(faces)
        pieces.uv.append(uv)
        pieces.colors.append(None if colors is None else _srgb(colors[:, :3]))
        pieces.images.append(image)


@dataclass(frozen=True)
class _Arrays:
    """A primitive's arrays, from accessors or out of Draco."""

    gltf: Gltf
    primitive: dict[str, Any]
    packed: dict[str, np.ndarray]
    packed_faces: np.ndarray | None

    @staticmethod
    def of(gltf: Gltf, primitive: dict[str, Any]) -> "_Arrays":
        extensions = primitive.get("extensions", {})
        draco = extensions.get("KHR_draco_mesh_compression") if isinstance(extensions, dict) else None
        if not isinstance(draco, dict):
            return _Arrays(gltf, primitive, {}, None)
        _, start, _ = view_stretch(gltf, draco.get("bufferView"))
        mesh = decode_draco(gltf.path, start, read_view(gltf, draco.get("bufferView")))
        names = draco.get("attributes", {})
        packed = {name: mesh.attributes[number] for name, number in names.items() if number in mesh.attributes}
        for name, values in packed.items():
            item = gltf.item("accessors", primitive["attributes"].get(name))
            if item.get("normalized") and values.dtype.kind in "iu":
                packed[name] = values / np.iinfo(values.dtype).max
        return _Arrays(gltf, primitive, packed, mesh.faces)

    def points(self, name: str) -> np.ndarray:
        values = self.optional(name, ("VEC3",))
        if values is None:
            raise FrameError(self.gltf.path, "a primitive of it has no positions", REMEDY)
        return values.astype(np.float64)

    def optional(self, name: str, kinds: tuple[str, ...]) -> np.ndarray | None:
        if name in self.packed:
            return self.packed[name].astype(np.float64)
        index = self.primitive["attributes"].get(name)
        if index is None:
            return None
        values = read_accessor(self.gltf, index, kinds)
        return values.astype(np.float64)

    def faces(self, where: str) -> np.ndarray:
        if self.packed_faces is not None:
            return self.packed_faces
        index = self.primitive.get("indices")
        if index is None:
            corners = np.arange(len(self.points("POSITION")))
        else:
            corners = read_accessor(self.gltf, index, ("SCALAR",))
            if corners.dtype.kind != "u":
                raise FrameError(self.gltf.path, f"{where}: expected indices of an unsigned type", REMEDY)
            corners = corners.astype(np.int64)
        mode = self.primitive.get("mode", _TRIANGLES)
        if mode == _TRIANGLES:
            if len(corners) % 3:
                raise FrameError(self.gltf.path, f"{where}: expected triangles, found {len(corners)} indices", REMEDY)
            return corners.reshape(-1, 3)
        if mode == _FAN:
            return np.column_stack([np.full(max(len(corners) - 2, 0), corners[0]), corners[1:-1], corners[2:]])
        strip = np.column_stack([corners[:-2], corners[1:-1], corners[2:]])
        strip[1::2] = strip[1::2, [1, 0, 2]]
        return strip


def _bent(gltf: Gltf, primitive: dict[str, Any], points: np.ndarray, weights: np.ndarray, where: str) -> np.ndarray:
    targets = primitive.get("targets", [])
    for target, weight in zip(targets if isinstance(targets, list) else [], weights, strict=False):
        if weight == 0 or not isinstance(target, dict) or "POSITION" not in target:
            continue
        moved = read_accessor(gltf, target["POSITION"], ("VEC3",))
        if len(moved) != len(points):
            raise FrameError(gltf.path, f"{where}: a morph target has {len(moved)} rows for {len(points)}", REMEDY)
        points = points + weight * moved
    return points


def _material(gltf: Gltf, folder: Path, index: Any) -> tuple[Texture | None, np.ndarray, int]:
    """The base colour's image, the transform of its uvs, and which uvs it has."""
    if index is None:
        return None, np.eye(3), 0
    material = gltf.item("materials", index)
    roughness = material.get("pbrMetallicRoughness", {})
    info = roughness.get("baseColorTexture") if isinstance(roughness, dict) else None
    if not isinstance(info, dict):
        return None, np.eye(3), 0
    uv_set = info.get("texCoord", 0)
    extension = info.get("extensions", {}).get("KHR_texture_transform", {})
    transform = np.eye(3)
    if extension:
        try:
            angle = float(extension.get("rotation", 0))
            scale, offset = (
                np.array(extension.get("scale", [1, 1]), float),
                np.array(extension.get("offset", [0, 0]), float),
            )
            turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
            transform[:2, :2], transform[:2, 2] = turn * scale, offset
        except (TypeError, ValueError):
            raise FrameError(
                gltf.path, f"materials[{index}]: its texture's transform is not readable", REMEDY
            ) from None
        uv_set = extension.get("texCoord", uv_set)
    return _image(gltf, folder, info.get("index")), transform, uv_set if is_index(uv_set) else 0


def _image(gltf: Gltf, folder: Path, index: Any) -> Texture:
    texture = gltf.item("textures", index)
    extensions = texture.get("extensions", {})
    basis = extensions.get("KHR_texture_basisu", {}).get("source")
    source = texture.get("source", extensions.get("EXT_texture_webp", {}).get("source"))
    number = basis if source is None else source
    image = gltf.item("images", number)
    if "bufferView" in image:
        buffer, start, size = view_stretch(gltf, image["bufferView"])
        if buffer.data is not None:
            raise FrameError(gltf.path, "its texture is written into it as text", "export it as .glb")
        if source is None or image.get("mimeType") == "image/ktx2":
            return Texture(buffer.path, start, size, "basis")
        return Texture(buffer.path, start, size, ending=_ENDINGS.get(str(image.get("mimeType")), ".png"))
    uri = image.get("uri")
    if not isinstance(uri, str) or uri.startswith("data:"):
        raise FrameError(gltf.path, f"images[{number}] is written into it as text, or nowhere", "export it as .glb")
    file = find_named(unquote(uri), gltf.path, capture_roots(gltf.path, folder))
    if file is None:
        raise FrameError(gltf.path, f'its texture "{uri}" is not there', "put the image beside it")
    return Texture(file, coding="basis" if file.suffix.lower() in (".ktx2", ".basis") else "image")


def _srgb(linear: np.ndarray) -> np.ndarray:
    """glTF's vertex colours, which are linear (floats 0..1), to sRGB bytes."""
    linear = np.clip(np.nan_to_num(linear), 0, 1)
    encoded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    return np.rint(255 * encoded).astype(np.uint8)

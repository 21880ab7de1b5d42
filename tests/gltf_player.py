"""Plays a GLB: what a viewer must show at a time, straight from the specification."""

import io
import json
import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image
from scipy.spatial.transform import Rotation

TYPES = {5121: np.uint8, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
ROWS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


@dataclass(frozen=True)
class Shown:
    """One visible primitive: world vertices, corners, attributes, and its material's picture."""

    vertices: np.ndarray
    faces: np.ndarray
    uv: np.ndarray | None
    colors: np.ndarray | None
    picture: np.ndarray | None


class GltfPlayer:
    def __init__(self, path: Path):
        data = path.read_bytes()
        magic, version, length = struct.unpack_from("<4sII", data)
        assert (magic, version, length) == (b"glTF", 2, len(data))
        size, kind = struct.unpack_from("<I4s", data, 12)
        assert kind == b"JSON"
        self.gltf: dict[str, Any] = json.loads(data[20 : 20 + size])
        size_of_binary, kind = struct.unpack_from("<I4s", data, 20 + size)
        assert kind == b"BIN\0"
        self.binary = data[28 + size : 28 + size + size_of_binary]

    def view(self, index: int) -> bytes:
        view = self.gltf["bufferViews"][index]
        return self.binary[view.get("byteOffset", 0) :][: view["byteLength"]]

    def array(self, index: int) -> np.ndarray:
        accessor = self.gltf["accessors"][index]
        rows = ROWS[accessor["type"]]
        values = np.frombuffer(self.view(accessor["bufferView"]), TYPES[accessor["componentType"]],
                               accessor["count"] * rows, accessor.get("byteOffset", 0)).reshape(-1, rows)  # fmt: skip
        if accessor.get("normalized"):
            return values / np.iinfo(values.dtype).max
        return values[:, 0] if rows == 1 else values

    def shown(self, time: float) -> list[Shown]:
        """What is not scaled to nothing at ``time``, in seconds."""
        state = [dict(node) for node in self.gltf["nodes"]]
        for node in state:
            if "mesh" in node:
                node["weights"] = self.gltf["meshes"][node["mesh"]].get("weights", [])
        for animation in self.gltf.get("animations", []):
            for channel in animation["channels"]:
                sampler = animation["samplers"][channel["sampler"]]
                assert sampler["interpolation"] == "STEP"
                times, values = self.array(sampler["input"]), self.array(sampler["output"])
                step = max(int(np.searchsorted(times, time, side="right")) - 1, 0)
                values = values.reshape(len(times), -1)
                state[channel["target"]["node"]][channel["target"]["path"]] = values[step]
        return [each for root in self.gltf["scenes"][0]["nodes"] for each in self._below(state, root, np.eye(4))]

    def _below(self, state: list[dict[str, Any]], index: int, parent: np.ndarray) -> list[Shown]:
        node = state[index]
        scale = np.asarray(node.get("scale", [1, 1, 1]), float)
        matrix = np.eye(4)
        matrix[:3, :3] = Rotation.from_quat(node.get("rotation", [0, 0, 0, 1])).as_matrix() * scale
        matrix[:3, 3] = node.get("translation", [0, 0, 0])
        matrix = parent @ matrix
        if not scale.any():
            return []
        found = [each for child in node.get("children", []) for each in self._below(state, child, matrix)]
        if "mesh" in node:
            found += [self._primitive(each, node["weights"], matrix) for each in
                      self.gltf["meshes"][node["mesh"]]["primitives"]]  # fmt: skip
        return found

    def _primitive(self, primitive: dict[str, Any], weights: np.ndarray, matrix: np.ndarray) -> Shown:
        attributes = primitive["attributes"]
        positions = self.array(attributes["POSITION"]).astype(float)
        for weight, target in zip(weights, primitive.get("targets", []), strict=True):
            positions = positions + weight * self.array(target["POSITION"])
        material = self.gltf["materials"][primitive["material"]]
        texture = material["pbrMetallicRoughness"].get("baseColorTexture")
        return Shown(
            positions @ matrix[:3, :3].T + matrix[:3, 3],
            self.array(primitive["indices"]).reshape(-1, 3),
            self.array(attributes["TEXCOORD_0"]) if "TEXCOORD_0" in attributes else None,
            self.array(attributes["COLOR_0"]) if "COLOR_0" in attributes else None,
            None if texture is None else self.picture(texture["index"]),
        )

    def picture(self, texture: int) -> np.ndarray:
        image = self.gltf["images"][self.gltf["textures"][texture]["source"]]
        with Image.open(io.BytesIO(self.view(image["bufferView"]))) as opened:
            assert Image.MIME[opened.format] == image["mimeType"]
            return np.asarray(opened.convert("RGB"))

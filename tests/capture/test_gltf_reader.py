import json
import struct

import DracoPy
import numpy as np
import pytest
import trimesh
from broken_captures import BODY_FACES, BODY_UV, BODY_VERTICES
from PIL import Image
from sequence_samples import ETC1S_VIDEO, Packer, layer_picture, moved_body

from unstructured_mg.capture.frame_error import FrameError, malformed
from unstructured_mg.capture.gltf_reader import list_gltf, read_gltf
from unstructured_mg.capture.reader import open_capture

IMAGE = Image.fromarray(np.repeat(np.arange(64, dtype=np.uint8).reshape(8, 8, 1) * 4, 3, axis=2))


def textured(vertices):
    visual = trimesh.visual.TextureVisuals(
        uv=BODY_UV, material=trimesh.visual.material.PBRMaterial(baseColorTexture=IMAGE)
    )
    return trimesh.Trimesh(vertices, BODY_FACES, visual=visual, process=False)


def corners(raw):
    return raw.vertices[raw.faces], raw.uv[raw.face_uv]


@pytest.mark.parametrize("suffix", ["glb", "gltf"])
def test_a_file_a_frame_as_trimesh_writes_them(tmp_path, suffix):
    for number in range(3):
        scene = trimesh.Scene(textured(moved_body(number)))
        if suffix == "glb":
            (tmp_path / f"frame_{number:03d}.glb").write_bytes(scene.export(file_type="glb"))
        else:
            files = trimesh.exchange.gltf.export_gltf(scene)
            data = json.loads(files.pop("model.gltf"))
            for item in (*data["buffers"], *data["images"]):
                if "uri" in item:
                    item["uri"] = f"{number}_{item['uri']}"
            (tmp_path / f"frame_{number:03d}.gltf").write_text(json.dumps(data))
            for name, content in files.items():
                (tmp_path / f"{number}_{name}").write_bytes(content)
    capture = open_capture(tmp_path, fps=30)
    assert len(capture) == 3 and not capture.faults and (capture.unit, capture.up) == (1.0, "y")
    for number in range(3):
        raw = read_gltf(tmp_path / f"frame_{number:03d}.{suffix}", tmp_path)
        points, uv = corners(raw)
        np.testing.assert_allclose(points, moved_body(number)[BODY_FACES], atol=1e-6)
        np.testing.assert_allclose(uv, BODY_UV[BODY_FACES], atol=1e-6)
        np.testing.assert_array_equal(raw.images[0].pixels(), np.asarray(IMAGE))
        assert raw.images[0].suffix == ".png" and raw.images[0].read_bytes().startswith(b"\x89PNG")


def body_mesh(packer, vertices=BODY_VERTICES, targets=(), material=None):
    """A mesh of the body, with morph targets to where ``targets`` says."""
    primitive = {
        "attributes": {
            "POSITION": packer.add(vertices, "f4"),
            "TEXCOORD_0": packer.add(BODY_UV * [1, -1] + [0, 1], "f4"),
        },
        "indices": packer.add(BODY_FACES.ravel(), "u2"),
        "targets": [{"POSITION": packer.add(target - vertices, "f4")} for target in targets],
    }
    return {"primitives": [primitive if material is None else {**primitive, "material": material}]}


def animated(packer, channels):
    """An animation of channels (target, times, values, interpolation)."""
    samplers = [
        {
            "input": packer.add(np.array(times), "f4"),
            "output": packer.add(np.array(values), "f4"),
            "interpolation": kind,
        }
        for _, times, values, kind in channels
    ]
    targets = [{"sampler": i, "target": target} for i, (target, *_) in enumerate(channels)]
    return [{"samplers": samplers, "channels": targets}]


@pytest.mark.parametrize("hide", ["scale", "KHR_node_visibility"])
def test_meshes_that_take_turns_and_bend_are_frames(tmp_path, hide):
    """Two meshes, the first of them with two morph targets, shown for three and two frames by steps."""
    packer, fps = Packer(), 25
    meshes = [
        body_mesh(packer, moved_body(0), [moved_body(1), moved_body(2)]),
        body_mesh(packer, moved_body(3), [moved_body(4)]),
    ]
    shown = [np.array([1, 1, 1, 0, 0]), np.array([0, 0, 0, 1, 1])]
    times = np.arange(5) / fps
    channels = [
        ({"node": 0, "path": "weights"}, times[:3], [0, 0, 1, 0, 0, 1], "STEP"),
        ({"node": 1, "path": "weights"}, times[3:], [0, 1], "STEP"),
    ]
    for node in range(2):
        if hide == "scale":
            target, values = {"node": node, "path": "scale"}, np.repeat(shown[node][:, None], 3, axis=1)
        else:
            pointer = {"KHR_animation_pointer": {"pointer": f"/nodes/{node}/extensions/{hide}/visible"}}
            target, values = {"path": "pointer", "extensions": pointer}, shown[node]
        channels.append((target, times, values, "STEP"))
    data = {"meshes": meshes, "nodes": [{"mesh": 0}, {"mesh": 1}], "scenes": [{"nodes": [0, 1]}], "scene": 0}
    path = tmp_path / "take.glb"
    path.write_bytes(packer.glb({**data, "animations": animated(packer, channels)}))
    frames = list_gltf(path, tmp_path)
    assert frames.numbers == (0, 1, 2, 3, 4) and frames.fps == fps
    for part in (4, 0, 2, 3, 1):
        np.testing.assert_allclose(read_gltf(path, tmp_path, part).vertices, moved_body(part), atol=1e-6)
    capture = open_capture(tmp_path)
    assert len(capture) == 5 and capture.fps == fps and len({frame.sha256 for frame in capture.frames}) == 5
    assert capture.from_json(json.loads(json.dumps(capture.to_json()))) == capture


@pytest.mark.parametrize("last", ["nothing", "the same"])
def test_a_last_key_frame_that_only_ends_the_take_is_no_frame(tmp_path, last):
    packer, count = Packer(), 3
    channels = []
    for i in range(count):
        times, shown = [[0, i, i + 1], [0, 1, 0]] if i else [[0, 1], [1, 0]]
        if last == "the same" and i == count - 1:
            shown = [0, 1, 1]
        scale = np.repeat(np.array(shown)[:, None], 3, axis=1)
        channels.append(({"node": i, "path": "scale"}, np.array(times) / 10, scale, "STEP"))
    nodes = [{"mesh": i} for i in range(count)]
    data = {"meshes": [body_mesh(packer, moved_body(i)) for i in range(count)], "nodes": nodes}
    path = tmp_path / "take.glb"
    path.write_bytes(packer.glb({**data, "animations": animated(packer, channels)}))
    assert list_gltf(path, tmp_path).numbers == (0, 1, 2) and list_gltf(path, tmp_path).fps == 10
    for part in range(count):
        np.testing.assert_allclose(read_gltf(path, tmp_path, part).vertices, moved_body(part), atol=1e-6)


def test_linear_motion_between_key_frames_is_sampled_at_the_shortest_gap(tmp_path):
    packer = Packer()
    quarter = np.sin(np.pi / 4)
    channels = [
        ({"node": 0, "path": "translation"}, [0, 0.1, 0.4], [[0, 0, 0], [1, 0, 0], [4, 0, 0]], "LINEAR"),
        ({"node": 0, "path": "rotation"}, [0, 0.4], [[0, 0, 0, 1], [0, quarter, 0, quarter]], "LINEAR"),
    ]
    data = {"meshes": [body_mesh(packer)], "nodes": [{"mesh": 0}], "scenes": [{"nodes": [0]}]}
    path = tmp_path / "take.glb"
    path.write_bytes(packer.glb({**data, "animations": animated(packer, channels)}))
    assert list_gltf(path, tmp_path).fps == 10
    for part in range(5):
        turn = trimesh.transformations.rotation_matrix(np.pi / 2 * part / 4, [0, 1, 0])[:3, :3]
        expected = BODY_VERTICES @ turn.T + [part, 0, 0]
        np.testing.assert_allclose(read_gltf(path, tmp_path, part).vertices, expected, atol=1e-5)


def test_meshes_with_numbers_in_their_names_are_frames(tmp_path):
    packer = Packer()
    order = [2, 0, 1]
    nodes = [{"mesh": i, "name": f"body_{number:03d}"} for i, number in enumerate(order)]
    path = tmp_path / "take.glb"
    meshes = [body_mesh(packer, moved_body(number)) for number in order]
    path.write_bytes(packer.glb({"meshes": meshes, "nodes": nodes, "scenes": [{"nodes": [0, 1, 2]}]}))
    assert list_gltf(path, tmp_path).numbers == (0, 1, 2)
    for part in range(3):
        np.testing.assert_allclose(read_gltf(path, tmp_path, part).vertices, moved_body(part), atol=1e-6)
    for node, name in zip(nodes, ("body", "left arm", "right arm"), strict=True):
        node["name"] = name
    path.write_bytes(packer.glb({"meshes": meshes, "nodes": nodes, "scenes": [{"nodes": [0, 1, 2]}]}))
    assert list_gltf(path, tmp_path) is None
    assert len(read_gltf(path, tmp_path).faces) == 3 * len(BODY_FACES)


def test_nodes_place_quantised_meshes_and_mirrors_keep_their_outside(tmp_path):
    packer = Packer()
    low, size = BODY_VERTICES.min(0), np.ptp(BODY_VERTICES, axis=0)
    quantised = np.rint((BODY_VERTICES - low) / size * 65535)
    primitive = {
        "attributes": {"POSITION": packer.add(quantised, "u2", normalized=True)},
        "indices": packer.add(BODY_FACES.ravel(), "u4"),
    }
    nodes = [
        {"children": [1], "scale": [-1, 1, 1]},
        {"mesh": 0, "scale": size.tolist(), "translation": low.tolist()},
    ]
    path = tmp_path / "f.glb"
    path.write_bytes(packer.glb({"meshes": [{"primitives": [primitive]}], "nodes": nodes, "scenes": [{"nodes": [0]}]}))
    raw = read_gltf(path, tmp_path)
    np.testing.assert_allclose(raw.vertices, BODY_VERTICES * [-1, 1, 1], atol=2e-5)
    assert trimesh.Trimesh(raw.vertices, raw.faces, process=False).volume > 0


def test_draco_inside_and_a_basis_texture(tmp_path):
    packer = Packer()
    packed = DracoPy.encode(BODY_VERTICES, BODY_FACES, quantization_bits=14, tex_coord=BODY_UV * [1, -1] + [0, 1])
    ids = {a["attribute_type"]: a["unique_id"] for a in DracoPy.decode(packed).attributes}
    view, texture = packer.view(packed), packer.view(ETC1S_VIDEO)
    for width, count in (("VEC3", len(BODY_VERTICES)), ("VEC2", len(BODY_VERTICES)), ("SCALAR", BODY_FACES.size)):
        packer.accessors.append({"componentType": 5126 if width != "SCALAR" else 5125, "count": count, "type": width})
    extension = {"bufferView": view, "attributes": {"POSITION": ids[0], "TEXCOORD_0": ids[3]}}
    primitive = {
        "attributes": {"POSITION": 0, "TEXCOORD_0": 1},
        "indices": 2,
        "material": 0,
        "extensions": {"KHR_draco_mesh_compression": extension},
    }
    path = tmp_path / "f.glb"
    data = {
        "meshes": [{"primitives": [primitive]}],
        "nodes": [{"mesh": 0}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "textures": [{"extensions": {"KHR_texture_basisu": {"source": 0}}}],
        "images": [{"bufferView": texture, "mimeType": "image/ktx2"}],
        "extensionsRequired": ["KHR_draco_mesh_compression", "KHR_texture_basisu"],
    }
    path.write_bytes(packer.glb(data))
    points, uv = corners(read_gltf(path, tmp_path))
    expected = np.concatenate([BODY_VERTICES[BODY_FACES], BODY_UV[BODY_FACES]], axis=2).reshape(len(BODY_FACES), -1)
    found = np.concatenate([points, uv], axis=2).reshape(len(points), -1)
    centre = lambda rows: rows.reshape(-1, 3, 5).mean(axis=1)  # noqa: E731
    order = [np.lexsort(np.round(centre(rows), 2).T) for rows in (expected, found)]
    np.testing.assert_allclose(centre(found)[order[1]], centre(expected)[order[0]], atol=2e-2)
    texture = read_gltf(path, tmp_path).images[0]
    assert texture.suffix == ".png" and np.abs(texture.pixels().astype(int) - layer_picture(0)).max() <= 20


def test_vertex_colours_are_linear_and_become_srgb(tmp_path):
    packer = Packer()
    linear = np.tile([[0.0, 0.21586, 1.0]], (len(BODY_VERTICES), 1))
    mesh = body_mesh(packer)
    mesh["primitives"][0]["attributes"]["COLOR_0"] = packer.add(linear, "f4")
    path = tmp_path / "f.glb"
    path.write_bytes(packer.glb({"meshes": [mesh], "nodes": [{"mesh": 0}]}))
    assert (read_gltf(path, tmp_path).colors == [0, 128, 255]).all()


def single(tmp_path, change=lambda data, packer: None):
    packer = Packer()
    data = {"meshes": [body_mesh(packer)], "nodes": [{"mesh": 0}], "scenes": [{"nodes": [0]}]}
    change(data, packer)
    path = tmp_path / "f.glb"
    path.write_bytes(packer.glb(data))
    return path


@pytest.mark.parametrize(
    "change, fault",
    [
        (lambda d, p: p.accessors[0].update(count=2**31), r"accessors\[0\]: its 2147483648 values need \d+ bytes, but"),
        (lambda d, p: p.views[0].update(byteLength=2**40), r"bufferViews\[0\] should take 1099511627776 bytes"),
        (lambda d, p: p.accessors[0].pop("bufferView"), r"accessors\[0\]: expected data, found none"),
        (lambda d, p: p.accessors[0].update(type="VEC2"), r"accessors\[0\]: expected VEC3, found VEC2"),
        (lambda d, p: p.accessors[0].update(componentType=1), r"accessors\[0\]: expected a component type, found 1"),
        (lambda d, p: d["nodes"][0].update(children=[0]), r"nodes\[0\] stands below itself"),
        (lambda d, p: d["nodes"][0].update(mesh=3), r"it names meshes\[3\], but has 1 meshes"),
        (lambda d, p: d["nodes"][0].update(skin=0), "a skin, which is not supported"),
        (lambda d, p: d["nodes"][0].update(scale=[1, None, 1]), r"nodes\[0\]: expected 3 numbers for its scale"),
        (lambda d, p: d.update(extensionsRequired=["EXT_meshopt_compression"]), "cannot be read without EXT_meshopt"),
        (lambda d, p: d["meshes"][0]["primitives"][0].update(mode=1), "it holds no triangles"),
    ],
)
def test_lying_and_unknown_contents_are_named(tmp_path, change, fault):
    with pytest.raises(FrameError, match=fault):
        read_gltf(single(tmp_path, change), tmp_path)


def test_a_file_cut_off_anywhere_names_a_byte(tmp_path):
    path = single(tmp_path)
    whole = path.read_bytes()
    for end in (*range(0, 60), len(whole) // 2, len(whole) - 1):
        path.write_bytes(whole[:end])
        with pytest.raises(FrameError, match=r"byte \d+"):
            read_gltf(path, tmp_path)
    path.write_bytes(whole[:8] + struct.pack("<I", 2**32 - 1) + whole[12:])
    with pytest.raises(FrameError, match=f"it ends at byte {len(whole)}, but byte 8 promises 4294967295"):
        read_gltf(path, tmp_path)


def test_damaged_json_is_a_fault_or_reads_in_range(tmp_path):
    """Every value of the JSON replaced by one of another kind."""
    path = single(tmp_path)
    whole = path.read_bytes()
    size = struct.unpack_from("<I", whole, 12)[0]
    data, binary = json.loads(whole[20 : 20 + size]), whole[28 + size :]

    def places(item, at=()):
        for key, value in item.items() if isinstance(item, dict) else enumerate(item):
            yield (*at, key)
            if isinstance(value, (dict, list)):
                yield from places(value, (*at, key))

    for place in list(places(data)):
        for value in (None, -1, 2**40, "word", [], {}, [None], 0.5):
            changed = json.loads(json.dumps(data))
            holder = changed
            for key in place[:-1]:
                holder = holder[key]
            holder[place[-1]] = value
            text = json.dumps(changed).encode()
            chunks = (
                struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary
            )
            path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)
            try:
                with malformed(path):
                    raw = read_gltf(path, tmp_path)
            except FrameError:
                continue
            assert raw.faces.min() >= 0 and raw.faces.max() < len(raw.vertices)

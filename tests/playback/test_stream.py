from itertools import islice

import numpy as np
from moving_toy import FACE_UV, FACES, UV, K, load_transition, moving_capture, moving_links, placed

from unstructured_mg.capture.mesh import Texture
from unstructured_mg.graph.motion_graph import build_graph
from unstructured_mg.playback.stream import EncodedImage, posed_frames
from unstructured_mg.playback.walk import WalkFrame, endless_walk, random_walk

LINKS = moving_links((20, 68), (30, 54), (12, 84))


def test_a_steady_motion_stays_steady_across_every_seam():
    capture = moving_capture(100)
    graph = build_graph(capture, LINKS)
    walk = random_walk(graph, capture, 600, 4)
    assert len({f.transition for f in walk}) > 4
    for time, frame in enumerate(posed_frames(walk, capture, load_transition), start=walk.start):
        np.testing.assert_allclose(frame.vertices, placed(time), atol=1e-9)


def test_frames_carry_what_was_stored(tmp_path):
    pictures = [tmp_path / "a.jpg", tmp_path / "b.png"]
    for picture in pictures:
        picture.write_bytes(picture.name.encode())
    capture = moving_capture(100, textures=tuple(Texture(picture) for picture in pictures))
    walk = random_walk(build_graph(capture, LINKS), capture, 80, 4)
    kinds = set()
    for origin, frame in zip(walk, posed_frames(walk, capture, load_transition), strict=True):
        kinds.add(origin.source)
        assert frame.origin == origin
        np.testing.assert_array_equal(frame.faces, FACES)
        np.testing.assert_array_equal(frame.uv, UV)
        np.testing.assert_array_equal(frame.face_uv, FACE_UV)
        if origin.transition is None:
            assert frame.textures == (EncodedImage(b"a.jpg", ".jpg"), EncodedImage(b"b.png", ".png"))
            np.testing.assert_array_equal(frame.face_material, [0, 1])
        else:
            source, target = origin.transition
            assert frame.textures == (EncodedImage(f"{source}-{target}{origin.step:+d}".encode(), ".png"),)
            assert frame.face_material is None
    assert kinds == {"capture", "transition"}


def test_a_transition_is_loaded_once_while_it_plays_and_few_are_kept():
    capture = moving_capture(100)
    graph, loaded = build_graph(capture, LINKS), []

    def load(source, target):
        loaded.append((source, target))
        return load_transition(source, target)

    walk = random_walk(graph, capture, 1500, 1)
    played = [f.transition for f in walk if f.step == -K + 1]
    assert sum(1 for _ in posed_frames(walk, capture, load, transitions_kept=1)) == len(walk)
    assert loaded == [now for before, now in zip([None, *played], played, strict=False) if now != before]


def test_it_streams():
    capture = moving_capture(100)
    graph, read = build_graph(capture, LINKS), []

    def tell(frames):
        for frame in frames:
            read.append(frame)
            yield frame

    stream = posed_frames(tell(endless_walk(graph, 0, int(graph.frames[0]))), capture, load_transition)
    first = list(islice(stream, 5))
    assert len(read) == len(first) == 5
    assert all(isinstance(frame, WalkFrame) for frame in read)

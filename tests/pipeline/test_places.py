import json

import numpy as np
from small_build import quiet

from unstructured_mg.geometry.centre import floor_centre
from unstructured_mg.pipeline import places
from unstructured_mg.pipeline.pool import Pool
from unstructured_mg.pipeline.store import Store
from unstructured_mg.pipeline.timings import Timings
from unstructured_mg.pipeline.work import open_work


def test_places_of_a_build_are_those_of_its_frames_and_steps(built):
    work = open_work(built.work)
    kept = json.loads((built.work / "places.json").read_text())
    np.testing.assert_allclose(work.graph.places.captured, kept, atol=1e-6)
    for index in (0, 41, 99):
        mesh = work.capture.read(index)
        np.testing.assert_array_equal(kept[index], floor_centre(mesh.vertices, mesh.faces))
    for link, steps in zip(work.graph.links, work.graph.places.steps, strict=True):
        transition = work.load_transition(link.source, link.target)
        expected = [floor_centre(vertices, transition.faces) for vertices in transition.vertices]
        np.testing.assert_allclose(steps, expected, atol=1e-6)


def test_they_are_measured_once(built, tmp_path, monkeypatch):
    work = open_work(built.work)
    store = Store(tmp_path / "work")
    store.create()
    timings = Timings(tmp_path / "timings.json")
    with Pool(2) as pool:
        first = places.captured_places(store, pool, work.capture, quiet(), timings)
    monkeypatch.setattr(places, "_centres", None)
    again = places.captured_places(store, None, work.capture, quiet(), timings)
    np.testing.assert_array_equal(again, first)

import json
import os

import pytest

from unstructured_mg.errors import UserError
from unstructured_mg.pipeline.store import Store, write_whole

INPUTS = {"stage": "pairs", "frames": ["a", "b"]}


@pytest.fixture
def store(tmp_path):
    store = Store(tmp_path / "work")
    store.create()
    return store


def commit(store, name="pairs/1-2", inputs=INPUTS, text="hello"):
    folder = store.new_scratch()
    (folder / "tracked.txt").write_text(text)
    (folder / "deep").mkdir()
    (folder / "deep" / "more.bin").write_bytes(b"\0\1")
    return store.commit(name, inputs, folder)


def test_an_artefact_is_found_by_its_inputs_only(store):
    path = commit(store)
    assert store.find("pairs/1-2", dict(reversed(INPUTS.items()))) == path
    assert store.find("pairs/1-2", {**INPUTS, "frames": ["a", "c"]}) is None
    assert store.find("pairs/1-3", INPUTS) is None
    assert store.names("pairs") == ["pairs/1-2"]
    assert store.manifest("pairs/1-2")["inputs"] == INPUTS


@pytest.mark.parametrize("damage", ["flip", "truncate", "delete", "add"])
def test_damage_is_noticed_and_named(store, damage):
    path = commit(store)
    file = path / "deep" / "more.bin"
    if damage == "flip":
        file.write_bytes(b"\0\2")
    elif damage == "truncate":
        file.write_bytes(b"\0")
    elif damage == "delete":
        file.unlink()
    else:
        (path / "stray").touch()
    assert store.find("pairs/1-2", INPUTS) is None
    assert store.damaged == ["pairs/1-2"]


def test_replacing_leaves_no_file_of_the_old_one(store):
    commit(store)
    folder = store.new_scratch()
    (folder / "only.txt").write_text("new")
    path = store.commit("pairs/1-2", {"stage": "other"}, folder)
    assert [child.name for child in path.iterdir()] == ["only.txt"]
    assert not list(store.scratch.iterdir())


def test_without_a_manifest_it_does_not_count(store):
    commit(store)
    (store.root / "manifests" / "pairs" / "1-2.json").write_text("{ half")
    assert store.find("pairs/1-2", INPUTS) is None


@pytest.mark.parametrize("failing", ["fsync", "replace"])
def test_every_failing_write_leaves_the_old_artefact_or_none(store, monkeypatch, failing):
    original = getattr(os, failing)
    for fail_at in range(1, 20):
        commit(store)
        calls = 0

        def fail(*args, fail_at=fail_at):
            nonlocal calls
            calls += 1
            if calls == fail_at:
                raise OSError(28, "No space left on device")
            return original(*args)

        monkeypatch.setattr(os, failing, fail)
        try:
            commit(store, inputs={"stage": "new"}, text="new")
            survived = True
        except UserError as error:
            survived = False
            assert "No space left on device" in str(error) and "free some space" in str(error)
        monkeypatch.setattr(os, failing, original)
        found_new, found_old = store.find("pairs/1-2", {"stage": "new"}), store.find("pairs/1-2", INPUTS)
        assert not (found_new and found_old)
        if survived:
            assert found_new and calls < fail_at
        if found_new:
            assert (found_new / "tracked.txt").read_text() == "new"
        if found_old:
            assert (found_old / "tracked.txt").read_text() == "hello"
        if survived:
            break
    else:
        pytest.fail("the loop should have outlasted the number of calls")


def test_foreign_folders_are_left_alone(tmp_path):
    (tmp_path / "thesis.tex").write_text("precious")
    with pytest.raises(UserError, match="holds files that are not umg's"):
        Store(tmp_path).create()
    assert [child.name for child in tmp_path.iterdir()] == ["thesis.tex"]


def test_write_whole_leaves_no_litter(tmp_path):
    write_whole(tmp_path / "a.json", json.dumps({"a": 1}).encode())
    assert [child.name for child in tmp_path.iterdir()] == ["a.json"]

"""What a night can do to a build: kills, failing disks, damage, clocks. The result is always that of an unbroken build.

The whole road is gone once and killed; everything that is tried hundreds of times runs with tasks that copy what the
whole road made, through the same store.
"""

import builtins
import io
import json
import os
import random
import shutil
import signal
import subprocess
import tempfile
import time
from pathlib import Path

import pytest
from inline_pool import InlinePool
from rich.console import Console
from small_build import quiet
from tiny_capture import TINY, write_tiny_capture
from work_contents import contents

from unstructured_mg.capture.capture import Capture
from unstructured_mg.errors import UserError
from unstructured_mg.matching.files import read_matching
from unstructured_mg.pipeline import build as build_module
from unstructured_mg.pipeline import tasks
from unstructured_mg.pipeline.build import build
from unstructured_mg.pipeline.names import pair_name
from unstructured_mg.pipeline.progress import StageProgress
from unstructured_mg.pipeline.store import Store


@pytest.fixture(scope="module")
def tiny(tmp_path_factory):
    """A capture and its unbroken build, made in this process."""
    folder = tmp_path_factory.mktemp("tiny")
    capture, work = write_tiny_capture(folder / "capture"), folder / "work"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(build_module, "open_pool", lambda workers, address: InlinePool())
        build(capture, work, TINY, 1, quiet())
    kept = [row["status"] for row in json.loads((work / "outcomes.json").read_text())]
    assert kept.count("kept") == 1
    return capture, work


@pytest.fixture
def tmp_path(tmp_path):
    """In memory where the system has such a place: a thousand flushes to a real disk take minutes."""
    memory = Path("/dev/shm")
    if not os.access(memory, os.W_OK):
        yield tmp_path
        return
    with tempfile.TemporaryDirectory(dir=memory) as folder:
        yield Path(folder)


@pytest.fixture
def copied(tiny, monkeypatch):
    """Builds whose tasks copy the artefacts of the unbroken one; the list of what they copied."""
    capture, reference = tiny
    made = []

    def copy(name, scratch):
        made.append(name)
        folder = Path(tempfile.mkdtemp(dir=scratch))
        for file in sorted((reference / name).iterdir()):
            (folder / file.name).write_bytes(file.read_bytes())
        return folder

    def task(group, ways):
        def run(capture, first, *rest):
            scratch = rest[-1]
            if group == "transitions":
                pair = json.loads((first / "tracked.json").read_text())
                source, target = pair["source"], pair["target"]
            else:
                source, target = first.source, first.target
            with tasks.user_errors(scratch):
                pairs = [(source, target), (target, source)][:ways]
                names = [pair_name(capture, s, t, group) for s, t in pairs]
                return tasks.TaskResult(tuple(copy(name, scratch) for name in names), None, 0.0)

        return run

    def opened(folder, **options):
        made.append("capture.json")
        return Capture.from_json(json.loads((reference / "capture.json").read_text()))

    def matched(capture, options, *, scratch, **rest):
        made.append("matching")
        return read_matching(reference / "matching")

    monkeypatch.setattr(build_module, "open_pool", lambda workers, address: InlinePool())
    monkeypatch.setattr(build_module, "open_capture", opened)
    monkeypatch.setattr(build_module, "match", matched)
    for name, group, ways in (("prepare", "cages", 1), ("track", "pairs", 1), ("synthesise", "transitions", 2)):
        monkeypatch.setattr(tasks, name, task(group, ways))
    return made


def told(capture, work):
    """Build, and what it said."""
    out = io.StringIO()
    build(capture, work, TINY, 1, StageProgress(Console(file=out, width=400)))
    return out.getvalue()


def assert_nothing_half_written(work, expected):
    """What has a manifest is what an unbroken build has there, byte for byte."""
    store = Store(work)
    manifests = [path for path in (work / "manifests").rglob("*.json") if not path.name.startswith(".")]
    for path in manifests:
        name = path.relative_to(work / "manifests").as_posix().removesuffix(".json")
        assert store.verify(name) is not None
        files = {key: value for key, value in contents(work).items() if key == name or key.startswith(f"{name}/")}
        assert files and files == {key: expected[key] for key in files}


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork and interval timers")
def test_a_build_killed_twenty_times_ends_like_an_unbroken_one(tiny, tmp_path, monkeypatch):
    """The system ends the process at a random moment of its own time, as SIGKILL does: no line of ours runs then."""
    capture, reference = tiny
    expected, work = contents(reference), tmp_path / "work"
    monkeypatch.setattr(build_module, "open_pool", lambda workers, address: InlinePool())
    draw, killed, done = random.Random(8), 0, {}
    while killed < 20:
        child = os.fork()
        if child == 0:
            try:
                signal.signal(signal.SIGPROF, signal.SIG_DFL)
                signal.setitimer(signal.ITIMER_PROF, draw.uniform(0.002, 0.3))
                build(capture, work, TINY, 1, quiet())
            finally:
                os._exit(0)
        draw.uniform(0, 1)  # as the child did
        _, status = os.waitpid(child, 0)
        killed += os.WIFSIGNALED(status)
        if (work / "manifests").exists():
            assert_nothing_half_written(work, expected)
            # No finished item is made again.
            files = {path: path.stat().st_mtime_ns for path in work.glob("*s/*/*.npz")}
            assert {path: files.get(path) for path in done} == done
            done = files
        if not os.WIFSIGNALED(status):
            shutil.rmtree(work)  # it was faster than the timer: again from the beginning
            done = {}
    output = told(capture, work)
    assert "damaged" not in output
    assert contents(work) == expected
    assert {path: path.stat().st_mtime_ns for path in done} == done
    assert not (work / "scratch").exists()


class FailingDisk:
    """The ``at``-th call of one kind below ``root`` fails, once."""

    def __init__(self, monkeypatch, root, kind, at):
        self.root, self.calls, self.at = str(root), 0, at
        if kind == "write":
            original = io.open

            def opened(file, mode="r", *rest, **options):
                stream = original(file, mode, *rest, **options)
                writes = any(letter in mode for letter in "wax+")
                if not writes or not (isinstance(file, int) or str(file).startswith(self.root)):
                    return stream
                return Writing(stream, self)

            monkeypatch.setattr(io, "open", opened)
            monkeypatch.setattr(builtins, "open", opened)
        else:
            name = {"fsync": "fsync", "rename": "replace"}[kind]
            call = getattr(os, name)

            def counted(*arguments):
                self.count()
                return call(*arguments)

            monkeypatch.setattr(os, name, counted)

    def count(self):
        self.calls += 1
        if self.calls == self.at:
            raise OSError(28, "No space left on device")


class Writing:
    """A stream whose writes are counted."""

    def __init__(self, stream, disk):
        self._stream, self._disk = stream, disk

    def write(self, data):
        self._disk.count()
        return self._stream.write(data)

    def __getattr__(self, name):
        return getattr(self._stream, name)

    def __enter__(self):
        self._stream.__enter__()
        return self

    def __exit__(self, *error):
        return self._stream.__exit__(*error)


@pytest.mark.parametrize("kind", ["write", "fsync", "rename"])
def test_wherever_the_disk_fails_the_next_run_ends_like_an_unbroken_one(tiny, tmp_path, copied, kind):
    capture, reference = tiny
    expected = contents(reference)
    for at in range(1, 1000):
        work = tmp_path / f"{kind}{at}"
        with pytest.MonkeyPatch.context() as patch:
            disk = FailingDisk(patch, work, kind, at)
            try:
                build(capture, work, TINY, 1, quiet())
                failed = False
            except UserError as error:
                failed = True
                assert "No space left on device; free some space" in str(error) and str(work) in str(error)
        if disk.calls < at:
            break
        if failed and work.exists():
            assert_nothing_half_written(work, expected)
        assert "damaged" not in told(capture, work)
        assert contents(work) == expected
        shutil.rmtree(work)
    assert at > 10 and not failed
    assert contents(work) == expected


def test_a_full_disk_is_said_so_and_the_build_goes_on_when_there_is_space(tiny, tmp_path, copied):
    if not hasattr(os, "geteuid") or os.geteuid() != 0 or shutil.which("mount") is None:
        pytest.skip("only root may mount a small disk")
    capture, reference = tiny
    disk = tmp_path / "disk"
    disk.mkdir()
    if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=64k", "tmpfs", disk], capture_output=True).returncode:
        pytest.skip("this system lets nobody mount a small disk")
    try:
        for size in (64, 128, 192):
            subprocess.run(["mount", "-o", f"remount,size={size}k", disk], check=True)
            with pytest.raises(UserError, match="No space left on device; free some space"):
                build(capture, disk / "work", TINY, 1, quiet())
            assert_nothing_half_written(disk / "work", contents(reference))
        subprocess.run(["mount", "-o", "remount,size=16m", disk], check=True)
        assert "damaged" not in told(capture, disk / "work")
        assert contents(disk / "work") == contents(reference)
    finally:
        subprocess.run(["umount", disk], check=True)


@pytest.mark.parametrize("damage", ["truncated", "flipped", "zeroed"])
def test_every_damaged_file_is_found_told_and_made_again(tiny, tmp_path, copied, damage):
    capture, reference = tiny
    expected, work = contents(reference), tmp_path / "work"
    shutil.copytree(reference, work)
    for name, content in expected.items():
        if name == "work.json":
            continue
        middle = len(content) // 2
        (work / name).write_bytes(
            {
                "truncated": content[:middle],
                "flipped": content[:middle] + bytes([content[middle] ^ 1]) + content[middle + 1 :],
                "zeroed": bytes(len(content)),
            }[damage]
        )
        copied.clear()
        output = told(capture, work)
        assert contents(work) == expected, name
        group = name.split("/")[0]
        artefact = "/".join(name.split("/")[:2]) if group in ("cages", "pairs", "transitions") else group
        # outcomes.json is made by every build; damage to a manifest is as if there were none.
        if artefact not in ("outcomes.json", "manifests"):
            assert f"{artefact} was damaged and has been made again" in output
        # Nothing is made but the damaged artefact (both ways of a transition are one task).
        assert len(set(copied)) <= 2, name


def test_clocks_and_touched_files_change_nothing(tiny, tmp_path, copied, monkeypatch):
    capture, reference = tiny
    moved = tmp_path / "capture"
    shutil.copytree(capture, moved)
    work = tmp_path / "work"
    build(moved, work, TINY, 1, quiet())
    before = {path: path.stat().st_mtime_ns for path in work.glob("*s/*/*")}
    for year in (0, 4_000_000_000):
        for path in moved.iterdir():
            os.utime(path, (year, year))
        monkeypatch.setattr(time, "time", lambda year=year: year)
        monkeypatch.setattr(time, "perf_counter", lambda year=year: -year)
        copied.clear()
        build(moved, work, TINY, 1, quiet())
        assert copied == ["capture.json"]  # frames are read again, and found to be the same
    assert {path: path.stat().st_mtime_ns for path in work.glob("*s/*/*")} == before
    same = {name: data for name, data in contents(work).items() if "capture.json" not in name}
    assert same == {name: data for name, data in contents(reference).items() if "capture.json" not in name}


def test_a_capture_is_only_read(tiny, tmp_path, monkeypatch):
    """The whole road leaves names, bytes and times in the capture's folder as they were."""
    capture = tmp_path / "capture"
    shutil.copytree(tiny[0], capture)

    def state():
        return {path: (path.stat().st_mtime_ns, path.stat().st_mode) for path in [capture, *capture.rglob("*")]}

    before = state()
    monkeypatch.setattr(build_module, "open_pool", lambda workers, address: InlinePool())
    opened = []

    def watched(file, mode="r", *rest, original=io.open, **options):
        if str(file).startswith(str(capture)) and mode not in ("r", "rb"):
            opened.append(file)
        return original(file, mode, *rest, **options)

    monkeypatch.setattr(io, "open", watched)
    monkeypatch.setattr(builtins, "open", watched)
    build(capture, tmp_path / "work", TINY, 1, quiet())
    assert opened == [] and state() == before

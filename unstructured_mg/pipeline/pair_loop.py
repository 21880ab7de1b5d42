"""The loop over candidates (P section 4): choose one, try it, on refusal choose another."""

import shutil
from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Future, wait
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from unstructured_mg.capture.capture import Capture, frame_hash
from unstructured_mg.errors import Refusal
from unstructured_mg.graph.construction import CONSTRUCTIONS
from unstructured_mg.matching.candidates import Candidate
from unstructured_mg.pipeline import tasks
from unstructured_mg.pipeline.choices import CHOICES_FILE, NO_CHOICES, Choices
from unstructured_mg.pipeline.cluster import ClusterPool
from unstructured_mg.pipeline.names import pair_name
from unstructured_mg.pipeline.options import BuildOptions
from unstructured_mg.pipeline.pool import Pool
from unstructured_mg.pipeline.preview import preview_inputs
from unstructured_mg.pipeline.progress import Advance
from unstructured_mg.pipeline.selection import GreedySelection
from unstructured_mg.pipeline.store import Store, user_errors

# A stage's version changes when its code would make other results from the same inputs.
VERSIONS = {"cages": 1, "pairs": 2, "transitions": 5}
TRACEBACKS = "tracebacks"


@dataclass(frozen=True)
class Outcome:
    """How one candidate ended: kept, or refused with the reason."""

    candidate: Candidate
    refusal: Refusal | None


@dataclass
class _Trial:
    index: int
    candidate: Candidate


class PairLoop:
    """Try candidates in ranked order over a pool of workers, committing what they make.

    A trial goes through three steps, each an artefact of its own, so that a killed build loses at most one step a
    worker: the cage, the tracked pair, the two transitions.
    """

    def __init__(
        self,
        store: Store,
        pool: Pool | ClusterPool,
        capture: Capture,
        options: BuildOptions,
        seconds: dict[str, float],
        choices: Choices = NO_CHOICES,
        why: Callable[[str, str], None] = lambda name, reason: None,
    ):
        self.store = store
        self.pool = pool
        self.capture = capture
        self.options = options
        self.seconds = seconds
        self.choices = choices
        self._why = why
        self._running: dict[Future[tasks.TaskResult], tuple[_Trial, str]] = {}
        self._refusals: dict[int, Refusal] = {}
        # Trials that were running when a worker died. Each is tried again by itself, which tells whose fault it was and
        # leaves it all the memory.
        self._suspects: list[_Trial] = []
        self._alone = False
        self._report: Callable[[int, bool], None] = lambda index, accepted: None

    def run(self, candidates: tuple[Candidate, ...], advance: Advance) -> list[Outcome]:
        """Decide all candidates; what was tried comes back in ranked order."""
        options, pins = self.options, self.choices.pins
        construction = CONSTRUCTIONS[options.graph.construction]

        def near(candidate: Candidate, others: list[Candidate]) -> bool:
            pinned = (candidate.source, candidate.target) in pins
            return not pinned and construction.is_near(candidate, others, self.capture, options.matching)

        shutil.rmtree(self.store.root / TRACEBACKS, ignore_errors=True)
        selection = GreedySelection(candidates, near, options.retries, options.max_pairs)
        self._report = selection.report
        while not selection.finished:
            if not self._running:
                self._alone = bool(self._suspects)
                if self._suspects:
                    self._begin(self._suspects.pop(0))
            room = 0 if self._alone or self._suspects else self.pool.workers
            while len(self._running) < room and (index := selection.next()) is not None:
                self._begin(_Trial(index, candidates[index]))
            if self._running:
                self._collect()
            advance(selection.decided, len(candidates))
        for future in list(self._running):
            future.cancel()
        wait(self._running)
        self._running.clear()
        rank = {candidate: index for index, candidate in enumerate(candidates)}
        decided = sorted(selection.accepted + selection.refused, key=rank.__getitem__)
        return [Outcome(candidate, self._refusals.get(rank[candidate])) for candidate in decided]

    def inputs(self, candidate: Candidate, group: str) -> dict[str, Any]:
        """What a candidate's artefact of ``group`` is made from."""
        k, capture = candidate.k, self.capture
        own, other = candidate.windows
        inputs: dict[str, Any] = {
            "stage": group,
            "stage_version": VERSIONS[group],
            "frames": [frame_hash(capture, i) for i in (*own, *other)],
            "unit": capture.unit,
            "up": capture.up,
            "floor": capture.floor,
            "yaw": candidate.yaw,
            "k": k,
            "tracking": asdict(self.options.tracking),
            **preview_inputs(self.options),
        }
        if candidate.warp is not None:
            inputs["warp"] = [[frame - way[0] for frame in way] for way in candidate.warp]
        if group == "transitions":
            inputs["synthesis"] = asdict(self.options.synthesis)
        return inputs

    def artefacts(self, candidate: Candidate, group: str) -> list[str]:
        """Names of a candidate's artefacts of ``group``."""
        source, target = candidate.source, candidate.target
        both = [(source, target), (target, source)] if group == "transitions" else [(source, target)]
        return [pair_name(self.capture, s, t, group) for s, t in both]

    def _begin(self, trial: _Trial) -> None:
        """Start a trial at the first step that is needed.

        Results stand without what they were made from (``umg clean`` takes that away), but what is there and damaged
        is made again.
        """
        candidate = trial.candidate
        if (candidate.source, candidate.target) in self.choices.vetoes:
            self._after(trial, "cages", Refusal("choice", f"it is vetoed in {CHOICES_FILE}"))
            return
        groups = ("transitions", "pairs", "cages")
        for position, group in enumerate(groups):
            if group == "cages" or (
                self._found(candidate, group)
                and all(
                    self._gone(candidate, earlier) or self._found(candidate, earlier)
                    for earlier in groups[position + 1 :]
                )
            ):
                self._step(trial, group)
                return

    def _found(self, candidate: Candidate, group: str) -> bool:
        inputs = self.inputs(candidate, group)
        return all([self.store.find(name, inputs) is not None for name in self.artefacts(candidate, group)])

    def _gone(self, candidate: Candidate, group: str) -> bool:
        return all(self.store.absent(name) for name in self.artefacts(candidate, group))

    def _step(self, trial: _Trial, group: str) -> None:
        """Go on with a trial at ``group``: reuse what is there, else start a worker on it."""
        candidate, options, capture = trial.candidate, self.options, self.capture
        names, inputs = self.artefacts(candidate, group), self.inputs(candidate, group)
        if self._found(candidate, group):
            self._after(trial, group, tasks.read_refusal(self.store.path(names[0])))
            return
        lacking = next(name for name in names if self.store.find(name, inputs) is None)
        self._why(lacking, self.store.why(lacking, inputs))
        scratch = self.store.scratch
        submit: Callable[..., Future[tasks.TaskResult]] = self.pool.submit
        if group == "cages":
            future = submit(tasks.prepare, capture, candidate, options.tracking, scratch)
        elif group == "pairs":
            cage = self._path(candidate, "cages")
            future = submit(tasks.track, capture, candidate, cage, options.tracking, scratch)
        else:
            future = submit(tasks.synthesise, capture, self._path(candidate, "pairs"), options.synthesis, scratch)
        self._running[future] = (trial, group)

    def _path(self, candidate: Candidate, group: str) -> Path:
        return self.store.path(self.artefacts(candidate, group)[0])

    def _after(self, trial: _Trial, group: str, refusal: Refusal | None) -> None:
        """An artefact is in the store: go on to the next step, or tell the selection."""
        following = {"cages": "pairs", "pairs": "transitions"}
        if refusal is not None:
            self._refusals[trial.index] = refusal
            self._report(trial.index, False)
        elif group in following:
            self._step(trial, following[group])
        else:
            self._report(trial.index, True)

    def _collect(self) -> None:
        """Wait for workers and commit what they made, in ranked order."""
        done, _ = wait(self._running, return_when=FIRST_COMPLETED)
        broken: list[_Trial] = []
        for future in sorted(done, key=lambda future: self._running[future][0].index):
            trial, group = self._running.pop(future)
            try:
                result = future.result()
            except BrokenExecutor:
                broken.append(trial)
                continue
            names = self.artefacts(trial.candidate, group)
            if result.traceback is not None:
                self._keep_traceback(trial, group, result)
                continue
            for name, folder in zip(names, result.folders, strict=True):
                self.store.commit(name, self.inputs(trial.candidate, group), folder)
            self.seconds[names[0]] = result.seconds
            self._after(trial, group, result.refusal)
        if broken:
            self._restart(broken)

    def _keep_traceback(self, trial: _Trial, group: str, result: tasks.TaskResult) -> None:
        """A defect of ours: the pair is refused for now, and what a developer needs is kept in ``tracebacks/``."""
        assert result.refusal is not None and result.traceback is not None
        for folder in result.folders:
            shutil.rmtree(folder)
        path = self.store.root / TRACEBACKS / f"{self.artefacts(trial.candidate, 'pairs')[0].split('/')[1]}.txt"
        with user_errors(path):
            path.parent.mkdir(exist_ok=True)
            path.write_text(result.traceback)
        reason = f"{result.refusal.reason} (see {TRACEBACKS}/{path.name})"
        self._after(trial, group, Refusal(result.refusal.stage, reason))

    def _restart(self, broken: list[_Trial]) -> None:
        """A worker died and took the pool with it."""
        wait(self._running)
        trials = broken + [trial for trial, _ in self._running.values()]
        self._running.clear()
        self.pool.restart()
        if self._alone:
            # Not stored: with more memory the next run may succeed.
            reason = "its worker process died twice, the second time by itself, most likely for want of memory"
            self._after(trials[0], "cages", Refusal("tracking", reason))
        else:
            self._suspects.extend(sorted(trials, key=lambda trial: trial.index))

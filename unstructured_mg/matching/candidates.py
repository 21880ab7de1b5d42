"""Candidate pairs, ranked (P A.1). Only ranking: trying and refusing them is the pipeline's loop."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from unstructured_mg.capture.capture import Capture
from unstructured_mg.matching.dissimilarity import Dissimilarity
from unstructured_mg.matching.loops import short_loops
from unstructured_mg.matching.options import MatchingOptions


@dataclass(frozen=True)
class Candidate:
    """A pair of similar windows, centred at frame indices ``source < target``.

    ``yaw`` (radians) turns the target about the vertical so that it best matches the source;
    ``score`` is the windowed dissimilarity after that turn, in the descriptor's unit (lower is better). Both windows
    have 2 k + 1 frames, k either side of the centre; unless there is a ``warp``: the 2 k + 1 source frames and as many
    target frames that belong together, each never falling and growing by one at most, the source and target in their
    middles.
    """

    source: int
    target: int
    score: float
    yaw: float
    k: int
    warp: tuple[tuple[int, ...], tuple[int, ...]] | None = None

    @property
    def windows(self) -> tuple[range, range]:
        """The frames of the source's window and of the target's."""
        if self.warp is not None:
            source, target = self.warp
            return range(source[0], source[-1] + 1), range(target[0], target[-1] + 1)
        source_window, target_window = (range(s - self.k, s + self.k + 1) for s in (self.source, self.target))
        return source_window, target_window


def is_near(candidate: Candidate, accepted: Iterable[Candidate], capture: Capture, options: MatchingOptions) -> bool:
    """Whether a transition was already made between the same actions: one whose source and whose target both lie in
    the same clip as the candidate's and less than ``separation_seconds`` from them (P A.1)."""

    separation = _separation(capture, options)

    def close(first: int, second: int) -> bool:
        a, b = capture.frames[first], capture.frames[second]
        return a.clip == b.clip and abs(a.number - b.number) < separation

    return any(close(candidate.source, other.source) and close(candidate.target, other.target) for other in accepted)


def eligible_pairs(
    capture: Capture, dissimilarity: Dissimilarity, threshold: float, options: MatchingOptions
) -> np.ndarray:
    """``(n, n) bool``: pairs s < t that have a score and are in different clips or far enough apart in their clip.

    Far enough is ``minimum_gap_seconds``, and the pair's 2 k + 1 frames, so that no frame is in both windows. With
    ``loops``, windows that share no frame are also far enough where the motion between them went away and came back.
    """
    numbers = np.array([frame.number for frame in capture.frames])
    names = {name: index for index, name in enumerate(dict.fromkeys(frame.clip for frame in capture.frames))}
    clips = np.array([names[frame.clip] for frame in capture.frames])
    wanted = options.minimum_gap_seconds * capture.fps - 1e-9
    gap = np.maximum(wanted, 2 * dissimilarity.k + 1)
    apart = (clips[:, None] != clips) | (np.abs(numbers[:, None] - numbers) >= gap)
    if options.loops:
        apart |= short_loops(capture, dissimilarity, threshold, wanted)
    return np.triu(apart & np.isfinite(dissimilarity.scores), 1)


def rank_candidates(
    capture: Capture, dissimilarity: Dissimilarity, threshold: float, options: MatchingOptions
) -> tuple[Candidate, ...]:
    """All eligible pairs up to ``threshold`` that are worth a try, best first.

    These are the pairs that P A.1 would choose were none refused: again and again the best eligible pair that is not
    near a chosen one. And, for when one of these is refused, up to ``alternatives`` of the best pairs near each (but
    at least a quarter of the separation from it and from each other in one of the frames). Whoever walks down the
    list passes over those that ``is_near`` an accepted one, so alternatives count only after a refusal, and a
    neighbourhood is tried at most 1 + ``alternatives`` times. Equal scores go by source, then target.
    """
    scores = np.where(eligible_pairs(capture, dissimilarity, threshold, options), dissimilarity.scores, np.inf)
    scores[scores > threshold] = np.inf
    return _best_first(spread_pairs(scores, capture, options), dissimilarity)


def spread_pairs(scores: np.ndarray, capture: Capture, options: MatchingOptions) -> list[tuple[int, int]]:
    """The finite pairs of ``scores`` (n, n) that ``rank_candidates`` would choose, then the alternatives near each."""
    separation = _separation(capture, options)
    spacing = max(1, round(separation / 4))
    chosen = _best_apart(scores, separation, None)
    taken = np.isinf(scores)
    for pair in chosen:
        taken[_box(*pair, spacing)] = True
    listed = list(chosen)
    for pair in chosen:
        rows, columns = _box(*pair, separation)
        for _ in range(options.alternatives):
            free = np.where(taken[rows, columns], np.inf, scores[rows, columns])
            row, column = np.unravel_index(np.argmin(free), free.shape)
            if not np.isfinite(free[row, column]):
                break
            listed.append((rows.start + int(row), columns.start + int(column)))
            taken[_box(*listed[-1], spacing)] = True
    return listed


def nearest_pairs(
    capture: Capture, dissimilarity: Dissimilarity, threshold: float, options: MatchingOptions, same_run: bool = False
) -> tuple[Candidate, ...]:
    """The ``nearest`` best eligible pairs whatever their score, no two near each other: for the report.

    With ``same_run`` only those of frames that follow each other without a gap: each of these closes a loop by itself.
    """
    eligible = eligible_pairs(capture, dissimilarity, threshold, options)
    if same_run:
        run = np.repeat(np.arange(len(capture.runs())), [len(run) for run in capture.runs()])
        eligible &= run[:, None] == run
    scores = np.where(eligible, dissimilarity.scores, np.inf)
    return _best_first(_best_apart(scores, _separation(capture, options), options.nearest), dissimilarity)


def _best_apart(scores: np.ndarray, separation: int, count: int | None) -> list[tuple[int, int]]:
    """Up to ``count`` finite pairs, best first, none closer than ``separation`` to a better one in both frames."""
    sources, targets = np.nonzero(np.isfinite(scores))
    order = np.argsort(scores[sources, targets], kind="stable")
    free = np.ones(scores.shape, bool)
    pairs: list[tuple[int, int]] = []
    for pair in zip(sources[order].tolist(), targets[order].tolist(), strict=True):
        if len(pairs) == count:
            break
        if free[pair]:
            pairs.append(pair)
            free[_box(*pair, separation)] = False
    return pairs


def _separation(capture: Capture, options: MatchingOptions) -> int:
    return max(1, math.ceil(options.separation_seconds * capture.fps - 1e-9))


def _box(source: int, target: int, reach: int) -> tuple[slice, slice]:
    """Pairs closer than ``reach`` in both frames."""
    return slice(max(0, source - reach + 1), source + reach), slice(max(0, target - reach + 1), target + reach)


def _best_first(pairs: list[tuple[int, int]], dissimilarity: Dissimilarity) -> tuple[Candidate, ...]:
    d = dissimilarity
    candidates = [Candidate(s, t, float(d.scores[s, t]), float(d.yaw[s, t]), int(d.k[s, t])) for s, t in pairs]
    return tuple(sorted(candidates, key=lambda candidate: (candidate.score, candidate.source, candidate.target)))

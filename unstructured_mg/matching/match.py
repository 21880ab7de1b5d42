"""From a capture to ranked candidate pairs: the whole of the matching room."""

from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path

from unstructured_mg.capture.capture import Capture
from unstructured_mg.capture.progress import Progress
from unstructured_mg.matching.candidates import Candidate, nearest_pairs, rank_candidates
from unstructured_mg.matching.descriptors import DESCRIPTORS
from unstructured_mg.matching.dissimilarity import Dissimilarity, compute_dissimilarity
from unstructured_mg.matching.options import MatchingOptions


@dataclass(frozen=True)
class Matching:
    """What matching found.

    Attributes
    ----------
    dissimilarity : scores and yaws of all pairs of windows
    candidates : pairs worth a try, best first (see ``rank_candidates``)
    nearest : the best pairs whatever their score, best first
    missing : likewise, but only pairs that would close a loop by themselves, those within one run of frames
    threshold : in the scores' unit; no candidate's score is above it
    """

    dissimilarity: Dissimilarity
    candidates: tuple[Candidate, ...]
    nearest: tuple[Candidate, ...]
    missing: tuple[Candidate, ...]
    threshold: float


def match(
    capture: Capture,
    options: MatchingOptions,
    *,
    scratch: Path,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> Matching:
    """Compare all windows of a capture and rank the pairs between which a transition may be made (P section 4, A.1).

    Where scores are in metres, root mean square surface distances, the threshold is a share of the actor's size,
    whatever the frame rate and the actor's own speed. P's, three times the mean score of neighbouring frames,
    measures the grid when scores have its floor in them, and the frame rate and the actor's speed when they have not:
    it would refuse all repeats of a still actor and admit unlike poses of a fast one. On five captures (standing,
    walking, stepping, dancing, talking) the local minima that repeat an action score 0.1 to 2.2 % of the actor's
    size. From 2.7 to about 4 % lie loose matches: the same action in another stance. About one in three could be
    synthesized well, and synthesis judges; beyond, planted feet slide. A loose threshold costs time, a strict one
    actions: no transition of the stepping capture scores below 2.7 %.

    Parameters
    ----------
    capture : all frames in metres, z up, floor at 0
    scratch : folder for intermediate files (about 2 MB a frame), which are removed
    executor : workers to share the work out to; None works here. The result is the same
    progress : told (done, total)

    Returns ------- Matching. A capture without a pair below the threshold has no candidates; one shorter than two
    windows has no pairs at all.
    """
    dissimilarity = compute_dissimilarity(capture, options, scratch=scratch, executor=executor, progress=progress)
    descriptor = DESCRIPTORS[options.descriptor]
    threshold = descriptor.threshold if options.threshold is None else options.threshold
    if descriptor.unit == "m":
        threshold *= dissimilarity.size
    return Matching(
        dissimilarity,
        rank_candidates(capture, dissimilarity, threshold, options),
        nearest_pairs(capture, dissimilarity, threshold, options),
        nearest_pairs(capture, dissimilarity, threshold, options, same_run=True),
        threshold,
    )

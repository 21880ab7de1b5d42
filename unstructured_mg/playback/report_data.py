"""What the report is made of: plain values, filled in from a work folder."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from unstructured_mg.capture.capture import Capture
from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.matching.candidates import Candidate
from unstructured_mg.playback.pictures import Picture, TransitionPictures
from unstructured_mg.synthesis.options import SynthesisOptions


@dataclass(frozen=True)
class PairOutcome:
    """What became of a candidate that was tried: ``status`` is "kept" or "refused"."""

    candidate: Candidate
    status: str
    stage: str = ""
    reason: str = ""
    measures: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class TransitionEntry:
    """One synthesized transition, without its frames.

    Attributes
    ----------
    source, target : frame indices s and t
    k : half window
    alignment : the target's captured place to the source's
    cost : lower is better
    card : the quality card, JSON-ready
    in_graph : whether the graph's strongly connected part plays it
    ends : the frames that it leaves and arrives at; None where these are ``source - k`` and ``target + k``
    """

    source: int
    target: int
    k: int
    alignment: PlanarRigid
    cost: float
    card: dict[str, Any]
    in_graph: bool
    ends: tuple[int, int] | None = None

    @property
    def leaves(self) -> int:
        """The captured frame that is shown before it."""
        return self.source - self.k if self.ends is None else self.ends[0]

    @property
    def arrives(self) -> int:
        """The captured frame that is shown after it."""
        return self.target + self.k if self.ends is None else self.ends[1]


@dataclass(frozen=True)
class ReportData:
    """Everything that ``write_report`` shows, with n captured frames.

    Attributes
    ----------
    title : the report's heading
    capture : for frame ids, clips, gaps, faults and warnings; its frames are not read
    capture_summary : (label, value) rows
    scores : (n, n) float32 windowed dissimilarity, NaN where there is no window, or None
    unit : of the scores: "m", "rad" or ""
    threshold : no candidate scores more
    gap : pairs of one clip closer than this many frames are no candidates
    candidates : ranked best first
    nearest : the best pairs whatever their score
    pairs : the candidates that were tried, in that order
    transitions : every synthesized transition
    covered : (n,) bool, the captured frames in the graph, or None before there is one
    visiting_before, visiting_after : (n,) float64, each captured frame's share of a long walk's captured frames, with
        even choices and with the chosen probabilities, 0 outside the graph; or None
    stage_minutes : (stage, minutes) rows
    notes : sentences on the graph, for instance why the visits cannot be uniform
    pictures : pictures of the transition with the given source and target; called once each, in order
    pair_picture : a picture of a refused or nearest pair; or None to do without
    limits : what the transitions' quality was judged by
    version : of the program
    """

    title: str
    capture: Capture
    capture_summary: tuple[tuple[str, str], ...]
    scores: np.ndarray | None
    unit: str
    threshold: float
    gap: int
    candidates: tuple[Candidate, ...]
    nearest: tuple[Candidate, ...]
    pairs: tuple[PairOutcome, ...]
    transitions: tuple[TransitionEntry, ...]
    covered: np.ndarray | None
    visiting_before: np.ndarray | None
    visiting_after: np.ndarray | None
    stage_minutes: tuple[tuple[str, float], ...]
    pictures: Callable[[int, int], TransitionPictures]
    pair_picture: Callable[[Candidate], Picture] | None = None
    limits: SynthesisOptions = field(default_factory=SynthesisOptions)
    notes: tuple[str, ...] = ()
    version: str = ""

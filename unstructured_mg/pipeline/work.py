"""A finished build, opened for reading."""

import json
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from unstructured_mg.capture.capture import Capture
from unstructured_mg.errors import UserError
from unstructured_mg.geometry.array_file import as_written, read_json
from unstructured_mg.graph.files import graph_from_json
from unstructured_mg.graph.motion_graph import MotionGraph
from unstructured_mg.matching.files import read_matching
from unstructured_mg.matching.match import Matching
from unstructured_mg.matching.options import MatchingOptions
from unstructured_mg.pipeline.names import pair_name
from unstructured_mg.pipeline.store import Store
from unstructured_mg.pipeline.timings import Timings
from unstructured_mg.synthesis.files import read_transition
from unstructured_mg.synthesis.options import SynthesisOptions
from unstructured_mg.synthesis.texture_options import TextureOptions
from unstructured_mg.synthesis.transition import Transition


@dataclass(frozen=True)
class Work:
    """What a work folder holds. Every artefact is verified against its checksum when it is read."""

    store: Store
    capture: Capture

    @cached_property
    def graph_json(self) -> dict[str, Any]:
        return self._json("graph.json")

    @cached_property
    def graph(self) -> MotionGraph:
        path = self.store.path("graph.json")
        with as_written(path):
            try:
                return graph_from_json(self.graph_json, self.capture)
            except UserError as error:
                raise ValueError(str(error).rstrip(".")) from None

    @cached_property
    def matching(self) -> Matching:
        return read_matching(self.verified("matching"))

    @cached_property
    def matching_options(self) -> MatchingOptions:
        with as_written(self.store.path("manifests/outcomes.json.json")):
            return MatchingOptions(**self._options()["matching"])

    @cached_property
    def synthesis_options(self) -> SynthesisOptions:
        with as_written(self.store.path("manifests/outcomes.json.json")):
            words = self._options()["synthesis"]
            return SynthesisOptions(**{**words, "texturing": TextureOptions(**words["texturing"])})

    @cached_property
    def outcomes(self) -> list[dict[str, Any]]:
        """A row for every candidate that was tried: source, target, score, yaw, status, refusal."""
        return self._json("outcomes.json")

    @cached_property
    def timings(self) -> Timings:
        return Timings(self.store.path("timings.json"))

    def load_transition(self, source: int, target: int) -> Transition:
        """A kept transition by its frame indices."""
        return read_transition(self.verified(pair_name(self.capture, source, target, "transitions")))

    def verified(self, name: str) -> Path:
        """The path of an artefact whose checksums hold; a UserError where they do not."""
        path = self.store.verify(name)
        if path is None:
            raise UserError(f"{self.store.path(name)}: is missing or damaged; run umg build again, it makes it anew.")
        return path

    def _options(self) -> dict[str, Any]:
        """The options that the build ran with, by room."""
        return (self.store.manifest("outcomes.json") or {})["inputs"]

    def _json(self, name: str) -> Any:
        return read_json(self.verified(name))


def open_work(folder: Path) -> Work:
    """Open a work folder that ``umg build`` has finished; a UserError where it has not."""
    folder = Path(folder)
    store = Store(folder)
    if not (folder / "work.json").exists():
        raise UserError(f"{folder}: is not a work folder; make one with umg build CAPTURE -o {folder}.")
    if store.manifest("graph.json") is None or store.verify("capture.json") is None:
        raise UserError(f"{folder}: its build has not finished; run umg build with the same arguments again.")
    with as_written(store.path("capture.json")):
        return Work(store, Capture.from_json(json.loads(store.path("capture.json").read_text())))

"""A work folder as a web page."""

from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from unstructured_mg.errors import UserError
from unstructured_mg.pipeline.keys import file_hash
from unstructured_mg.pipeline.names import pair_name
from unstructured_mg.pipeline.pool import Pool
from unstructured_mg.pipeline.progress import StageProgress
from unstructured_mg.pipeline.work import Work
from unstructured_mg.playback.serve import ADDRESS, site_server
from unstructured_mg.playback.site import export_site
from unstructured_mg.playback.site_options import SiteOptions
from unstructured_mg.synthesis.files import read_transition
from unstructured_mg.synthesis.transition import Transition


@dataclass(frozen=True)
class _Load:
    """Reads transitions in a worker, from folders whose checksums hold."""

    folders: dict[tuple[int, int], Path]

    def __call__(self, source: int, target: int) -> Transition:
        return read_transition(self.folders[source, target])


def serve_site(folder: Path, port: int) -> None:
    """Serve a page's folder on this machine until Ctrl-C."""
    if not (folder / "site.js").is_file():
        raise UserError(f"{folder}: is not a page's folder; write one with umg web WORK -o {folder}.")
    try:
        server = site_server(folder, port)
    except OSError as error:
        raise UserError(f"port {port}: cannot be used ({error.strerror}); give another with --port.") from error
    print(f"the page is http://{ADDRESS}:{server.server_address[1]}/ (this machine only; Ctrl-C ends it)", flush=True)
    with server, suppress(KeyboardInterrupt):
        server.serve_forever()


def make_site(work: Work, out: Path, options: SiteOptions, force: bool, workers: int, progress: StageProgress) -> None:
    """Write the page of a work folder into ``out``."""
    if Path(out).resolve().is_relative_to(work.capture.folder.resolve()):
        raise UserError(f"{out}: lies inside the capture, where it would count as a clip; give a folder elsewhere.")
    used = work.graph.links_used()
    ways = [(link.source, link.target) for index, link in enumerate(work.graph.links) if index in used]
    load = _Load({way: work.verified(pair_name(work.capture, *way, "transitions")) for way in ways})
    inputs = {"graph.json": file_hash(work.store.path("graph.json"))}
    with Pool(workers) as pool, progress.stage("writing the page") as advance:
        export_site(
            work.graph,
            work.capture,
            load,
            Path(out),
            options=options,
            force=force,
            inputs=inputs,
            executor=pool.executor,
            progress=advance,
        )

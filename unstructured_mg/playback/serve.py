"""A file server for one folder, for this machine only: what a page needs that a browser does not open from a disk."""

import mimetypes
import re
import shutil
from email.utils import formatdate, parsedate_to_datetime
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from io import BytesIO
from pathlib import Path
from typing import BinaryIO
from urllib.parse import unquote, urlsplit

ADDRESS = "127.0.0.1"


def site_server(folder: Path, port: int = 0) -> ThreadingHTTPServer:
    """A server of the files in ``folder`` on 127.0.0.1, not yet running; port 0 takes a free one.

    It answers GET and HEAD, whole files and single byte ranges. Nothing outside the folder can be read through it, by
    dots in the address or by links in the folder; nor can another site's page read it under a name of its own (DNS
    rebinding). Folders are not listed.

    Raises
    ------
    OSError
        Where the port is taken.
    """
    handler = type("SiteHandler", (_Handler,), {"root": Path(folder).resolve(strict=True)})
    server = ThreadingHTTPServer((ADDRESS, port), handler)
    server.daemon_threads = True
    return server


class _Handler(BaseHTTPRequestHandler):
    root: Path
    protocol_version = "HTTP/1.1"
    server_version, sys_version = "umg", ""

    def do_GET(self) -> None:
        self._answer(with_body=True)

    def do_HEAD(self) -> None:
        self._answer(with_body=False)

    def log_message(self, format: str, *arguments: object) -> None:
        """Every frame is a request: nobody wants to read them all."""

    def _answer(self, with_body: bool) -> None:
        if not _is_local(self.headers.get("Host", "")):
            self._refuse(HTTPStatus.FORBIDDEN)
            return
        path = _file_of(self.root, self.path)
        try:
            if path is None:
                raise FileNotFoundError
            status = path.stat()
            stream: BinaryIO = path.open("rb")
        except OSError:
            self._refuse(HTTPStatus.NOT_FOUND)
            return
        with stream:
            changed = formatdate(int(status.st_mtime), usegmt=True)
            if "Range" not in self.headers and _unchanged(self.headers.get("If-Modified-Since"), int(status.st_mtime)):
                self.send_response(HTTPStatus.NOT_MODIFIED)
                self.end_headers()
                return
            part = byte_range(self.headers.get("Range"), status.st_size)
            if part is None:
                self.send_response(HTTPStatus.REQUESTED_RANGE_NOT_SATISFIABLE)
                self.send_header("Content-Range", f"bytes */{status.st_size}")
                self.send_header("Content-Length", "0")
                self.end_headers()
                return
            whole = len(part) == status.st_size
            self.send_response(HTTPStatus.OK if whole else HTTPStatus.PARTIAL_CONTENT)
            if not whole:
                self.send_header("Content-Range", f"bytes {part.start}-{part.stop - 1}/{status.st_size}")
            self.send_header("Content-Type", mimetypes.guess_type(path.name)[0] or "application/octet-stream")
            self.send_header("Content-Length", str(len(part)))
            self.send_header("Accept-Ranges", "bytes")
            self.send_header("Last-Modified", changed)
            # A site that was written again must be seen at once.
            self.send_header("Cache-Control", "no-cache")
            self.send_header("X-Content-Type-Options", "nosniff")
            self.end_headers()
            if with_body:
                self._send(stream, part)

    def _send(self, stream: BinaryIO, part: range) -> None:
        stream.seek(part.start)
        try:
            shutil.copyfileobj(BytesIO(stream.read(len(part))), self.wfile)
        except (BrokenPipeError, ConnectionResetError):
            self.close_connection = True  # the page was closed

    def _refuse(self, status: HTTPStatus) -> None:
        self.send_response(status)
        self.send_header("Content-Length", "0")
        self.end_headers()


def byte_range(asked: str | None, size: int) -> range | None:
    """The bytes that a Range header asks for of a file of ``size`` bytes (RFC 9110, 14.1.2).

    All of them where it asks for none, for several ranges, or in another unit; None where there are no such bytes.
    """
    found = re.fullmatch(r"\s*bytes\s*=\s*(\d*)\s*-\s*(\d*)\s*", asked or "")
    if found is None or found.groups() == ("", ""):
        return range(size)
    first, last = found.groups()
    if not first:
        part = range(max(size - int(last), 0), size)
    elif last and int(last) < int(first):
        return range(size)
    else:
        part = range(int(first), min(int(last) + 1, size) if last else size)
    return part if len(part) else None


def _is_local(host: str) -> bool:
    return re.fullmatch(r"(127\.0\.0\.1|localhost)(:\d+)?", host) is not None


def _file_of(root: Path, address: str) -> Path | None:
    """The file that an address names, or None where it is not a file inside the folder."""
    name = unquote(urlsplit(address).path, errors="surrogateescape").lstrip("/")
    if "\0" in name or "\\" in name:
        return None
    try:
        path = (root / (name or "index.html")).resolve(strict=True)
    except (OSError, RuntimeError):
        return None
    return path if path.is_relative_to(root) and path.is_file() else None


def _unchanged(since: str | None, changed: int) -> bool:
    try:
        return since is not None and changed <= parsedate_to_datetime(since).timestamp()
    except (TypeError, ValueError):
        return False

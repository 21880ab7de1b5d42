import http.client
import os
import threading
from email.utils import formatdate

import pytest

from unstructured_mg.playback.serve import byte_range, site_server

CONTENT = bytes(range(256)) * 10


@pytest.fixture(scope="module")
def served(tmp_path_factory):
    """A server of ``site/``, beside which lies a secret that links in the site point to."""
    place = tmp_path_factory.mktemp("served")
    site = place / "site"
    (site / "frames").mkdir(parents=True)
    (site / "index.html").write_text("<p>page</p>")
    (site / "frames" / "a b.js").write_bytes(CONTENT)
    (site / "empty").write_bytes(b"")
    (place / "secret").write_text("secret")
    os.symlink(place / "secret", site / "link")
    os.symlink(place, site / "up")
    os.symlink(site / "index.html", site / "inside")
    server = site_server(site)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield server
    server.shutdown()
    server.server_close()


def ask(server, path, method="GET", **headers):
    connection = http.client.HTTPConnection("127.0.0.1", server.server_address[1], timeout=10)
    connection.putrequest(method, path, skip_host="Host" in headers)
    for name, value in headers.items():
        connection.putheader(name.replace("_", "-"), value)
    connection.endheaders()
    answer = connection.getresponse()
    body = answer.read()
    connection.close()
    return answer.status, body, answer.headers


def test_only_this_machine_is_served(served):
    assert served.server_address[0] == "127.0.0.1"


def test_files_and_the_page_are_served(served):
    assert ask(served, "/")[:2] == (200, b"<p>page</p>")
    assert ask(served, "/?x=1#y")[:2] == (200, b"<p>page</p>")
    status, body, headers = ask(served, "/frames/a%20b.js")
    assert (status, body) == (200, CONTENT)
    assert headers["Content-Length"] == "2560" and headers["Accept-Ranges"] == "bytes"
    assert "javascript" in headers["Content-Type"]
    assert ask(served, "/inside")[1] == b"<p>page</p>"
    assert ask(served, "/empty")[:2] == (200, b"")


def test_head_sends_no_body(served):
    status, body, headers = ask(served, "/frames/a%20b.js", "HEAD")
    assert (status, body, headers["Content-Length"]) == (200, b"", "2560")


@pytest.mark.parametrize(
    "path",
    [
        "/../secret", "/frames/../../secret", "/%2e%2e/secret", "/frames/%2e%2e%2f%2e%2e%2fsecret", "//../secret",
        "/..%5csecret", "/link", "/up/secret", "/up/site/index.html/../../secret", "/frames", "/frames/", "/none",
        "/index.html%00", "/%ff", "/" + "a" * 5000, "/etc/passwd", "//etc/passwd",
    ],
)  # fmt: skip
def test_nothing_outside_the_folder_can_be_read(served, path):
    status, body, _ = ask(served, path)
    assert (status, body) == (404, b"")


def test_links_that_stay_inside_are_followed_by_their_place(served):
    assert ask(served, "/up/site/index.html")[:2] == (200, b"<p>page</p>")


def test_a_page_under_another_name_reads_nothing(served):
    assert ask(served, "/", Host="evil.example:80")[0] == 403
    assert ask(served, "/", Host=f"localhost:{served.server_address[1]}")[0] == 200


def test_writing_is_not_answered(served):
    for method in ("POST", "PUT", "DELETE"):
        assert ask(served, "/", method)[0] == 501


@pytest.mark.parametrize(
    ("asked", "first", "stop"),
    [("bytes=0-99", 0, 100), ("bytes=100-", 100, 2560), ("bytes=-60", 2500, 2560), ("bytes=2550-9999", 2550, 2560)],
)
def test_a_part_is_served(served, asked, first, stop):
    status, body, headers = ask(served, "/frames/a%20b.js", Range=asked)
    assert (status, body) == (206, CONTENT[first:stop])
    assert headers["Content-Range"] == f"bytes {first}-{stop - 1}/2560"


def test_a_part_that_is_not_there_is_refused(served):
    status, body, headers = ask(served, "/frames/a%20b.js", Range="bytes=2560-")
    assert (status, body, headers["Content-Range"]) == (416, b"", "bytes */2560")


@pytest.mark.parametrize("asked", [None, "bytes=-", "lines=0-4", "bytes=5-2", "bytes=0-1,4-5", "nonsense"])
def test_what_is_no_single_range_of_bytes_gets_everything(asked):
    assert byte_range(asked, 10) == range(10)


def test_what_has_not_changed_is_not_sent_again(served):
    changed = ask(served, "/")[2]["Last-Modified"]
    assert ask(served, "/", If_Modified_Since=changed)[:2] == (304, b"")
    assert ask(served, "/", If_Modified_Since=formatdate(0, usegmt=True))[0] == 200
    assert ask(served, "/", If_Modified_Since="yesterday")[0] == 200

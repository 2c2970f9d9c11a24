"""The page behind nginx: user names, TLS and a path, with the configuration that PROXY.md shows."""

from __future__ import annotations

import base64
import http.client
import os
import re
import shutil
import signal
import ssl
import subprocess
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import pytest
import viser
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect
from websockets.typing import Origin, Subprotocol

from intellwheels_schemas.files import write_file
from intellwheels_schemas.messages import Identity, Lab, May
from tests.e2e.stage import DEADLINE, Peer, Stage, free_port
from tests.viewer.browser import Browser
from tests.viewer.panels.board import CHROMIUM, browser

pytestmark = [pytest.mark.process, pytest.mark.filterwarnings("ignore::DeprecationWarning")]

LAB = Lab(
    format="iw.v1",
    name="room3",
    identity=(
        Identity(name="teacher", may=(May(role="operator", world="proxied", agents=("*",)),)),
        Identity(name="student1", may=(May(role="viewer", world="proxied", agents=("chair1",)),)),
    ),
)
DOCUMENT = Path(__file__).parents[2] / "viewer" / "PROXY.md"


def nginx() -> str:
    # Debian keeps it where only root's PATH leads.
    found = shutil.which("nginx", path=f"{os.environ['PATH']}:/usr/sbin")
    why = "no nginx here" if found is None else "no openssl here" if shutil.which("openssl") is None else ""
    if why:
        if os.environ.get("REQUIRE_PROXY"):
            pytest.fail(why)
        pytest.skip(why)
    return str(found)


class Site:
    """A proxy, the page behind it, and the world that the page shows."""

    def __init__(self, stage: Stage, peer: Peer, port: int, trust: ssl.SSLContext) -> None:
        self.stage, self.peer, self.port, self.trust = stage, peer, port, trust

    def get(self, path: str, user: str | None) -> tuple[int, str, bytes]:
        """Return status, `Location` and body."""
        connection = http.client.HTTPSConnection("localhost", self.port, timeout=DEADLINE, context=self.trust)
        with closing(connection):
            connection.request("GET", path, headers=login(user))
            answer = connection.getresponse()
            return answer.status, answer.headers.get("Location", ""), answer.read()

    @contextmanager
    def page(self, user: str | None, origin: str | None = None, **more: str) -> Iterator[Browser]:
        """Open the page as a browser does: its websocket has the page's address without the last slash."""
        connection = connect(
            f"wss://localhost:{self.port}/sim",
            ssl=self.trust,
            origin=Origin(origin or f"https://localhost:{self.port}"),
            additional_headers={**login(user), **more},
            subprotocols=[Subprotocol(f"viser-v{viser.__version__}")],
            max_size=None,
            open_timeout=DEADLINE,
            compression=None,
        )
        with connection:
            browser = Browser(connection)
            browser.look()
            yield browser


def login(user: str | None) -> dict[str, str]:
    if user is None:
        return {}
    return {"Authorization": f"Basic {base64.b64encode(f'{user}:secret'.encode()).decode()}"}


def configuration(folder: Path, port: int, page: int) -> Path:
    """Write the block of the document into a configuration for this test."""
    found = re.search(r"```nginx\n(.*?)```", DOCUMENT.read_text(), re.DOTALL)
    assert found is not None
    block = found[1].replace("/etc/nginx", str(folder)).replace("127.0.0.1:8080", f"127.0.0.1:{page}")
    block = block.replace("listen 8443", f"listen 127.0.0.1:{port}").replace("_name site", "_name localhost")
    kinds = ("client_body", "proxy", "fastcgi", "uwsgi", "scgi")
    places = "".join(f"{kind}_temp_path {folder}/{kind};" for kind in kinds)
    file = folder / "nginx.conf"
    file.write_text(
        f"pid {folder}/pid; daemon off; master_process off; error_log {folder}/error.log;\n"
        f"events {{}}\nhttp {{ access_log off; {places}\n{block}}}\n"
    )
    return file


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    program, folder = nginx(), tmp_path_factory.mktemp("proxy")
    port, page = free_port(), free_port()
    words = ["req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-days", "2"]
    words += ["-subj", "/CN=localhost"]
    words += ["-addext", "subjectAltName=DNS:localhost", "-keyout", f"{folder}/site.key", "-out", f"{folder}/site.pem"]
    subprocess.run(["openssl", *words], check=True, capture_output=True, timeout=60)
    (folder / "users").write_text("".join(f"{name}:{{PLAIN}}secret\n" for name in ("teacher", "student1", "guest")))
    (folder / "lab.xml").write_text(write_file(LAB))
    proxy = subprocess.Popen([program, "-p", str(folder), "-c", str(configuration(folder, port, page))],
                             stderr=subprocess.PIPE, text=True, start_new_session=True)  # fmt: skip
    try:
        with Stage(folder, "proxied") as stage:
            stage.server("--map", "room", "--pace", "realtime")
            stage.agent("chair1")
            viewer = stage.start(
                "viewer", "intellwheels_viewer", "--port", str(page), "--connect", stage.endpoint, "--world", "proxied",
                "--allow-host", f"localhost:{port}", "--user-header", "X-Remote-User", "--lab", f"{folder}/lab.xml",
            )  # fmt: skip
            stage.line(viewer, "ready")
            with stage.peer() as peer:
                yield Site(stage, peer, port, ssl.create_default_context(cafile=f"{folder}/site.pem"))
    finally:
        os.killpg(proxy.pid, signal.SIGKILL)
        proxy.communicate(timeout=DEADLINE)


def test_page_is_served_below_a_path_to_users_only(site: Site) -> None:
    assert site.get("/sim/", None)[0] == 401
    status, _, body = site.get("/sim/", "guest")
    assert (status, b"<html" in body) == (200, True)
    assert site.get("/sim", "guest")[:2] == (301, f"https://localhost:{site.port}/sim/")
    for user, origin, status in ((None, None, 401), ("teacher", "https://evil.example", 403)):
        with pytest.raises(InvalidStatus) as refused, site.page(user, origin):
            pass
        assert refused.value.response.status_code == status


def test_user_who_may_steers(site: Site) -> None:
    with site.page("teacher") as browser:
        browser.wait(lambda: "As teacher this page may pause, resume" in browser.text())
        browser.enter("Pause", True)
        site.stage.wait(lambda: site.peer.clock()["State"] == "paused" or None, "a pause")
        browser.enter("Resume", True)
        site.stage.wait(lambda: site.peer.clock()["State"] == "running" or None, "that it goes on")


def test_user_who_may_drive_one_chair_is_told_what_not(site: Site) -> None:
    with site.page("student1") as browser:
        browser.wait(lambda: "As student1 this page may steer chair1" in browser.text())
        browser.wait(lambda: "student1 may not ask for ctl/pause, ctl/resume" in browser.text())
        pause = browser.element("Pause")
        assert browser.gui[pause]["disabled"]
        browser.enter("Pause", True)
        browser.wait(lambda: any("ctl/pause" in str(one) for one in browser.heard))
    assert site.peer.clock()["State"] == "running"


def test_who_may_only_look_has_no_controls_whatever_is_sent(site: Site) -> None:
    with site.page("guest", **{"X-Remote-User": "teacher"}) as browser:
        browser.wait(lambda: "guest is not in the lab&#x27;s document" in browser.text())
        pause = browser.element("Pause")
        browser.wait(lambda: browser.gui[pause].get("visible") is False)
        shown = {str(one.get("label")) for one in browser.gui.values() if one.get("visible", True)}
        assert not shown & {"Pause", "Resume", "Step, ticks", "Speed, \u00d7", "New run"}
        browser.enter("Pause", True)
        browser.wait(lambda: any("View only" in str(one) for one in browser.heard))
    assert site.peer.clock()["State"] == "running"


@pytest.mark.browser
def test_real_browser_finds_its_websocket_below_the_path(site: Site) -> None:
    if CHROMIUM is None:
        if os.environ.get("REQUIRE_BROWSER") == "1":
            pytest.fail("no Chromium")
        pytest.skip("no Chromium")
    with browser() as chromium:
        login = {"username": "teacher", "password": "secret"}
        # Few pixels: software draws them.
        size: Any = {"width": 800, "height": 420}
        context = chromium.new_context(http_credentials=login, ignore_https_errors=True, viewport=size)
        page = context.new_page()
        page.goto(f"https://localhost:{site.port}/sim/?fixedDpr=0.5")
        page.get_by_text("As teacher this page may").wait_for(timeout=60_000)
        context.close()

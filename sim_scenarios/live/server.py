"""A page that shows a run while it goes on, served on the loopback of this machine alone.

The page has an address that nobody can guess. What there is to see comes to it as server-sent events, all
that there is at first, so that a reader may come late.
"""

from __future__ import annotations

import json
import math
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from hmac import compare_digest
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from threading import Condition, Thread
from typing import Final

from sim_scenarios.html import interactive, render
from sim_scenarios.live.looks import Look
from sim_scenarios.units import DEGREE

LOOPBACK: Final = "127.0.0.1"
EVENTS: Final = "looks"
"""Where the events are, beside the page."""
PATIENCE: Final = 2.0
"""How long readers may take for the last event [s]."""


class Story:
    """Looks at a run for any number of readers, who may come late."""

    def __init__(self) -> None:
        self._looks: list[str] = []
        self._readers = 0
        self._ended = False
        self._news = Condition()

    def tell(self, look: Look) -> None:
        """Tell the readers."""
        with self._news:
            self._looks.append(_text(look))
            self._news.notify_all()

    def end(self) -> None:
        """Tell the readers that there is no more, and wait until they know."""
        with self._news:
            self._ended = True
            self._news.notify_all()
            self._news.wait_for(lambda: self._readers == 0, PATIENCE)

    def events(self) -> Iterator[str]:
        """All that there is to tell, as it comes, in the form of server-sent events."""
        told = 0
        with self._news:
            self._readers += 1
        try:
            while not self._ended or told < len(self._looks):
                with self._news:
                    self._news.wait_for(lambda: self._ended or told < len(self._looks))  # noqa: B023
                    new = self._looks[told:]
                told += len(new)
                yield f"data: [{','.join(new)}]\n\n"
            yield "event: end\ndata:\n\n"
        finally:
            with self._news:
                self._readers -= 1
                self._news.notify_all()


@contextmanager
def served(title: str, story: Story) -> Iterator[str]:
    """Serve the page of a run; its address. At the end the readers are told, and it is gone."""
    with _Server(title, story) as server:
        thread = Thread(target=server.serve_forever, kwargs={"poll_interval": 0.05}, daemon=True)
        thread.start()
        try:
            yield f"http://{server.host}{server.place}"
        finally:
            story.end()
            server.shutdown()
            thread.join()


class _Server(ThreadingHTTPServer):
    daemon_threads = True  # a reader that does not read keeps nobody

    def __init__(self, title: str, story: Story) -> None:
        super().__init__((LOOPBACK, 0), _Handler)
        self.host = f"{LOOPBACK}:{self.server_port}"
        self.place = f"/{secrets.token_urlsafe(24)}/"
        self.page = render("live.html", title=title, listens=True, **interactive("live.js", EVENTS)).encode()
        self.story = story


class _Handler(BaseHTTPRequestHandler):
    server: _Server

    def do_GET(self) -> None:
        """Page or events to who knows the address; nothing to a name that somebody has led here."""
        asked = self.path.encode(), self.headers.get("Host", "").encode()
        for name, answer in (("", self._page), (EVENTS, self._events)):
            allowed = f"{self.server.place}{name}".encode(), self.server.host.encode()
            if all(map(compare_digest, asked, allowed)):
                answer()
                return
        self.send_error(HTTPStatus.NOT_FOUND)

    def _page(self) -> None:
        self._begin("text/html; charset=utf-8")
        self.wfile.write(self.server.page)

    def _events(self) -> None:
        self._begin("text/event-stream")
        try:
            for event in self.server.story.events():
                self.wfile.write(event.encode())
        except ConnectionError:  # the reader has left
            self.close_connection = True

    def _begin(self, kind: str) -> None:
        self.send_response(HTTPStatus.OK)
        for name, value in {
            "Content-Type": kind,
            "Cache-Control": "no-store",
            "Content-Security-Policy": "frame-ancestors 'none'",
            "Referrer-Policy": "no-referrer",
            "X-Content-Type-Options": "nosniff",
        }.items():
            self.send_header(name, value)
        self.end_headers()

    def log_message(self, *_: object) -> None:
        """Nothing: the terminal belongs to the run."""


def _text(look: Look) -> str:
    """A look as JSON: angles in degrees, null for what is not known."""
    angles = {
        "heading": look.heading,
        "sigma": look.heading_sigma,
        "true_heading": look.true_heading,
        "error": look.heading_error,
    }
    places = {"place": look.place, "true_place": look.true_place}
    return json.dumps(
        {
            "time": look.time,
            "duration": look.duration,
            "status": look.status,
            **{name: _known(angle / DEGREE) for name, angle in angles.items()},
            **{name: [*map(_known, place)] for name, place in places.items()},
        }
    )


def _known(value: float) -> float | None:
    return round(value, 6) if math.isfinite(value) else None

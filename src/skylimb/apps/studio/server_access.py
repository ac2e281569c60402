"""Who may talk to the studio, and which files a browser is given.

A page on another site can open a WebSocket to this machine. So the Origin must be our own. A name that an
attacker points at 127.0.0.1 gives it our own Origin (DNS rebinding). So the Host must be ours as well.
"""

from __future__ import annotations

import hmac
import ipaddress
import secrets
from dataclasses import dataclass, field
from pathlib import Path
from urllib.parse import parse_qs, urlsplit

from skylimb.analysis.viewer import VENDOR
from skylimb.base.errors import ConfigError

LOOPBACK = ("127.0.0.1", "localhost", "::1")

_SHORTEST_TOKEN = 8
_PAGE = Path(__file__).parent / "page"
_FILES = {
    "/": (_PAGE / "index.html", "text/html; charset=utf-8"),
    "/vendor.js": (VENDOR, "text/javascript; charset=utf-8"),
    "/studio.js": (_PAGE / "studio.js", "text/javascript; charset=utf-8"),
    "/studio.css": (_PAGE / "studio.css", "text/css; charset=utf-8"),
}
PUBLIC = ("/vendor.js", "/studio.js", "/studio.css")
"""What everybody may have, without a token: the program, which knows nothing of the flight."""

HEADERS = {
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; "
    "img-src 'self' data: blob:; connect-src 'self'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}
"""Of every answer: the page runs and asks nothing but its own server, and is in nobody's frame."""


@dataclass(frozen=True)
class Access:
    """Where the studio listens, and the word that opens it.

    Attributes:
        host: an address or a name of this machine.
        port: as bound.
        token: empty where none is needed.
        watch: another one, with which a page may only watch.
    """

    host: str
    port: int
    token: str
    watch: str = field(default_factory=lambda: secrets.token_urlsafe(16))

    @property
    def url(self) -> str:
        """What to open in a browser."""
        return self._url(self.token)

    @property
    def watching_url(self) -> str:
        """What to open in order to watch; empty where everybody may drive."""
        return self._url(self.watch) if self.token else ""

    def _url(self, token: str) -> str:
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"http://{host}:{self.port}/" + (f"?token={token}" if token else "")

    def knows_host(self, host: str | None) -> bool:
        """Whether a request's Host header is a name under which the studio listens."""
        if not host:
            return False
        try:
            split = urlsplit(f"//{host}")
            name, port = split.hostname or "", split.port or 80
        except ValueError:
            return False
        names = LOOPBACK if self.host in LOOPBACK else (self.host.lower(),)
        everywhere = self.host in ("0.0.0.0", "::")
        return port == self.port and (name in names or (everywhere and _is_address(name)))

    def knows_origin(self, origin: str | None, host: str | None) -> bool:
        """Whether a page came from here; a browser always says where from."""
        return bool(origin) and self.knows_host(host) and origin == f"http://{host}"

    def may_drive(self, path: str) -> bool:
        """Whether the address has the right token, compared in constant time."""
        return not self.token or _has(path, self.token)

    def may_watch(self, path: str) -> bool:
        """Whether the address has one of the tokens."""
        return self.may_drive(path) or _has(path, self.watch)


def _has(path: str, token: str) -> bool:
    given = parse_qs(urlsplit(path).query).get("token", [""])[0]
    return hmac.compare_digest(given.encode(), token.encode())


def checked_token(host: str, token: str) -> str:
    """The token for a host; `new` stands for one made up, `none` for none.

    Raises:
        ConfigError: for an address that others can reach without a token, or for a short one.
    """
    token = {"new": secrets.token_urlsafe(16), "none": ""}.get(token, token)
    if host not in LOOPBACK and not token:
        raise ConfigError(f"--host = '{host}' can be reached by others: not with --token none")
    plain = all(letter.isascii() and (letter.isalnum() or letter in "-_") for letter in token)
    if token and (len(token) < _SHORTEST_TOKEN or not plain):
        raise ConfigError(
            f"--token needs at least {_SHORTEST_TOKEN} letters, digits, '-' or '_'; or is 'new' or 'none'"
        )
    return token


def file_of(path: str) -> tuple[bytes, str] | None:
    """Content and type of one of the page's own files; None for every other path."""
    found = _FILES.get(urlsplit(path).path)
    return None if found is None else (found[0].read_bytes(), found[1])


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return name == "localhost"
    return True

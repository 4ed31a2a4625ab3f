"""Which ports a recorder opens: devices, and two kinds of network address; nothing that writes files.

pyserial has more kinds of URL than a rig has plugs: ``spy://`` writes everything into a file that the URL names,
``alt://`` loads a class by name. A manifest that came with somebody's folder must not reach them.
"""

from __future__ import annotations

import ipaddress
import re
import stat
from pathlib import Path
from urllib.parse import urlsplit

from gcode.support.errors import UserError

NETWORK = ("socket", "rfc2217")
# To open another device may do something: /dev/watchdog, for one, restarts the machine a minute later.
_TERMINAL = re.compile(r"tty[A-Za-z.][\w.-]*|cu\.[\w.-]+|rfcomm\d+|pts/\d+", re.ASCII)
ALLOWED = "a device such as /dev/ttyUSB0, or socket://HOST:PORT, or rfc2217://HOST:PORT"


def stated_port(url: str) -> str:
    """The port that a person named, if it is one of ours; a device by a path that means it in any folder.

    Raises
    ------
    UserError
        For any other kind of URL.
    """
    if not isinstance(url, str) or not url:
        raise UserError(f"port: must be {ALLOWED}, got {url!r}")
    if "://" not in url:
        return str(Path(url).absolute())
    kind, _, rest = url.partition("://")
    try:
        host, number = urlsplit(url).hostname, urlsplit(url).port
    except ValueError as error:
        raise UserError(f"{url}: not a port: {error}; allowed is {ALLOWED}") from None
    if kind not in NETWORK:
        raise UserError(f"{url}: this kind of port is not opened; allowed is {ALLOWED}")
    if not host or not number or any(mark in rest for mark in "?#@/"):
        raise UserError(f"{url}: not an address; it must be {kind}://HOST:PORT and nothing more")
    return url


def remembered_port(url: str, source: Path) -> str:
    """The port that a campaign's manifest names; less is allowed, since the folder may be a stranger's.

    Raises
    ------
    UserError
        Unless it is a terminal device, or an address of this machine. Whoever means it can say so with ``--port``.
    """
    try:
        stated_port(url)
        fine = _is_here(url) if "://" in url else _is_terminal(Path(url))
    except UserError:
        fine = False
    if not fine:
        raise UserError(
            f"{source}: names the port {url!r}, which is not opened on the word of a file (a device that is there, "
            "or an address of this machine, is); if you mean it, give `port`"
        )
    return url


def _is_here(url: str) -> bool:
    host = urlsplit(url).hostname or ""
    try:
        return host == "localhost" or ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def _is_terminal(path: Path) -> bool:
    """Whether this can be a serial port, told without opening it: opening resets many boards.

    A device that is away just now is fine: waiting for it harms nobody. A link elsewhere, such as `testbench rig
    --link` makes, must lead to a device.
    """
    if not path.is_absolute():
        return False
    try:
        real = path.resolve()
        named = real.parts[1:2] == ("dev",) and _TERMINAL.fullmatch("/".join(real.parts[2:])) is not None
        return named and (not real.exists() or stat.S_ISCHR(real.stat().st_mode))
    except (OSError, RuntimeError, ValueError):
        # RuntimeError: links in a circle; ValueError: a zero byte in the name.
        return False

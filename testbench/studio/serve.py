"""Starting the studio's server: this machine only."""

from __future__ import annotations

import importlib
import socket
import threading

from gcode.support.colours import BLUE
from gcode.support.errors import UserError
from gcode.support.files import make_folder
from testbench.rig.acquisition.stopping import what_ends_it
from testbench.studio.studio import KEY_RECORDING, RESULTS_URL, Studio
from testbench.studio.workspace import RESULTS

HOST = "127.0.0.1"
WARM = (
    "pandas",
    "tsdownsample",
    "testbench.api.models.comparing",
    "testbench.api.experiments.investigating",
)
FAVICON = (
    f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 30 30" fill="none" stroke="{BLUE}" stroke-width="6" '
    'stroke-linecap="round"><path d="M5 6 L15 24 M25 6 L15 24"/></svg>'
)


def serve(studio: Studio, port: int, show: bool) -> None:
    """Serve until Ctrl-C, or SIGTERM.

    Raises
    ------
    UserError
        If the port is taken.
    """
    from nicegui import app, ui
    from starlette.middleware.trustedhost import TrustedHostMiddleware

    from testbench.studio.parts.picture import serve_plotly
    from testbench.studio.shell import frame

    _check_free(port)
    serve_plotly()
    app.add_static_files(RESULTS_URL, make_folder(studio.workspace.root / RESULTS), max_cache_age=0)
    # A page elsewhere must not reach the studio by giving this machine another name (DNS rebinding).
    app.add_middleware(TrustedHostMiddleware, allowed_hosts=[HOST, "localhost"])
    app.on_startup(lambda: threading.Thread(target=_warm, args=[studio], daemon=True).start())
    app.on_shutdown(lambda: _close(studio))
    print(f"studio of {studio.workspace.root}: http://{HOST}:{port} ({what_ends_it()} ends it)", flush=True)
    ui.run(
        lambda: frame(studio),
        host=HOST,
        port=port,
        show=show,
        reload=False,
        title="knitbench studio",
        language="en-US",
        favicon=FAVICON,
        show_welcome_message=False,
        reconnect_timeout=30,
        tailwind=False,  # it compiles style sheets in the browser at every load
        gzip_middleware_factory=None,  # nothing leaves this machine
        message_history_length=50,  # hours of live plots must not pile up
    )


async def _close(studio: Studio) -> None:
    """End all jobs but a recording, and say that it goes on."""
    for job in await studio.jobs.close():
        if job.key == KEY_RECORDING and job.about:
            again = "open the studio again to see it"
            print(f"{job.title} goes on without the studio; {again}, or end it with: kill -INT {job.about.pid}")


def _warm(studio: Studio) -> None:
    """Read the manifests and import what the first pages need, while the browser is still opening."""
    studio.workspace.campaigns()
    for module in WARM:
        importlib.import_module(module)


def _check_free(port: int) -> None:
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((HOST, port))
        except OSError as error:
            raise UserError(f"port {port} cannot be used ({error.strerror}); choose another with --port") from None

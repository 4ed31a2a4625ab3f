"""``testbench studio``: the test bench in a browser."""

from __future__ import annotations

import argparse

from gcode.support.console import whole

SUMMARY = "open the test bench in a browser, on this machine only"
EXAMPLE = "testbench studio campaigns"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "folder", nargs="?", default=".", metavar="FOLDER", help="folder of campaigns (default: this one)"
    )
    parser.add_argument(
        "--port", type=whole(1, 65535), default=8123, metavar="P", help="on 127.0.0.1 (default: 8123)"
    )
    parser.add_argument("--no-browser", action="store_true", help="only serve; do not open a browser")


def run(args: argparse.Namespace) -> int:
    from testbench.studio.serve import serve
    from testbench.studio.studio import Studio

    serve(Studio(args.folder), args.port, show=not args.no_browser)
    return 0

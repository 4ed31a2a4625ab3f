#!/usr/bin/env bash
# Checks for what cannot come from PyPI and names the Debian/Ubuntu package that brings it.
set -u
missing=()
say() { echo "setup: $1 -> apt-get install $2" >&2; missing+=("$2"); }

if ! command -v "$PYTHON" >/dev/null 2>&1; then
  say "no $PYTHON found" python3
else
  "$PYTHON" -c 'import sys; raise SystemExit(sys.version_info < (3, 11))' ||
    say "$("$PYTHON" --version) is too old, 3.11 or newer is needed (make PYTHON=python3.12 picks another)" python3
  "$PYTHON" -c 'import venv, ensurepip' 2>/dev/null || say "python cannot make virtual environments" python3-venv
  "$PYTHON" -c 'import sys, sysconfig, pathlib; raise SystemExit(not pathlib.Path(sysconfig.get_path("include"), "Python.h").exists())' ||
    say "no Python headers (the noise package is compiled here)" python3-dev
fi
command -v gcc >/dev/null 2>&1 || say "no C compiler (the noise package is compiled here)" gcc

[ ${#missing[@]} -eq 0 ] || { echo "setup: install them all with: apt-get install ${missing[*]}" >&2; exit 2; }

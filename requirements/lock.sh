#!/usr/bin/env bash
# Pins every dependency with hashes. The output names no host, so it may be committed.
set -eu
cd "$(dirname "$0")/.."
pin() { "$1" pip compile --universal --generate-hashes --no-emit-index-url --python-version 3.11 -q "${@:2}"; }
pin "$1" requirements/bootstrap.in -o requirements/bootstrap.lock
pin "$1" pyproject.toml -c requirements/constraints.in -o requirements/run.lock
pin "$1" pyproject.toml --extra dev --extra bench -c requirements/run.lock -o requirements/dev.lock
pin "$1" pyproject.toml --extra docs -c requirements/run.lock -c requirements/dev.lock -o requirements/docs.lock

#!/usr/bin/env bash
# Resolve the project's dependencies in fresh environments and pin what comes out, names and versions only: for the
# oldest Python first, then for one without PyBullet, with the same versions; what only one of them has is marked so.
set -euo pipefail
cd "$(dirname "$0")/.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

resolved() { # python, constraints
  "$1" -m venv "$work/$1"
  "$work/$1/bin/python" -m pip install --quiet --constraint "$2" '.[dev]' 'setuptools>=77'
  "$work/$1/bin/python" -m pip freeze --all --exclude stackdsl --exclude pip | sort --ignore-case
}

: > "$work/none"
resolved "${1:-python3.11}" "$work/none" > "$work/older"
resolved "${2:-python3.12}" "$work/older" > "$work/newer"
{
  echo "# Written by 'make lock'. Exact versions of all that a set-up installs."
  grep -Fxf "$work/newer" "$work/older"
  grep -Fxvf "$work/newer" "$work/older" | sed "s/\$/; python_version < '3.12'/"
  grep -Fxvf "$work/older" "$work/newer" | sed "s/\$/; python_version >= '3.12'/"
} > requirements.lock

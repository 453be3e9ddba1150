#!/usr/bin/env bash
# Resolve the project's dependencies in a fresh environment and pin what came out, names and versions only.
set -euo pipefail
cd "$(dirname "$0")/.."
fresh=$(mktemp -d)
trap 'rm -rf "$fresh"' EXIT
"${1:-python3.11}" -m venv "$fresh"
"$fresh/bin/python" -m pip install --quiet '.[dev]' 'setuptools>=77'
{
  echo "# Written by 'make lock'. Exact versions of all that a set-up installs."
  "$fresh/bin/python" -m pip freeze --exclude stackdsl
  "$fresh/bin/python" -m pip list --format=freeze | grep -E '^setuptools=='
} > requirements.lock

#!/usr/bin/env bash
# Pin what `make` installs, with the digest of every file that an index has of it and no address: what running needs, and
# what tests and documentation need in addition. With `--keep` the versions stay, and only what is missing is resolved.
set -euo pipefail
cd "$(dirname "$0")/.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

python3 -m venv "$work/uv"
"$work/uv/bin/python" -m pip install --quiet uv
index=$("$work/uv/bin/python" -m pip config get global.index-url 2> "$work/unset" || true)
echo 'setuptools>=77' > "$work/build.in" # builds this package
: > "$work/pins"
if [ "${1:-}" = --keep ]; then
  sed -n 's/^\([A-Za-z0-9._-]*==[^ ;]*\)\( ;[^\\]*\)\?.*/\1\2/p' requirements*.lock > "$work/pins"
fi

lock() { # file, what it is for, arguments of uv
  local file=$1 purpose=$2
  shift 2
  {
    echo "# Written by 'make lock'. Exact versions of what $purpose, with the digests of their files."
    "$work/uv/bin/uv" pip compile --quiet --no-config --universal --python-version 3.11 --generate-hashes --no-header \
      --no-annotate --no-emit-index-url ${index:+--index-url "$index"} --constraint "$work/pins" "$@" pyproject.toml
  } > "$work/lock"
  mv "$work/lock" "$file"
  sed -n 's/^\([A-Za-z0-9._-]*==[^ ;\\]*\)\( ;[^\\]*\)\?.*/\1\2/p' "$file" >> "$work/pins"
}
without() { # the options that leave out what these files have
  sed -n 's/^\([A-Za-z0-9._-]*\)==.*/--no-emit-package=\1/p' "$@"
}

# Scenarios of this repository import URDF.
lock requirements.lock 'running needs' --extra urdf "$work/build.in"
lock requirements-dev.lock 'tests and style need in addition' --extra dev $(without requirements.lock)
lock requirements-docs.lock 'the documentation needs in addition' --extra docs $(without requirements.lock)

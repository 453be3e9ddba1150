#!/usr/bin/env bash
# Resolve the project's dependencies in fresh environments and pin what comes out, with the digest of every file that an
# index has of it and no address: for the oldest Python first, then for one without PyBullet, with the same versions;
# what only one of them has is marked so. `tools/lock.sh --hashes` keeps the versions, and takes the digests anew.
set -euo pipefail
cd "$(dirname "$0")/.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

resolved() { # python, constraints
  "$1" -m venv "$work/$1"
  "$work/$1/bin/python" -m pip install --quiet --constraint "$2" '.[dev]' 'setuptools>=77'
  "$work/$1/bin/python" -m pip freeze --all --exclude stackdsl --exclude pip | sort --ignore-case
}

if [ "${1:-}" = --hashes ]; then
  grep -v '^ *#\|^ *--hash' requirements.lock | sed 's/ *\\$//' > "$work/pins"
else
  : > "$work/none"
  resolved "${1:-python3.11}" "$work/none" > "$work/older"
  resolved "${2:-python3.12}" "$work/older" > "$work/newer"
  {
    grep -Fxf "$work/newer" "$work/older"
    grep -Fxvf "$work/newer" "$work/older" | sed "s/\$/; python_version < '3.12'/"
    grep -Fxvf "$work/older" "$work/newer" | sed "s/\$/; python_version >= '3.12'/"
  } > "$work/pins"
fi

# pip tells the digests of what it installs here, and uv those of all files, for other machines too.
python3 -m venv "$work/hashing"
"$work/hashing/bin/python" -m pip install --quiet uv
index=$("$work/hashing/bin/python" -m pip config get global.index-url 2> "$work/unset" || true)
{
  echo "# Written by 'make lock'. Exact versions of all that a set-up installs, with the digests of their files."
  "$work/hashing/bin/uv" pip compile --quiet --no-config --no-deps --universal --python-version 3.11 --generate-hashes \
    --no-header --no-annotate --no-emit-index-url ${index:+--index-url "$index"} "$work/pins"
} > "$work/lock"
mv "$work/lock" requirements.lock

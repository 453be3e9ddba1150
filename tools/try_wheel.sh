#!/usr/bin/env bash
# Build the wheel and use it as somebody would who has never seen this checkout: in an empty environment, elsewhere,
# first the command alone, then the plugin of pytest with the extra that brings it, in the test that docs/python-api.md gives.
set -euo pipefail
cd "$(dirname "$0")/.."
checkout=$PWD
python=$(realpath --no-symlinks "${1:-.venv/bin/python}")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
unset PYTHONPATH
"$python" -m pip wheel --quiet --disable-pip-version-check --no-deps --no-build-isolation --wheel-dir "$work" .
wheel=$(echo "$work"/stackdsl-*.whl)
"$python" -m venv "$work/empty"
bin=$work/empty/bin
cd "$work"
CI=
export CI

"$bin/python" -m pip install --quiet --disable-pip-version-check "$wheel"
"$bin/stackdsl" schema | cmp - "$work"/empty/lib/python*/site-packages/stackdsl/scenario.schema.json
"$bin/stackdsl" demo | grep 'proven to stand' > demo.txt
"$bin/stackdsl" new tower
"$bin/stackdsl" check scenarios --update
"$bin/stackdsl" check scenarios

"$bin/python" -m pip install --quiet --disable-pip-version-check "stackdsl[pytest] @ file://$wheel"
sed -n '/^## Golden files in your own tests/,$ { /^```python/,/^```$/ { /^```/d; p } }' "$checkout/docs/python-api.md" > test_tower.py
test -s test_tower.py
"$bin/python" -m pytest -q --snapshot-update test_tower.py scenarios
"$bin/python" -m pytest -q test_tower.py scenarios

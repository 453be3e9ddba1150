"""What a set-up installs is known to the digest, wherever it comes from."""

import re

from tests.paths import ROOT

LOCK = (ROOT / "requirements.lock").read_text(encoding="utf-8")
PINNED = re.compile(
    r"[A-Za-z0-9._-]+==[A-Za-z0-9.!+_-]+( ; python_full_version (<|>=) '3\.12')?( \\\n    --hash=sha256:[0-9a-f]{64})+"
)


def test_every_requirement_has_a_version_and_the_digests_of_its_files_and_nothing_else() -> None:
    _comment, *lines = LOCK.splitlines(keepends=True)
    assert PINNED.sub("", "".join(lines)).strip() == ""


def test_the_lock_has_no_address() -> None:
    assert re.search(r"://|www\.|index|@ ", LOCK) is None


def test_the_set_up_installs_nothing_without_a_digest() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    set_up = makefile.split("$(READY): pyproject.toml", 1)[1].split("touch $@", 1)[0]
    installs = [line for line in set_up.splitlines() if "INSTALL" in line]
    assert [line for line in installs if "--require-hashes" not in line] == [
        "\t$(PIP_INSTALL) --no-build-isolation --editable ."
    ]
    assert "--no-deps" in makefile.split("PIP_INSTALL :=", 1)[1].splitlines()[0]
    assert re.search(r"^setuptools==", LOCK, re.MULTILINE)

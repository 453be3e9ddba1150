"""What a set-up installs is known to the digest, wherever it comes from."""

import re
from pathlib import Path

import pytest

from tests.paths import ROOT

LOCKS = sorted(ROOT.glob("requirements*.lock"))
CONDITION = (
    r"(python_full_version|sys_platform|implementation_name|platform_python_implementation) (<|>=|==|!=) '[\w.*]+'"
)
PINNED = re.compile(rf"[A-Za-z0-9._-]+==[A-Za-z0-9.!+_-]+( ; {CONDITION})?( \\\n    --hash=sha256:[0-9a-f]{{64}})+")
NAMES = re.compile(r"^([A-Za-z0-9._-]+)==", re.MULTILINE)


def read(lock: Path) -> str:
    return lock.read_text(encoding="utf-8")


@pytest.mark.parametrize("lock", LOCKS, ids=lambda lock: lock.name)
def test_every_requirement_has_a_version_and_the_digests_of_its_files_and_nothing_else(lock: Path) -> None:
    _comment, *lines = read(lock).splitlines(keepends=True)
    assert PINNED.sub("", "".join(lines)).strip() == ""


@pytest.mark.parametrize("lock", LOCKS, ids=lambda lock: lock.name)
def test_a_lock_has_no_address(lock: Path) -> None:
    assert re.search(r"://|www\.|index|@ ", read(lock)) is None


def test_running_installs_nothing_that_only_tests_and_style_need() -> None:
    running = set(NAMES.findall(read(ROOT / "requirements.lock")))
    assert running & {"pytest", "mypy", "ruff", "selenium", "hypothesis", "trimesh", "sphinx"} == set()
    assert {"numpy", "pydantic", "rich"} <= running


def test_the_set_up_installs_nothing_without_a_digest() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    set_up = makefile.split("$(READY): pyproject.toml", 1)[1].split("setup:", 1)[0]
    installs = [line for line in set_up.splitlines() if "INSTALL" in line]
    assert [line for line in installs if "--require-hashes" not in line] == [
        "\t$(PIP_INSTALL) --quiet --no-build-isolation --editable ."
    ]
    assert "--require-hashes" in makefile.split("LOCKED =", 1)[1].splitlines()[0]
    assert "--no-deps" in makefile.split("PIP_INSTALL :=", 1)[1].splitlines()[0]
    assert re.search(r"^setuptools==", read(ROOT / "requirements.lock"), re.MULTILINE)

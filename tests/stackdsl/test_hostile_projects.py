"""A project that somebody else sent: nothing outside of it is read, written or removed, whatever it is made of."""

import json
import os
import socket
import subprocess
import sys
from hashlib import sha256
from pathlib import Path

import pytest

from tests.command_line import GOOD, Result, Stackdsl, stackdsl_in, write
from tests.paths import ROOT

__all__ = ["stackdsl_in"]

MOVED = GOOD.replace("levels: 3", "levels: 4")
YEAR = 365 * 86400.0  # [s]


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """A project with a scenario, beside a home that is somebody's."""
    write(tmp_path, "precious", "home/docs/letter.txt")
    write(tmp_path, "precious", f"home/{'0' * 32}/letter.txt")
    write(tmp_path, "{}", f"home/{'1' * 32}/{'2' * 64}.json")
    write(tmp_path, '{"secret": 1}', "home/secret.json")
    for path in sorted((tmp_path / "home").rglob("*"), reverse=True):
        os.utime(path, (path.stat().st_mtime - YEAR,) * 2)
    write(tmp_path, "", "project/stackdsl.toml")
    write(tmp_path, GOOD, "project/scenarios/good.yaml")
    return tmp_path / "project"


@pytest.fixture
def stackdsl(stackdsl_in: Stackdsl, project: Path) -> Stackdsl:
    def call(*arguments: str, **environment: str) -> Result:
        return stackdsl_in(project, *arguments, **environment)

    return call


@pytest.fixture(autouse=True)
def home_is_as_it_was(project: Path) -> object:
    home = project.parent / "home"

    def seen() -> dict[str, tuple[bytes, float]]:
        files = {path: path.stat() for path in sorted(home.rglob("*"))}
        return {str(path): (path.read_bytes() if path.is_file() else b"", at.st_mtime) for path, at in files.items()}

    before = seen()
    yield
    assert seen() == before


def link(project: Path, name: str, target: str = "home") -> None:
    """A link in the project that leads to somebody's home."""
    path = project / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.symlink_to(os.path.relpath(project.parent / target, path.parent))


@pytest.mark.parametrize("name", [".stackdsl", ".stackdsl/passed", ".stackdsl/pending", ".stackdsl/failed.json"])
def test_links_in_place_of_what_is_remembered_are_refused(stackdsl: Stackdsl, project: Path, name: str) -> None:
    link(project, name)
    for command in (("check",), ("golden", "status"), ("golden", "accept"), ("check", "--update")):
        refused = stackdsl(*command)
        assert (refused.code, f"{name} is a link, which is not followed" in refused.err) == (4, True)


def test_only_directories_that_this_program_named_are_forgotten(stackdsl: Stackdsl, project: Path) -> None:
    passed = project / ".stackdsl" / "passed"
    old, foreign, mixed = passed / ("a" * 32), passed / "photos", passed / ("b" * 32)
    for folder in (old, foreign, mixed):
        write(folder, "{}", f"{'c' * 64}.json")
    write(mixed, "precious", "letter.txt")
    link(project, f".stackdsl/passed/{'d' * 32}")
    link(project, f".stackdsl/passed/{'e' * 32}", f"home/{'1' * 32}")
    for folder in (old, foreign, mixed):
        os.utime(folder, (0.0, 0.0))
    assert stackdsl("check").code == 0
    assert (old.exists(), (foreign / f"{'c' * 64}.json").exists()) == (False, True)
    assert [path.name for path in mixed.iterdir()] == ["letter.txt"]


def test_a_link_in_place_of_a_record_is_no_record_and_is_not_written_through(stackdsl: Stackdsl, project: Path) -> None:
    for _ in range(2):
        assert stackdsl("check").code == 0
    assert "remembered" in stackdsl("check").out
    for record in (project / ".stackdsl" / "passed").rglob("*.json"):
        record.rename(project / record.name)
        record.symlink_to(project.parent / "home" / "secret.json")
    assert "remembered" not in stackdsl("check").out


@pytest.mark.parametrize("kind", ["link", "hard link", "dangling"])
def test_the_file_that_keeps_git_off_is_not_written_through_a_link(
    stackdsl: Stackdsl, project: Path, kind: str
) -> None:
    (project / ".stackdsl").mkdir()
    if kind == "hard link":
        os.link(project.parent / "home" / "secret.json", project / ".stackdsl" / "failed.json")
    else:
        link(project, ".stackdsl/.gitignore", "home/secret.json" if kind == "link" else "home/new")
    write(project, GOOD.replace("stands: all", "height: < 1 mm"), "scenarios/good.yaml")
    assert stackdsl("check").code == (1 if kind == "hard link" else 4)


# --- golden files -----------------------------------------------------------------------------------------------------


def forged(project: Path, **changed: str) -> None:
    """Let something wait that this program did not write."""
    folder = project / ".stackdsl" / "pending"
    (file,) = folder.glob("*.json")
    value = {**json.loads(file.read_text()), "against": "", **changed}
    file.unlink()
    (folder / f"{sha256(value['golden'].encode()).hexdigest()[:32]}.json").write_text(json.dumps(value))


@pytest.fixture
def waiting(stackdsl: Stackdsl, project: Path) -> None:
    stackdsl("check")
    write(project, MOVED, "scenarios/good.yaml")
    assert stackdsl("check").code == 3


@pytest.mark.usefixtures("waiting")
@pytest.mark.parametrize(
    "changed",
    [
        {"golden": "golden/a/exact.json"},
        {"golden": "golden/a/.bashrc"},
        {"golden": "golden/good/other.json"},
        {"golden": "../home/new.json"},
        {"renamed_from": "golden/a/secret.json"},
        {"renamed_from": "golden/../../home/secret.json"},
        {"renamed_from": "golden/a/exact.json"},
        {"text": "alias ls='rm -rf ~'"},
        {"text": '{"format": 1}'},
        {"case": "other[exact]"},
    ],
)
def test_what_waits_is_accepted_only_as_this_program_writes_it(
    stackdsl: Stackdsl, project: Path, changed: dict[str, str]
) -> None:
    link(project, "golden/a")
    before = (project / "golden/good/exact.json").read_bytes()
    forged(project, **changed)
    if changed != {"renamed_from": "golden/a/exact.json"}:
        assert stackdsl("golden", "status").out == "0 waiting\n"
    stackdsl("golden", "accept")
    assert (project / "golden/good/exact.json").read_bytes() == before
    assert [path.name for path in (project / "golden").iterdir() if not path.is_symlink()] == ["good"]


@pytest.mark.usefixtures("waiting")
def test_what_a_link_leads_away_is_neither_accepted_nor_read(stackdsl: Stackdsl, project: Path) -> None:
    for file in (project / "golden" / "good").iterdir():
        file.unlink()
    (project / "golden" / "good").rmdir()
    link(project, "golden/good")
    stackdsl("check")
    for command in (("golden", "accept"), ("check", "--update"), ("check",)):
        refused = stackdsl(*command)
        assert (refused.code, "a link leads out of golden" in refused.text) == (3, True)


def test_a_golden_file_that_is_a_link_is_not_read(stackdsl: Stackdsl, project: Path) -> None:
    link(project, "golden/good/exact.json", "home/secret.json")
    seen = stackdsl("check")
    assert (seen.code, "secret" in seen.text, "a link leads out of golden" in seen.text) == (3, False, True)


@pytest.mark.parametrize("written", ["../home", "golden/../../home", "..", "/home"])
@pytest.mark.parametrize("key", ["golden", "scenarios"])
def test_a_directory_outside_of_the_project_is_refused(
    stackdsl: Stackdsl, project: Path, written: str, key: str
) -> None:
    write(project, f'{key} = "{written}"\n', "stackdsl.toml")
    refused = stackdsl("check", "scenarios")
    assert (refused.code, f"{key} is to be a directory below the file" in refused.err) == (4, True)


@pytest.mark.parametrize("marked", [True, False])
def test_a_directory_of_goldens_that_a_link_leads_outside_is_refused(
    stackdsl: Stackdsl, project: Path, marked: bool
) -> None:
    if not marked:
        (project / "stackdsl.toml").unlink()
    link(project, "golden")
    for command in (("check",), ("check", "--update"), ("check", "--golden", "golden"), ("golden", "prune")):
        refused = stackdsl(*command)
        assert (refused.code, "golden: a link leads out of" in refused.err) == (4, True)


def test_an_old_golden_file_is_not_renamed_through_a_link(stackdsl: Stackdsl, project: Path) -> None:
    assert stackdsl("check").code == 0
    (project / "golden" / "good" / "exact.json").rename(project / "golden" / "good[exact].json")
    (project / "golden" / "good").rmdir()
    link(project, "golden/good")
    assert stackdsl("golden", "rename").code != 0
    assert (project / "golden" / "good[exact].json").exists()


# --- what is read and what is written ---------------------------------------------------------------------------------


@pytest.mark.parametrize("target", ["home", "/", "home/secret.json"])
def test_links_out_of_a_project_are_told_and_not_followed(stackdsl: Stackdsl, project: Path, target: str) -> None:
    (project / "scenarios" / "more.yaml").symlink_to(target if target == "/" else project.parent / target)
    seen = stackdsl("check")
    assert (seen.code, "scenarios/more.yaml" in seen.out, "a link leads out of the project" in seen.out) == (
        2,
        True,
        True,
    )
    assert "secret" not in seen.out


@pytest.mark.parametrize("target", ["home/new", "home/secret.json"])
@pytest.mark.parametrize("form", ["json", "junit"])
def test_a_report_is_not_written_through_a_link(stackdsl: Stackdsl, project: Path, target: str, form: str) -> None:
    link(project, "report", target)
    refused = stackdsl("check", "--format", f"{form}=report")
    assert "a link leads out of" in refused.err


def test_folders_of_reports_rows_and_pages_are_not_written_through_a_link(stackdsl: Stackdsl, project: Path) -> None:
    link(project, "out")
    for arguments in (
        ("check", "--html", "out"),
        ("check", "--format", "json=out/report.json"),
        ("run", "scenarios/good.yaml", "--html", "out/run.html"),
        ("run", "scenarios/good.yaml", "--record", "out/run.npz"),
        ("new", "tower", "--to", "out"),
    ):
        assert "a link leads out of" in stackdsl(*arguments).err, arguments


def test_a_report_cuts_a_hard_link(stackdsl: Stackdsl, project: Path) -> None:
    os.link(project.parent / "home" / "secret.json", project / "report.json")
    assert stackdsl("check", "--format", "json=report.json").code == 0
    assert json.loads((project / "report.json").read_text())["results"]


# --- pipes, devices, sockets and directories --------------------------------------------------------------------------


def odd(path: Path, kind: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "device":
        path.symlink_to("/dev/zero")
    elif kind == "directory":
        path.mkdir()
    else:
        folder = os.getcwd()
        os.chdir(path.parent)  # the name of a socket has a hundred characters at most
        with socket.socket(socket.AF_UNIX) as unix:
            unix.bind(path.name)
        os.chdir(folder)


KINDS = pytest.mark.parametrize("kind", ["pipe", "device", "directory", "socket"])


@KINDS
@pytest.mark.parametrize(
    ("name", "arguments"),
    [
        ("load.csv", ("import", "load.csv")),
        ("tower.yaml", ("check", "tower.yaml")),
        ("tower.yaml", ("check", "tower.yaml:3")),
        ("tower.yaml", ("run", "tower.yaml")),
        ("tower.yaml", ("explain", "tower.yaml")),
        ("tower.yaml", ("find", "tower.yaml")),
        ("tower.yaml", ("suggest", "tower.yaml")),
        ("tower.yaml", ("order", "tower.yaml")),
        ("tower.yaml", ("survive", "tower.yaml")),
        ("tower.yaml", ("fragility", "tower.yaml", "--over", "friction")),
    ],
)
def test_what_is_no_regular_file_is_refused_by_every_command(
    stackdsl: Stackdsl, project: Path, kind: str, name: str, arguments: tuple[str, ...]
) -> None:
    odd(project / name, kind)
    refused = stackdsl(*arguments)
    assert refused.code in (2, 4)
    assert "it is no regular file" in refused.text or kind == "directory" or arguments[0] in ("find",)


@KINDS
@pytest.mark.parametrize("name", [".stackdsl/failed.json", "golden/good/exact.json", ".stackdsl/pending/ab.json"])
def test_what_is_no_regular_file_is_not_waited_for_in_place_of_state(
    stackdsl: Stackdsl, project: Path, kind: str, name: str
) -> None:
    odd(project / name, kind)
    for command in (("check",), ("golden", "status"), ("check", "--failed"), ("golden", "accept")):
        assert stackdsl(*command).code in (0, 3, 4)
    if name.startswith("golden"):
        assert stackdsl("check", "--update").code in (0, 3)


def test_a_pipe_that_nobody_reads_is_not_waited_for(stackdsl: Stackdsl, project: Path) -> None:
    os.mkfifo(project / "report.json")
    refused = stackdsl("check", "--format", "json=report.json")
    assert "report.json cannot be written" in refused.err


def test_a_module_of_the_project_is_not_run_in_place_of_one_of_python(tmp_path: Path, project: Path) -> None:
    write(project, "open('ran', 'w').close()\n", "multiprocessing.py")
    # As the installed command: what is found first is beside this script, and not in the project.
    write(tmp_path, "from stackdsl.__main__ import main\nif __name__ == '__main__':\n    main()\n", "command.py")
    command = [str(tmp_path / "command.py"), "sweep", "scenarios/good.yaml", "--out", "rows.jsonl", "--jobs", "2"]
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONSAFEPATH"}
    environment["PYTHONPATH"] = str(ROOT)
    done = subprocess.run([sys.executable, *command], cwd=project, env=environment, capture_output=True, check=False)
    assert not (project / "ran").exists()
    assert done.returncode == 0

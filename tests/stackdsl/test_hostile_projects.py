"""A project that somebody else sent: nothing outside of it is read, written or removed, whatever it is made of."""

import json
import os
import shutil
import socket
import subprocess
import sys
from collections.abc import Callable
from hashlib import sha256
from pathlib import Path
from types import SimpleNamespace

import pytest

from stackdsl.checking.cache import ResultCache
from stackdsl.checking.cases import cases_of
from stackdsl.checking.results import Goldens, checked
from stackdsl.disk import LeadsOutsideError, read_file
from stackdsl.goldens.golden import content, remove_obsolete, write_golden
from stackdsl.language.yaml.source import parse
from stackdsl.project_file import confined, project_of
from stackdsl.report.outline import remedy_text
from stackdsl.report.studies import sweep_lines
from stackdsl.results import GoldenResult
from stackdsl.supervising.worker import TaskResult, TaskStatus
from stackdsl.user_files import open_user_file, read_user_file, write_user_file
from stackdsl.viewing.server import Folder
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


@pytest.mark.parametrize(
    ("name", "commands"),
    [
        (".stackdsl", ("check", "golden status", "golden accept", "check --update")),
        (".stackdsl/passed", ("check",)),
        (".stackdsl/pending", ("check", "golden accept")),
        (".stackdsl/failed.json", ("check",)),
    ],
)
def test_links_in_place_of_what_is_remembered_are_refused(
    stackdsl: Stackdsl, project: Path, name: str, commands: tuple[str, ...]
) -> None:
    link(project, name)
    for command in map(str.split, commands):
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


@pytest.mark.parametrize(
    "value", ['{"cases": []}', '{"parts": [5], "cases": []}', '{"parts": {}, "cases": [[1, 2, 3, 4, 5]]}']
)
def test_a_record_of_cases_that_is_forged_is_no_record(stackdsl: Stackdsl, project: Path, value: str) -> None:
    stackdsl("check")
    for record in (project / ".stackdsl" / "passed").rglob("*.json"):
        digest = sha256(record.stem.encode() + value.encode()).hexdigest()
        record.write_text(f"{digest}\n{value}", encoding="utf-8")
    assert stackdsl("check").code == 0


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


@pytest.fixture(scope="module")
def moved(stackdsl_in: Stackdsl, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A project in which a change of a golden file waits."""
    folder = tmp_path_factory.mktemp("moved")
    write(folder, "", "stackdsl.toml")
    for text, code in ((GOOD, 0), (MOVED, 3)):
        write(folder, text, "scenarios/good.yaml")
        assert stackdsl_in(folder, "check").code == code
    return folder


@pytest.fixture
def waiting(moved: Path, project: Path) -> None:
    shutil.copytree(moved, project, dirs_exist_ok=True)


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
def test_a_forged_pending_golden_is_not_accepted(stackdsl: Stackdsl, project: Path, changed: dict[str, str]) -> None:
    link(project, "golden/a")
    before = (project / "golden/good/exact.json").read_bytes()
    forged(project, **changed)
    if changed != {"renamed_from": "golden/a/exact.json"}:
        assert stackdsl("golden", "status").out.startswith("0 pending;")
    stackdsl("golden", "accept")
    assert (project / "golden/good/exact.json").read_bytes() == before
    assert [path.name for path in (project / "golden").iterdir() if not path.is_symlink()] == ["good"]


@pytest.mark.usefixtures("waiting")
def test_a_golden_directory_that_a_link_leads_outside_is_neither_accepted_nor_read(
    stackdsl: Stackdsl, project: Path
) -> None:
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
    assert (refused.code, f"{key} must be a directory below the file" in refused.err) == (4, True)


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


ODD = ("pipe", "device", "directory", "socket")
KINDS = pytest.mark.parametrize("kind", ODD)


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
def test_every_command_refuses_a_file_that_is_not_regular(
    stackdsl: Stackdsl, project: Path, kind: str, name: str, arguments: tuple[str, ...]
) -> None:
    odd(project / name, kind)
    refused = stackdsl(*arguments)
    assert refused.code in (2, 4)
    told = "a link leads out of" if kind == "device" else "it is not a regular file"  # a link stands for the device
    assert told in refused.text or kind == "directory" or arguments[0] in ("find",)


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        *((".stackdsl/failed.json", kind) for kind in ODD),
        ("golden/good/exact.json", "pipe"),
        (".stackdsl/pending/ab.json", "pipe"),
    ],
)
def test_state_files_that_are_not_regular_block_no_command(
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


@pytest.mark.parametrize("start", ["reads a load", "NEW", "PREPARED"])
def test_a_module_of_the_project_is_not_run_for_a_library_beside_a_thread(
    tmp_path: Path, project: Path, start: str
) -> None:
    write(project, "open('ran', 'w').close()\n", "multiprocessing.py")
    script = write(tmp_path, BESIDE_A_THREAD, "script.py")
    write(project, "name,length,width,height,mass,x,y,z\na,1,1,1,1,0,0,0\n", "load.csv")
    done = run_by_python(project, str(script), start)
    assert (done.stdout, done.stderr) == ("done, and the environment is as it was\n", "")
    assert not (project / "ran").exists()


# A program of somebody else, with a thread: no copy of it is safe.
BESIDE_A_THREAD = """
import os
import sys
import threading
from pathlib import Path

from stackdsl.importers.supervised_reading import load_supervised
from stackdsl.language.imports import Import
from stackdsl.supervising.processes import run_supervised
from stackdsl.supervising.worker import WorkerStart, Task, TaskStatus

if __name__ == "__main__":
    end, before = threading.Event(), dict(os.environ)
    threading.Thread(target=end.wait).start()
    try:
        if sys.argv[1] in WorkerStart.__members__:
            ran = run_supervised([Task(os.getpid, (), 60.0)], 1, start=WorkerStart[sys.argv[1]])
            assert ran.results[0].status is TaskStatus.DONE, ran
        else:
            units = {"length": "m", "mass": "kg"}
            asked = Import.model_validate({"file": "load.csv", "point": "corner", "units": units})
            assert load_supervised(Path("load.csv").read_bytes(), "load.csv", asked, lambda name: b"").boxes
    finally:
        end.set()
    print("done, and the environment is", "as it was" if dict(os.environ) == before else "another")
"""


def run_by_python(project: Path, *arguments: str) -> "subprocess.CompletedProcess[str]":
    """Python, called in the project by somebody whose own settings let it import modules from there."""
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONSAFEPATH"}
    command, environment = [sys.executable, *arguments], environment | {"PYTHONPATH": str(ROOT)}
    return subprocess.run(command, cwd=project, env=environment, capture_output=True, check=False, text=True)


def test_a_module_of_the_project_is_not_run_by_the_module_switch(project: Path) -> None:
    for name in ("yaml.py", "signal.py", "click/__init__.py"):
        write(project, "open('ran', 'w').close()\n", name)
    done = run_by_python(project, "-m", "stackdsl", "explain", "scenarios/good.yaml")
    assert (done.returncode, (project / "ran").exists()) == (0, False)


# --- what is written bit by bit ---------------------------------------------------------------------------------------


def test_rows_are_not_written_through_a_hard_link(stackdsl: Stackdsl, project: Path) -> None:
    (project.parent / "home" / "empty").touch()
    os.link(project.parent / "home" / "empty", project / "rows.jsonl")
    refused = stackdsl("sweep", "scenarios/good.yaml", "--out", "rows.jsonl")
    (project / "rows.jsonl").unlink()
    assert "rows.jsonl cannot be written: it has several hard links" in refused.err
    assert (project.parent / "home" / "empty").read_bytes() == b""
    (project.parent / "home" / "empty").unlink()


# --- what a project names outside of itself ---------------------------------------------------------------------------


def test_dots_behind_a_link_lead_nowhere_else(stackdsl: Stackdsl, project: Path) -> None:
    """What is looked at is what is read, wherever the `..` of a path is taken back to."""
    write(project.parent, GOOD.replace("good", "base"), "secret/base.yaml")
    (project / "a" / "b" / "c").mkdir(parents=True)
    (project / "scenarios" / "l").symlink_to("../a/b/c")
    write(project, "scenario: good\nextends: l/../../../secret/base.yaml\n", "scenarios/good.yaml")
    write(project, GOOD.replace("good", "base"), "a/secret/base.yaml")  # which the system would take it for
    refused = stackdsl("check")
    assert (refused.code, "is outside the project" in refused.text) == (2, True)


def test_a_file_whose_name_cannot_be_shown_is_not_taken_for_another(stackdsl: Stackdsl, project: Path) -> None:
    write(project, "scenario: good\nextends: base.yaml\n", "scenarios/a\x1b/good.yaml")
    write(project, GOOD.replace("good", "base"), "scenarios/a\\x1b/base.yaml")
    (project / "scenarios/good.yaml").unlink()
    refused = stackdsl("check")
    assert (refused.code, "its name has characters that cannot be displayed" in refused.text) == (2, True)


@pytest.mark.parametrize("marked", [True, False])
@pytest.mark.parametrize("arguments", [(), ("scenarios",), ("scenarios/secret.yaml",)])
def test_scenarios_that_a_link_leads_outside_are_not_read(
    stackdsl: Stackdsl, project: Path, marked: bool, arguments: tuple[str, ...]
) -> None:
    write(project.parent, "password: 1234\n", "elsewhere/secret.yaml")
    write(project.parent, "", "elsewhere/stackdsl.toml")  # what a link leads to may be marked as well
    shutil.rmtree(project / "scenarios")
    if not marked:
        (project / "stackdsl.toml").unlink()
    link(project, "scenarios", "elsewhere")
    refused = stackdsl("check", *arguments)
    assert (refused.code in (2, 4), "a link leads out of" in refused.text) == (True, True)
    assert "password" not in refused.text


def test_files_outside_the_project_that_the_user_names_are_read(stackdsl: Stackdsl, project: Path) -> None:
    write(project.parent, GOOD, "elsewhere/good.yaml")
    for name in ("../elsewhere/good.yaml", str(project.parent / "elsewhere")):
        assert stackdsl("check", name, "--golden", "../elsewhere/golden").code == 0
    assert stackdsl("run", "../elsewhere/good.yaml", "--html", "../elsewhere/run.html").code == 0


@pytest.mark.parametrize("mark", ["stackdsl.toml", ".git/HEAD"])
def test_links_of_a_project_are_not_followed_from_outside_of_it(
    stackdsl_in: Stackdsl, project: Path, mark: str
) -> None:
    """The project of the files counts, and not only that of the working directory."""
    (project / "stackdsl.toml").unlink()
    write(project, "", mark)
    link(project, "out")
    for arguments in (
        ("check", "project/scenarios", "--html", "project/out"),
        ("check", "project/scenarios", "--format", "json=project/out/report.json"),
        ("run", "project/scenarios/good.yaml", "--html", "project/out/run.html"),
        ("new", "tower", "--to", "project/out"),
        ("init", "project/out"),
        ("sweep", "project/scenarios/good.yaml", "--out", "project/out/rows.jsonl"),
        ("check", "project/scenarios", "--golden", "project/out"),
    ):
        refused = stackdsl_in(project.parent, *arguments)
        assert (refused.code != 0, "a link leads out of project" in refused.err) == (True, True), arguments


def test_a_repository_inside_of_a_project_reaches_nothing_of_it(stackdsl_in: Stackdsl, project: Path) -> None:
    write(project, GOOD.replace("good", "password"), "private.yaml")
    write(project, "", "clone/.git/HEAD")
    write(project, "extends: ../private.yaml\nscenario: t\n", "clone/t.yaml")
    write(project, GOOD, "clone/scenarios/good.yaml")
    refused = stackdsl_in(project / "clone", "check", "t.yaml")
    assert (refused.code, "is outside the project" in refused.text) == (2, True)
    assert stackdsl_in(project / "clone", "check", "--update").code == 0
    assert (project / "clone/golden/good").is_dir()
    assert not (project / "golden").exists()


def test_folders_too_deep_to_be_read_are_told(
    stackdsl: Stackdsl, project: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(project / "scenarios")
    for _ in range(25):
        os.mkdir("d" * 200)
        os.chdir("d" * 200)
    refused = stackdsl("check")
    assert (refused.code, "cannot read the directory: File name too long" in refused.text) == (2, True)
    assert "1 files in scenarios" in stackdsl("doctor").text


@pytest.mark.usefixtures("waiting")
def test_no_file_outside_is_looked_into_for_what_waits(stackdsl: Stackdsl, project: Path) -> None:
    link(project, "l")
    for file in ("../home/docs/letter.txt", "l/docs/letter.txt", str(project.parent / "home/docs/letter.txt")):
        forged(project, file=file)
        assert "has no case" not in stackdsl("golden", "status").out
        read = stackdsl("golden", "accept", program=READ_BY + str([str(project.parent / "home"), "golden", "status"]))
        assert read.out.splitlines()[-1] == "[]", file


READ_BY = """
import os, sys
def told(event, arguments):
    if event == "open" and "letter" in str(arguments[0]):
        opened.append(arguments[0])
opened = []
sys.addaudithook(told)
from stackdsl.__main__ import main
sys.argv = ["stackdsl", "golden", "status"]
try:
    main()
except SystemExit:
    print(opened)
#"""


@pytest.mark.usefixtures("waiting")
@pytest.mark.parametrize("name", ["-", "./-", "/dev/stdin"])
def test_the_input_is_not_taken_for_the_file_of_what_waits(stackdsl_in: Stackdsl, project: Path, name: str) -> None:
    forged(project, file=name)
    asked = stackdsl_in(project, "golden", "status", keys="scenario: [")
    assert ("is gone" in asked.out, "1 pending" in asked.out) == (False, True)


@pytest.mark.parametrize("kept_by", ["../home/secret.json", "l/secret.json"])
def test_nobody_outside_keeps_a_golden_file(stackdsl: Stackdsl, project: Path, kept_by: str) -> None:
    """Else a project could learn which files there are elsewhere."""
    assert stackdsl("check").code == 0
    link(project, "l")
    (golden,) = (project / "golden").rglob("*.json")
    said = json.dumps({"kept_by": kept_by} | json.loads(golden.read_text()), indent=2)
    golden.write_text(said)
    write(project, GOOD.replace("scenario: good", "scenario: other"), "scenarios/good.yaml")
    assert "obsolete: " in stackdsl("golden", "prune", "--dry-run").out


@pytest.mark.parametrize("name", ["stackdsl.toml", "pyproject.toml"])
def test_a_mark_that_is_a_link_to_elsewhere_is_not_read(stackdsl: Stackdsl, project: Path, name: str) -> None:
    (project / "stackdsl.toml").unlink()
    write(project.parent, "[tool.stackdsl]\nhunter2 = 1\n", "elsewhere/secret.toml")
    link(project, name, "elsewhere/secret.toml")
    refused = stackdsl("check")
    assert (refused.code, "hunter2" in refused.text) == (4, False)
    assert f"{name}: a link leads out of" in refused.err


# --- links that are put in the way meanwhile --------------------------------------------------------------------------


@pytest.mark.parametrize("swapped", ["out", "out/file"])
@pytest.mark.parametrize("call", ["write", "append", "read"])
def test_a_link_that_is_put_in_the_way_after_a_path_was_looked_at_is_not_followed(
    project: Path, monkeypatch: pytest.MonkeyPatch, swapped: str, call: str
) -> None:
    write(project.parent, "precious", "home/file")
    before = (project.parent / "home").stat()
    write(project, "own", "out/file")
    looked_at = confined

    def swapping(path: Path, *folders: Path) -> str:
        true = looked_at(path, *folders)
        (project / swapped).rename(project / "aside")
        link(project, swapped, "home" if swapped == "out" else "home/file")
        return true

    monkeypatch.setattr("stackdsl.user_files.confined", swapping)
    file = project / "out" / "file"
    calls: dict[str, Callable[[], object]] = {
        "write": lambda: write_user_file(file, b"new"),
        "append": lambda: open_user_file(file, os.O_WRONLY | os.O_APPEND),
        "read": lambda: read_user_file(file),
    }
    with pytest.raises(OSError, match=r"Not a directory|Too many levels of symbolic links|it is not a regular file"):
        calls[call]()
    assert (project.parent / "home" / "file").read_text() == "precious"
    (project.parent / "home" / "file").unlink()
    os.utime(project.parent / "home", ns=(before.st_atime_ns, before.st_mtime_ns))


def test_a_directory_of_goldens_that_becomes_a_link_is_no_way_out(
    project: Path, stackdsl: Stackdsl, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("CI", raising=False)  # CI writes no golden
    assert stackdsl("check").code == 0
    golden = project_of([project / "scenarios"]).goldens()
    out = project.parent / "out"
    shutil.copytree(golden, out)
    write(out, "{}", f".{'0' * 32}.golden.tmp")
    os.utime(out / f".{'0' * 32}.golden.tmp", (0.0, 0.0))
    (out / "empty").mkdir()
    before = sorted(out.rglob("*"))
    golden.rename(project / "g0")
    link(project, "golden", "out")
    file = golden / "good" / "exact.json"
    assert isinstance(content(file, golden), GoldenResult)
    for written in (file, golden / "new" / "exact.json"):
        with pytest.raises(LeadsOutsideError):
            write_golden(written, "new", golden)
    assert remove_obsolete([str(file), str(golden / "empty" / "gone.json")]) == ()
    assert sorted(out.rglob("*")) == before


def test_a_root_that_becomes_a_link_is_no_place_to_remember_in(project: Path) -> None:
    memory = ResultCache(project / ".stackdsl")
    memory.keep_failed(["a"], ["a"])
    project.rename(project.parent / "p0")
    (project.parent / "out").mkdir()
    project.symlink_to(project.parent / "out")
    memory.keep_failed(["a"], ["a"])
    assert list((project.parent / "out").iterdir()) == []


def test_a_device_is_not_opened_to_see_what_it_is(project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    opened = list[object]()
    monkeypatch.setattr("stackdsl.disk.os.open", lambda *arguments, **_: opened.append(arguments))
    with pytest.raises(OSError, match="it is not a regular file"):
        read_file(Path("/dev/zero"))
    assert opened == []


def test_nobody_is_told_how_long_a_file_outside_is(stackdsl: Stackdsl, project: Path) -> None:
    link(project, "scenarios/more.yaml", "home/secret.json")
    refused = stackdsl("check", "scenarios/more.yaml:900")
    assert (refused.code, "has 1 lines" in refused.text, "a link leads out of" in refused.text) == (2, False, True)


@pytest.mark.parametrize("arguments", [("init",), ("new", "mine")])
def test_nothing_new_is_made_where_a_dangling_link_leads(
    stackdsl: Stackdsl, project: Path, arguments: tuple[str, ...]
) -> None:
    there = project.parent / "elsewhere"
    (there / "scenarios").mkdir(parents=True)
    for name in ("stackdsl.toml", "scenarios/mine.yaml"):
        (there / name).symlink_to(project.parent / "new.txt")
    stackdsl(*arguments, *([str(there)] if arguments == ("init",) else ["--to", str(there / "scenarios")]))
    assert not (project.parent / "new.txt").exists()


def test_no_schema_outside_is_read_nor_advised_to_be_written_over(stackdsl: Stackdsl, project: Path) -> None:
    link(project, "scenario.schema.json", "home/secret.json")
    told = stackdsl("doctor").out
    assert ("scenario.schema.json: a link leads out of" in told, "stackdsl schema >" in told) == (True, False)


def test_no_page_outside_is_served_and_no_link_out_is_watched(stackdsl: Stackdsl, project: Path) -> None:
    write(project.parent, "secret", "pages/index.html")
    link(project, "report", "pages")
    assert Folder(project / "report").page("index.html") is None
    refused = stackdsl("check", "--watch", "--html", "report")
    assert (refused.code != 0, "a link leads out of" in refused.err, "open http" in refused.text) == (True, True, False)
    refused = stackdsl("check", "--watch")
    assert (refused.code, "report is a link out of the watched folder" in refused.err) == (4, True)


def test_file_names_in_advice_are_quoted_for_a_shell() -> None:
    (case,), _ = cases_of(parse(GOOD, "x;touch PWNED;.yaml"))
    crashed = checked(case, TaskResult(TaskStatus.CRASHED, message="it ended"), Goldens(None))
    assert "stackdsl run 'x;touch PWNED;.yaml' -k" in remedy_text(crashed)


def test_what_a_forged_row_of_a_sweep_says_steers_no_terminal() -> None:
    kind = SimpleNamespace(verdict="stands", level=None, how="\x1b]0;pwn\x07")
    entry = SimpleNamespace(name="good", case=SimpleNamespace(is_sampled=False))
    (told,) = sweep_lines([SimpleNamespace(rows=1, entry=entry, kinds=[kind])])  # type: ignore[list-item]
    assert told == r"good: stands (\x1b]0;pwn\x07)"


# --- plots ------------------------------------------------------------------------------------------------------------

PLOT = ("survive", "scenarios/good.yaml", "--bearings", "4", "--plot", "plot.svg")


@pytest.mark.parametrize("target", ["home/new.svg", "home/secret.json"])
def test_a_plot_is_not_written_through_a_link(stackdsl: Stackdsl, project: Path, target: str) -> None:
    link(project, "plot.svg", target)
    assert "plot.svg cannot be written: a link leads out of this directory" in stackdsl(*PLOT).err


def test_a_plot_cuts_a_hard_link(stackdsl: Stackdsl, project: Path) -> None:
    secret = project.parent / "home" / "secret.json"
    before = secret.read_bytes()
    os.link(secret, project / "plot.svg")
    assert stackdsl(*PLOT).code == 0
    assert (project / "plot.svg").read_bytes().startswith(b"<svg")
    assert secret.read_bytes() == before

"""The architecture, as a test: imports point one way, and one file knows the engine."""

import ast
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
FILES = sorted(path for package in ("stability", "stackdsl") for path in (ROOT / package).rglob("*.py"))

# From the facts up to the shell: a module may import only what stands before it.
ORDER = {
    "stability": (
        "model",
        "geometry",
        "vectors",
        "pendulum",
        "impulse",
        "rigid_group",
        "separation",
        "patch",
        "contact",
        "contact_graph",
        "support",
        "statics.facts",
        "statics.polygons",
        "statics.contacts.solids",
        "statics.contacts.axes",
        "statics.contacts.level",
        "statics.contacts.planes",
        "statics.contacts.faces",
        "statics.contacts.cones",
        "statics.contacts.features",
        "statics.contacts.touch",
        "leaning",
        "impact",
        "statics.contacts.neighbours",
        "statics.proof",
        "statics.programmes.programme",
        "statics.programmes.wrench_matrix",
        "statics.programmes.opening",
        "statics.programmes.equilibrium",
        "statics.programmes.self_stress",
        "statics.programmes.fall_words",
        "statics.programmes.mechanism",
        "statics.programmes.onset",
        "statics.load_core",
        "statics.propagation",
        "statics.tipping",
        "statics.structure",
        "statics.overlaps",
        "statics.ledger",
        "statics.certificate",
        "statics.brick_graph",
        "statics.cascade",
        "statics.admission",
        "statics.assembly",
        "statics.onset",
        "statics.turning",
        "statics.sliding",
        "statics.margins.prestress",
        "statics.margins.arc_forces",
        "statics.margins.face_centre",
        "statics.margins.acceleration_cut",
        "statics.margins.sliding_all_ways",
        "statics.margins.acceleration",
        "statics.margins.friction",
        "statics.margins.placement_patches",
        "statics.margins.placement_programme",
        "statics.margins.placement",
        "statics.margins.summary",
        "freezing",
        "engine_settings",
        "stepping",
        "engine",
        "edge_contacts",
        "approach",
        "bounding_boxes",
        "kept_bodies",
        "mujoco_engine",
        "mujoco_engine.settings",
        "mujoco_engine.binding",
        "mujoco_engine.model",
        "mujoco_engine.world",
        "sapien_engine",
        "sapien_engine.settings",
        "sapien_engine.binding",
        "sapien_engine.world",
        "pybullet_engine",
        "pybullet_engine.binding",
        "pybullet_engine.parameters",
        "pybullet_engine.solids",
        "pybullet_engine.bodies",
        "pybullet_engine.planes",
        "pybullet_engine.world",
        "pybullet_engine.reshaping",
        "pybullet_engine.cones",
        "pybullet_engine.joining",
        "toppling",
        "falling",
        "resting",
        "touching",
        "stillness",
        "refusals",
        "held_bodies",
        "direct_hits",
        "watching",
        "extension",
        "statics.extra_load",
        "judgement",
        "candidates",
        "foreign_changes",
        "overload",
        "disturbances",
        "riders",
        "region",
        "putting_back",
        "awake_bricks",
        "proven_extension",
        "resting_world",
    ),
    "stackdsl": (
        "diagnostics",
        "reading.characters",
        "reading.plain_scalars",
        "reading.yaml_syntax",
        "reading.nodes",
        "reading.source",
        "language.mistakes",
        "language.quantities",
        "language.tolerances",
        "language.expressions",
        "language.variants",
        "language.author_types",
        "language.author_models",
        "language.anchors",
        "language.catalogue",
        "language.layouts",
        "language.card_house",
        "language.leaning_structure",
        "language.bricks",
        "language.claims",
        "language.impacts",
        "language.schema",
        "language.validation",
        "timeline",
        "compiling.fitting",
        "compiling.written",
        "compiling.site",
        "compiling.naming",
        "compiling.scheduling",
        "compiling.removals",
        "compiling.standing",
        "compiling.throws",
        "compiling.drops",
        "compiling.flights",
        "compiling.pushes",
        "compiling.hits",
        "compiling.agreement",
        "compiling.compiler",
        "playing.systems",
        "playing.resolution",
        "playing.peers",
        "trace",
        "margins",
        "observations",
        "proving",
        "refinement",
        "playing.watch",
        "playing.clearance",
        "playing.tracks",
        "playing.energy",
        "playing.onset",
        "playing.landing",
        "playing.measuring",
        "playing.going_on",
        "playing.carrying",
        "playing.edges",
        "playing.event_log",
        "playing.opening",
        "playing.runner",
        "assessing.assessment",
        "assessing.compas",
        "outcome",
        "judging.finding",
        "judging.standing",
        "judging.moving",
        "judging.falling",
        "judging.proven",
        "expectations",
        "snapshots.record",
        "snapshots.snapshot",
        "snapshots.canonical",
        "snapshots.comparison",
        "snapshots.golden",
        "pool",
        "gathering",
        "selection",
        "check",
        "report.diagnostic_text",
        "report.event_text",
        "report.edge_text",
        "report.explanation",
        "report.outcome_text",
        "report.run_text",
        "report.change_text",
        "report.blocks",
        "report.text",
        "report.json",
        "terminal",
        "options",
        "bench.entrants",
        "bench.measuring",
        "bench.answers",
        "bench.record",
        "bench.journal",
        "bench.scoring",
        "bench.points",
        "bench.conduct",
        "bench.table",
        "bench.summary",
        "bench.plot",
        "bench.page",
        "bench.command",
        "cli",
        "__main__",
        "pytest_plugin",
    ),
}


def imported(path: Path) -> Iterator[str]:
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def module_name(path: Path) -> str:
    return ".".join(path.relative_to(ROOT).with_suffix("").parts)


@pytest.mark.parametrize("path", FILES, ids=module_name)
def test_modules_import_only_what_stands_before_them(path: Path) -> None:
    package, _, own = module_name(path).partition(".")
    if own.endswith("__init__"):
        return
    order = ORDER[package]
    assert own in order, f"{own} has no place in ORDER: decide what it may import"
    for name in imported(path):
        head, _, rest = name.partition(".")
        if head == package and rest in order:
            assert order.index(rest) < order.index(own), f"{own} imports {rest}, which stands after it"


def test_stability_does_not_know_the_language() -> None:
    offenders = [p for p in FILES if p.parts[-2] == "stability" and any(n.startswith("stackdsl") for n in imported(p))]
    assert offenders == []


ENGINES = pytest.mark.parametrize("engine", ["pybullet", "mujoco", "sapien"])


@ENGINES
def test_one_file_imports_the_engine(engine: str) -> None:
    users = [module_name(p) for p in FILES if any(n.split(".")[0] == engine for n in imported(p))]
    assert users == [f"stability.{engine}_engine.binding"]


def test_one_file_imports_the_assessor() -> None:
    names = {"compas", "compas_assembly", "compas_cra"}
    users = [module_name(p) for p in FILES if any(n.split(".")[0] in names for n in imported(p))]
    assert users == ["stackdsl.assessing.compas"]


@ENGINES
def test_one_package_knows_the_engine_and_all_else_asks_it(engine: str) -> None:
    package = f"stability.{engine}_engine"
    users = {module_name(p) for p in FILES if any(n.startswith(f"{package}.binding") for n in imported(p))}
    assert all(user.startswith(package) for user in users)


def test_the_command_line_starts_without_the_engine() -> None:
    code = "import sys, stackdsl.cli; sys.exit(bool({'pybullet', 'mujoco', 'sapien', 'compas'} & set(sys.modules)))"
    assert subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=False).returncode == 0

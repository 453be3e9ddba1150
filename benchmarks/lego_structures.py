"""Judges the published LEGO structures of StableLego, BrickGPT and APEX-MR, also by the rule of StableLego.

Each gets a verdict and a load factor, and the load factor by that rule, for the mirrored structure, too.
The structures are files of three repositories, of which this project holds no copy. Times are processor times of the
verdict on all bricks at once. Run: python -m benchmarks.lego_structures STABLELEGO BRICKGPT APEX_MR [--write], with the
folders of intelligent-control-lab/StableLego, AvaLovelace1/BrickGPT and intelligent-control-lab/APEX-MR.
"""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from math import isclose, pi
from pathlib import Path
from time import process_time
from typing import Final

from rich.console import Console

from benchmarks.figures.data import Row, Rows
from benchmarks.figures.recording import parser, record
from benchmarks.stablelego_rule import MOST, LegoBrick, rule_load_factor
from stability.analysis.load_factor import LoadFactor, load_factor
from stability.geometry.box import Box
from stability.joints import JointRule, Joints, Studs
from stability.model import GROUND, Brick, Plane, Pose
from stability.problem import Placed, Stability
from stability.statics.assembly import Assembly
from stackdsl.importers.formats import read_load
from stackdsl.importers.load import LEVEL, ImportedLoad
from stackdsl.language.imports import Import
from stackdsl.language.joints import LEGO_STUDS
from stackdsl.language.lego import PITCH, PLATE, PLATES
from stackdsl.language.rotations import about_z

FRICTION: Final = 0.5
HEIGHT: Final = PLATES * PLATE
MIRRORED: Final = 1e-6  # largest relative difference of the load factors of a structure and its mirror image
# Outcomes that the authors of StableLego saw; the file with a horizontal force has no published result. Verdicts of
# BrickGPT are those of its score: a structure that it prints has passed it.
SEEN: Final[Mapping[str, str]] = {
    "stair_19": "stands",
    "stair_20": "falls",
    "stair_20_good": "stands",
    "stick_light": "stands",
    "stick_heavy": "falls",
    "stick_heavy_good": "stands",
    "external_weight_good": "stands",
    "external_weight_fail": "falls",
}
WORDS: Final = {Stability.STABLE: "stands", Stability.UNSTABLE: "falls", Stability.UNDECIDED: "undecided"}


@dataclass(frozen=True)
class Structure:
    """A published structure and its published verdict."""

    source: str
    name: str
    load: ImportedLoad
    published: str


def structures(stablelego: Path, brickgpt: Path, apex: Path) -> Iterator[Structure]:
    """Yield the structures of three repositories."""
    for path in sorted((stablelego / "test_lego").glob("*.json")):
        load = _read(path.read_bytes(), path, library="../lego_library.json")
        yield Structure("StableLego", path.stem, load, SEEN.get(path.stem, "not published"))
    for path in sorted([*brickgpt.glob("src/texture/examples/*.txt"), *brickgpt.glob("src/mesh2brick/tests/*.txt")]):
        yield Structure("BrickGPT", f"{path.parent.name}/{path.stem}", _read(path.read_bytes(), path), "stands")
    path = brickgpt / "src/demo/examples/examples.json"
    for name, example in json.loads(path.read_text(encoding="utf-8")).items():
        load = _read(example["output_txt"].encode(), path, format="brickgpt")
        yield Structure("BrickGPT", f"demo/{name}", load, "stands")
    path = brickgpt / "src/brickgpt/models/few_shot_examples.json"
    for number, example in enumerate(json.loads(path.read_text(encoding="utf-8")), start=1):
        load = _read(example["bricks"].encode(), path, format="brickgpt")
        yield Structure("BrickGPT", f"examples/{number}", load, "stands" if example["is_stable"] else "falls")
    for path in sorted((apex / "config/lego_tasks/assembly_tasks").glob("*.json")):
        load = _read(path.read_bytes(), path, library="../lego_library.json", format="apex-mr")
        yield Structure("APEX-MR", path.stem, load, "task")


def _read(data: bytes, path: Path, **options: str) -> ImportedLoad:
    asked = Import.model_validate({"file": path.name, **options})
    return read_load(data, path.name, asked, lambda name: (path.parent / name).read_bytes())


def assembly_of(load: ImportedLoad) -> tuple[Assembly, list[Placed]]:
    """Return an empty assembly on a base plate, and the bricks of a structure."""
    placed = []
    for box in load.boxes:
        length, width, height = map(float, box.size)
        x, y, z = map(float, box.centre)
        pose = Pose((x, y, z), about_z(0.0 if box.turn == LEVEL else 0.5 * pi))
        placed.append(Placed(Brick(str(box.name), Box((length, width, height)), float(box.mass)), pose))
    names = {*(brick.brick.id for brick in placed), GROUND}
    grid = LEGO_STUDS
    studs = Studs(grid.pitch, grid.pull, grid.shear, grid.narrow_pull)
    planes = (Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), FRICTION),)
    return Assembly(planes, FRICTION, joints=Joints((JointRule(studs, (names, names)),))), placed


def lego_bricks(load: ImportedLoad) -> list[LegoBrick]:
    """Return the bricks in studs."""
    bricks = []
    for box in load.boxes:
        length, width, height = box.size
        along, across = (length, width) if box.turn == LEVEL else (width, length)
        at = [(box.centre[0] - along / 2) / PITCH, (box.centre[1] - across / 2) / PITCH]
        cell = int(at[0]), int(at[1]), int((box.centre[2] - height / 2) / HEIGHT)
        bricks.append(LegoBrick(cell, (int(along / PITCH), int(across / PITCH)), float(box.mass)))
    return bricks


def measured(structure: Structure) -> Row:
    """Return one row of the table."""
    assembly, bricks = assembly_of(structure.load)
    started = process_time()
    verdict = assembly.add_all(bricks)
    verdict_ms = 1e3 * (process_time() - started)
    started = process_time()
    factor = load_factor(assembly.problem())
    factor_ms = 1e3 * (process_time() - started)
    _require_same_mirrored(structure, verdict.stability, factor)
    cells = lego_bricks(structure.load)
    rules = [rule_load_factor(cells, float(PITCH), float(HEIGHT), mirrored) for mirrored in (False, True)]
    return {
        "source": structure.source,
        "structure": structure.name,
        "bricks": len(bricks),
        "verdict": WORDS[verdict.stability],
        "load_factor": "not found" if factor is None else _text(factor.factor),
        "verdict_ms": verdict_ms,
        "factor_ms": factor_ms,
        "rule": _text(rules[0]),
        "mirrored": _text(rules[1]),
        "published": structure.published,
    }


def _require_same_mirrored(structure: Structure, stability: Stability, factor: LoadFactor | None) -> None:
    """Raise ArithmeticError if the mirrored structure has another verdict or load factor."""
    boxes = (replace(box, centre=(-box.centre[0], box.centre[1], box.centre[2])) for box in structure.load.boxes)
    assembly, bricks = assembly_of(replace(structure.load, boxes=tuple(boxes)))
    verdict = assembly.add_all(bricks).stability
    mirrored = load_factor(assembly.problem())
    factors = [-1.0 if each is None else each.factor for each in (factor, mirrored)]
    if verdict is not stability or not isclose(*factors, rel_tol=MIRRORED):
        raise ArithmeticError(f"{structure.name}: {stability}, {factors[0]}; mirrored {verdict}, {factors[1]}")


def _text(factor: float) -> str:
    return "no limit" if factor >= MOST * (1.0 - 1e-6) else f"{factor:.3f}" if factor < 10.0 else f"{factor:.3g}"  # noqa: PLR2004


def main() -> None:
    """Measure and print the table; write it on request."""
    arguments = parser(__doc__)
    for name in ("stablelego", "brickgpt", "apex_mr"):
        arguments.add_argument(name, type=Path)
    chosen = arguments.parse_args()
    console = Console(stderr=True)
    rows: dict[str, Row] = {}
    for structure in structures(chosen.stablelego, chosen.brickgpt, chosen.apex_mr):
        rows[f"{structure.source} {structure.name}"] = row = measured(structure)
        console.print(*row.values())
    tables: Mapping[str, Rows] = {"structures": rows}
    if chosen.write:
        command = "python -m benchmarks.lego_structures STABLELEGO BRICKGPT APEX_MR --write"
        record("lego-structures", command, tables)


if __name__ == "__main__":
    main()

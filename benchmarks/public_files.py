"""Judges public files of blocks: vaults of compas_dem, arches and slopes of Rigid-IPC, towers with off-centre masses.

The files are of three repositories, of which this project holds no copy. Published results are compared with proofs:
contact forces of a barrel vault with the least and the greatest that balance it, and labels of towers with verdicts.
Times are processor times of the verdict on all bricks at once, with contact detection.

Run: python -m benchmarks.public_files COMPAS_DEM RIGID_IPC STACKING [--write], with the folders of
BlockResearchGroup/compas_dem (559107e), ipc-sim/rigid-ipc (23b6ba6) and
Learning-and-Intelligent-Systems/stacking (114f412).
"""

import json
import pickle
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import degrees, hypot, inf, isfinite, radians, tan
from pathlib import Path
from time import process_time
from typing import Any, Final

import numpy as np
from rich.console import Console
from scipy.spatial.transform import Rotation

from benchmarks.compas_reading import assembly_of
from benchmarks.figures.data import Row, Rows, Value
from benchmarks.figures.recording import parser, record
from stability.analysis.load_bounds import loads_between
from stability.geometry.box import Box, OffCentreBox
from stability.geometry.rows import Array
from stability.model import Brick, Plane, Pose
from stability.problem import Placed, Problem, Stability
from stability.statics.assembly import LEVEL_GROUND, Assembly
from stackdsl.importers.closing import with_closed_joints
from stackdsl.importers.formats import read_load
from stackdsl.importers.load import ImportedLoad, UnreadableLoadError
from stackdsl.language.imports import Import

WORDS: Final = {Stability.STABLE: "stands", Stability.UNSTABLE: "falls", Stability.UNDECIDED: "undecided"}
VAULT: Final = "scripts/DEM_Analysis_References/Barrel_Vault/DEM_results.json"
SEEN: Final = {"0.49": "slides", "0.5": "holds"}  # of the slopes, by friction
UPPER, LOWER = [2, 3, 6, 7], [0, 1, 4, 5]  # corners of the faces of a stone that meet its neighbours
FRICTION_STEP: Final = 5e-4
EVERY: Final = 16  # interfaces of the barrel vault of which one is compared; each takes more than 0.1 s
FLUSH: Final = 1e-4  # largest gap or overlap of blocks of a tower [m]
PENETRATION: Final = 1e-3  # share of a force by which the published ones, of a motion, may miss balance


@dataclass(frozen=True)
class Judged:
    """A file with the verdict on its blocks."""

    row: dict[str, Value]
    problem: Problem | None = None


def main() -> None:
    """Measure, print and write on request."""
    arguments = parser(__doc__)
    for name in ("compas_dem", "rigid_ipc", "stacking"):
        arguments.add_argument(name, type=Path, help="folder of a checkout")
    asked = arguments.parse_args()
    console = Console(width=200)
    rows: dict[str, Row] = {}
    forces: Rows = {}
    for name, judged in files(asked.compas_dem, asked.rigid_ipc):
        rows[name] = judged.row
        console.print(name, *judged.row.values())
        if name == "barrel vault" and judged.problem is not None:
            forces = {name: compared_forces(judged.problem, asked.compas_dem / VAULT)}
            console.print(forces)
    towers = judged_towers(sorted((asked.stacking / "learning/data").glob("*.pkl")))
    for name, row in towers.items():
        console.print(name, *row.values())
    if asked.write:
        command = "python -m benchmarks.public_files COMPAS_DEM RIGID_IPC STACKING --write"
        record("public-files", command, {"files": rows, "forces": forces, "towers": towers})


def files(compas_dem: Path, rigid_ipc: Path) -> Iterator[tuple[str, Judged]]:
    """Yield each file with its verdict."""
    said: Mapping[str, object] = {"format": "compas", "units": {"length": "m"}, "supports": "bricks"}
    stone: Mapping[str, object] = {"density": "2000 kg/m3"}
    ignored = {"ignore": ["boundary_conditions", "contact_properties"]}
    yield "barrel vault", model(compas_dem / VAULT, {**said, **ignored}, 0.5, "stands: forces")
    path = compas_dem / "data/dem_crossvault.json"
    yield "cross vault of 38", model(path, {**said, **stone}, tan(radians(70.0)), "no result")
    path = compas_dem / "data/crossvault.json"
    yield "cross vault of 184", model(path, {**said, **stone}, tan(radians(70.0)), "no result")
    meshes: Mapping[str, object] = {"format": "obj", "units": {"length": "m"}, "up": "+z", **stone}
    for name in ("wall", "dome"):
        yield name, model(compas_dem / f"data/{name}.obj", meshes, 0.7, "no result")
    for count in (25, 101):
        yield f"arch of {count}", arch(rigid_ipc, count)
    yield "arch of 25, moved", arch(rigid_ipc, 25, "2")
    for friction in ("0.49", "0.5"):
        yield f"slope, friction {friction}", slope(rigid_ipc, friction)


def model(path: Path, said: Mapping[str, object], friction: float, published: str) -> Judged:
    """Judge a file as `import` reads it, with its supports fixed; without supports, with its lowest blocks fixed."""
    started = process_time()
    try:
        load = read_load(path.read_bytes(), path.name, Import.model_validate({"file": path.name, **said}))
    except UnreadableLoadError as error:
        return Judged(_row(0, friction, "not read", published, "", 0.0, 0.0, error.diagnostics[0].message))
    reading = process_time() - started
    fixed = supports_of(path, load)
    return judged(load, fixed, friction, published, "as it is", reading)


def supports_of(path: Path, load: ImportedLoad) -> set[str]:
    """Return the names of the fixed blocks: those that the file marks, else those on the level of the lowest corner."""
    marked: set[str] = set()
    if path.suffix == ".json":
        whole = json.loads(path.read_text(encoding="utf-8"))["data"]
        whole = whole["model"]["data"] if "model" in whole else whole
        elements = whole["elements"]
        by_guid = {each["guid"]: each for each in elements} if isinstance(elements, list) else elements
        nodes = whole["graph"]["node"]
        marked = {f"block-{key}" for key, node in nodes.items() if by_guid[node["element"]]["data"]["is_support"]}
    if marked:
        return marked
    lows = {each.name or "": float(each.centre[2] - each.size[2] / 2) for each in load.boxes}
    level = min(lows.values()) + 0.01 * max(float(each.size[2]) for each in load.boxes)
    return {name for name, low in lows.items() if low <= level}


def judged(  # noqa: PLR0913, PLR0917 -- the cells of a row
    load: ImportedLoad, fixed: set[str], friction: float, published: str, way: str, reading: float
) -> Judged:
    """Judge blocks on fixed ones, or on the ground if none is fixed."""
    assembly, bricks = assembly_of(load, fixed, friction)
    started = process_time()
    verdict = assembly.add_all(bricks)
    seconds = process_time() - started
    word = WORDS[verdict.stability]
    problem = assembly.problem() if verdict.stability is Stability.STABLE else None
    note = verdict.reason if verdict.stability is not Stability.STABLE else ""
    count = len(load.boxes)
    return Judged(_row(count, friction, word, published, way, reading, seconds, note.split(" (")[0]), problem)


def _row(  # noqa: PLR0913, PLR0917 -- the cells of a row
    blocks: int, friction: float, verdict: str, published: str, way: str, reading: float, seconds: float, note: str
) -> dict[str, Value]:
    return {
        "blocks": blocks,
        "friction": friction,
        "verdict": verdict,
        "published": published,
        "read": way,
        "reading_s": reading,
        "ms": 1e3 * seconds,
        "note": note,
    }


# --- the published forces of the barrel vault -------------------------------------------------------------------------


def compared_forces(problem: Problem, path: Path) -> Row:
    """Compare the published normal force of each interface with the least and the greatest that balance the blocks."""
    graph = json.loads(path.read_text(encoding="utf-8"))["data"]["model"]["data"]["graph"]
    published: dict[frozenset[str], float] = defaultdict(float)
    net: dict[str, Array] = defaultdict(lambda: np.zeros(3))
    steepest = 0.0
    for one, others in graph["edge"].items():
        for other, edge in others.items():
            for n, s, t in zip(
                *(edge.get(f"force_{key}", ()) for key in ("normal", "tangent1", "tangent2")), strict=True
            ):
                published[frozenset((f"block-{one}", f"block-{other}"))] += n
                steepest = max(steepest, hypot(s, t) / n if n > 1.0 else 0.0)
            for force in edge.get("force_vector", ()):
                net[one] = net[one] + force
                net[other] = net[other] - force
    started = process_time()
    touching = sorted({(contact.lower, contact.upper) for contact in problem.contacts})
    bounds = loads_between(problem, touching[::EVERY])
    seconds = process_time() - started
    assert bounds is not None
    below = above = reached = proven = 0
    for (lower, upper), carried in bounds.items():
        force = published[frozenset((lower, upper))]
        least, greatest = carried.least.reached, carried.greatest.reached
        slack = PENETRATION * max(force, 1.0)
        proven += isfinite(carried.least.force) and isfinite(carried.greatest.force)
        below += least is not None and force < least - slack
        reached += greatest is not None
        above += greatest is not None and force > greatest + slack
    residual = max(
        abs(float(hypot(*(net[name.removeprefix("block-")] * sign + wrench.force_W)[:3])))
        for sign in (_sign(net, problem),)
        for name, wrench in problem.loads.items()
    )
    return {
        "interfaces": len(touching),
        "compared": len(bounds),
        "proven": proven,
        "below_least": below,
        "greatest_reached": reached,
        "above_greatest": above,
        "not_touching": sum(
            force > 1.0 and pair not in {*map(frozenset, touching)} for pair, force in published.items()
        ),
        "largest_residual_n": residual,
        "steepest": steepest,
        "seconds": seconds,
        "ms_each": 1e3 * seconds / len(bounds),
    }


def _sign(net: Mapping[str, Array], problem: Problem) -> float:
    """Return the sign of the published forces: those on the blocks together carry the weight."""
    return 1.0 if sum(float(net[name.removeprefix("block-")][2]) for name in problem.bricks) > 0.0 else -1.0


# --- Rigid-IPC --------------------------------------------------------------------------------------------------------


def arch(folder: Path, count: int, settle: str = "") -> Judged:
    """Judge the stones of an arch, one OBJ file each, on the ground.

    The stones are 0.1 to 0.2 m apart. Their joints are filled: the faces of both move to the middle between them, and
    the lowest faces to the ground. With `settle` the stones move instead.
    """
    paths = sorted(
        (folder / f"meshes/arch/num_stones={count}").glob("stone-*.obj"), key=lambda path: int(path.stem[6:])
    )
    fixture = json.loads((folder / f"fixtures/3D/friction/arch/arch-{count}-stones.json").read_text(encoding="utf-8"))
    friction = float(fixture["rigid_body_problem"]["coefficient_friction"])
    stones = [[line.split() for line in path.read_text(encoding="utf-8").splitlines()] for path in paths]
    corners = np.array([[[*map(float, parts)] for kind, *parts in stone if kind == "v"] for stone in stones])
    if not settle:
        middle = 0.5 * (corners[:-1, UPPER] + corners[1:, LOWER])
        corners[:-1, UPPER] = corners[1:, LOWER] = middle
        corners[0, LOWER, 1] = corners[-1, UPPER, 1] = 0.0
    lines: list[str] = []
    for number, (path, stone) in enumerate(zip(paths, stones, strict=True)):
        lines.append(f"o {path.stem}")
        lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in corners[number].tolist()]
        first = number * len(corners[number])
        lines += ["f " + " ".join(str(int(part) + first) for part in parts) for kind, *parts in stone if kind == "f"]
    said: dict[str, object] = {"file": "a.obj", "units": {"length": "m"}, "up": "+y", "density": "1000 kg/m3"}
    started = process_time()
    load = read_load("\n".join(lines).encode(), "a.obj", Import.model_validate(said))
    way = "joints filled"
    if settle:
        made = with_closed_joints(load, Fraction(settle))
        load, way = made.load, f"`closed within {settle} m`, by {max(made.moved):.2f} m"
    reading = process_time() - started
    found = judged(load, set(), friction, "stands", way, reading)
    found.row["note"] = found.row["note"] or f"least friction {least_friction(load):.3f}"
    return found


def least_friction(load: ImportedLoad) -> float:
    """Return the least coefficient at which blocks on the ground are proven to stand, to 5e-4."""
    low, high = 0.0, 0.5
    while high - low > FRICTION_STEP:
        middle = 0.5 * (low + high)
        assembly, bricks = assembly_of(load, set(), middle)
        if assembly.add_all(bricks).stability is Stability.STABLE:
            high = middle
        else:
            low = middle
    return high


def slope(folder: Path, friction: str) -> Judged:
    """Judge the cube of a fixture on its slope, which is a plane."""
    path = folder / f"fixtures/3D/friction/incline-plane/slopeTest_highSchoolPhysics_mu={friction}.json"
    scene = json.loads(path.read_text(encoding="utf-8"))["rigid_body_problem"]
    (cube, plane), coefficient = scene["rigid_bodies"], float(scene["coefficient_friction"])
    angle = -radians(plane["rotation"][2])
    assert cube["rotation"] == plane["rotation"]
    # The file is two-dimensional with y up; here the slope falls towards +x, with z up. The cube has sides of 1 m.
    about = Rotation.from_euler("y", angle).as_quat().tolist()
    up = (float(np.sin(angle)), 0.0, float(np.cos(angle)))
    middle = (0.5 * up[0], 0.0, 0.5 * up[2])
    brick = Placed(Brick("cube", Box((1.0, 1.0, 1.0)), 1000.0), Pose(middle, (about[0], about[1], about[2], about[3])))
    assembly = Assembly((Plane("slope", (0.0, 0.0, 0.0), up, coefficient),), coefficient)
    started = process_time()
    verdict = assembly.add_all([brick])
    seconds = process_time() - started
    seen = SEEN[friction]
    note = f"tan {degrees(angle):.3f} deg = {tan(angle):.7f}"
    return Judged(_row(1, coefficient, WORDS[verdict.stability], seen, "from the fixture", 0.0, seconds, note))


# --- towers with off-centre masses ------------------------------------------------------------------------------------


class PlainUnpickler(pickle.Unpickler):
    """Reads arrays of numbers from a pickle, and refuses all else: a pickle can run any program."""

    def find_class(self, module: str, name: str) -> Any:  # noqa: ANN401 -- the interface of pickle
        """Return the classes of arrays."""
        from numpy._core import multiarray  # noqa: PLC0415 -- the names in pickles of arrays

        if module.startswith("numpy") and name in {"dtype", "ndarray"}:
            return getattr(np, name)
        if module in {"numpy.core.multiarray", "numpy._core.multiarray"} and name in {"_reconstruct", "scalar"}:
            return getattr(multiarray, name)
        raise pickle.UnpicklingError(f"{module}.{name} is not read")


@dataclass(frozen=True, slots=True)
class Tower:
    """Upright blocks on each other, from the lowest one."""

    sizes: Array  # (n, 3) [m]
    places: Array  # (n, 3) of the middles [m]
    centres: Array  # (n, 3) of mass, from the middles [m]
    masses: Array  # (n,) [kg]

    def placed(self) -> list[Placed]:
        """Return the blocks as bricks."""
        bricks = []
        for number, (size, place, centre, mass) in enumerate(
            zip(self.sizes.tolist(), self.places.tolist(), self.centres.tolist(), self.masses.tolist(), strict=True)
        ):
            shape = OffCentreBox((size[0], size[1], size[2]), (centre[0], centre[1], centre[2]))
            x, y, z = (a + b for a, b in zip(place, centre, strict=True))
            bricks.append(Placed(Brick(f"{number}", shape, mass), Pose((x, y, z))))
        return bricks

    def edges(self) -> tuple[float, float, float]:
        """Return how far the centre of mass of what is above lies inside of contacts at least [m], in three ways.

        Inside of the faces that touch, inside of the upper face of the lower block alone, and inside of the faces that
        touch by an angle of 3 degrees at its height.
        """
        touching = below = leaning = inf
        for n in range(1, len(self.masses)):
            masses = self.masses[n:]
            centre = (masses[:, None] * (self.places[n:] + self.centres[n:])).sum(axis=0) / masses.sum()
            height = centre[2] - (self.places[n, 2] - 0.5 * self.sizes[n, 2])
            lows = self.places[n - 1 : n + 1, :2] - 0.5 * self.sizes[n - 1 : n + 1, :2]
            highs = self.places[n - 1 : n + 1, :2] + 0.5 * self.sizes[n - 1 : n + 1, :2]
            within = min(float((centre[:2] - lows.max(axis=0)).min()), float((highs.min(axis=0) - centre[:2]).min()))
            touching = min(touching, within)
            below = min(below, float((centre[:2] - lows[0]).min()), float((highs[0] - centre[:2]).min()))
            leaning = min(leaning, within - float(height) * tan(radians(3.0)))
        return touching, below, leaning


def towers_of(path: Path) -> Iterator[tuple[Tower, bool]]:
    """Yield the towers of a file with their labels."""
    with path.open("rb") as file:
        whole = PlainUnpickler(file).load()
    for part in whole.values():
        for vectors, label in zip(part["towers"], part["labels"], strict=True):
            turns = Rotation.from_quat(vectors[:, 10:14])
            sizes = np.abs(turns.apply(vectors[:, 4:7]))
            places = vectors[:, 7:10]
            yield Tower(sizes, places, turns.apply(vectors[:, 1:4]), vectors[:, 0]), bool(label)


def is_a_tower(tower: Tower) -> bool:
    """Return whether each block lies on the one below it, to 0.1 mm, and touches it."""
    tops = tower.places[:-1, 2] + 0.5 * tower.sizes[:-1, 2]
    lows = tower.places[1:, 2] - 0.5 * tower.sizes[1:, 2]
    reach = 0.5 * (tower.sizes[:-1, :2] + tower.sizes[1:, :2])
    apart = np.abs(np.diff(tower.places[:, :2], axis=0))
    return bool((np.abs(tops - lows) <= FLUSH).all() and (apart < reach).all() and (tower.masses > 0.0).all())


def judged_towers(paths: Sequence[Path]) -> Rows:
    """Compare the labels of the towers of each file with verdicts and with three rules."""
    rows: dict[str, Row] = {}
    for path in paths:
        counts: Counter[str] = Counter()
        furthest, seconds = 0.0, 0.0
        for tower, label in towers_of(path):
            counts["towers"] += 1
            if not is_a_tower(tower):
                continue
            counts["usable"] += 1
            assembly = Assembly((LEVEL_GROUND,), 1.0)
            started = process_time()
            verdict = assembly.add_all(tower.placed()).stability
            seconds += process_time() - started
            touching, below, leaning = tower.edges()
            counts["undecided"] += verdict is Stability.UNDECIDED
            counts["against_closed_form"] += (verdict is Stability.STABLE) is not (touching >= 0.0)
            counts["by_below"] += label is (below >= 0.0)
            counts["by_angle"] += label is (leaning >= 0.0)
            if label is not (verdict is Stability.STABLE):
                counts["label_stands" if label else "label_falls"] += 1
                furthest = max(furthest, abs(touching))
        usable = max(counts["usable"], 1)
        keys = ("towers", "usable", "undecided", "against_closed_form", "label_stands", "label_falls")
        rows[path.stem] = {key: counts[key] for key in keys} | {
            "furthest_mm": 1e3 * furthest,
            "by_below_percent": 100.0 * counts["by_below"] / usable,
            "by_angle_percent": 100.0 * counts["by_angle"] / usable,
            "ms_each": 1e3 * seconds / usable,
        }
    return rows


if __name__ == "__main__":
    main()

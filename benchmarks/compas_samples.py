"""Judges every sample of compas_cra by it, by LMGC90 and by exact statics: verdict, certificate, time, in one run.

A sample is a file of blocks; its fixed blocks, friction and rotation are those of the peer's own examples. Both methods
get the same contacts, computed by the peer or read from the file, and the same weights and centres, so blocks need not
be convex. `own` judges the file as `import` reads it, with contacts of its own. LMGC90 gets the blocks, which must be
convex, and finds contacts in each step. Times are processor times of computing forces or a motion, without contact
detection; those of `own` and of LMGC90 include it.

Run: python -m benchmarks.compas_samples [--write]. It needs the peer: pip install "compas_cra==0.8.0". LMGC90 is left
out unless it is installed: pip install --no-deps compas_lmgc90==0.1.11
"""

import sys
from collections.abc import Callable, Mapping
from contextlib import redirect_stdout
from dataclasses import dataclass
from io import StringIO
from math import hypot, radians, sqrt
from pathlib import Path
from typing import Any, Final, TypeVar

from rich.console import Console
from rich.table import Table
from scipy.spatial import ConvexHull

from benchmarks.against_compas import INSTALL, processor_time
from benchmarks.compas_reading import own_assembly
from benchmarks.figures.data import Row
from benchmarks.figures.recording import parser, record
from benchmarks.systems.compas import Compas, Programme, largest_pull
from benchmarks.systems.lmgc90 import Block, Lmgc90, outward_triangles
from stability.analysis.margins import guarantee
from stability.contact_law import Coulomb
from stability.geometry.box import Box
from stability.model import EARTH, Brick, Pose, Vec3
from stability.problem import Contact, Placed, Problem, Stability, Tolerances, Wrench, rounded
from stability.statics.equilibrium import balance
from stability.statics.fall_description import described
from stability.statics.initial_motion import find_start
from stability.statics.proof import check_forces, check_motion
from stability.statics.self_stress import forces_without_self_stress
from stackdsl.diagnostics import MOST_REPORTED
from stackdsl.importers.load import UnreadableLoadError

Y: Final[Vec3] = (0.0, 1.0, 0.0)
# blocks: larger samples take the peer tens of minutes (40 min are published for the armadillo vault)
TOO_LARGE: Final = 100
DENTED: Final = 1e-3  # share of the volume that the hull of a block may add
Answered = TypeVar("Answered")


@dataclass(frozen=True, slots=True)
class Sample:
    """Settings of the peer's examples for one of its files."""

    file: str
    supports: tuple[int, ...] = (0,)  # () if the file has them
    friction: float = 0.84
    # settings of the peer's contact detection; None if the file has contacts
    finding: Mapping[str, float] | None = None
    turn: float = 0.0  # rotation about y [deg]
    heavy: tuple[int, ...] = ()  # blocks of 3.51 times the density of the others

    @property
    def name(self) -> str:
        """Return the file with its rotation."""
        return self.file + (f" at {self.turn:g} deg" if self.turn else "")


COARSE: Final[Mapping[str, float]] = {"nmax": 10, "amin": 1e-2, "tmax": 1e-2}
FINE: Final[Mapping[str, float]] = {"amin": 1e-6, "tmax": 1e-4}
SAMPLES: Final = (
    *(Sample(file, (0, 1), finding=COARSE) for file in ("A", "H", "type-a", "type-b", "type-c", "type-d")),
    *(Sample(file, (0, 1), finding=COARSE, turn=90.0) for file in ("type-a", "type-b", "type-c", "type-d")),
    Sample("cubes", finding=COARSE),
    Sample("shelf", friction=0.9, finding=FINE),
    *(Sample(f"shelf-{kind}", friction=0.9, finding=FINE) for kind in ("stable", "s1", "s2", "s3")),
    Sample("snake", friction=0.7, finding={"amin": 1e-4, "tmax": 1e-2}),
    Sample("bridge", (0, 1), 0.9, FINE, heavy=(11, 12, 13, 14, 15)),
    Sample("concave-short"),
    Sample("concave-short", turn=40.0),
    Sample("concave-long"),
    Sample("concave-long", turn=50.0),
    Sample("curve-3-blocks"),
    Sample("cube-curve-short"),
    Sample("cube-curve-tall"),
    Sample("armadillo_cra", ()),
)


@dataclass(frozen=True, slots=True)
class Answer:
    """Verdict of a method and its time."""

    verdict: str
    seconds: float
    error: float = 0.0  # of the proof, by plain arithmetic
    lets_go: str = ""  # start of a motion of a structure that only self-stress can hold, proven


def main() -> None:
    """Measure and print the table; write it on request."""
    write = parser(__doc__).parse_args().write
    if not Compas(Programme.CRA).package.installed:
        sys.exit(INSTALL)
    Compas(Programme.CRA).load()
    if not Lmgc90().package.installed:
        Console(stderr=True).print(f"LMGC90 is left out; install it with: {Lmgc90().package.remedy}")
    names = ("sample", "blocks", "interfaces", "exact", "ms", "error", "lets go", "cra", "ms", "times slower")
    table = Table(*names, "rbe", "rbe times slower", "lmgc90", "ms", "own")
    rows: dict[str, Row] = {}
    for sample in SAMPLES:
        row = measured(sample)
        rows[sample.name] = row
        cells = {key: f"{value:.3g}" if isinstance(value, float) else str(value) for key, value in row.items()}
        table.add_row(sample.name, *cells.values())
        Console(stderr=True).print(sample.name, *cells.values())
    Console(width=180).print(table)
    if write:
        record("compas-samples", "python -m benchmarks.compas_samples --write", {"samples": rows})


def measured(sample: Sample) -> Row:
    """Return one row of the table."""
    assembly = quietly(lambda: loaded(sample))
    problem = problem_of(assembly, sample.friction)
    exact = judged_exactly(problem)
    large = len(problem.bricks) > TOO_LARGE
    peer = as_its_file_says(assembly) if large else judged_by_peer(assembly, sample.friction)
    rbe = Answer("not run", 0.0) if large else judged_by_rbe(assembly, sample.friction)
    moved = judged_by_lmgc90(assembly, sample.friction)
    return {
        "blocks": assembly.graph.number_of_nodes(),
        "interfaces": len(problem.contacts),
        "exact": exact.verdict,
        "exact_ms": 1e3 * exact.seconds,
        "error": exact.error,
        "lets_go": exact.lets_go,
        "cra": peer.verdict,
        "cra_ms": 1e3 * peer.seconds,
        "times_slower": "not run" if large else times(peer, exact),
        "rbe": rbe.verdict,
        "rbe_times_slower": "not run" if large else times(rbe, exact),
        "lmgc90": moved.verdict,
        "lmgc90_times_slower": times(moved, exact) if moved.seconds else "not run",
        "own": judged_with_own_contacts(sample, assembly),
    }


def times(answer: Answer, exact: Answer) -> str:
    """Return the time of an answer as a multiple of that of another, with two digits."""
    return f"{float(f'{answer.seconds / exact.seconds:.2g}'):g}"


# --- the sample -------------------------------------------------------------------------------------------------------


def path_of(sample: Sample) -> Path:
    """Return the path of the sample in the peer's package."""
    import compas_cra  # noqa: PLC0415 -- the peer is optional

    return Path(compas_cra.SAMPLE) / f"{sample.file}.json"


def loaded(sample: Sample) -> Any:  # noqa: ANN401 -- the peer is untyped
    """Return the peer's assembly, with contacts, as in its examples."""
    import compas  # noqa: PLC0415 -- the peer is optional
    from compas_cra.algorithms import assembly_interfaces_numpy  # noqa: PLC0415
    from compas_cra.datastructures import CRA_Assembly  # noqa: PLC0415
    from compas_cra.equilibrium import density_setup  # noqa: PLC0415

    assembly = compas.json_load(str(path_of(sample))).copy(cls=CRA_Assembly)
    assembly.set_boundary_conditions(list(sample.supports))
    density_setup(assembly, {node: 3.51 if node in sample.heavy else 1.0 for node in assembly.graph.nodes()})
    if sample.finding is not None:
        assembly_interfaces_numpy(assembly, **sample.finding)
    if sample.turn:
        assembly.rotate_assembly([0, 0, 0], list(Y), sample.turn)
    return assembly


def supports_of(assembly: Any) -> set[int]:  # noqa: ANN401 -- the peer is untyped
    """Return the fixed nodes."""
    return set(assembly.graph.nodes_where({"is_support": True}))


def problem_of(assembly: Any, friction: float) -> Problem:  # noqa: ANN401 -- the peer is untyped
    """Return the peer's blocks and contacts as a problem of statics; the density is 1 t/m3."""
    fixed = supports_of(assembly)
    bricks = {f"{node}": placed(assembly.node_block(node), f"{node}") for node in assembly.nodes() if node not in fixed}
    contacts = [
        contact(f"{one}", f"{other}", interface, friction)
        for one, other in assembly.graph.edges()
        for interface in assembly.graph.edge_attribute((one, other), "interfaces")
    ]
    moving = [each for each in contacts if each.lower in bricks or each.upper in bricks]
    loads = {name: Wrench((0.0, 0.0, -EARTH * each.brick.mass)) for name, each in bricks.items()}
    return Problem(bricks, moving, loads)


def placed(block: Any, name: str) -> Placed:  # noqa: ANN401 -- the peer is untyped
    """Return the data of a block for equilibrium: centre, mass and extent."""
    x, y, z = block.center()
    corners = block.vertices_attributes("xyz")
    reach = max(hypot(px - x, py - y, pz - z) for px, py, pz in corners)
    side = 2.0 * reach / sqrt(3.0)
    mass = 1000.0 * block.volume() * block.attributes["density"]
    return Placed(Brick(name, Box((side, side, side)), mass), Pose((x, y, z)))


def contact(one: str, other: str, interface: Any, friction: float) -> Contact:  # noqa: ANN401 -- the peer is untyped
    """Return an interface as a contact whose normal points from `one` to `other`."""
    nx, ny, nz = interface.frame.zaxis
    length = hypot(nx, ny, nz)
    points = tuple((float(x), float(y), float(z)) for x, y, z in interface.points)
    if nz < 0.0:
        return Contact(other, one, points, ((-nx / length, -ny / length, -nz / length),), Coulomb(friction))
    return Contact(one, other, points, ((nx / length, ny / length, nz / length),), Coulomb(friction))


# --- verdicts ---------------------------------------------------------------------------------------------------------


def judged_exactly(problem: Problem) -> Answer:
    """Judge these contacts by exact statics, with the certificate of a stable assembly."""
    started = processor_time()
    balanced = balance(problem, Tolerances())
    honest = forces_without_self_stress(problem, balanced.forces, Tolerances()) if balanced.forces is not None else None
    certain = guarantee(problem, honest) is not None if honest is not None else False
    seconds = processor_time() - started
    limits = rounded(problem, Tolerances())
    if honest is not None:
        check = check_forces(problem, honest, limits)
        return Answer("guaranteed" if certain else "possible", seconds, check.residual if check.holds else float("inf"))
    if balanced.motion is not None:
        fall = check_motion(problem, balanced.motion, limits)
        return Answer("unstable", seconds, fall.violation if fall.holds else float("inf"))
    if balanced.forces is None:
        return Answer("undecided", seconds)
    squeezed, start = check_forces(problem, balanced.forces, limits), find_start(problem, Tolerances())
    error = squeezed.residual if squeezed.holds else float("inf")
    return Answer("self-stress", seconds, error, described(problem, start.acceleration) if start is not None else "")


def judged_by_peer(assembly: Any, friction: float) -> Answer:  # noqa: ANN401 -- the peer is untyped
    """Judge by the peer's own program, with the bounds of its own examples."""
    from compas_cra.equilibrium import cra_solve  # noqa: PLC0415 -- the peer is optional

    started = processor_time()
    try:
        quietly(lambda: cra_solve(assembly, mu=friction, density=1.0, d_bnd=1e-1, eps=1e-3))
    except ValueError as error:  # raised both for a fall and for a failure of its solver
        verdict = "infeasible" if "Infeasible" in str(error) else "solver failed"
        return Answer(verdict, processor_time() - started)
    return Answer("stands", processor_time() - started)


def judged_by_rbe(assembly: Any, friction: float) -> Answer:  # noqa: ANN401 -- the peer is untyped
    """Judge by the peer's convex program: it stands if no contact has to pull."""
    from compas_cra.equilibrium import rbe_solve  # noqa: PLC0415 -- the peer is optional

    started = processor_time()
    try:
        quietly(lambda: rbe_solve(assembly, mu=friction, density=1.0))
    except ValueError as error:
        verdict = "infeasible" if "Infeasible" in str(error) else "solver failed"
        return Answer(verdict, processor_time() - started)
    seconds = processor_time() - started
    nodes = set(assembly.graph.nodes()) - supports_of(assembly)
    weight = sum(assembly.node_block(node).volume() * assembly.node_block(node).attributes["density"] for node in nodes)
    return Answer("stands" if largest_pull(assembly) <= Compas(Programme.RBE).pull * weight else "pulls", seconds)


def judged_by_lmgc90(assembly: Any, friction: float) -> Answer:  # noqa: ANN401 -- the peer is untyped
    """Judge by the motion that LMGC90 computes, of blocks that are convex."""
    solver = Lmgc90()
    if not solver.package.installed:
        return Answer("not installed", 0.0)
    fixed = supports_of(assembly)
    blocks = []
    for node in assembly.nodes():
        block = assembly.node_block(node)
        corners = [(float(x), float(y), float(z)) for x, y, z in block.vertices_attributes("xyz")]
        if ConvexHull(corners).volume > (1.0 + DENTED) * abs(block.volume()):
            return Answer("not convex", 0.0)
        density = 1000.0 * block.attributes["density"]
        blocks.append(Block(corners, outward_triangles(corners), density, fixed=node in fixed))
    started = processor_time()
    move = solver.largest_move(blocks, friction)
    return Answer("stands" if move <= solver.moved else "moves", processor_time() - started)


def as_its_file_says(assembly: Any) -> Answer:  # noqa: ANN401 -- the peer is untyped
    """Return the result that the file of a large sample holds: forces at all interfaces mean that it stands."""
    edges = [assembly.graph.edge_attribute(edge, "interfaces") for edge in assembly.graph.edges()]
    has_forces = all(interface.forces for interfaces in edges for interface in interfaces)
    return Answer("stands, in its file" if has_forces else "not run", 0.0)


def judged_with_own_contacts(sample: Sample, assembly: Any) -> str:  # noqa: ANN401 -- the peer is untyped
    """Judge the imported file by exact statics, or return the reason why it is not importable."""
    try:
        own, bricks = own_assembly(path_of(sample), supports_of(assembly), sample.friction, radians(sample.turn))
    except UnreadableLoadError as error:
        count = len(error.diagnostics)
        return f"not convex: {'more than 100' if count > MOST_REPORTED else count} blocks"
    started = processor_time()
    verdict = own.add_all(bricks)
    word = verdict.stability.value
    if verdict.stability is Stability.STABLE:
        word = "guaranteed" if guarantee(own.problem(), own.forces()) is not None else "possible"
    seconds = processor_time() - started
    return f"{word}, {1e3 * seconds:.1f} ms, {len(own.all_contacts())} contacts"


def quietly(work: Callable[[], Answered]) -> Answered:
    """Call a function without the peer's output."""
    with redirect_stdout(StringIO()):
        return work()


if __name__ == "__main__":
    main()

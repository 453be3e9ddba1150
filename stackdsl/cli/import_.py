"""`stackdsl import`: converts a file of another program into a scenario."""

import re
import shlex
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Final, get_args

import click
from click.core import ParameterSource
from pydantic import ValidationError

from stability.contact_law import Rule
from stackdsl.checking.cases import cases_of
from stackdsl.cli.command_help import ExplainedCommand
from stackdsl.cli.options import FilePath, Number
from stackdsl.cli.terminal import Counter, counted, tell, write
from stackdsl.diagnostics import Diagnostic, Span
from stackdsl.disk import read_file
from stackdsl.exits import ExitCode
from stackdsl.importers.built_deck import BuiltDeck, on_deck
from stackdsl.importers.closing import ClosedLoad, OpenJointError, closed_lines, with_closed_joints
from stackdsl.importers.expansion import path_beside
from stackdsl.importers.formats import MAX_IMPORTED, scenario_text, slug
from stackdsl.importers.imported_friction import missing_rule
from stackdsl.importers.load import ImportedLoad, ImportedSurfaces, UnreadableLoadError, digits
from stackdsl.importers.load_warnings import load_warnings
from stackdsl.importers.overhang import permitted_area
from stackdsl.importers.settling import SettledLoad, first_unsettleable, moved_lines, settled
from stackdsl.importers.supervised_reading import load_supervised
from stackdsl.importers.tables import COLUMNS
from stackdsl.language.imports import LOAD_FORMATS, DefaultUnits, Import
from stackdsl.language.pallets import DECKS
from stackdsl.language.quantities import InputError
from stackdsl.language.yaml.includes import root_of
from stackdsl.language.yaml.source import Area, KeyPath, Source, parse
from stackdsl.report.diagnostics import diagnostic_text
from stackdsl.shown_text import visible
from stackdsl.user_files import read_user_file

# Diagnostics of `stackdsl check` for an imported scenario, with places in the file of the load.


def faults(text: str, file: str, load: ImportedLoad, built: BuiltDeck | None, asked: Import) -> list[Diagnostic]:
    """Return the mistakes of a scenario that builds these boxes on a pallet, such as overlapping boxes.

    `file` is the place of mistakes that belong to no box.
    """
    loaded = parse(text, file)
    sources = tuple(_placed(source, load, built, asked) for source in loaded.sources)
    _, mistakes = cases_of(replace(loaded, sources=sources))
    return mistakes


def _placed(source: Source, load: ImportedLoad, built: BuiltDeck | None, asked: Import) -> Source:
    """Return a scenario whose bricks have the places of the boxes in their file, and their deck."""
    first = 0 if built is None else 1
    places: dict[KeyPath, Span] = {
        ("build", 0, "bricks", number): box.span for number, box in enumerate(load.boxes, first)
    }
    area = permitted_area(load, asked)
    decks: dict[KeyPath, Area] = {("build", 0): area} if area is not None else {}
    return replace(source, value_spans={**source.value_spans, **places}, decks=decks)


# `stackdsl import`: converts the boxes in a file of another program to a scenario.


REAL_DECK: Final = "--surface closed builds it"
HANGS: Final = "SD202"  # a brick in the air

_LENGTHS, _MASSES = (
    list(get_args(get_args(DefaultUnits.model_fields[key].annotation)[0])) for key in ("length", "mass")
)


@click.command("import", cls=ExplainedCommand)
@click.argument("file", type=FilePath)
@click.option(
    "--format", "format_", type=click.Choice(LOAD_FORMATS), help="Format of FILE. Default: detected from its content."
)
@click.option("--load", help="Number of the pallet or order, if FILE has several loads.")
@click.option(
    "--settle",
    default="as written",
    show_default=True,
    help="How to close gaps: as written, down, within a gap such as 'within 5 mm', or 'closed within 5 mm'.",
)
@click.option(
    "--point", type=click.Choice(("corner", "centre")), help="Point of a box that x, y, z of a table refer to."
)
@click.option("--map", "map_", multiple=True, help="Column of a table by its header: length=L. Can be repeated.")
@click.option(
    "--decimals",
    type=click.Choice(("point", "comma")),
    help="Sign of decimals in a table; the other separates thousands.",
)
@click.option("--encoding", type=click.Choice(("utf-8", "windows-1252")), help="Encoding of a table. Default: utf-8.")
@click.option("--length", type=click.Choice(_LENGTHS), help="Unit of lengths, if FILE does not give one.")
@click.option("--mass", type=click.Choice(_MASSES), help="Unit of masses in a table, if FILE does not give one.")
@click.option("--density", help="Density of the solids in a mesh or COMPAS file, such as '2400 kg/m3'.")
@click.option("--up", type=click.Choice(("+y", "+z")), help="Axis of an OBJ, STL or PLY file that points up.")
@click.option(
    "--supports", type=click.Choice(("bricks",)), help="Import the fixed supports of a COMPAS file as bricks."
)
@click.option("--library", help="File with the sizes and masses of bricks, beside a StableLego or APEX-MR file.")
@click.option(
    "--deck", help=f"Deck of the pallet, to report overhanging boxes: {', '.join(DECKS)}, or '1200 mm x 800 mm'."
)
@click.option(
    "--surface",
    help="Build the pallet below the load: closed, boards (of an EUR pallet), or widths such as '90 mm, 90 mm'.",
)
@click.option("--level", help="Height of the deck in FILE, such as '144 mm' if z counts from the floor.")
@click.option("--overhang", help="Allowed overhang of a box beyond the deck, such as '20 mm'.")
@click.option("--origin", nargs=3, help="Shift of the load along x, y, z, such as '0 mm' '0 mm' '1 m'.")
@click.option("--ignore", multiple=True, help="Column, key or body to leave out. Can be repeated.")
@click.option(
    "--friction", type=Number(0.0, 10.0), default=0.5, show_default=True, help="Coefficient of friction between boxes."
)
@click.option(
    "--rule",
    type=click.Choice([each.value for each in Rule]),
    help="Rule that combines the coefficients of two touching bodies in FILE.",
)
@click.option("--name", help="Name of the scenario. Default: the name of FILE.")
@click.pass_context
def import_command(  # noqa: PLR0913, PLR0917 -- one parameter an option
    context: click.Context,
    file: Path,
    format_: str | None,
    load: str | None,
    settle: str,
    point: str | None,
    map_: tuple[str, ...],
    decimals: str | None,
    encoding: str | None,
    length: str | None,
    mass: str | None,
    density: str | None,
    up: str | None,
    supports: str | None,
    library: str | None,
    deck: str | None,
    surface: str | None,
    level: str | None,
    overhang: str | None,
    origin: tuple[str, str, str] | None,
    ignore: tuple[str, ...],
    friction: float,
    rule: str | None,
    name: str | None,
) -> None:
    """Convert the boxes in FILE, written by another program, to a scenario, and print it."""
    of_load = {"format": format_, "load": load, "settle": settle, "point": point, "ignore": ignore, "origin": origin}
    of_file = {"length": length, "mass": mass, "density": density, "up": up, "supports": supports, "library": library}
    of_table = {"map": _map(map_), "decimals": decimals, "encoding": encoding}
    on = _deck(size=deck, surface=surface, level=level, overhang=overhang)
    asked = _asked(file=str(file), deck=on, **of_load, **of_file, **of_table)

    def beside(named: str) -> bytes:
        return read_file(Path(path_beside(named, str(file))), MAX_IMPORTED, root_of(str(file)))

    try:
        data = read_user_file(file, MAX_IMPORTED + 1)
    except OSError as error:
        raise click.UsageError(f"cannot read {file}: {error.strerror}; name a file, such as a table (.csv)") from error
    shown = visible(file.as_posix())
    try:
        with counted(100, f"importing {shown}: percent") as known:
            read = load_supervised(data, shown, asked, beside, lambda: known(0))
            ruled, built = _on_deck(_with_rule(read, Rule(rule) if rule else None), asked)
            closed = _closed(ruled, asked)
            found = _settled(ruled if closed is None else closed.load, built, asked, _share(known, READ, SETTLED))
            is_assumed = context.get_parameter_source("friction") is ParameterSource.DEFAULT
            notes = [*_notes(shown, asked, found, friction if is_assumed else None), *_warnings(found, asked)]
            notes += () if closed is None else closed_lines(closed)
            called = slug(name or "-".join(filter(None, [file.name.split(".")[0], load])))
            text = scenario_text(called, notes, found.load, built, friction, _share(known, SETTLED, WRITTEN))
            mistakes = faults(text, f"{called}.yaml", found.load, built, asked)
    except UnreadableLoadError as error:
        for mistake in error.diagnostics:
            tell(diagnostic_text(replace(mistake, hint=_as_options(mistake.hint))))
        if error.proposed:
            edits = any(
                "add the column" in mistake.hint
                or "needs `" in mistake.hint
                or (mistake.code != OPEN and "`ignore`" not in mistake.hint)
                for mistake in error.diagnostics
            )
            when = "when the file is corrected, this command" if edits else "this command"
            tell(f"\n{when} answers the open questions; change its values where they are wrong:")
            tell(f"  {_command(error.proposed)}")
        context.exit(ExitCode.INVALID)
    for note in notes:
        tell(note)
    _warn(mistakes, found)
    if any(mistake.code == TOO_LARGE for mistake in mistakes):
        tell(f"a scenario of any size can read the file itself: build: [{{import: {{file: {shown}, ...}}}}]")
    write(text)


def _warnings(found: SettledLoad, asked: Import) -> Iterator[str]:
    for odd in load_warnings(found.load, asked):
        yield f"warning: {replace(odd, hint=_as_options(odd.hint))}"


# Percent of the time of an import after each step, measured with a table of 20,000 boxes.
READ, SETTLED, WRITTEN = 20, 70, 95


def _share(known: Counter, start: int, end: int) -> Callable[[float], None]:
    """Return a function that shows the share of a step, which takes the progress from `start` to `end`."""
    return lambda share: known(round(start + share * (end - start)))


def _command(proposed: Mapping[str, Any]) -> str:
    """Return the command of this call, with proposed options added."""
    words = ["stackdsl", "import", *_call_arguments()]
    for key, value in proposed.items():
        pairs = [f"{column}={header}" for column, header in value.items()] if isinstance(value, dict) else [value]
        for each in value if isinstance(value, list) else pairs:
            words += [f"--{key}", each]
    return visible(shlex.join(words))


def _call_arguments() -> Sequence[str]:
    """Return the arguments of this call after `import`."""
    arguments = sys.argv[1:]
    return arguments[arguments.index("import") + 1 :] if "import" in arguments else arguments


TOO_LARGE: Final = "SD006"  # a file over the limit of its kind
OPEN: Final = "SD115"  # a property that the file leaves open
KEY: Final = re.compile(r"`(?P<key>\w+)(?:: (?:\{(?P<inside>[^`}]*)\}|(?P<value>[^`]+)))?`")
OPTIONS: Final = (
    "format",
    "load",
    "settle",
    "point",
    "decimals",
    "encoding",
    "density",
    "up",
    "supports",
    "library",
    "ignore",
    "origin",
)


def _as_options(hint: str) -> str:
    """Return a remedy with the options of this command in place of the keys of a scenario."""

    def option(match: re.Match[str]) -> str:
        key, inside = match["key"], match["inside"]
        if key == "map" and inside:
            columns = re.findall(r"(\w+): ('[^']*'|[^,]*)", inside)
            return " ".join(f"--map {shlex.quote(f'{column}={header.strip(chr(39))}')}" for column, header in columns)
        if key in ("units", "deck") and inside:
            pairs = (pair.split(": ", 1) for pair in inside.split(", "))
            return " ".join(f"--{name} {shlex.quote(value)}" for name, value in pairs)
        if key not in OPTIONS:
            return match[0]
        if key == "ignore" and match["value"]:
            return " ".join(f"--ignore {shlex.quote(name)}" for name in re.findall(r"'([^']*)'", match["value"]))
        value = match["value"] or ""
        return f"--{key} {shlex.quote(value)}" if value else f"--{key}"

    return KEY.sub(option, hint)


def _warn(mistakes: Sequence[Diagnostic], found: SettledLoad) -> None:
    """Report the errors of the scenario. It is printed anyway, so that they can be corrected in it or in the file."""
    if not mistakes:
        return
    count = f"{len(mistakes)} mistake{'s' * (len(mistakes) != 1)}"
    tell(f"\nwarning: the scenario has {count}, so `check` will refuse it:\n")
    for mistake in mistakes:
        tell(diagnostic_text(mistake) + "\n")
    untouched = not any((*found.moved, *found.grown, *found.trimmed))
    if untouched and any(mistake.code == HANGS for mistake in mistakes):
        tell("to lower boxes that hang slightly in the air, as in measured loads, add: --settle 'within 5 mm'")


def _asked(**written: object) -> Import:
    """Return the import that the options describe. Raises a usage error."""
    units = {key: value for key in ("length", "mass") if (value := written.pop(key)) is not None}
    given = {key: value for key, value in written.items() if value is not None} | ({"units": units} if units else {})
    try:
        return Import.model_validate(given)
    except ValidationError as error:
        first = error.errors()[0]
        cause = first.get("ctx", {}).get("error")
        said = f"{cause.message}; {cause.hint}" if isinstance(cause, InputError) else first["msg"]
        raise click.UsageError(said) from error


def _map(written: Sequence[str]) -> dict[str, str] | None:
    """Return the entry `map` of a scenario. Raises a usage error."""
    columns: dict[str, str] = {}
    for each in written:
        column, sign, header = each.partition("=")
        if not sign or column not in COLUMNS:
            raise click.UsageError(
                f"--map {each}: write COLUMN=HEADER, such as length=L, with one of the columns {', '.join(COLUMNS)}"
            )
        columns[column] = header
    return columns or None


def _deck(size: str | None, **others: str | list[str] | None) -> dict[str, object] | None:
    """Return the entry of the deck in a scenario."""
    sides = [part.strip() for part in size.split("x")] if size is not None and size not in DECKS else []
    if isinstance(surface := others.get("surface"), str) and "," in surface:
        others["surface"] = [width.strip() for width in surface.strip("[] ").split(",")]
    written = {"size": sides if len(sides) > 1 else size, **others}
    return {key: value for key, value in written.items() if value is not None} or None


def _with_rule(load: ImportedLoad, rule: Rule | None) -> ImportedLoad:
    """Return the load with a rule for the friction of two touching bodies. Raises UnreadableLoadError."""
    if rule is not None:
        return replace(load, surfaces=replace(load.surfaces or ImportedSurfaces(rule), rule=rule))
    if load.surfaces is not None and load.surfaces.rule is None:
        raise UnreadableLoadError([missing_rule(load.boxes[0].span, "--rule lower", "--ignore contact")])
    return load


def _on_deck(load: ImportedLoad, asked: Import) -> tuple[ImportedLoad, BuiltDeck | None]:
    """Return the load on its deck, and the pallet that is built. Raises a usage error."""
    try:
        return on_deck(load, asked)
    except InputError as error:
        raise click.UsageError(f"{error.message}; {_as_options(error.hint)}") from error


def _settled(
    load: ImportedLoad, built: BuiltDeck | None, asked: Import, on_share: Callable[[float], None]
) -> SettledLoad:
    if (odd := first_unsettleable(load, asked.settle)) is not None:
        message, hint = "a tilted box or a solid cannot be lowered", "use `as written`, or straighten the box"
        raise UnreadableLoadError([Diagnostic("SD115", odd.span, message, hint)])
    return settled(load, asked.settle, on_share, () if built is None else built.boxes)


def _closed(load: ImportedLoad, asked: Import) -> ClosedLoad | None:
    """Return the load with closed joints, if the author wants that. Raises UnreadableLoadError."""
    if asked.settle.closed is None:
        return None
    try:
        return with_closed_joints(load, asked.settle.closed)
    except OpenJointError as error:
        raise UnreadableLoadError([Diagnostic("SD115", error.box.span, error.message, error.hint)]) from error


def _notes(file: str, asked: Import, found: SettledLoad, assumed: float | None) -> list[str]:
    """Return notes on imported, moved and skipped bodies, on an assumed friction, and on the deck."""
    load = found.load
    which = f" of load '{asked.load}'" if asked.load else ""
    exact = f", written to {digits(1000 * load.precision)} mm" if load.precision else ""
    lines = [f"{len(load.boxes)} boxes{which} in {file}{exact}"]
    if asked.settle.lowered or asked.settle.within is not None:
        lines += moved_lines(found)
    if load.prefix:
        lines.append(f"names that begin with a digit have the prefix '{load.prefix}'")
    if load.skipped or asked.ignore:
        lines.append(f"left out: {', '.join((*load.skipped, *asked.ignore))}")
    if assumed is not None and load.surfaces is None:
        lines.append(f"friction between boxes assumed: {assumed:g}; measure it, and set --friction")
    if (area := permitted_area(load, asked)) is not None:
        (x, y), (to_x, to_y) = ([f"{1000.0 * float(side):g} mm" for side in corner] for corner in area)
        place = f"deck from [{x}, {y}] to [{to_x}, {to_y}]"
        is_built = asked.deck is not None and asked.deck.surface is not None
        lines.append(place if is_built else f"{place}, not built: the ground continues around it; {REAL_DECK}")
    return lines

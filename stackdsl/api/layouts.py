"""Layouts, each a step of the build.

Written by `make words` from the models of the language; docs/language.md says more of every key. What is left out, or
None, is not written, and has its default there. Quantities are texts with their units, as in YAML: "12 mm".
"""

from collections.abc import Mapping, Sequence

from stackdsl.api.written import Written, written


def four_stack(
    *,
    origin: Sequence[int | str] | None = None,
    heading: int | str | None = None,
    omit: Sequence[str] | None = None,
    levels: int | None = None,
    step: int | str | None = None,
    spacing: str | None = None,
    when: int | str | None = None,
    after: str | None = None,
    name: str | None = None,
    brick: str | object | None = None,
    every: str | None = None,
    until: str | None = None,
    place: str | Mapping[str, object] | None = None,
    jitter: Mapping[str, object] | None = None,
) -> Written:
    """Two parallel planks a level, turned by 90 deg each level.

    origin: shifts the layout to [x, y, z]
    heading: turns the layout about the vertical through its origin, x towards y
    omit: bricks that are left out, such as `L2.3`; all others keep their names
    levels: how many levels of two planks
    step: how far each level is shifted along x from the one below
    spacing: between the centres of the two planks; default: length - width, so that ends are flush
    when: when the step begins; default: after the previous step
    after: the event that the step begins after
    name: goes before the names of the bricks of this step
    brick: what this step is built of; default: the scenario's brick
    every: time for each brick; default: all at one time
    until: goes on until the structure falls
    place: by hand, one brick after another; default: set down as if from nowhere
    jitter: how far off its bricks are set down, in `samples`; default: not at all
    """
    what_is_written = {
        "origin": origin,
        "heading": heading,
        "omit": omit,
        "levels": levels,
        "step": step,
        "spacing": spacing,
    }
    return written(
        {
            "four_stack": what_is_written,
            "at": when,
            "after": after,
            "name": name,
            "brick": brick,
            "every": every,
            "until": until,
            "place": place,
            "jitter": jitter,
        }
    )


def column(
    *,
    origin: Sequence[int | str] | None = None,
    heading: int | str | None = None,
    omit: Sequence[str] | None = None,
    levels: int | None = None,
    step: int | str | None = None,
    when: int | str | None = None,
    after: str | None = None,
    name: str | None = None,
    brick: str | object | None = None,
    every: str | None = None,
    until: str | None = None,
    place: str | Mapping[str, object] | None = None,
    jitter: Mapping[str, object] | None = None,
) -> Written:
    """One flat plank a level, each shifted by the same step along its length.

    origin: shifts the layout to [x, y, z]
    heading: turns the layout about the vertical through its origin, x towards y
    omit: bricks that are left out, such as `L2.3`; all others keep their names
    levels: how many planks
    step: how far each plank is shifted along its length from the one below
    when: when the step begins; default: after the previous step
    after: the event that the step begins after
    name: goes before the names of the bricks of this step
    brick: what this step is built of; default: the scenario's brick
    every: time for each brick; default: all at one time
    until: goes on until the structure falls
    place: by hand, one brick after another; default: set down as if from nowhere
    jitter: how far off its bricks are set down, in `samples`; default: not at all
    """
    what_is_written = {"origin": origin, "heading": heading, "omit": omit, "levels": levels, "step": step}
    return written(
        {
            "column": what_is_written,
            "at": when,
            "after": after,
            "name": name,
            "brick": brick,
            "every": every,
            "until": until,
            "place": place,
            "jitter": jitter,
        }
    )


def wall(
    *,
    origin: Sequence[int | str] | None = None,
    heading: int | str | None = None,
    omit: Sequence[str] | None = None,
    levels: int | None = None,
    bricks: int | None = None,
    gap: int | str | None = None,
    when: int | str | None = None,
    after: str | None = None,
    name: str | None = None,
    brick: str | object | None = None,
    every: str | None = None,
    until: str | None = None,
    place: str | Mapping[str, object] | None = None,
    jitter: Mapping[str, object] | None = None,
) -> Written:
    """Planks end to end along x in running bond, closed at both ends.

    origin: shifts the layout to [x, y, z]
    heading: turns the layout about the vertical through its origin, x towards y
    omit: bricks that are left out, such as `L2.3`; all others keep their names
    levels: how many levels
    bricks: planks of a full level
    gap: between the ends of neighbours
    when: when the step begins; default: after the previous step
    after: the event that the step begins after
    name: goes before the names of the bricks of this step
    brick: what this step is built of; default: the scenario's brick
    every: time for each brick; default: all at one time
    until: goes on until the structure falls
    place: by hand, one brick after another; default: set down as if from nowhere
    jitter: how far off its bricks are set down, in `samples`; default: not at all
    """
    what_is_written = {
        "origin": origin,
        "heading": heading,
        "omit": omit,
        "levels": levels,
        "bricks": bricks,
        "gap": gap,
    }
    return written(
        {
            "wall": what_is_written,
            "at": when,
            "after": after,
            "name": name,
            "brick": brick,
            "every": every,
            "until": until,
            "place": place,
            "jitter": jitter,
        }
    )


def harmonic(
    *,
    origin: Sequence[int | str] | None = None,
    heading: int | str | None = None,
    omit: Sequence[str] | None = None,
    bricks: int | None = None,
    share: float | str | None = None,
    when: int | str | None = None,
    after: str | None = None,
    name: str | None = None,
    brick: str | object | None = None,
    every: str | None = None,
    until: str | None = None,
    place: str | Mapping[str, object] | None = None,
    jitter: Mapping[str, object] | None = None,
) -> Written:
    """The overhanging stack: from the top, each plank leans out by 1/2, 1/4, 1/6 ... of a length, towards +x.

    origin: shifts the layout to [x, y, z]
    heading: turns the layout about the vertical through its origin, x towards y
    omit: bricks that are left out, such as `L2.3`; all others keep their names
    bricks: how many planks
    share: of the overhang at which the stack is on the point of tipping
    when: when the step begins; default: after the previous step
    after: the event that the step begins after
    name: goes before the names of the bricks of this step
    brick: what this step is built of; default: the scenario's brick
    every: time for each brick; default: all at one time
    until: goes on until the structure falls
    place: by hand, one brick after another; default: set down as if from nowhere
    jitter: how far off its bricks are set down, in `samples`; default: not at all
    """
    what_is_written = {"origin": origin, "heading": heading, "omit": omit, "bricks": bricks, "share": share}
    return written(
        {
            "harmonic": what_is_written,
            "at": when,
            "after": after,
            "name": name,
            "brick": brick,
            "every": every,
            "until": until,
            "place": place,
            "jitter": jitter,
        }
    )


def tower(
    *,
    origin: Sequence[int | str] | None = None,
    heading: int | str | None = None,
    omit: Sequence[str] | None = None,
    levels: int | None = None,
    bricks: int | None = None,
    overlap: float | str | None = None,
    when: int | str | None = None,
    after: str | None = None,
    name: str | None = None,
    brick: str | object | None = None,
    every: str | None = None,
    until: str | None = None,
    place: str | Mapping[str, object] | None = None,
    jitter: Mapping[str, object] | None = None,
) -> Written:
    """Rings of planks, each ring turned by half a pitch, so that every plank bridges two of the ring below.

    origin: shifts the layout to [x, y, z]
    heading: turns the layout about the vertical through its origin, x towards y
    omit: bricks that are left out, such as `L2.3`; all others keep their names
    levels: how many rings
    bricks: planks of a ring
    overlap: of a plank's length that lies on each of the two planks below
    when: when the step begins; default: after the previous step
    after: the event that the step begins after
    name: goes before the names of the bricks of this step
    brick: what this step is built of; default: the scenario's brick
    every: time for each brick; default: all at one time
    until: goes on until the structure falls
    place: by hand, one brick after another; default: set down as if from nowhere
    jitter: how far off its bricks are set down, in `samples`; default: not at all
    """
    what_is_written = {
        "origin": origin,
        "heading": heading,
        "omit": omit,
        "levels": levels,
        "bricks": bricks,
        "overlap": overlap,
    }
    return written(
        {
            "tower": what_is_written,
            "at": when,
            "after": after,
            "name": name,
            "brick": brick,
            "every": every,
            "until": until,
            "place": place,
            "jitter": jitter,
        }
    )


def card_house(
    *,
    origin: Sequence[int | str] | None = None,
    heading: int | str | None = None,
    omit: Sequence[str] | None = None,
    levels: int | None = None,
    angle: int | str | None = None,
    spacing: str | None = None,
    when: int | str | None = None,
    after: str | None = None,
    name: str | None = None,
    brick: str | object | None = None,
    every: str | None = None,
    until: str | None = None,
    place: str | Mapping[str, object] | None = None,
    jitter: Mapping[str, object] | None = None,
) -> Written:
    """Inverted Vs of two planks, flat planks on each two neighbouring peaks, further Vs on these, up to a single one.

    origin: shifts the layout to [x, y, z]
    heading: turns the layout about the vertical through its origin, x towards y
    omit: bricks that are left out, such as `L2.3`; all others keep their names
    levels: how many inverted Vs stand in the lowest storey; each one above has one less
    angle: of the leaning planks to the level
    spacing: between the middles of neighbouring Vs; default: nearer together than apart
    when: when the step begins; default: after the previous step
    after: the event that the step begins after
    name: goes before the names of the bricks of this step
    brick: what this step is built of; default: the scenario's brick
    every: time for each brick; default: all at one time
    until: goes on until the structure falls
    place: by hand, one brick after another; default: set down as if from nowhere
    jitter: how far off its bricks are set down, in `samples`; default: not at all
    """
    what_is_written = {
        "origin": origin,
        "heading": heading,
        "omit": omit,
        "levels": levels,
        "angle": angle,
        "spacing": spacing,
    }
    return written(
        {
            "card_house": what_is_written,
            "at": when,
            "after": after,
            "name": name,
            "brick": brick,
            "every": every,
            "until": until,
            "place": place,
            "jitter": jitter,
        }
    )


def leaning_structure(
    *,
    origin: Sequence[int | str] | None = None,
    heading: int | str | None = None,
    omit: Sequence[str] | None = None,
    levels: int | None = None,
    step: str | None = None,
    spacing: str | None = None,
    when: int | str | None = None,
    after: str | None = None,
    name: str | None = None,
    brick: str | object | None = None,
    every: str | None = None,
    until: str | None = None,
    place: str | Mapping[str, object] | None = None,
    jitter: Mapping[str, object] | None = None,
) -> Written:
    """A four-stack whose levels are all shifted the same way, to be built on until it falls.

    origin: shifts the layout to [x, y, z]
    heading: turns the layout about the vertical through its origin, x towards y
    omit: bricks that are left out, such as `L2.3`; all others keep their names
    levels: how many levels of two planks
    step: how far each level is shifted along x from the one below; default: 11 % of the length
    spacing: between the centres of the two planks; default: two thirds of the length
    when: when the step begins; default: after the previous step
    after: the event that the step begins after
    name: goes before the names of the bricks of this step
    brick: what this step is built of; default: the scenario's brick
    every: time for each brick; default: all at one time
    until: goes on until the structure falls
    place: by hand, one brick after another; default: set down as if from nowhere
    jitter: how far off its bricks are set down, in `samples`; default: not at all
    """
    what_is_written = {
        "origin": origin,
        "heading": heading,
        "omit": omit,
        "levels": levels,
        "step": step,
        "spacing": spacing,
    }
    return written(
        {
            "leaning_structure": what_is_written,
            "at": when,
            "after": after,
            "name": name,
            "brick": brick,
            "every": every,
            "until": until,
            "place": place,
            "jitter": jitter,
        }
    )


def arch(
    *,
    origin: Sequence[int | str] | None = None,
    heading: int | str | None = None,
    omit: Sequence[str] | None = None,
    span: str | None = None,
    rise: str | None = None,
    thickness: str | None = None,
    voussoirs: int | None = None,
    depth: str | None = None,
    abutment: str | None = None,
    height: str | None = None,
    when: int | str | None = None,
    after: str | None = None,
    name: str | None = None,
    brick: str | object | None = None,
    every: str | None = None,
    until: str | None = None,
    place: str | Mapping[str, object] | None = None,
    jitter: Mapping[str, object] | None = None,
) -> Written:
    """Stones with radial joints, all set down at one moment, as no part of an arch stands by itself.

    origin: shifts the layout to [x, y, z]
    heading: turns the layout about the vertical through its origin, x towards y
    omit: bricks that are left out, such as `L2.3`; all others keep their names
    span: between the springings, on the inner side
    rise: of the crown above the springings, on the inner side; default: half the span, a semicircle
    thickness: of the ring of stones, along the joints
    voussoirs: how many stones
    depth: from front to back; default: the width of the brick
    abutment: how wide each abutment is behind the arch; a semicircle stands on the ground without any
    height: of the springings above the ground, where there are abutments; default: the thickness
    when: when the step begins; default: after the previous step
    after: the event that the step begins after
    name: goes before the names of the bricks of this step
    brick: what this step is built of; default: the scenario's brick
    every: time for each brick; default: all at one time
    until: goes on until the structure falls
    place: by hand, one brick after another; default: set down as if from nowhere
    jitter: how far off its bricks are set down, in `samples`; default: not at all
    """
    what_is_written = {
        "origin": origin,
        "heading": heading,
        "omit": omit,
        "span": span,
        "rise": rise,
        "thickness": thickness,
        "voussoirs": voussoirs,
        "depth": depth,
        "abutment": abutment,
        "height": height,
    }
    return written(
        {
            "arch": what_is_written,
            "at": when,
            "after": after,
            "name": name,
            "brick": brick,
            "every": every,
            "until": until,
            "place": place,
            "jitter": jitter,
        }
    )


def flat_arch(
    *,
    origin: Sequence[int | str] | None = None,
    heading: int | str | None = None,
    omit: Sequence[str] | None = None,
    span: str | None = None,
    height: str | None = None,
    thickness: str | None = None,
    voussoirs: int | None = None,
    lean: int | str | None = None,
    abutment: str | None = None,
    depth: str | None = None,
    when: int | str | None = None,
    after: str | None = None,
    name: str | None = None,
    brick: str | object | None = None,
    every: str | None = None,
    until: str | None = None,
    place: str | Mapping[str, object] | None = None,
    jitter: Mapping[str, object] | None = None,
) -> Written:
    """Two abutments, and wedges between them, level below and above, all set down at one moment.

    origin: shifts the layout to [x, y, z]
    heading: turns the layout about the vertical through its origin, x towards y
    omit: bricks that are left out, such as `L2.3`; all others keep their names
    span: between the abutments, on the lower side
    height: of the lower side above the ground
    thickness: from the lower side to the upper one
    voussoirs: how many stones
    lean: of the outermost joints from upright
    abutment: how wide each abutment is on top
    depth: from front to back; default: the width of the brick
    when: when the step begins; default: after the previous step
    after: the event that the step begins after
    name: goes before the names of the bricks of this step
    brick: what this step is built of; default: the scenario's brick
    every: time for each brick; default: all at one time
    until: goes on until the structure falls
    place: by hand, one brick after another; default: set down as if from nowhere
    jitter: how far off its bricks are set down, in `samples`; default: not at all
    """
    what_is_written = {
        "origin": origin,
        "heading": heading,
        "omit": omit,
        "span": span,
        "height": height,
        "thickness": thickness,
        "voussoirs": voussoirs,
        "lean": lean,
        "abutment": abutment,
        "depth": depth,
    }
    return written(
        {
            "flat_arch": what_is_written,
            "at": when,
            "after": after,
            "name": name,
            "brick": brick,
            "every": every,
            "until": until,
            "place": place,
            "jitter": jitter,
        }
    )


def jenga(
    *,
    origin: Sequence[int | str] | None = None,
    heading: int | str | None = None,
    omit: Sequence[str] | None = None,
    levels: int | None = None,
    bricks: int | None = None,
    spacing: str | None = None,
    when: int | str | None = None,
    after: str | None = None,
    name: str | None = None,
    brick: str | object | None = None,
    every: str | None = None,
    until: str | None = None,
    place: str | Mapping[str, object] | None = None,
    jitter: Mapping[str, object] | None = None,
) -> Written:
    """Planks side by side, turned by a quarter each level, to be pulled out one by one.

    origin: shifts the layout to [x, y, z]
    heading: turns the layout about the vertical through its origin, x towards y
    omit: bricks that are left out, such as `L2.3`; all others keep their names
    levels: how many levels
    bricks: planks of a level
    spacing: between the centres of neighbours; default: the length of a plank, divided among all
    when: when the step begins; default: after the previous step
    after: the event that the step begins after
    name: goes before the names of the bricks of this step
    brick: what this step is built of; default: the scenario's brick
    every: time for each brick; default: all at one time
    until: goes on until the structure falls
    place: by hand, one brick after another; default: set down as if from nowhere
    jitter: how far off its bricks are set down, in `samples`; default: not at all
    """
    what_is_written = {
        "origin": origin,
        "heading": heading,
        "omit": omit,
        "levels": levels,
        "bricks": bricks,
        "spacing": spacing,
    }
    return written(
        {
            "jenga": what_is_written,
            "at": when,
            "after": after,
            "name": name,
            "brick": brick,
            "every": every,
            "until": until,
            "place": place,
            "jitter": jitter,
        }
    )


def pyramid(
    *,
    origin: Sequence[int | str] | None = None,
    heading: int | str | None = None,
    omit: Sequence[str] | None = None,
    levels: int | None = None,
    gap: int | str | None = None,
    when: int | str | None = None,
    after: str | None = None,
    name: str | None = None,
    brick: str | object | None = None,
    every: str | None = None,
    until: str | None = None,
    place: str | Mapping[str, object] | None = None,
    jitter: Mapping[str, object] | None = None,
) -> Written:
    """Rows of planks end to end along x, each plank upon the ends of two of the row below, up to a single one.

    origin: shifts the layout to [x, y, z]
    heading: turns the layout about the vertical through its origin, x towards y
    omit: bricks that are left out, such as `L2.3`; all others keep their names
    levels: how many rows; as many planks lie in the lowest
    gap: between the ends of neighbours
    when: when the step begins; default: after the previous step
    after: the event that the step begins after
    name: goes before the names of the bricks of this step
    brick: what this step is built of; default: the scenario's brick
    every: time for each brick; default: all at one time
    until: goes on until the structure falls
    place: by hand, one brick after another; default: set down as if from nowhere
    jitter: how far off its bricks are set down, in `samples`; default: not at all
    """
    what_is_written = {"origin": origin, "heading": heading, "omit": omit, "levels": levels, "gap": gap}
    return written(
        {
            "pyramid": what_is_written,
            "at": when,
            "after": after,
            "name": name,
            "brick": brick,
            "every": every,
            "until": until,
            "place": place,
            "jitter": jitter,
        }
    )


def corbel(
    *,
    origin: Sequence[int | str] | None = None,
    heading: int | str | None = None,
    omit: Sequence[str] | None = None,
    levels: int | None = None,
    share: float | str | None = None,
    gap: str | None = None,
    when: int | str | None = None,
    after: str | None = None,
    name: str | None = None,
    brick: str | object | None = None,
    every: str | None = None,
    until: str | None = None,
    place: str | Mapping[str, object] | None = None,
    jitter: Mapping[str, object] | None = None,
) -> Written:
    """Two stacks that lean towards each other by harmonic overhangs, a share of those at which they tip.

    origin: shifts the layout to [x, y, z]
    heading: turns the layout about the vertical through its origin, x towards y
    omit: bricks that are left out, such as `L2.3`; all others keep their names
    levels: how many planks each side has
    share: of the overhangs at which a side is on the point of tipping
    gap: between the two uppermost planks; default: the thickness of a plank
    when: when the step begins; default: after the previous step
    after: the event that the step begins after
    name: goes before the names of the bricks of this step
    brick: what this step is built of; default: the scenario's brick
    every: time for each brick; default: all at one time
    until: goes on until the structure falls
    place: by hand, one brick after another; default: set down as if from nowhere
    jitter: how far off its bricks are set down, in `samples`; default: not at all
    """
    what_is_written = {"origin": origin, "heading": heading, "omit": omit, "levels": levels, "share": share, "gap": gap}
    return written(
        {
            "corbel": what_is_written,
            "at": when,
            "after": after,
            "name": name,
            "brick": brick,
            "every": every,
            "until": until,
            "place": place,
            "jitter": jitter,
        }
    )


def dominoes(
    *,
    origin: Sequence[int | str] | None = None,
    heading: int | str | None = None,
    omit: Sequence[str] | None = None,
    bricks: int | None = None,
    spacing: str | None = None,
    when: int | str | None = None,
    after: str | None = None,
    name: str | None = None,
    brick: str | object | None = None,
    every: str | None = None,
    until: str | None = None,
    place: str | Mapping[str, object] | None = None,
    jitter: Mapping[str, object] | None = None,
) -> Written:
    """Planks on end in a row along x, their flat sides to each other; the first stands at the origin.

    origin: shifts the layout to [x, y, z]
    heading: turns the layout about the vertical through its origin, x towards y
    omit: bricks that are left out, such as `L2.3`; all others keep their names
    bricks: how many planks
    spacing: from the middle of one to that of the next
    when: when the step begins; default: after the previous step
    after: the event that the step begins after
    name: goes before the names of the bricks of this step
    brick: what this step is built of; default: the scenario's brick
    every: time for each brick; default: all at one time
    until: goes on until the structure falls
    place: by hand, one brick after another; default: set down as if from nowhere
    jitter: how far off its bricks are set down, in `samples`; default: not at all
    """
    what_is_written = {"origin": origin, "heading": heading, "omit": omit, "bricks": bricks, "spacing": spacing}
    return written(
        {
            "dominoes": what_is_written,
            "at": when,
            "after": after,
            "name": name,
            "brick": brick,
            "every": every,
            "until": until,
            "place": place,
            "jitter": jitter,
        }
    )


def ring(
    *,
    origin: Sequence[int | str] | None = None,
    heading: int | str | None = None,
    omit: Sequence[str] | None = None,
    posts: int | None = None,
    overlap: float | str | None = None,
    when: int | str | None = None,
    after: str | None = None,
    name: str | None = None,
    brick: str | object | None = None,
    every: str | None = None,
    until: str | None = None,
    place: str | Mapping[str, object] | None = None,
    jitter: Mapping[str, object] | None = None,
) -> Written:
    """Posts on end round a circle, and lintels that each lie on two of them, half of their weight on either.

    origin: shifts the layout to [x, y, z]
    heading: turns the layout about the vertical through its origin, x towards y
    omit: bricks that are left out, such as `L2.3`; all others keep their names
    posts: how many posts, and as many lintels
    overlap: of the most by which lintels can lie on posts without meeting each other
    when: when the step begins; default: after the previous step
    after: the event that the step begins after
    name: goes before the names of the bricks of this step
    brick: what this step is built of; default: the scenario's brick
    every: time for each brick; default: all at one time
    until: goes on until the structure falls
    place: by hand, one brick after another; default: set down as if from nowhere
    jitter: how far off its bricks are set down, in `samples`; default: not at all
    """
    what_is_written = {"origin": origin, "heading": heading, "omit": omit, "posts": posts, "overlap": overlap}
    return written(
        {
            "ring": what_is_written,
            "at": when,
            "after": after,
            "name": name,
            "brick": brick,
            "every": every,
            "until": until,
            "place": place,
            "jitter": jitter,
        }
    )

"""Which file a snapshot is kept in: `tower/step-10mm.exact.json`, a name that shells, git and Windows take as it is.

A name is made so that what it was made from can be read from it again; one of which that is not so, such as one with
capitals, which some disks take for small letters, gets a digest; so does one that ends as if it had one. So no two
identities share a file, and no file is called otherwise because of what other variants there are.
"""

import re
from hashlib import sha256
from os.path import exists
from pathlib import Path
from typing import Final

from stackdsl.snapshots.record import Identity

LONGEST_PART: Final = 60  # characters of each part of a name: disks that encrypt take 143
DIGEST: Final = 10  # hexadecimal digits, where a name alone does not do
ENDS_IN_DIGEST: Final = re.compile(rf".*-[0-9a-f]{{{DIGEST}}}")
DEVICES: Final = re.compile(r"(con|prn|aux|nul|com[0-9]|lpt[0-9])(\..*)?")  # which Windows takes for no file
OLD_NAME: Final = re.compile(r"[^\[\]]+\[[^\[\]]*\]\.json")  # such as `tower[step=10mm,exact].json`
NEW_NAME: Final = re.compile(r"(?:[a-z0-9][a-z0-9._-]*\.)?(?:exact|thesis|tuned|stock|modified)\.json")
_CHOICE: Final = re.compile(r"([a-z][a-z0-9_]*)-(.*?)(?:_(?=[a-z][a-z0-9_]*-)|$)")


def golden_name(identity: Identity) -> str:
    """The name of the file of a snapshot, below the directory of golden files."""
    chosen = identity.variant.removesuffix(identity.system).removesuffix(",")
    parts = [_variant(chosen)] if chosen else []
    parts += [_plain(identity.system)] if identity.system else []
    return f"{_plain(identity.scenario)}/{'.'.join(parts) or _with_digest('', '')}.json"


def golden_file(directory: Path, identity: Identity) -> Path:
    """The file of a snapshot: under its name, or under the one that earlier versions gave it, if it is there alone."""
    path, old = directory / golden_name(identity), directory / old_name(identity)
    return old if not exists(path) and exists(old) else path


def directory_of(file: Path) -> Path:
    """The directory of golden files that one of them is in, by its name."""
    return file.parent if OLD_NAME.fullmatch(file.name) else file.parent.parent


def _variant(chosen: str) -> str:
    slug = chosen.replace("/", "-per-").replace("%", "pct").replace("=", "-").replace(",", "_")
    choices = [f"{name}={_value(value)}" for name, value in _CHOICE.findall(slug)]
    return slug if ",".join(choices) == chosen and _is_plain(slug) else _with_digest(slug, chosen)


def _value(slug: str) -> str:
    return re.sub(r"(?<=[0-9])pct$", "%", slug.replace("-per-", "/"))


def _plain(name: str) -> str:
    return name if _is_plain(name) and "." not in name else _with_digest(name, name)


def _is_plain(slug: str) -> bool:
    plain = re.fullmatch(r"[a-z0-9](?:[a-z0-9._-]*[a-z0-9])?", slug) is not None
    taken = DEVICES.fullmatch(slug) or ENDS_IN_DIGEST.fullmatch(slug)
    return plain and len(slug) <= LONGEST_PART and not taken


def _with_digest(slug: str, meant: str) -> str:
    digest = sha256(_bytes(meant)).hexdigest()[:DIGEST]
    kept = re.sub(r"[^a-z0-9]+", "-", slug.casefold())[: LONGEST_PART - DIGEST - 1].strip("-")
    return f"{kept or 'x'}-{digest}"


def old_name(identity: Identity) -> str:
    """The name of the same file in versions up to 0.1."""
    # A dot in a scenario's name could make a device name of Windows, such as `con.txt[...]`.
    return f"{_old_part(identity.scenario, r'[^a-z0-9_=,+-]')}[{_old_part(identity.variant, r'[^a-z0-9_=,+.-]')}].json"


def _old_part(name: str, unsafe: str) -> str:
    """A name with every unsafe character as %xx (capitals too: some disks take `A` for `a`), shortened by a hash."""
    escaped = re.sub(unsafe, lambda found: "".join(f"%{byte:02x}" for byte in _bytes(found.group())), name)
    if len(escaped) <= LONGEST_PART:
        return escaped
    digest = sha256(_bytes(name)).hexdigest()[:16]
    return f"{escaped[: LONGEST_PART - len(digest) - 1]}~{digest}"


def _bytes(text: str) -> bytes:
    return text.encode("utf-8", errors="surrogatepass")

"""Credits for renderings of a track: its designer, and the licences of exactly the files that it uses."""

import re
from collections.abc import Iterable
from fnmatch import translate
from pathlib import Path

from supersampling.scenes.stk.nodes import parse

_DEBIAN_NOTICE = Path("/usr/share/doc/supertuxkart-data/copyright")
_GENERAL = "the SuperTuxKart team and others, by the package's general terms"
_UNNAMED = "licence not stated in the package's copyright file"


def attribution(track: Path, root: Path, files: Iterable[Path], notice: Path = _DEBIAN_NOTICE) -> str:
    """Return one paragraph: title, designer, package, and each licence with its holders and number of files.

    ``notice`` is a Debian copyright file (machine-readable format 1.0); the last stanza that matches a file applies,
    and the stanza of ``*`` has the package's general terms.
    """
    head = parse(track / "track.xml") if (track / "track.xml").is_file() else None
    title = track.name if head is None else head.get("name", track.name)
    designer = "unknown" if head is None else head.get("designer", "unknown")
    credit = f'SuperTuxKart track "{title}" by {designer}.'
    if not notice.is_file():
        return f"{credit} See the licence files of the SuperTuxKart data for the terms of its models and textures."
    owners = _owners(sorted({_packaged(file, root) for file in files}), _stanzas(notice.read_text("utf-8")))
    terms = [
        f"{licence}: {count} files ({'; '.join(sorted(holders))})" if holders else f"{licence}: {count} files"
        for licence, (count, holders) in sorted(owners.items())
    ]
    return f"{credit} Files used, by licence, from the Debian package supertuxkart-data: {'. '.join(terms)}."


def _packaged(file: Path, root: Path) -> str:
    return f"data/{file.relative_to(root).as_posix()}" if file.is_relative_to(root) else file.name


def _stanzas(text: str) -> list[tuple[re.Pattern[str], str, list[str]]]:
    """Return pattern, licence and holders of each ``Files:`` stanza, in order."""
    stanzas = []
    for block in re.split(r"\n\s*\n", text):
        fields = {m[1]: m[2] for m in re.finditer(r"^(\S[^:\n]*):(.*(?:\n[ \t].*)*)", block, re.MULTILINE)}
        if "Files" in fields and "License" in fields:
            patterns = "|".join(translate(glob) for glob in fields["Files"].split())
            holders = [line.strip() for line in fields.get("Copyright", "").splitlines() if line.strip()]
            if fields["Files"].strip() == "*":
                holders = [_GENERAL]
            stanzas.append((re.compile(patterns), fields["License"].strip().splitlines()[0].strip(), holders))
    return stanzas


def _owners(files: list[str], stanzas: list[tuple[re.Pattern[str], str, list[str]]]) -> dict[str, tuple[int, set[str]]]:
    owners: dict[str, tuple[int, set[str]]] = {}
    for file in files:
        match = next(((licence, names) for pattern, licence, names in reversed(stanzas) if pattern.match(file)), None)
        licence, names = match or (_UNNAMED, [])
        count, holders = owners.get(licence, (0, set()))
        owners[licence] = (count + 1, holders | set(names))
    return owners

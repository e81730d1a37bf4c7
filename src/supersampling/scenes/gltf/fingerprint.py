"""Fingerprint of a glTF file: of its bytes and of those of every file that it refers to."""

import hashlib
from pathlib import Path

from supersampling.scenes.gltf.document import MALFORMED, Document, malformed

_READER = b"2"
"""Version of the reader: a file that is drawn otherwise by a newer one gets a data set of its own."""


def fingerprint(path: Path) -> str:
    """Return 16 hex digits of the content of a ``.gltf`` or ``.glb`` file with its buffers and images.

    They do not depend on the file's location.

    Raises:
        UserError: The file is not readable glTF 2.0, or one of its files is missing or outside its folder.
    """
    try:
        document = Document(path)
        digest = hashlib.sha256(_READER + path.read_bytes())
        for kind in ("buffers", "images"):
            for index, item in enumerate(getattr(document.gltf, kind)):
                if item.uri is not None and not item.uri.startswith("data:"):
                    digest.update(document.resource(item.uri, f"{kind[:-1]} {index}"))
        return digest.hexdigest()[:16]
    except MALFORMED as error:
        raise malformed(path.name, error) from error

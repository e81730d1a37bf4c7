"""Accessors: typed, strided, sparse and normalised views of buffers, as arrays (specification, section 3.6.2)."""

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from supersampling.errors import UserError
from supersampling.scenes.gltf.document import Document

_COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
_MOST = 1 << 26  # elements
_MOST_ZEROS = 1 << 22  # elements of an accessor without a buffer view, which could declare any number


class Accessors:
    """Accessors of a document, each read once.

    Raises:
        UserError: An accessor exceeds its buffer or has an unknown type.
    """

    def __init__(self, document: Document) -> None:
        self._document = document
        self._values = cache(self._decode)

    def floats(self, index: int, *widths: int) -> NDArray[np.float32]:
        """Return ``(count, width)`` float32, normalised integers as fractions; the width must be one of ``widths``."""
        values, normalized = self._values(index)
        self._expect(index, values.shape[1], widths)
        if normalized and values.dtype.kind in "iu":
            return np.maximum(values / np.float32(np.iinfo(values.dtype).max), np.float32(-1.0)).astype(np.float32)
        return values.astype(np.float32, copy=False)

    def integers(self, index: int, width: int = 1) -> NDArray[np.int64]:
        """Return ``(count, width)`` int64 of unsigned integers."""
        values, _ = self._values(index)
        self._expect(index, values.shape[1], (width,))
        if values.dtype.kind != "u":
            raise UserError(
                f"Accessor {index} of {self._document.name} has {values.dtype.name} values, not unsigned integers: "
                "export it again."
            )
        return values.astype(np.int64)

    def _expect(self, index: int, width: int, widths: tuple[int, ...]) -> None:
        if width not in widths:
            raise UserError(
                f"Accessor {index} of {self._document.name} has {width} components instead of "
                f"{' or '.join(map(str, widths))}: export it again."
            )

    def _decode(self, index: int) -> tuple[NDArray[Any], bool]:
        accessor = self._document.item("accessors", index)
        dtype, width = self._type(index, accessor.componentType), _WIDTHS.get(accessor.type)
        count = accessor.count or 0
        most = _MOST_ZEROS if accessor.bufferView is None else _MOST
        if width is None or not 0 < count <= most:
            raise UserError(
                f"Accessor {index} of {self._document.name} has the invalid type {accessor.type} or count {count}: "
                "export it again."
            )
        if accessor.bufferView is None:
            values = np.zeros((count, width), dtype)
        else:
            values = self._read_strided(index, accessor.bufferView, accessor.byteOffset or 0, dtype, count, width)
        if accessor.sparse is not None:
            values = self._replace_sparse(index, values, accessor.sparse)
        return values, bool(accessor.normalized)

    def _type(self, index: int, component: int) -> np.dtype[Any]:
        if component not in _COMPONENTS:
            raise UserError(
                f"Accessor {index} of {self._document.name} has the unknown component type {component}: "
                "export it again."
            )
        return np.dtype(_COMPONENTS[component])

    def _read_strided(
        self, index: int, view: int, offset: int, dtype: np.dtype[Any], count: int, width: int
    ) -> NDArray[Any]:
        data, stride = self._document.view(view)
        size = width * dtype.itemsize
        step = stride or size
        end = offset + step * (count - 1) + size
        if offset < 0 or step < size or end > len(data):
            raise UserError(
                f"Accessor {index} of {self._document.name} ends at byte {end} of a buffer view of {len(data)} bytes "
                f"(byteOffset {offset}, count {count}): the file is broken, export it again."
            )
        shape, strides = (count, width), (step, dtype.itemsize)
        return np.ascontiguousarray(np.ndarray(shape, dtype, data, offset, strides))

    def _replace_sparse(self, index: int, values: NDArray[Any], sparse: Any) -> NDArray[Any]:
        """Return the values with some elements replaced (section 3.6.2.3)."""
        count, width = sparse.count or 0, values.shape[1]
        kind = self._type(index, sparse.indices.componentType)
        places = self._read_strided(index, sparse.indices.bufferView, sparse.indices.byteOffset or 0, kind, count, 1)[
            :, 0
        ]
        new = self._read_strided(
            index, sparse.values.bufferView, sparse.values.byteOffset or 0, values.dtype, count, width
        )
        if len(places) and int(places.max()) >= len(values):
            raise UserError(
                f"The sparse accessor {index} of {self._document.name} replaces element {int(places.max())} of "
                f"{len(values)}: the file is broken, export it again."
            )
        out = values.copy()
        out[places] = new
        return out

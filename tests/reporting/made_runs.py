from typing import Any

from supersampling.runs.store import Run


def made_run(
    name: str,
    ended: int = 0,
    dataset: str = "aaaa",
    method: str = "m",
    metrics: dict[str, float] | None = None,
    **params: Any,
) -> Run:
    """A finished 4x4 job; parameter names are written with ``__`` for a dot."""
    base = {
        "model": "dlctus",
        "task.scale": "4",
        "task.mip_bias": "matched",
        "data": "laptop",
        "data.scenes": "atrium",
    }
    given = {key.replace("__", "."): str(value) for key, value in params.items()}
    return Run(name, name, name, dataset, method, "machine", "1", ended, {**base, **given}, metrics or {})

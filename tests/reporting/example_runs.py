from typing import Any

from supersampling.runs.store import Run


def example_run(
    name: str,
    ended: int = 0,
    dataset: str = "aaaa",
    method: str = "m",
    metrics: dict[str, float] | None = None,
    **params: Any,
) -> Run:
    """Return a finished 4x4 job; parameter names are written with ``__`` for a dot."""
    base = {"model": "dlctus", "task.scale": "4", "task.mip_bias": "matched", "data": "laptop", "data.scenes": "atrium"}
    return Run(
        id=name,
        name=name,
        identity=name,
        dataset=dataset,
        method=method,
        machine="machine",
        version="1",
        ended=ended,
        params={**base, **{key.replace("__", "."): str(value) for key, value in params.items()}},
        metrics=metrics or {},
    )

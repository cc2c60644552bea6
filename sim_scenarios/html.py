"""Pages of HTML from the templates of the package.

plotly.js (MIT licence) travels in pages with curves, compressed, and the figures as JSON: a page loads
nothing.
"""

from __future__ import annotations

import base64
import gzip
import hashlib
import json
from collections.abc import Sequence
from functools import cache
from typing import Any

import jinja2
import numpy as np
from numpy.typing import NDArray


def render(template: str, **content: Any) -> str:
    """Page of a template. Templates know the filters `base64` (of bytes) and `from_json` (of text).

    A page loads nothing, and runs none but the `scripts` of its content.
    """
    return _environment().get_template(template).render(**content)


def source(name: str) -> str:
    """Text of a file that lies with the templates."""
    loader, environment = _environment().loader, _environment()
    assert loader is not None
    return loader.get_source(environment, name)[0]


def interactive(script: str, content: object) -> dict[str, Any]:
    """What the template of a page with curves is given: the script that draws, and what it draws.

    Parameters
    ----------
    script : str
        Name of a file with the templates; it stands behind plots.js.
    content : object
        As JSON takes it; not a number is None.
    """
    code = source("plots.js") + source(script)
    plain, packed = _plotly()
    text = json.dumps(content, allow_nan=False).replace("<", "\\u003c")  # it cannot end its element
    return {"content": text, "plotly": packed, "script": code, "scripts": [code, plain]}


def numbers(values: NDArray[np.float64]) -> list[float | None]:
    """Values with five digits, None for those that do not exist."""
    return [float(f"{value:.5g}") if np.isfinite(value) else None for value in values.tolist()]


def policy(scripts: Sequence[str], listens: bool = False) -> str:
    """What a page may do (Content-Security-Policy): show what it holds, and run these scripts.

    A page that listens may ask who served it for more to show.
    """
    hashes = [base64.b64encode(hashlib.sha256(script.encode()).digest()).decode() for script in scripts]
    allowed = " ".join(f"'sha256-{one}'" for one in hashes) or "'none'"
    listening = "; connect-src 'self'" if listens else ""
    return (
        "default-src 'none'; img-src data:; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'; "
        f"script-src {allowed}{listening}"
    )


@cache
def _plotly() -> tuple[str, str]:
    """plotly.js, and base64 of it compressed."""
    from plotly.offline import get_plotlyjs  # slow

    script: str = get_plotlyjs()
    return script, base64.b64encode(gzip.compress(script.encode(), 6, mtime=0)).decode("ascii")


@cache
def _environment() -> jinja2.Environment:
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("sim_scenarios", "templates"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {
        "base64": lambda raw: base64.b64encode(raw).decode("ascii"),
        "from_json": json.loads,
    }
    environment.globals |= {"policy": policy}
    return environment

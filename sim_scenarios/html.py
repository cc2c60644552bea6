"""Pages of HTML from the templates of the package."""

from __future__ import annotations

import base64
import json
from functools import cache
from typing import Any

import jinja2


def render(template: str, **content: Any) -> str:
    """Page of a template. Templates know the filters `base64` (of bytes) and `from_json` (of text)."""
    return _environment().get_template(template).render(**content)


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
    return environment

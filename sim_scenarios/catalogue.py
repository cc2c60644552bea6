"""What comes with the package, by name: scenarios, campaigns, papers; and files that stand in their place.

Nothing that takes long to import is needed here, so that `truenorth list` and the completion of a shell
answer at once.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

from sim_scenarios import toml
from sim_scenarios.errors import InputError

_PACKAGE: Final = Path(__file__).parent
SCENARIOS: Final = _PACKAGE / "scenarios"
CAMPAIGNS: Final = _PACKAGE / "campaigns" / "shipped"
PAPERS: Final = _PACKAGE / "papers"


def scenarios() -> dict[str, str]:
    """Description of every scenario, by name."""
    return {name: str(read_scenario(path).get("description", "")) for name, path in files(SCENARIOS).items()}


def campaigns() -> dict[str, str]:
    """Description of every campaign, by name."""
    return {name: str(toml.read(path)["description"]) for name, path in files(CAMPAIGNS).items()}


def papers() -> dict[str, str]:
    """Citation of every paper, by name."""
    return {name: str(toml.read(path)["citation"]) for name, path in files(PAPERS).items()}


def files(folder: Path) -> dict[str, Path]:
    """Files of one of the three folders, by name."""
    return {path.stem: path for path in sorted(folder.glob("*.toml"))}


def scenario_path(name: str | Path) -> Path:
    """Path of a scenario: of a shipped name, of a file, or of a file without its `.toml`.

    Raises
    ------
    InputError
        There is no such scenario.
    """
    is_path = isinstance(name, Path) or name.endswith(".toml") or "/" in name
    beside = Path(f"{name}.toml")
    for path in (Path(name) if is_path else SCENARIOS / beside, beside):
        if toml.exists(path):
            return path
    if is_path:
        raise InputError(f"there is no scenario file {name}")
    from sim_scenarios.fmus import did_you_mean  # slow: FMPy

    names = list(files(SCENARIOS))
    hint = (
        did_you_mean(str(name), names) or f"; there are {', '.join(names)}, or give the path of a .toml file"
    )
    raise InputError(f"there is no scenario '{name}'{hint}")


def read_scenario(path: Path, above: tuple[Path, ...] = ()) -> dict[str, Any]:
    """Content of a scenario file upon that of the one it extends; `above` are those that extend it."""
    table = toml.read(path)
    if "extends" not in table:
        return table
    try:
        below = scenario_path(str(table.pop("extends")))
    except InputError as error:
        raise InputError(f"{path}: extends: {error}") from None
    if below.resolve() in [one.resolve() for one in (*above, path)]:
        raise InputError(f"{path}: extends: {below} extends this file in turn")
    base = read_scenario(below, (*above, path))
    if "compare" in table:
        base.pop("compare", None)
    return _merged(base, table)


def _merged(base: dict[str, Any], upper: dict[str, Any]) -> dict[str, Any]:
    """Nested tables, entries of the upper one in front."""
    merged = dict(base)
    for key, value in upper.items():
        below = merged.get(key)
        if isinstance(below, dict) and isinstance(value, dict):
            merged[key] = _merged(below, value)
        else:
            merged[key] = value
    return merged

"""What comes with the package, by name: scenarios, campaigns, papers; and files that stand in their place.

Nothing that takes long to import is needed here, so that `truenorth list` and the completion of a shell
answer at once.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from sim_scenarios import toml
from sim_scenarios.errors import InputError

_PACKAGE: Final = Path(__file__).parent
SCENARIOS: Final = _PACKAGE / "scenarios"
CAMPAIGNS: Final = _PACKAGE / "campaigns"
PAPERS: Final = _PACKAGE / "papers"
BANDS: Final = _PACKAGE / "bands"


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
    """Files of one of these folders, by name."""
    return {path.stem: path for path in sorted(folder.glob("*.toml"))}


def scenario_path(name: str | Path) -> Path:
    """Path of a scenario: of a shipped name, of a file, or of a file without its `.toml`.

    Raises
    ------
    InputError
        There is no such scenario, or it is a file of another kind.
    """
    if Path(name).suffix not in ("", ".toml") and toml.exists(Path(name)):
        raise InputError(
            f"{name} is no scenario; a recording is for `truenorth import`, `replay` and `derive`"
        )
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


def is_own_fmu(name: str) -> bool:
    """Whether the name of an FMU is the path of somebody else's."""
    return name.endswith(".fmu")


def located(entry: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """Entry of a file for a filter, or all of it; paths that it has count from the folder of the file."""
    fmu, trajectory = entry.get("filter_fmu"), entry.get("trajectory")
    placed = dict(entry)
    if isinstance(fmu, str) and is_own_fmu(fmu):
        placed["filter_fmu"] = str(folder.resolve() / fmu)
    if isinstance(trajectory, str):
        placed["trajectory"] = str(folder.resolve() / trajectory)
    return placed


def located_filters(filters: object, folder: Path) -> object:
    """Entries of a file for filters by label, each as of `located`; what is no such table stays as it is."""
    if not isinstance(filters, Mapping):
        return filters
    return {
        k: located(entry, folder) if isinstance(entry, Mapping) else entry for k, entry in filters.items()
    }


def with_filter_fmu(table: Mapping[str, Any], fmu: str) -> dict[str, Any]:
    """A scenario with another FMU for its filter; one of somebody else's is told nothing of what ours was."""
    kept = {k: v for k, v in table.items() if not is_own_fmu(fmu) or k not in ("filter", "compare")}
    return {**kept, "filter_fmu": fmu}


def read_scenario(path: Path, above: tuple[Path, ...] = ()) -> dict[str, Any]:
    """Content of a scenario file upon that of the one it extends; `above` are those that extend it."""
    table = located(toml.read(path), path.parent)
    if "imu" in table:
        raise InputError(f"{path} describes a recording: `truenorth replay {path}` takes it")
    if "compare" in table:
        table["compare"] = located_filters(table["compare"], path.parent)
    if "extends" not in table:
        return table
    try:
        below = scenario_path(str(table.pop("extends")))
    except InputError as error:
        raise InputError(f"{path}: extends: {error}") from None
    if below.resolve() in [one.resolve() for one in (*above, path)]:
        raise InputError(f"{path}: extends: {below} extends this file in turn")
    base = read_scenario(below, (*above, path))
    for entry, other in (("compare", "compare"), ("trajectory", "waypoints"), ("waypoints", "trajectory")):
        if entry in table:
            base.pop(other, None)
    if isinstance(fmu := table.get("filter_fmu"), str) and fmu != base.get("filter_fmu"):
        base = with_filter_fmu(base, fmu)
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

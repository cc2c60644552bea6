"""What a partner needs to run a scenario in another tool: FMUs, system descriptions, reference results.

`export` writes one folder::

    README.md                 what is here and how to use it
    fmi2/*.fmu fmi3/*.fmu     the FMUs, with the reference experiment inside (FMI-LS-REF)
    <scenario>.ssp            plant and filter as a system, SSP 1.0, of the FMI 2 FMUs
    OspSystemStructure.xml    the same for the Open Simulation Platform, with the FMUs of fmi2/; not written
                              for a scenario that sets enumerations, which libcosim cannot
    parameters/*.ssv          all that the scenario sets, as SSP parameter sets
    reference/                results in the form of the FMI cross-check: _in.csv, _ref.csv, _ref.opt
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from sim_scenarios.archives import with_members, write_archive
from sim_scenarios.errors import InputError
from sim_scenarios.exchange import documents, reference
from sim_scenarios.exchange.system import Component, System, of_scenario
from sim_scenarios.fmus import Fmus
from sim_scenarios.folders import filled
from sim_scenarios.scenario import load_scenario

__all__ = ["Component", "System", "export"]

STEP = 0.1
"""Communication step of the exported system [s]: ten IMU periods, so that slow importers take seconds."""
OSP = "OspSystemStructure.xml"
REFERENCES = "extra/org.fmi-standard.fmi-ls-ref"


def export(
    scenario: str | Path,
    folder: Path,
    *,
    seed: int | None = None,
    set: Mapping[str, object] | None = None,  # noqa: A002  (the word of the command line)
    step: float = STEP,
    fmus: Fmus | None = None,
) -> System:
    """Write a scenario with its filter for partners.

    Parameters
    ----------
    scenario, seed, set, fmus
        As for `run`.
    folder : Path
        Where to; files of the same names are replaced.
    step : float
        Communication step [s].

    Returns
    -------
    System
        What was written.
    """
    fmus = fmus or Fmus()
    settings = {**(set or {}), "communication_step": step}
    loaded = load_scenario(scenario, fmus, seed=seed, settings=settings)
    system = of_scenario(loaded, fmus)
    results = reference.simulate(loaded, fmus, system)
    with filled(folder) as draft:
        for component in system.components:
            _write_component(system, component, results[component.name], draft)
        _write_system(system, results, draft)
    if system.enumerations:
        (folder / OSP).unlink(missing_ok=True)  # of an earlier export
    return system


def _write_component(system: System, component: Component, results: reference.Results, folder: Path) -> None:
    """Parameters, reference results and the two FMUs of one component."""
    name = component.fmu.name
    parameters = documents.parameters(system, component)
    tables = {"ref": reference.csv(results.outputs)}
    if results.inputs:
        tables["in"] = reference.csv(results.inputs)
    _write(folder / "parameters" / f"{component.name}.ssv", parameters)
    _write(folder / "reference" / f"{name}_ref.opt", documents.options(system))
    members = {
        f"{REFERENCES}/fmi-ls-manifest.xml": documents.manifest(),
        f"{REFERENCES}/experiments.xml": documents.experiments(system, component),
        f"{REFERENCES}/{system.name}.ssv": parameters,
    }
    for kind, table in tables.items():
        _write(folder / "reference" / f"{name}_{kind}.csv", table)
        members[f"{REFERENCES}/{system.name}_{kind}.csv"] = table
    for version, path in (
        ("fmi2", component.fmu.path),
        ("fmi3", component.fmu.path.parent / "fmi3" / component.fmu.path.name),
    ):
        if not path.is_file():
            raise InputError(f"{path} is missing; run `make fmus` to build it")
        with_members(path, folder / version / path.name, members)


def _write_system(system: System, results: Mapping[str, reference.Results], folder: Path) -> None:
    """The descriptions of the system."""
    parts: dict[str, str | Path] = {"SystemStructure.ssd": documents.system_structure(system)}
    for component in system.components:
        parts[f"resources/{component.fmu.name}.fmu"] = component.fmu.path
        parts[f"resources/{component.name}.ssv"] = documents.parameters(system, component)
    write_archive(folder / f"{system.name}.ssp", parts)
    if not system.enumerations:
        _write(folder / OSP, documents.osp(system))
    _write(folder / "README.md", documents.readme(system, results))


def _write(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8", newline="\n")

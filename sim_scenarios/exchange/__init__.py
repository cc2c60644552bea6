"""What a partner needs to run a scenario in another tool: FMUs, system descriptions, reference results.

`export` writes one folder, and `export_recording` the same of a recording, which the Playback FMU holds::

    README.md                 what is here and how to use it
    fmi2/*.fmu fmi3/*.fmu     the FMUs, with the scenario's values as start values, and with the reference
                              experiment inside (FMI-LS-REF)
    <scenario>.ssp            plant and filter as a system, SSP 1.0, of the FMI 2 FMUs
    <scenario>_fmi3.ssp       the same of the FMI 3 FMUs, SSP 2.0
    OspSystemStructure.xml    the same for the Open Simulation Platform, with the FMUs of fmi2/
    parameters/*.ssv          all that the scenario sets, as SSP parameter sets
    reference/                results in the form of the FMI cross-check: _in.csv, _ref.csv, _ref.opt; below
                              fmi3/ with the arrays of FMI 3; _end.state is the state of FMI 2 at the end
    skeleton/*_in.csv         the first rows of inputs, to be replaced by one's own; below fmi3/ for FMI 3
    report.html               report of that run
    provenance.json           what it was made from and by
    sbom.cdx.json             software bill of materials of the FMUs, CycloneDX
    SHA256SUMS                checksums of all that; `truenorth verify` and `sha256sum --check` read it
    SHA256SUMS.sig            signature of that list, if a key was given

Each FMU has provenance, bill of materials and its own list of checksums, signed like that of the folder,
below extra/org.truenorth.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory

from sim_scenarios import recording, report
from sim_scenarios.archives import archive_bytes, as_bytes, read_archive
from sim_scenarios.catalogue import is_own_fmu
from sim_scenarios.errors import InputError
from sim_scenarios.exchange import checksums, documents, evidence, reference, replay, start_values
from sim_scenarios.exchange.driven import with_vehicle
from sim_scenarios.exchange.forms import FMI2, FORMS, Form
from sim_scenarios.exchange.recorded import of_recording
from sim_scenarios.exchange.signature import Sign, signer
from sim_scenarios.exchange.system import Component, System, of_scenario
from sim_scenarios.fmus import PLAYBACK, Fmus
from sim_scenarios.folders import filled, filling_temporary, temporary
from sim_scenarios.recordings.choices import Filter
from sim_scenarios.recordings.description import load
from sim_scenarios.recordings.replay import replay as replay_recording
from sim_scenarios.recordings.start import Start
from sim_scenarios.recordings.tables import Recording
from sim_scenarios.scenario import Scenario, load_scenario
from sim_scenarios.scenario.tables import FILTER
from sim_scenarios.simulation import run_filters
from sim_scenarios.stepping import EXPORTED_STEP, Order

__all__ = ["Component", "System", "export", "export_recording"]

SKELETONS = "skeleton"
"""Folder of the beginnings of input files, for signals of one's own."""


def export(
    scenario: str | Path,
    folder: Path,
    *,
    seed: int | None = None,
    set: Mapping[str, object] | None = None,  # noqa: A002  (the word of the command line)
    step: float = EXPORTED_STEP,
    fmus: Fmus | None = None,
    sign: Path | None = None,
) -> System:
    """Write a scenario with its filter for partners.

    Parameters
    ----------
    scenario, seed, set, fmus
        As for `run`.
    folder : Path
        Where to; files of the same names are replaced, and those of an earlier export removed.
    step : float
        Communication step [s].
    sign : Path, optional
        PEM file of a private key of Ed25519 that signs the lists of checksums.

    Returns
    -------
    System
        What was written.
    """
    key = signer(sign) if sign else None
    fmus = fmus or Fmus()
    settings = {**(set or {}), "communication_step": step}
    loaded = load_scenario(scenario, fmus, seed=seed, settings=settings)
    if is_own_fmu(loaded.filter_fmu):
        raise InputError(f"{scenario}: {loaded.filter_fmu} is not exported, but filters of TrueNorth alone")
    system, vehicle = of_scenario(loaded, fmus), loaded.vehicle()
    with TemporaryDirectory(dir=temporary()) as place:
        if vehicle is not None:
            with filling_temporary():
                system = with_vehicle(system, vehicle, fmus[PLAYBACK], Path(place))
        _write(system, folder, {"seed": seed, **(set or {})}, lambda: _report(loaded, fmus), key)
    return system


def export_recording(
    recording: Recording | str | Path,
    folder: Path,
    start: Start | None = None,
    *,
    filter: Filter | str = Filter.alignment,  # noqa: A002  (the word of the command line)
    set: Mapping[str, object] | None = None,  # noqa: A002
    step: float | None = None,
    fmus: Fmus | None = None,
    sign: Path | None = None,
) -> System:
    """Write a recording with what it goes through for partners.

    Parameters
    ----------
    recording, start, filter, fmus
        As for `replay`.
    folder : Path
        Where to; files of the same names are replaced, and those of an earlier export removed.
    set : mapping, optional
        As for `replay`; besides, parameters of Playback.
    step : float, optional
        Communication step [s]; by default one in which no two samples come.
    sign : Path, optional
        As for `export`.

    Returns
    -------
    System
        What was written.

    Raises
    ------
    InputError
        When the recording lacks what is needed, or a setting is wrong.
    """
    key = signer(sign) if sign else None
    task, start, fmus, set = Filter(filter), start or Start(), fmus or Fmus(), set or {}  # noqa: A001
    if not isinstance(recording, Recording):
        recording = load(Path(recording))
    of_filters = {name: value for name, value in set.items() if not fmus[PLAYBACK].has_parameter(name)}

    with TemporaryDirectory(dir=temporary()) as place:
        with filling_temporary():
            system = of_recording(
                recording, start, Path(place), task=task, settings=set, fmus=fmus, step=step
            )

        def page() -> bytes:
            run = replay_recording(recording, start, filter=task, set=of_filters, fmus=fmus)
            with filling_temporary():
                return report.report_replay(run, Path(place) / "report").read_bytes()

        _write(system, folder, dict(set), page, key)
    return system


def _write(
    system: System,
    folder: Path,
    settings: Mapping[str, object],
    page: Callable[[], bytes],
    sign: Sign | None,
) -> None:
    """The folder of a system; `page` makes its report. What is left of an earlier export there is removed."""
    results = reference.simulate(system)
    about: dict[str, str | bytes] = {
        "provenance.json": evidence.provenance(system, settings),
        "sbom.cdx.json": evidence.bill_of_materials(system),
    }
    before = checksums.unchanged(folder)
    with filled(folder) as draft:
        written = _Folder(draft)
        for form in FORMS:
            _write_form(system, results, form, about, written, sign)
        for name, content in {
            "OspSystemStructure.xml": documents.osp(system),
            "README.md": documents.readme(system, results, signed=sign is not None),
            "report.html": page(),
            **about,
        }.items():
            written.add(name, content)
        for name, content in checksums.with_list(written.files, sign=sign).items():
            if name not in written.files:
                written.add(name, content)
    for name in before:
        if name not in written.files:
            _remove(folder, name)


def _remove(folder: Path, name: str) -> None:
    """Remove a file of a folder, and the folders in it that then hold nothing."""
    path = folder / name
    path.unlink()
    for above in path.relative_to(folder).parents[:-1]:
        if not any((folder / above).iterdir()):
            (folder / above).rmdir()


def _report(scenario: Scenario, fmus: Fmus) -> bytes:
    """Report of the run that the reference results are of."""
    runs = run_filters(scenario, fmus, {FILTER: scenario.filter}, Order.jacobi)
    with filling_temporary(), TemporaryDirectory(dir=temporary()) as folder:
        return report.report_run(recording.of_filter(runs, FILTER), Path(folder)).read_bytes()


class _Folder:
    """The folder of an export, with what was written there."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self.files: dict[str, bytes] = {}

    def add(self, name: str, content: str | bytes) -> bytes:
        """Write a file; its bytes."""
        written = as_bytes(content)
        path = self._path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(written)
        self.files[name] = written
        return written


def _write_form(
    system: System,
    results: Mapping[str, reference.Results],
    form: Form,
    about: Mapping[str, str | bytes],
    folder: _Folder,
    sign: Sign | None,
) -> None:
    """The FMUs of one version of FMI, what goes with each of them, and their system."""
    parts: dict[str, str | bytes] = {"SystemStructure.ssd": documents.system_structure(system, form)}
    for component in system.components:
        files = _component_files(system, component, results[component.name], form)
        for name, content in files.items():
            folder.add(form.place(name), content)
        fmu = f"{component.fmu.name}.fmu"
        members = _fmu_members(system, component, form, files, about)
        members = checksums.with_list(members, evidence.FOLDER, sign)
        parts[f"resources/{fmu}"] = folder.add(f"{form.name}/{fmu}", archive_bytes(members))
        # libcosim aborts at an enumeration in an SSP; the FMUs begin with the right ones
        bound = documents.parameters(system, component, form, enumerations=form is not FMI2)
        parts[f"resources/{component.name}.ssv"] = bound
    folder.add(f"{system.name}{form.suffix}.ssp", archive_bytes(parts))


def _fmu_members(
    system: System,
    component: Component,
    form: Form,
    files: Mapping[str, str | bytes],
    about: Mapping[str, str | bytes],
) -> dict[str, bytes]:
    """An FMU with its start values, its reference experiment and the evidence but for its list."""
    built = read_archive(form.archive(component.fmu))
    experiment = {
        documents.experiment_file(system, name): content
        for name, content in files.items()
        if not name.endswith(".opt") and not name.startswith(f"{SKELETONS}/")
    }
    experiment["experiments.xml"] = documents.experiments(system, component)
    experiment["fmi-ls-manifest.xml"] = documents.manifest(system, list(experiment))
    added = {
        **start_values.members(system, component, built),
        **{f"{replay.FOLDER}/{name}": content for name, content in experiment.items()},
        **{f"{evidence.FOLDER}/{name}": content for name, content in about.items()},
    }
    return {**built, **{name: as_bytes(content) for name, content in added.items()}}


def _component_files(
    system: System, component: Component, results: reference.Results, form: Form
) -> dict[str, str | bytes]:
    """Parameters and reference results of a component, which lie beside the FMUs and in each."""
    name = component.fmu.name
    files: dict[str, str | bytes] = {
        f"parameters/{component.name}.ssv": documents.parameters(system, component, form),
        f"reference/{name}_ref.csv": reference.csv(
            results.outputs, form.entries(component, component.outputs), words=form.arrays
        ),
        f"reference/{name}_ref.opt": documents.options(system),
    }
    if component.inputs:
        inputs = form.entries(component, component.inputs)
        files[f"reference/{name}_in.csv"] = reference.csv(results.inputs, inputs, words=form.arrays)
        first = {column: values[:2] for column, values in results.inputs.items()}
        files[f"{SKELETONS}/{name}_in.csv"] = reference.csv(first, inputs, words=form.arrays)
    if form is FMI2:  # of the instance that ran
        files[f"reference/{name}_end.state"] = results.state
    return files

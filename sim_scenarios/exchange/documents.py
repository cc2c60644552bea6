"""The texts that describe a system: SSP, Open Simulation Platform, FMI-LS-REF, cross-check, README."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping, Sequence
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path, PurePosixPath

import jinja2

from sim_scenarios.exchange.forms import FMI2, Entry, Form
from sim_scenarios.exchange.reference import OUTPUT_INTERVAL, Results
from sim_scenarios.exchange.start_values import xml_text
from sim_scenarios.exchange.system import Component, System

TEMPLATES = Path(__file__).parents[1] / "templates" / "exchange"
FINAL = ("nav.time", "nav.heading", "heading_sigma", "nav.roll", "nav.pitch", "nav.latitude", "nav.longitude")
"""Outputs of the filter whose last values a partner sees at a glance."""


def system_structure(system: System, form: Form) -> str:
    """SystemStructure.ssd."""
    return _render("SystemStructure.ssd.xml", system=system, form=form)


def parameters(system: System, component: Component, form: Form, *, enumerations: bool = True) -> str:
    """Parameter set (SSV) of a component; those of a system have one name, by which Ecos chooses them."""
    kept = [e for e in form.entries(component, component.values) if enumerations or e.kind != "Enumeration"]
    return _render("parameters.ssv.xml", system=system, component=component, form=form, entries=kept)


def osp(system: System) -> str:
    """OspSystemStructure.xml."""
    return _render("OspSystemStructure.xml", system=system, form=FMI2)


def manifest(system: System, files: Sequence[str]) -> str:
    """Manifest of FMI-LS-REF, for the files of one experiment."""
    return _render("fmi-ls-manifest.xml", system=system, files=files)


def experiments(system: System, component: Component) -> str:
    """Experiments of FMI-LS-REF: one, the scenario."""
    return _render("experiments.xml", system=system, component=component)


def experiment_file(system: System, name: str) -> str:
    """What a file of parameters or results is called in the FMU."""
    return f"{system.name}{'.ssv' if name.endswith('.ssv') else name[name.rindex('_') :]}"


def options(system: System) -> str:
    """Options of the FMI cross-check."""
    return (
        f"StartTime,0.0\nStopTime,{system.checked}\nStepSize,{system.step}\nRelTol,0.0\nAbsTol,0.0\n"
        f"SolverName,FixedStep\nOutputIntervalLength,{OUTPUT_INTERVAL}\n"
    )


def readme(system: System, results: Mapping[str, Results], *, signed: bool) -> str:
    """README for the partner, with the last row of the results, and of a recording where it begins."""
    estimates = results[system.filter.name].outputs
    final = {name: float(estimates[name][-1]) for name in FINAL}
    told = results[system.plant.name].outputs
    begin = float(told["recording.time"][0]) if system.recorded else None
    platforms = sorted(set.intersection(*(_platforms(component) for component in system.components)))
    return _render("README.md", system=system, begin=begin, final=final, platforms=platforms, signed=signed)


def _platforms(component: Component) -> set[str]:
    """Folders of the binaries of an FMU."""
    with zipfile.ZipFile(component.fmu.path) as content:
        return {PurePosixPath(name).parts[1] for name in content.namelist() if name.startswith("binaries/")}


def _stated(component: Component, entry: Entry) -> str:
    """Value of a parameter as SSP has it: numbers, or the name of an item."""
    if entry.kind == "Enumeration":
        (variable,) = entry.elements
        return variable.display(component.value(variable.name))
    values = {element.name: component.value(element.name) for element in entry.elements}
    return entry.text(xml_text, values)


@cache
def _environment() -> jinja2.Environment:
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(TEMPLATES),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=jinja2.select_autoescape(["xml"]),
    )
    environment.globals |= {"stated": _stated}
    return environment


def _render(template: str, **context: object) -> str:
    try:
        product = f"TrueNorth {version('truenorth')}"
    except PackageNotFoundError:
        product = "TrueNorth"
    return _environment().get_template(template).render(tool=product, **context)

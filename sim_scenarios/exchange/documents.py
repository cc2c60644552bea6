"""The texts that describe a system: SSP 1.0, Open Simulation Platform, FMI-LS-REF, cross-check, README."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path, PurePosixPath

import jinja2

from sim_scenarios.exchange.reference import OUTPUT_INTERVAL, Results
from sim_scenarios.exchange.system import Component, System
from sim_scenarios.fmus import Number, Variable

TEMPLATES = Path(__file__).parents[1] / "templates" / "exchange"
FINAL = ("nav.time", "nav.heading", "heading_sigma", "nav.roll", "nav.pitch", "nav.latitude", "nav.longitude")
"""Outputs of the filter whose last values a partner sees at a glance."""
TYPES = {"Enumeration": "Integer"}
"""How enumerations are set: libcosim and FMPy take their numbers, not their names, in parameter sets."""


def system_structure(system: System) -> str:
    """SystemStructure.ssd."""
    return _render("SystemStructure.ssd.xml", system=system)


def parameters(system: System, component: Component) -> str:
    """Parameter set (SSV) of a component; those of a system have one name, by which Ecos chooses them."""
    return _render("parameters.ssv.xml", system=system, component=component)


def osp(system: System) -> str:
    """OspSystemStructure.xml."""
    return _render("OspSystemStructure.xml", system=system)


def manifest() -> str:
    """Manifest of FMI-LS-REF."""
    return _render("fmi-ls-manifest.xml")


def experiments(system: System, component: Component) -> str:
    """Experiments of FMI-LS-REF: one, the scenario."""
    return _render("experiments.xml", system=system, component=component)


def options(system: System) -> str:
    """Options of the FMI cross-check."""
    return (
        f"StartTime,0.0\nStopTime,{system.stop}\nStepSize,{system.step}\nRelTol,0.0\nAbsTol,0.0\n"
        f"SolverName,FixedStep\nOutputIntervalLength,{OUTPUT_INTERVAL}\n"
    )


def readme(system: System, results: Mapping[str, Results]) -> str:
    """README for the partner, with the last row of the results."""
    estimates = results[system.filter.name].outputs
    final = {name: float(estimates[name][-1]) for name in FINAL}
    platforms = sorted(set.intersection(*(_platforms(component) for component in system.components)))
    return _render("README.md", system=system, final=final, platforms=platforms)


def _platforms(component: Component) -> set[str]:
    """Folders of the binaries of an FMU."""
    with zipfile.ZipFile(component.fmu.path) as content:
        return {PurePosixPath(name).parts[1] for name in content.namelist() if name.startswith("binaries/")}


def _type(variable: Variable) -> str:
    return TYPES.get(variable.kind, variable.kind)


def _value(variable: Variable, value: Number) -> str:
    """Value as XML has it."""
    if variable.kind == "Boolean":
        return "true" if value else "false"
    return repr(float(value)) if variable.kind == "Real" else str(int(value))


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
    environment.filters |= {"type": _type}
    environment.globals |= {"value": _value}
    return environment


def _render(template: str, **context: object) -> str:
    try:
        product = f"TrueNorth {version('truenorth')}"
    except PackageNotFoundError:
        product = "TrueNorth"
    return _environment().get_template(template).render(tool=product, **context)

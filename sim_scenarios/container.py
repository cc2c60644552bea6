"""Plant and filters as one container FMU, which steps them all by itself: the same results, sooner.

The co-simulation master (`cosimulation`) calls every FMU and carries every signal 100 times a second, in
Python. Inside an FMU Container (fmu-manipulation-toolbox) compiled code does so, in the same order: the plant
steps, its outputs are passed on, the filters step (Gauss-Seidel). Python is called at the recorded instants
alone. The results are those of the master to the last bit.

What a container cannot show is a fix that another fix follows before the next recorded instant; `obstacle`
says so, and the master does such a scenario.
"""

from __future__ import annotations

import logging
import platform
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final
from zipfile import ZIP_STORED, ZipFile

import numpy as np
from fmu_manipulation_toolbox.container import FMUContainer, FMUContainerError
from numpy.typing import NDArray

from sim_scenarios.archives import write_archive
from sim_scenarios.cosimulation import FIX_SIGNALS, Recorded, Table, connected
from sim_scenarios.errors import SimulationError
from sim_scenarios.fmus import Fmu, Number
from sim_scenarios.folders import filling_temporary, temporary
from sim_scenarios.instance import Instance, Port

SOURCE: Final = "plant."
PLATFORMS: Final = {("Linux", "x86_64"), ("Windows", "AMD64")}
"""Those for which fmu-manipulation-toolbox has the compiled code of a container."""
_NEEDED: Final = ("modelDescription.xml", "binaries/", "resources/")


def obstacle(recording_period: float, fix_rate: float) -> str | None:
    """Why a container cannot do a scenario; None if it can."""
    if (platform.system(), platform.machine()) not in PLATFORMS:
        return f"there is no container for {platform.system()} on {platform.machine()}"
    if fix_rate * recording_period > 1 + 1e-9:
        return f"{fix_rate:g} fixes a second are more than one for each recorded instant"
    return None


class Container:
    """A container FMU of one plant and a number of filters, unpacked for as long as this object lives.

    Parameters
    ----------
    plant : Fmu
    filters : sequence of Fmu
        That of each filter; they see the same signals.
    step : float
        Communication step inside the container [s].
    outputs, fix_outputs : sequence of list of str
        Scalar outputs of each filter that are recorded periodically and at fixes.

    Raises
    ------
    SimulationError
        An FMU cannot be embedded.
    """

    def __init__(
        self,
        plant: Fmu,
        filters: Sequence[Fmu],
        step: float,
        outputs: Sequence[list[str]],
        fix_outputs: Sequence[list[str]],
    ) -> None:
        self._sinks = [f"filter{i}." for i in range(len(filters))]
        self._truth = [name for name in plant.outputs() if name.startswith("truth.")]
        self._outputs, self._fix_outputs = (
            [sink + name for sink, names in zip(self._sinks, each, strict=True) for name in names]
            for each in (outputs, fix_outputs)
        )
        try:
            with filling_temporary():
                self._folder = TemporaryDirectory(prefix="container-", dir=temporary())
                path = self._built(plant, filters, step)
            self._fmu = Fmu(path)
        except FMUContainerError as error:  # of a filter that is not ours
            raise SimulationError(f"the filters do not go into a container: {error}") from error

    def record(
        self,
        plant: Mapping[str, Number],
        filters: Sequence[Mapping[str, Number]],
        times: NDArray[np.float64],
    ) -> Recorded:
        """Run from 0 to the end, recording periodically and at fixes.

        Parameters
        ----------
        plant : mapping of str to number
            Parameters of the plant.
        filters : sequence of mapping of str to number
            Parameters of each filter, what it starts from included.
        times : ndarray, shape (n,)
            Instants that are recorded, from the start to the end of the run [s].

        Returns
        -------
        Recorded
            As `cosimulation.simulate` gives it.
        """
        values = dict(_prefixed(SOURCE, plant))
        for sink, given in zip(self._sinks, filters, strict=True):
            values |= _prefixed(sink, given)
        with closing(Instance(self._fmu, "container", values)) as instance:
            instance.begin_initialisation(0.0, float(times[-1]))
            instance.finish_initialisation()
            return self._recorded(instance, times)

    def _recorded(self, instance: Instance, times: NDArray[np.float64]) -> Recorded:
        outputs = [SOURCE + name for name in self._truth]
        outputs += self._outputs
        rows, fixes = (Table(Port(instance, names), len(times)) for names in (outputs, self._fix_outputs))
        signal = Port(instance, [SOURCE + name for name in FIX_SIGNALS])
        count, fix_time = signal.signals.buffers["Integer"], signal.signals.buffers["Real"]
        signal.read()
        rows.append()
        fixes_at: list[float] = []
        for time, end in pairwise(times.tolist()):
            before = int(count[0])
            instance.step(time, end - time)
            rows.append()
            signal.read()
            if count[0] != before:
                if count[0] != before + 1:
                    raise SimulationError(f"several fixes came between {time:g} s and {end:g} s")
                fixes_at.append(float(fix_time[0]))
                fixes.append()
        return Recorded(
            times,
            np.array(fixes_at),
            rows.columns(SOURCE),
            [rows.columns(sink) for sink in self._sinks],
            [fixes.columns(sink) for sink in self._sinks],
        )

    def _built(self, plant: Fmu, filters: Sequence[Fmu], step: float) -> Path:
        """Path of the container, with all parameters, what is recorded, and nothing else to be seen."""
        logging.getLogger("fmu_manipulation_toolbox").setLevel(logging.ERROR)
        folder = Path(self._folder.name)
        files = {fmu: f"{number}.fmu" for number, fmu in enumerate(dict.fromkeys((plant, *filters)))}
        for fmu, copy in files.items():
            _copy_what_runs(fmu.path, folder / copy)
        source = files[plant]
        container = FMUContainer("container", folder, fmi_version=2)
        container.get_fmu(source)
        for name in _settable(plant):
            container.add_input(SOURCE + name, source, name)
        for name in (*self._truth, *FIX_SIGNALS):
            container.add_output(source, name, SOURCE + name)
        for sink, fmu in zip(self._sinks, filters, strict=True):
            embedded = f"{sink}fmu"
            container.get_fmu(files[fmu], embedded)
            for name in connected(plant.outputs(), fmu):
                container.add_link(source, name, embedded, name)
            for name in _settable(fmu):
                container.add_input(sink + name, embedded, name)
            for output in (*self._outputs, *self._fix_outputs):
                if output.startswith(sink):
                    container.add_output(embedded, output.removeprefix(sink), output)
        container.make_fmu("container.fmu", step_size=step, sequential=True)
        return folder / "container.fmu"


def _copy_what_runs(fmu: Path, copy: Path) -> None:
    """Copy an FMU without sources and documentation: hundreds of files, once for every filter."""
    with ZipFile(fmu) as whole:
        names = [member.filename for member in whole.infolist() if not member.is_dir()]
        needed = {name: whole.read(name) for name in names if name.startswith(_NEEDED)}
    write_archive(copy, needed, ZIP_STORED)


def _settable(fmu: Fmu) -> Iterator[str]:
    return (name for name, variable in fmu.variables.items() if variable.settable)


def _prefixed(prefix: str, values: Mapping[str, Number]) -> dict[str, Number]:
    return {prefix + name: value for name, value in values.items()}

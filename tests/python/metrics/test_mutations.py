"""Mistakes that one may make in `metrics`: the tests of the same topic find each of them.

Every mistake is made in a copy of the package, whose tests must then fail. It takes minutes: `-m slow`.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
# Of the folder that it runs in, and not of an installation that leads to the checkout.
RUN = """
import sys
sys.meta_path = [finder for finder in sys.meta_path if "ScikitBuild" not in type(finder).__name__]
import pytest
sys.exit(pytest.main(sys.argv[1:]))
"""
TOPICS = ("alignment", "certainty", "figures", "folds", "hand_over_verdict", "statistics")
MISTAKES = [
    # file, what stands there, the mistake, topic
    (
        "errors",
        'estimated minus true", "position_error", 2',
        'estimated minus true", "position_error", 1',
        "figures",
    ),
    (
        "errors",
        'the horizontal position", "position_error", slice(2)',
        'x", "position_error", slice(3)',
        "figures",
    ),
    ("errors", '"Misalignment about east", "attitude_error", 0', '"", "attitude_error", 1', "figures"),
    ("errors", "return wrap(values) if variable in ANGLES else values", "return values", "figures"),
    ("errors", "np.square(_wrapped(run, name))", "np.abs(_wrapped(run, name))", "figures"),
    ("errors", "first = runs[0]", "first = runs[-1]", "figures"),
    ("figures/shipped", "float(good and (handed is None", "float(good or (handed is None", "figures"),
    ("figures/shipped", "> 2 * _limit", "> 3 * _limit", "figures"),
    ("figures/shipped", "error.size(run), span)[-1]", "error.size(run), span)[0]", "figures"),
    ("figures/shipped", 'ERRORS["heading"].of(run)[-1]', 'ERRORS["heading"].of(run)[0]', "figures"),
    ("figures/shipped", "return np.inf if since is None", "return np.nan if since is None", "figures"),
    ("figures/definition", "float(over / under)", "float(under / over)", "figures"),
    ("figures/shipped", "good = fit and ", "good = ", "alignment"),
    (
        "figures/shipped",
        "good and abs(_heading_end(run, span)) <= _limit(run, counting)",
        "good",
        "alignment",
    ),
    ("figures/shipped", "recording.under_way(run))", "run)", "hand_over_verdict"),
    ("folds", "np.std(values, ddof=1)", "np.std(values, ddof=0)", "folds"),
    ("folds", "ddof=1) / runs", "ddof=0) / runs", "folds"),
    ("folds", "return r**2 / (2 * square)", "return r**2 / square", "folds"),
    ("folds", "_influence(a) - _influence(b)", "_influence(a)", "folds"),
    ("folds", "runs == 0 or np.isnan", "runs == 0 and np.isnan", "folds"),
    ("folds", "np.ceil(share", "np.floor(share", "folds"),
    ("folds", "np.where(np.isnan(values), np.inf, values)", "values", "folds"),
    ("verdict", "self.nis.consistent if tells", "self.nis.consistent if not tells", "alignment"),
    ("certainty", "WRONG: Final = 3.0", "WRONG: Final = 2.0", "certainty"),
    ("certainty", "longest_stretch(somewhere)", "int(somewhere.sum())", "certainty"),
    ("hand_over", "self.time <= self.due", "self.time >= self.due", "hand_over_verdict"),
    ("statistics", "broken[-1] + 1", "broken[-1]", "statistics"),
    ("statistics", "axis=-1) / error.shape[-1]", "axis=-1)", "statistics"),
    ("statistics", 'run["fix_used"].values & inside', "inside", "figures"),
]


@pytest.fixture(scope="module")
def copied(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a copy of the package, which passes its tests."""
    folder = tmp_path_factory.mktemp("copy")
    shutil.copytree(
        ROOT / "sim_scenarios", folder / "sim_scenarios", ignore=shutil.ignore_patterns("__pycache__")
    )
    assert passes(folder, TOPICS)
    return folder


def passes(folder: Path, topics: tuple[str, ...]) -> bool:
    """Whether the copy passes the tests of some topics."""
    tests = [str(Path(__file__).with_name(f"test_{topic}.py")) for topic in topics]
    options = ["-x", "-q", "-n", "0", "-p", "no:cacheprovider", "-c", str(ROOT / "pyproject.toml")]
    command = [sys.executable, "-B", "-c", RUN, *options, "--rootdir", str(ROOT), *tests]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode in (0, 1), done.stdout + done.stderr  # tests ran, and passed or failed
    return done.returncode == 0


@pytest.mark.slow
@pytest.mark.parametrize(("file", "right", "wrong", "topic"), MISTAKES)
def test_a_mistake_is_found_by_the_tests_of_its_topic(
    copied: Path, file: str, right: str, wrong: str, topic: str
) -> None:
    module = copied / "sim_scenarios" / "metrics" / f"{file}.py"
    whole = module.read_text(encoding="utf-8")
    assert whole.count(right) == 1
    module.write_text(whole.replace(right, wrong), encoding="utf-8")
    try:
        assert not passes(copied, (topic,))
    finally:
        module.write_text(whole, encoding="utf-8")

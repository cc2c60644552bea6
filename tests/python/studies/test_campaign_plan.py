"""Campaign files: the cases they make, and what they refuse."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from sim_scenarios.errors import InputError
from sim_scenarios.fmus import ALIGNMENT_FILTER, NAVIGATION_FILTER, Fmus
from sim_scenarios.studies.cases import cases, fingerprint
from sim_scenarios.studies.plan import Plan, load_plan


def test_every_combination_of_the_grid_is_a_case(fmus: Fmus, plan_file: Path) -> None:
    made = cases(load_plan(plan_file, grid={"corrector": ["standard"]}), fmus)
    assert [case.label for case in made] == [
        f"{scenario} gnss.rate={rate} corrector=standard"
        for scenario in ("zigzag", "overconfident_prior")
        for rate in (1.0, 2.0)
    ]
    assert [case.scenario.plant["gnss.rate"] for case in made] == [1.0, 2.0] * 2
    assert all(case.scenario.duration == 40.0 for case in made)


def test_filters_are_those_that_a_scenario_compares(fmus: Fmus, plan_file: Path) -> None:
    made = cases(load_plan(plan_file), fmus)
    assert [list(case.filters()) for case in made] == [["EKF", "UKF"]] * 2 + [["UKF"]] * 2


def test_filters_of_its_own(fmus: Fmus, tmp_path: Path) -> None:
    path = tmp_path / "own.toml"
    filters = '[filters."a"]\npredictor = "linearised"\n"gate.threshold" = 9.0\n[filters."b"]\n'
    path.write_text(
        f'scenarios = ["zigzag"]\n[set]\n"gate.patience" = 20\n{filters}',
        encoding="utf-8",
    )
    (case,) = cases(load_plan(path), fmus)
    assert list(case.filters()) == ["a", "b"]
    predictor = fmus.filter.variables["predictor"].items
    assert case.filters()["a"]["predictor"] == predictor["linearised"]
    assert case.filters()["b"]["predictor"] == predictor["unscented"]  # of the scenario
    assert {values["gate.patience"] for values in case.filters().values()} == {20}
    path.write_text(
        f'scenarios = ["zigzag"]\n[set]\n"gate.threshold" = 20.0\n{filters}',
        encoding="utf-8",
    )
    with pytest.raises(InputError, match=r"gate\.threshold: a is what it is by its own gate\.threshold = 9"):
        cases(load_plan(path), fmus)


def test_a_scenario_alone_is_a_campaign(fmus: Fmus) -> None:
    plan = load_plan("swaying_ship", runs=3, seed=8, set={"gnss.rate": 5.0})
    (case,) = cases(plan, fmus)
    assert (plan.name, plan.runs, plan.seed, case.label) == ("swaying_ship", 3, 8, "swaying_ship")
    assert "EKF" in case.filters()
    assert case.with_seed(9).plant["seed"] == 9


def test_scenario_files_stand_relative_to_the_campaign(fmus: Fmus, tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text('extends = "waves"\ndescription = "mine"\n', encoding="utf-8")
    path = tmp_path / "c.toml"
    path.write_text('scenarios = ["mine.toml"]\n', encoding="utf-8")
    assert [case.label for case in cases(load_plan(path), fmus)] == ["mine"]


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ('scenarios = ["swaying_shp"]', "did you mean 'swaying_ship'"),
        ('scenarios = ["waves"]\nrun = 3', "did you mean 'runs'"),
        ("scenarios = []", "scenarios"),
        ('scenarios = ["waves"]\nruns = 0', "greater than or equal to 1"),
        ('scenarios = ["waves"]\nseed = 2147483647\nruns = 2', "must not exceed 2147483647"),
        ('scenarios = ["waves", "waves"]', "waves is named more than once"),
        ('scenarios = ["waves"]\nfilters = ["UFK"]', "did you mean 'UKF'"),
        ('scenarios = ["waves"]\nreference = "UFK"', "did you mean 'UKF'"),
        ('scenarios = ["waves"]\nperiod = 0.25', "period = 0.25 s: must be a whole multiple"),
        ('scenarios = ["waves"]\n[grid]\n"gnss.rat" = [1.0]', "did you mean 'gnss.rate'"),
        ('scenarios = ["waves"]\n[grid]\n"gnss.rate" = []', "grid"),
        ("scenarios = [", "not valid TOML"),
        ('scenarios = ["waves"]\n[draw]\n"gnss.rate" = { uniform = [1.0] }', "draw.gnss.rate"),
        ('scenarios = ["waves"]\n[draw]\n"gnss.rate" = {}', "must be one of uniform, log_uniform, choice"),
        (
            'scenarios = ["waves"]\n[set]\n"gnss.rate" = 2.0\n[draw]\n"gnss.rate" = { choice = [1.0] }',
            "gnss.rate is set and drawn",
        ),
        (
            'scenarios = ["waves"]\n[filters.a]\nscenarios = ["wave"]',
            "filters.a: the campaign has no scenario wave; did you mean 'waves'?",
        ),
        ('scenarios = ["waves"]\n[cases.a]\nsets = {}', "cases.a.sets: there is no such entry"),
        ('scenarios = ["waves"]\n[cases.a]\nset = { gnss.rat = 1.0 }', "did you mean 'gnss.rate'"),
        ('scenarios = ["waves"]\n[draw]\n"gnss.rat" = { choice = [1.0] }', "did you mean 'gnss.rate'"),
    ],
)
def test_what_is_refused(fmus: Fmus, tmp_path: Path, content: str, words: str) -> None:
    path = tmp_path / "bad.toml"
    path.write_text(content, encoding="utf-8")
    with pytest.raises(InputError) as refusal:
        cases(load_plan(path), fmus)
    assert words in str(refusal.value)
    assert str(refusal.value).startswith(f"{path}: ")


@pytest.mark.parametrize(
    ("content", "given", "is_of_the_file"),
    [
        ("set = { evror_model = 'large_azimuth' }", {"set": {"duration": 900.0}}, True),
        ("set = { evror_model = 'large_azimuth' }", {"grid": {"gnss.rate": [1.0]}, "runs": 2}, True),
        ("set = { evror_model = 'large_azimuth' }", {"set": {"evror_model": "invariant"}}, True),
        ("", {"set": {"evror_model": "invariant"}}, False),
        ("", {"grid": {"evror_model": ["invariant"]}}, False),
        ("", {"filters": ("UFK",)}, False),
        ("cases.a.set = { evror_model = 1 }\ncases.b.set = { gnss.rat = 1 }", {"cases": ("b",)}, True),
    ],
)
def test_a_refusal_names_the_file_that_is_to_blame(
    fmus: Fmus, tmp_path: Path, content: str, given: dict[str, Any], is_of_the_file: bool
) -> None:
    path = tmp_path / "plan.toml"
    path.write_text(f'scenarios = ["waves"]\n{content}', encoding="utf-8")
    with pytest.raises(InputError) as refusal:
        cases(load_plan(path, **given), fmus)
    assert str(refusal.value).startswith(f"{path}: ") == is_of_the_file


NAMED = """
scenarios = ["waves", "zigzag"]
[set]
duration = 40.0
"evaluation.start" = 20.0
[draw]
"fault.imu.begin" = { uniform = [20.0, 30.0] }
[cases."IMU silence"]
set = { "fault.imu.kind" = "silence", "fault.imu.duration" = 3.0 }
[cases."IMU spike"]
set = { "fault.imu.kind" = "spike", "fault.imu.begin" = 25.0, duration = 50.0 }
draw = { "fault.imu.size" = { log_uniform = [0.01, 1.0] } }
[cases.clean]
[filters.both]
[filters."one of them"]
scenarios = ["zigzag"]
predictor = "linearised"
"""


@pytest.fixture
def named(tmp_path: Path) -> Path:
    path = tmp_path / "named.toml"
    path.write_text(NAMED, encoding="utf-8")
    return path


def test_each_scenario_has_each_named_case(fmus: Fmus, named: Path) -> None:
    made = {case.label: case for case in cases(load_plan(named, cases=("IMU silence", "IMU spike")), fmus)}
    labels = [f"{name} {case}" for name in ("waves", "zigzag") for case in ("IMU silence", "IMU spike")]
    assert list(made) == ["waves unfaulted", "zigzag unfaulted", *labels]
    spike = made["waves IMU spike"]
    assert [one.name for one in spike.draws] == ["fault.imu.size"]  # its begin is set in its own table
    assert spike.scenario.plant["fault.imu.begin"] == 25
    assert [one.name for one in made["waves IMU silence"].draws] == ["fault.imu.begin"]


def test_a_fault_is_held_against_the_longest_case_without(fmus: Fmus, named: Path) -> None:
    made = {case.label: case for case in cases(load_plan(named), fmus)}
    against = {label: case.unfaulted for label, case in made.items()}
    assert against["waves IMU silence"] == against["waves IMU spike"] == "waves unfaulted"
    assert against["waves clean"] is against["waves unfaulted"] is None
    clean = made["waves unfaulted"]
    assert clean.scenario.duration == 50  # that of the spike; "clean" is shorter
    assert not any(name.startswith("fault.") for name in (*clean.scenario.plant, *clean.settings))
    assert clean.draws == ()
    same = cases(load_plan(named, set={"duration": 50.0}), fmus)
    assert {case.unfaulted for case in same if case.scenario.name == "waves"} == {None, "waves clean"}


def test_filters_are_run_in_their_scenarios_alone(fmus: Fmus, named: Path) -> None:
    made = {case.label: case for case in cases(load_plan(named), fmus)}
    assert list(made["waves clean"].filters()) == ["both"]
    assert list(made["zigzag clean"].filters()) == ["both", "one of them"]
    (case,) = cases(load_plan(named, filters=("one of them",), cases=("clean",)), fmus)
    assert (case.label, list(case.filters())) == ("zigzag clean", ["one of them"])


def test_the_command_line_wins_over_cases_and_draws(fmus: Fmus, named: Path) -> None:
    plan = load_plan(named, set={"fault.imu.begin": 21.0, "fault.imu.size": 0.5}, cases=("IMU spike",))
    spike = cases(plan, fmus)[-1]
    assert spike.draws == ()
    assert spike.scenario.plant["fault.imu.begin"] == 21
    assert spike.scenario.plant["fault.imu.size"] == 0.5


@pytest.mark.parametrize("name", ["faults", "soak"])
def test_shipped_campaigns_are_in_order(fmus: Fmus, name: str) -> None:
    """Every model and corrector of both filters, and every kind of fault, has a place."""
    made = cases(load_plan(name), fmus)
    for filter_fmu in (ALIGNMENT_FILTER, NAVIGATION_FILTER):
        parameters = [
            values
            for case in made
            if case.scenario.filter_fmu == filter_fmu
            for values in case.filters().values()
        ]
        for axis in ("error_model", "corrector"):
            start = fmus[filter_fmu].start(axis)
            used = {values.get(axis, start) for values in parameters}
            assert used == set(fmus[filter_fmu].variables[axis].items.values())
    if name == "faults":
        for sensor in ("imu", "gnss"):
            name = f"fault.{sensor}.kind"
            kinds = {case.scenario.plant.get(name, fmus.plant.start(name)) for case in made}
            assert kinds == set(fmus.plant.variables[name].items.values())


def test_grades_are_told_truthfully(fmus: Fmus) -> None:
    """Plant, filters and bound have the same sensors."""
    made = cases(load_plan("grades"), fmus)
    for case in made:
        plant, bound = case.scenario.plant, case.scenario.bound
        for values in case.filters().values():
            for sensor, walk in (("gyro", "angle"), ("accelerometer", "velocity")):
                sigma = plant[f"imu.{sensor}.bias_sigma"]
                assert values[f"prior.{sensor}_bias_sigma"] == sigma == getattr(bound, f"{sensor}_bias_sigma")
                assert values[f"process.{walk}_random_walk"] == plant[f"imu.{sensor}.white_noise"]
    sigmas = {case.scenario.plant["imu.accelerometer.bias_sigma"] for case in made}
    assert max(sigmas) == pytest.approx(0.020 * 9.80665)


def test_a_fingerprint_tells_campaigns_apart(fmus: Fmus, plan_file: Path) -> None:
    def of(**given: object) -> str:
        plan = load_plan(plan_file, **given)
        return fingerprint(plan, cases(plan, fmus), {"TruthPlant": "1"})

    assert of() == of() == of(reference="EKF", description="other words")
    assert len({of(), of(runs=6), of(seed=4), of(set={"duration": 41.0}), of(filters=("UKF",))}) == 5


@pytest.mark.parametrize(("runs", "batch"), [(1, 1), (10, 1), (100, 2), (1000, 16), (100_000, 16)])
def test_batches_are_few_and_even(runs: int, batch: int) -> None:
    assert Plan(name="any", scenarios=("waves",), runs=runs).batch == batch


@pytest.mark.parametrize(
    ("table", "changed", "harmless"),
    [
        ("set", 'corrector = "igg"', '"gate.enabled" = true'),
        ("grid", 'corrector = ["igg"]', '"gate.enabled" = [true, false]'),
        ("draw", 'corrector = { choice = ["igg"] }', '"gate.enabled" = { choice = [true, false] }'),
    ],
)
def test_a_campaign_makes_no_filter_another_than_its_label_says(
    tmp_path: Path, fmus: Fmus, table: str, changed: str, harmless: str
) -> None:
    plan = tmp_path / "plan.toml"
    plan.write_text(f'scenarios = ["waves"]\nfilters = ["EKF"]\n[{table}]\n{changed}\n')
    with pytest.raises(InputError, match=r"corrector.* EKF"):
        cases(load_plan(plan), fmus)
    plan.write_text(f'scenarios = ["waves"]\nfilters = ["EKF"]\n[{table}]\n{harmless}\n')
    assert cases(load_plan(plan), fmus)


def test_names_need_no_quotes(tmp_path: Path, fmus: Fmus) -> None:
    """As in a scenario file: a dotted key and a table within another say the same as a quoted name."""
    plan = tmp_path / "plan.toml"
    plain = """
        [set]
        gate.enabled = true
        [grid]
        gnss.rate = [1.0, 5.0]
        [draw]
        motion.speed = { uniform = [5.0, 6.0] }
        [draw.motion.course]
        choice = [0.0, 1.0]
        [cases.one]
        set = { gnss.velocity_sigma = 0.1 }
    """
    quoted = plain.replace("[draw.motion.course]", '[draw."motion.course"]')
    for name in ("gate.enabled", "gnss.rate", "motion.speed", "gnss.velocity_sigma"):
        quoted = quoted.replace(f"{name} =", f'"{name}" =')
    plans = []
    for content in (plain, quoted):
        plan.write_text(f'scenarios = ["waves"]\n{content}')
        plans.append(load_plan(plan))
    assert plans[0] == plans[1]
    assert set(plans[0].draw) == {"motion.speed", "motion.course"}
    assert len(cases(plans[0], fmus)) == 2


def test_regret_compares_every_corrector_on_one_model(fmus: Fmus) -> None:
    """Filters of a case differ in corrector and gate alone."""
    made = cases(load_plan("regret"), fmus)
    for case in made:
        items = fmus[case.scenario.filter_fmu].variables["corrector"].items
        assert {values["corrector"] for values in case.filters().values()} == set(items.values())
        others = [
            {name: value for name, value in values.items() if name not in ("corrector", "gate.enabled")}
            for values in case.filters().values()
        ]
        assert all(other == others[0] for other in others)

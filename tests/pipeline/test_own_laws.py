"""Laws of a user's own: Python objects, sent to workers by value, known to a store by a hash."""

import importlib
import pickle
import re
import sys
import textwrap
from dataclasses import replace

import nbclient
import nbformat
import numpy as np
import pytest

import pipeline
import tribo
from pipeline.store.create import writing
from pipeline.sweep.plan import points
from tests.helpers.points import run_point
from tests.helpers.processes import ROOT, python
from tests.helpers.scenes import SCENE, STEEL
from tests.pipeline.conftest import commit_all

PAGE = (ROOT / "workflows" / "OWN_LAWS.md").read_text(encoding="utf-8")
LAWS, *SCRIPT = re.findall(r"```python\n(.*?)```", PAGE, flags=re.DOTALL)
MORE = """

class Broken(Fading):
    def over(self, begin, end, pressure, velocity):
        return 1e-15


@dataclass(frozen=True, eq=False)
class Measured:
    distances: np.ndarray
    rates: np.ndarray
    pattern = "local"

    def over(self, begin, end, pressure, velocity):
        return tribo.Wear(np.interp(begin, self.distances, self.rates), self.pattern)


def _median(rises, share, quantiles):
    return np.apply_along_axis(lambda row: np.interp(0.5, quantiles, row), -1, rises)


median = tribo.Rule("rise_quantile", _median, "median of the contact", "its median above")
beyond = tribo.Rule("rise_quantile", lambda r, *_: 2 * r[..., -1], "twice", "twice above")
whole = tribo.Rule("rise_quantile", lambda r, *_: r, "all", "all above")
"""
RATES = (6e-15, 1e-15, 1.5)
POINT = {"sweep.loads": ["400 N"], "sweep.velocities": ["2 m/s"]}
PLACE = ["--load", "400 N", "--velocity", "2 m/s"]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "small.toml").write_text(SCENE.replace("increments = 10", "increments = 4"))
    (tmp_path / "laws.py").write_text(LAWS + MORE)
    return tmp_path


def imported(folder):
    """Import the module of laws from its file as it is now."""
    sys.modules.pop("laws", None)
    importlib.invalidate_caches()
    sys.path.insert(0, str(folder))
    try:
        return importlib.import_module("laws")
    finally:
        sys.path.remove(str(folder))


@pytest.fixture
def laws(folder):
    yield imported(folder)
    sys.modules.pop("laws", None)


def scene(laws, **overrides):
    return pipeline.load_scene("small.toml", overrides=overrides, laws=laws)


def resumed(laws, store="own.zarr", **overrides):
    """Lines of the error when a store is resumed with another law."""
    with pytest.raises(pipeline.StoreMismatchError) as caught:
        pipeline.run_sweep(scene(laws, **POINT, **overrides), store)
    return str(caught.value).splitlines()[1:]


def test_the_examples_of_the_page_run(folder, monkeypatch):
    first, *others = SCRIPT
    text = (first + textwrap.indent("".join(others), "    ")).replace("first_try", "small.toml")
    few = '    import pipeline\n    laws["criterion"] = hottest\n'
    monkeypatch.syspath_prepend(folder)
    exec(text + few, names := {"__name__": "__main__"})
    sys.modules.pop("laws")
    assert names["variations"].table["value"].nunique() == 4


def test_workers_have_a_law_whose_module_they_cannot_import(folder, laws):
    sweep, broken = (scene({"wear": law(*RATES)}, **POINT) for law in (laws.Fading, laws.Broken))
    (folder / "laws.py").unlink()
    pipeline.run_sweep(sweep, "own.zarr", workers=1)
    end = pipeline.end_of_point("own.zarr").sel(load=400, velocity=2)
    *_, state = tribo.simulate(sweep.scene, 400.0, 2.0)
    assert end["wear_volume"].item() == tribo.measures(sweep.scene, state)["wear_volume"]
    (failed,) = pipeline.run_sweep(broken, "no.zarr", workers=1).failed
    assert "InvariantError: wear law: its wear over" in str(failed)


def test_a_resume_with_another_law_is_refused_and_says_which(folder, laws):
    law = laws.Fading(*RATES)
    commit_all("own.zarr", scene({"wear": law}, **POINT))
    again = scene({"wear": laws.Fading(1.0, 1e-15, 1.5)}, **POINT, **{"wear.parameters": {
        "initial_rate": 6e-15, "distance": 1.5}})  # fmt: skip
    assert pipeline.run_sweep(again, "own.zarr").computed == 0
    (line,) = resumed({"wear": replace(law, distance=2.5)})
    assert line.endswith("wear.parameters.distance: 1.5 in the store, 2.5 in the scene")
    assert "wear.law: laws:Fading in the store, none in the scene" in resumed({})[0]
    assert "wear.law: laws:Fading in the store, laws:Broken" in resumed(
        {"wear": laws.Broken(*RATES)}
    )[0]  # fmt: skip
    with (folder / "laws.py").open("a") as file:
        file.write("# changed\n")
    assert pipeline.run_sweep(scene({"wear": law}, **POINT), "own.zarr").computed == 0
    (line,) = resumed({"wear": imported(folder).Fading(*RATES)})
    assert "wear.source_sha256: " in line


@pytest.mark.parametrize(
    ("name", "values"), [("Galling", (1.2e-15, 6e-15, 2e8)), ("Hastened", (1.2e-15, 1.0, 0.7))]
)
def test_a_law_by_pressure_or_velocity_shares_no_ramp_that_differs(laws, name, values):
    """A worker's points, of which half are of a resumed run, have the bits of points alone."""
    law = getattr(laws, name)(*values)
    loads = {"sweep.loads": ["400 N", "600 N"], "sweep.velocities": ["1 m/s", "2 m/s"]}
    sweep = scene({"wear": law}, **loads)
    half = points(sweep)[::2]
    with writing("own.zarr", sweep) as store:
        store.commit([run_point(sweep, point).record(with_fields=True) for point in half])
    assert pipeline.run_sweep(sweep, "own.zarr", workers=1).computed == 2
    end = pipeline.end_of_point("own.zarr")
    for point in points(sweep):
        *_, state = tribo.simulate(sweep.scene, point.load, point.velocity)
        volume = end["wear_volume"].sel(load=point.load, velocity=point.velocity).item()
        assert volume == tribo.measures(sweep.scene, state)["wear_volume"]


def test_answers_come_from_a_store_that_has_the_name_alone(folder, laws, irg):
    kinds = {
        "wear": laws.Fading(*RATES),
        "surface": laws.Dimples(2e-7, 1e-4),
        "pin": laws.Blunt(2e-3, 3.4e-3, scene({}).scene.pin.material, 1e-7),
    }
    sweep = scene(kinds)
    commit_all("own.zarr", sweep)
    sys.modules.pop("laws")
    (folder / "laws.py").unlink()
    stored = pipeline.results(pipeline.open_sweep("own.zarr")).sweep.scene
    names = [part.name for part in (stored.wear, stored.roughness, stored.pin)]
    assert names == ["laws:Fading", "laws:Dimples", "laws:Blunt"]
    end = pipeline.end_of_point("own.zarr").sel(load=400, velocity=2)
    *_, state = tribo.simulate(sweep.scene, 400.0, 2.0)
    assert end["wear_volume"].item() == tribo.measures(sweep.scene, state)["wear_volume"]
    assert "critical" in irg("boundary", "own.zarr")
    assert "severe wear is" in irg("margin", "own.zarr", *PLACE)
    with pytest.raises(tribo.InputError, match="laws:Fading is a Python object"):
        stored.wear.over(0.0, 1.0, 5e8, 1.0)
    with pytest.raises(tribo.InputError, match="laws:Blunt is a Python object"):
        stored.pin.profile(stored.grid)


def test_a_criterion_is_given_to_answers(laws):
    commit_all("small.zarr", scene({}))
    crossings = pipeline.boundary(pipeline.at("small.zarr", criterion=laws.median))
    half = pipeline.boundary(pipeline.at("small.zarr", share=0.5))
    np.testing.assert_allclose(crossings["critical_velocity"], half["critical_velocity"], rtol=1e-6)
    assert crossings.attrs["criterion"] == "laws:_median"
    warm = pipeline.at(pipeline.at("small.zarr", criterion=laws.median), friction=0.2)
    assert pipeline.boundary(warm).attrs["criterion"] == "laws:_median"
    with pytest.raises(tribo.InvariantError, match=r"laws:<lambda>: a rise lies beyond"):
        pipeline.boundary(pipeline.at("small.zarr", criterion=laws.beyond))
    with pytest.raises(tribo.InvariantError, match=r"laws:<lambda>: its rises have the shape"):
        pipeline.boundary(pipeline.at("small.zarr", criterion=laws.whole))
    with pytest.raises(tribo.InputError, match="allowed are share, highest, mean"):
        pipeline.at("small.zarr", criterion="laws:_median")


def test_a_store_judged_by_a_criterion_refuses_verdicts_by_its_name(folder, laws, irg):
    sweep = scene({"criterion": laws.median})
    assert pickle.loads(pickle.dumps(sweep.conditions.criterion.rule)) == laws.median
    commit_all("small.zarr", sweep)
    ds = pipeline.open_sweep("small.zarr")
    for judged in (sweep.conditions, pipeline.results(ds).sweep.conditions):
        copy = pickle.loads(pickle.dumps(judged))
        assert (copy, hash(copy)) == (judged, hash(judged))
        assert replace(judged, friction=0.2).criterion == judged.criterion
    for command in (["boundary"], ["margin", *PLACE], ["plot", "-o", "no.png"]):
        said = irg(command[0], "small.zarr", *command[1:], code=2)
        assert "judged by the criterion laws:_median, a Python object" in said
    assert not (folder / "no.png").exists()
    for kind in ("temperature", "ramp"):
        irg("plot", "small.zarr", "--kind", kind, "-o", f"{kind}.png")
    assert np.isfinite(pipeline.temperatures(ds)["max_temperature"].isel(step=-1)).all()
    assert "critical" in irg("boundary", "small.zarr", "--criterion", "mean")
    given = pipeline.boundary(pipeline.at(ds, criterion=laws.median))
    half = pipeline.boundary(pipeline.at(ds, share=0.5))
    np.testing.assert_allclose(given["critical_velocity"], half["critical_velocity"], rtol=1e-6)
    told = []
    pipeline.run_sweep(scene({}), "small.zarr", progress=told.append)
    assert any("temperature.criterion: laws:_median in the store" in str(one) for one in told)


MAIN = (
    LAWS
    + """

import sys
import pipeline

if __name__ == "__main__":
    steel = pipeline.load_scene("small.toml").scene.pin.material
    laws = {
        "wear": Fading(6e-15, 1e-15, 1.5),
        "surface": Dimples(2e-7, 1e-4),
        "pin": Blunt(2e-3, 3.4e-3, steel, flat=float(sys.argv[1])),
        "criterion": hottest,
    }
    over = {"wear.parameters.distance": [0.5, 4.0]}
    few = {"sweep.loads": ["400 N"], "sweep.velocities": ["2 m/s"], "sweep.over": over}
    sweep = pipeline.load_scene("small.toml", laws=laws, overrides=few)
    try:
        outcome = pipeline.run_sweep(sweep, "own.zarr", workers=1)
    except pipeline.StoreMismatchError as error:
        sys.exit(str(error))
    assert not outcome.failed, outcome.failed
    ds = pipeline.open_sweep("own.zarr")
    for case in sweep.cases:
        end = pipeline.end_of_point(pipeline.at(ds, **dict(zip(over, dict(case.name).values()))))
        *_, state = tribo.simulate(case.scene, 400.0, 2.0)
        assert end["wear_volume"].item() == tribo.measures(case.scene, state)["wear_volume"]
        assert case.scene.wear == Fading(6e-15, 1e-15, case.scene.wear.distance)
    print("computed", outcome.computed, "of", outcome.done)
"""
)


def test_laws_of_a_script_of_all_kinds_run_on_workers_and_are_known_again(folder):
    """A script's classes are `__main__`'s; two laws of one class differ in a field of a sweep."""

    def script(flat="1e-7"):
        return python("script.py", flat, cwd=folder)

    (folder / "script.py").write_text(MAIN)
    for computed in (2, 0):
        done = script()
        assert f"computed {computed} of 2" in done.stdout, done.stderr
    _, *lines = script("2e-7").stderr.splitlines()
    words = "pin.parameters.flat: 1e-07 in the store, 2e-07 in the scene"
    assert {line.partition(": ")[2] for line in lines} == {words}
    (folder / "script.py").write_text(MAIN + "# changed\n")
    _, *lines = script().stderr.splitlines()
    paths = {line.split(": ")[1] for line in lines}
    assert paths == {f"{of}.source_sha256" for of in ("wear", "pin", "disk.surface")}


CELL = """
from dataclasses import dataclass
import pipeline, tribo

@dataclass(frozen=True)
class Fading:
    distance: float
    pattern = "swept"

    def over(self, begin, end, pressure, velocity):
        return tribo.Wear(5e-15 / (1 + end / self.distance), self.pattern)
"""
RUN = '''
sweep = pipeline.load_scene("small.toml", laws={"wear": Fading(2.0)},
                            overrides={"sweep.loads": ["400 N"], "sweep.velocities": ["2 m/s"]})
outcome = pipeline.run_sweep(sweep, "own.zarr", workers=1)
print("computed", outcome.computed, "done", outcome.done)
'''  # fmt: skip


def test_a_law_of_a_notebook_runs_on_workers_and_is_known_again(folder):
    """A cell may run again, but a store refuses the law of a changed cell."""
    raising = f"try:\n{textwrap.indent(RUN, '    ')}\nexcept pipeline.StoreMismatchError as error:"
    cells = [CELL, RUN, CELL, RUN, CELL.replace("5e-15", "4e-15"), f"{raising}\n    print(error)"]
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(one) for one in cells])
    resources = {"metadata": {"path": str(folder)}}
    nbclient.NotebookClient(notebook, kernel_name="python3", resources=resources).execute()
    first, second, third = (str(cell.outputs) for cell in notebook.cells[1::2])
    assert "computed 1 done 1" in first
    assert "computed 0 done 1" in second
    assert "wear.source_sha256" in third


@pytest.mark.parametrize(
    ("kind", "law", "overrides", "said"),
    [
        ("pin", "Dimples(1, 2)", {}, "has no radius, length, material, words, profile"),
        ("wear", "fading", {"wear.parameters.distanc": 1.0}, "keyword argument 'distanc'"),
        ("wear", "fading", {"wear.parameters": 3}, "must be a mapping, not int"),
        ("pin", "Blunt(2e-3, 3e-3, STEEL, 0)", {"pin.radius": "1 mm"}, "pin.radius: laws.pin re"),
        ("surface", "Dimples(1, 2)", {"sweep.realizations": 3}, "made from a seed; give one"),
    ],
)  # fmt: skip
def test_each_mistake_is_named(laws, kind, law, overrides, said):
    names = vars(laws) | {"STEEL": STEEL, "fading": laws.Fading(*RATES)}
    with pytest.raises(pipeline.SceneFileError) as caught:
        scene({kind: eval(law, names)}, **overrides)
    assert said in str(caught.value)


def test_a_pin_and_a_surface_are_simulated_as_they_are(laws):
    plain = scene({})
    pin = laws.Blunt(2e-3, 3.4e-3, plain.scene.pin.material, 1e-7)
    blunt = scene({"pin": pin, "surface": laws.Dimples(2e-7, 1e-4)})
    assert blunt.scene.pin is pin
    assert blunt.scene.heights().max() == pytest.approx(2e-7)
    assert blunt.scene.separation(None).max() < plain.scene.separation(None).max()
    thick = scene({"pin": pin}, **{"pin.parameters.radius": 4e-3})
    assert thick.scene.pin == replace(pin, radius=4e-3)

"""Sweeps of the load–velocity plane: scene files, cluster, store, boundary and figures.

From a scene to its boundary, in a script under ``if __name__ == "__main__":``::

    import pipeline
    scene = pipeline.load_scene("first_try", overrides={"pin.radius": "2 mm"})
    pipeline.run_sweep(scene, "results/first_try.zarr")
    pipeline.boundary("results/first_try.zarr")["critical_velocity"]
    pipeline.margin("results/first_try.zarr", "400 N", "1.4 m/s", friction=0.12)["verdict"]
    pipeline.end_of_point("results/first_try.zarr")["contact_width"]

Arguments: a scene is a path, the name of a shipped scene, or what `load_scene` returned; a store is
a path, or what `open_sweep` returned; a quantity is a number in SI, or text with a unit such as
``"400 N"``. The end of each point is at step 0, which `end_of_point` takes.

The public names, in the order of the page ``API.md``, which says what each is for:

- scenes: `new_scene`, `load_scene`, `Sweep`
- simulation: `run_point`, `estimate`, `run_sweep`, `summary`, `verify_store`
- dataset: `open_sweep`, `end_of_point`
- answers: `boundary`, `margin`, `compare_tests`, `points`, `points_with_warnings`, `infer`,
  `temperatures`, `Conditions`
- accuracy: `trade`
- inputs: `sensitivity`
- figures and report: `plot`, `report`
- quantities: `to_si`
- errors: `SceneFileError`, `StoreError`, `StoreMismatchError`, `ExecutionError`

They are listed in ``__init__.pyi``. Each is loaded when it is first used, so that importing
the package costs next to nothing.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

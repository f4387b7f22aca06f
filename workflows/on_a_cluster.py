"""Compute the diagram in jobs of Slurm, as CLUSTER.md describes.

The same as ``irg run workflows/irg_transition.toml --cluster slurm --jobs 50 --walltime 2h``.
"""

import pipeline

if __name__ == "__main__":
    site = pipeline.Site(cores=4, memory="8 GB")  # and queue and account, where asked for
    outcome = pipeline.run_sweep(
        "workflows/irg_transition.toml",
        "results/irg_transition.zarr",
        cluster=pipeline.Batch("slurm", jobs=50, walltime="2 h", site=site),
        tell=print,
    )
    print(f"{outcome.done} of {outcome.total} points done")

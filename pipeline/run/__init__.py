"""Running a sweep on a Dask cluster; nothing else in the package knows Dask."""

"""The store of a sweep; nothing else in the package knows Zarr."""

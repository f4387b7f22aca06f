"""What writes our files makes stores as Zarr defines them, by the tests that it ships for that."""

import functools
from pathlib import Path

import boto3
import pytest
import s3fs
from pipeline.store.files import Files, RemoteFiles
from zarr.core.buffer import cpu
from zarr.storage import FsspecStore, LocalStore
from zarr.testing.store import StoreTests

from tests.pipeline.store.test_s3 import server

__all__ = ["server"]

BUCKET = "irg"


@functools.cache
def client():
    return boto3.client("s3")


class FilesOfZarr(LocalStore):
    """A store of Zarr that writes as ours do."""

    async def set(self, key, value):
        self._check_writable()
        (self.root / key).parent.mkdir(parents=True, exist_ok=True)
        Files(self.root).put_all([(key, value.to_bytes())])


class RemoteFilesOfZarr(FsspecStore):
    """The same in an object store."""

    async def set(self, key, value, byte_range=None):
        self._check_writable()
        await RemoteFiles(self.fs, self.path)._put(key, value.to_bytes())


class TestFiles(StoreTests[FilesOfZarr, cpu.Buffer]):
    store_cls = FilesOfZarr
    buffer_cls = cpu.Buffer

    @pytest.fixture
    def store_kwargs(self, tmp_path):
        return {"root": tmp_path}

    async def set(self, store, key, value):
        path = Path(store.root, key)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(value.to_bytes())

    async def get(self, store, key):
        return self.buffer_cls.from_bytes(Path(store.root, key).read_bytes())

    def test_store_repr(self, store):
        assert str(store.root.as_posix()) in repr(store)

    def test_store_supports_writes(self, store):
        assert store.supports_writes

    def test_store_supports_listing(self, store):
        assert store.supports_listing


@pytest.mark.slow
class TestRemoteFiles(StoreTests[RemoteFilesOfZarr, cpu.Buffer]):
    store_cls = RemoteFilesOfZarr
    buffer_cls = cpu.Buffer

    @pytest.fixture
    def store_kwargs(self, server, request):
        s3fs.S3FileSystem.clear_instance_cache()  # one for each test, since each has its own loop
        objects = s3fs.S3FileSystem(asynchronous=True)
        return {"fs": objects, "path": f"{BUCKET}/{abs(hash(request.node.name))}"}

    @pytest.fixture(autouse=True)
    async def _closed(self, store_kwargs):
        yield
        session = await store_kwargs["fs"].set_session()
        await session.close()

    async def set(self, store, key, value):
        _, prefix = store.path.split("/", 1)
        client().put_object(Bucket=BUCKET, Key=f"{prefix}/{key}", Body=value.to_bytes())

    async def get(self, store, key):
        _, prefix = store.path.split("/", 1)
        found = client().get_object(Bucket=BUCKET, Key=f"{prefix}/{key}")
        return self.buffer_cls.from_bytes(found["Body"].read())

    def test_store_repr(self, store):
        assert store.path in repr(store)

    def test_store_supports_writes(self, store):
        assert store.supports_writes

    def test_store_supports_listing(self, store):
        assert store.supports_listing

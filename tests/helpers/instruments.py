"""Writers of the files of instruments, after their public descriptions: heights (nx, ny) in m."""

import io
import struct
import zipfile

import numpy as np


def x3p(heights, pixel, dtype="D"):
    """Content of an ISO 25178-72 file: heights, as doubles or as whole nm, with a mask."""
    nx, ny = heights.shape
    step = {"D": 1.0, "L": 1e-9}[dtype]
    axes = "".join(
        f"<{axis}><AxisType>{'A' if axis == 'CZ' else 'I'}</AxisType>"
        f"<DataType>{'D' if axis != 'CZ' else dtype}</DataType>"
        f"<Increment>{size}</Increment><Offset>0</Offset></{axis}>"
        for axis, size in (("CX", pixel[0]), ("CY", pixel[1]), ("CZ", step))
    )
    links = (
        "<DataLink><PointDataLink>bindata/data.bin</PointDataLink>"
        "<ValidPointsLink>bindata/valid.bin</ValidPointsLink></DataLink>"
    )
    xml = (
        '<?xml version="1.0" encoding="UTF-8"?>'
        '<p:ISO5436_2 xmlns:p="http://www.opengps.eu/2008/ISO5436_2"><Record1>'
        "<Revision>ISO5436 - 2000</Revision><FeatureType>SUR</FeatureType>"
        f"<Axes>{axes}</Axes></Record1>"
        f"<Record3><MatrixDimension><SizeX>{nx}</SizeX><SizeY>{ny}</SizeY><SizeZ>1</SizeZ>"
        f"</MatrixDimension>{links}</Record3></p:ISO5436_2>"
    )
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        archive.writestr("main.xml", xml)
        values = np.where(np.isnan(heights), 0, heights).T / step
        values = values.astype("<f8") if dtype == "D" else np.round(values).astype("<i4")
        archive.writestr("bindata/data.bin", values.tobytes())
        valid = np.packbits(np.isfinite(heights.T).ravel(), bitorder="little")
        archive.writestr("bindata/valid.bin", valid.tobytes())
    return buffer.getvalue()


def gwy(channels, pixel):
    """Content of a Gwyddion file: channels of heights with their units, "" for none."""

    def component(name, kind, value):
        return name.encode() + b"\0" + kind.encode() + value

    def body(name, *parts):
        content = b"".join(parts)
        return name.encode() + b"\0" + struct.pack("<I", len(content)) + content

    def unit(text):
        return body("GwySIUnit", component("unitstr", "s", text.encode() + b"\0"))

    parts = []
    for number, (title, heights, of_heights) in enumerate(channels):
        nx, ny = heights.shape
        values = heights.T.astype("<f8")
        field = [
            component("xres", "i", struct.pack("<i", nx)),
            component("yres", "i", struct.pack("<i", ny)),
            component("xreal", "d", struct.pack("<d", nx * pixel[0])),
            component("yreal", "d", struct.pack("<d", ny * pixel[1])),
        ]
        if of_heights:
            field += [component("si_unit_xy", "o", unit("m")),
                      component("si_unit_z", "o", unit(of_heights))]  # fmt: skip
        field += [component("data", "D", struct.pack("<I", values.size) + values.tobytes())]
        parts += [
            component(f"/{number}/data", "o", body("GwyDataField", *field)),
            component(f"/{number}/data/title", "s", title.encode() + b"\0"),
        ]
    return b"GWYP" + body("GwyContainer", *parts)


_SUR = (
    "<12s4H30s30s5HIIHiiiiIfff" + "16s" * 9 + "fffHHHIII7HfIIHHH128sfff34s"
)  # fields of the header of 512 bytes


def sur(heights, pixel):
    """Content of a Digital Surf file, 32 bits a height."""
    nx, ny = heights.shape
    holes = np.isnan(heights)
    step = np.abs(heights[~holes]).max() / 2**24
    points = np.round(np.where(holes, 0, heights) / step).astype("<i4")
    low, high = int(points[~holes].min()), int(points[~holes].max())
    points[holes] = low - 2
    units = [b"X", b"Y", b"Z", *[b"m"] * 6]
    head = struct.pack(
        _SUR, b"DIGITAL SURF", 0, 1, 1, 2, b"scan", b"own",
        0, 0, 0, int(holes.any()), 0, 0, 0, 32, low, high, nx, ny, nx * ny, *pixel, step, *units,
        1, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 8, 0, b"", 0, 0, 0, b"",
    )  # fmt: skip
    return head + b"own data" + points.T.tobytes()


def al3d(heights, pixel):
    """Content of an Alicona file: tags as text, then heights as floats, rows padded to 8 bytes."""
    nx, ny = heights.shape
    invalid = 1e10
    tags = {
        "Version": 1, "TagCount": 7, "Rows": ny, "Cols": nx, "PixelSizeXMeter": pixel[0],
        "PixelSizeYMeter": pixel[1], "InvalidPixelValue": invalid, "DepthImageOffset": 2048,
        "Rows2": ny,
    }  # fmt: skip
    text = b"".join(
        key.encode().ljust(20, b"\0") + str(value).encode().ljust(30, b"\0") + b"\r\n"
        for key, value in tags.items()
    )
    rows = np.full((ny, -(-nx // 2) * 2), 0.0, "<f4")
    rows[:, :nx] = np.where(np.isnan(heights), invalid, heights).T
    head = b"AliconaImaging\0\r\n" + text + b"".ljust(254, b"\0") + b"\r\n"
    return head.ljust(2048, b"\0") + rows.tobytes()

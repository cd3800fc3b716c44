# SPDX-License-Identifier: BSD-3-Clause
"""Files of scanners and of neuroimaging: DICOM, MGH, FreeSurfer's surfaces, GIFTI; and volumes of NumPy arrays."""

import base64
import gzip
import os
import struct
import subprocess
import sys
import zlib

import numpy as np
import pytest
import surfacesynthesis
from conftest import add_array, icosphere, polydata_of, run_command
from surfacesynthesis import FormatError, SurfaceSynthesisWarning, read_mesh, read_volume, volume_from_numpy, write_mesh
from vtkmodules.util.numpy_support import vtk_to_numpy

SHAPE = (4, 3, 5)  # columns, rows, slices
VALUES = np.arange(60, dtype=np.int16).reshape(SHAPE, order="F")


def world_of(image, index):
    point = [0.0, 0.0, 0.0]
    image.TransformContinuousIndexToPhysicalPoint([float(i) for i in index], point)
    return np.array(point)


def samples_of(image):
    return vtk_to_numpy(image.GetPointData().GetScalars()).reshape(image.GetDimensions(), order="F")


def lies_at(image, affine):
    """True when every sample lies where ``affine`` puts it."""
    indices = np.ndindex(image.GetDimensions())
    return all(np.abs(world_of(image, index) - (affine @ [*index, 1.0])[:3]).max() < 1e-4 for index in indices)


# -- DICOM -------------------------------------------------------------------------------------------------------------


def element(tag, kind, value):
    """The bytes of a data element, explicit little endian."""
    if isinstance(value, str):
        value = value.encode()
        value += (b"\0" if kind == "UI" else b" ") * (len(value) % 2)
    head = struct.pack("<HH2s", tag >> 16, tag & 0xFFFF, kind.encode())
    long = kind in ("OW", "OB", "SQ", "UN")
    return head + (struct.pack("<2xI", len(value)) if long else struct.pack("<H", len(value))) + value


def sequence(tag, *items):
    """A sequence of datasets, each a list of elements."""
    joined = [b"".join(item) for item in items]
    return element(tag, "SQ", b"".join(struct.pack("<HHI", 0xFFFE, 0xE000, len(item)) + item for item in joined))


def decimals(numbers):
    return "\\".join(f"{number:.10g}" for number in numbers)


def geometry(affine, k):
    """Position, orientation and spacing of slice ``k`` of an affine in LPS."""
    spacing = np.linalg.norm(affine[:3, :2], axis=0)
    cosines = affine[:3, :2] / spacing
    return (affine @ [0, 0, k, 1])[:3], cosines.T.ravel(), spacing[::-1]


def dicom(values, affine, k=0, syntax="1.2.840.10008.1.2.1", uid="1.2.3", more=(), **changes):
    """The bytes of a DICOM file of the values [columns, rows]; changes: texts or numbers of some elements."""
    position, orientation, spacing = geometry(affine, k)
    signed = values.dtype.kind == "i"
    elements = {
        "class": element(0x00080016, "UI", "1.2.840.10008.5.1.4.1.1.4"),
        "instance_uid": element(0x00080018, "UI", f"{uid}.{k + 1}"),
        "modality": element(0x00080060, "CS", "MR"),
        "description": element(0x0008103E, "LO", "T1"),
        "series": element(0x0020000E, "UI", uid),
        "number": element(0x00200011, "IS", "4"),
        "instance": element(0x00200013, "IS", str(k + 1)),
        "position": element(0x00200032, "DS", decimals(position)),
        "orientation": element(0x00200037, "DS", decimals(orientation)),
        "samples": element(0x00280002, "US", struct.pack("<H", 1)),
        "photometric": element(0x00280004, "CS", "MONOCHROME2"),
        "rows": element(0x00280010, "US", struct.pack("<H", values.shape[1])),
        "columns": element(0x00280011, "US", struct.pack("<H", values.shape[0])),
        "spacing": element(0x00280030, "DS", decimals(spacing)),
        "allocated": element(0x00280100, "US", struct.pack("<H", 8 * values.dtype.itemsize)),
        "stored": element(0x00280101, "US", struct.pack("<H", 8 * values.dtype.itemsize)),
        "high": element(0x00280102, "US", struct.pack("<H", 8 * values.dtype.itemsize - 1)),
        "signed": element(0x00280103, "US", struct.pack("<H", signed)),
        "pixels": element(0x7FE00010, "OW", values.tobytes(order="F")),
    }
    elements.update(changes)
    body = b"".join(sorted([*filter(None, elements.values()), *more], key=lambda e: struct.unpack("<HH", e[:4])))
    meta = element(0x00020001, "OB", b"\0\1") + element(0x00020002, "UI", "1.2.840.10008.5.1.4.1.1.4")
    meta += element(0x00020003, "UI", f"{uid}.{k + 1}") + element(0x00020010, "UI", syntax)
    return bytes(128) + b"DICM" + element(0x00020000, "UL", struct.pack("<I", len(meta))) + meta + body


def oblique():
    """An affine in LPS with oblique axes, and a left-handed third one."""
    a, b = 0.3, -0.8
    about_x = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
    about_z = np.array([[np.cos(b), -np.sin(b), 0], [np.sin(b), np.cos(b), 0], [0, 0, 1]])
    axes = about_z @ about_x * [0.5, 0.75, 2.0]
    return np.vstack([np.column_stack([axes, [10.0, -20.0, 30.0]]), [0, 0, 0, 1]])


LPS_TO_RAS = np.diag([-1.0, -1.0, 1.0, 1.0])


def series(folder, affine=None, values=VALUES, order=(3, 0, 4, 1, 2), **changes):
    """A folder with a series, whose file names are in another order than the slices."""
    affine = oblique() if affine is None else affine
    folder.mkdir(exist_ok=True)
    for name, k in enumerate(order):
        (folder / f"IM{name:04}").write_bytes(dicom(values[:, :, k], affine, k, **changes))
    return folder


gdcm = pytest.mark.skipif(
    subprocess.run([sys.executable, "-c", "import gdcm"], capture_output=True, check=False).returncode != 0,
    reason="python3-gdcm is not installed",
)


@gdcm
@pytest.mark.parametrize("space, turn", [("RAS", LPS_TO_RAS), ("LPS", np.eye(4)), ("file", np.eye(4))])
def test_a_dicom_series_lies_where_its_positions_say(tmp_path, space, turn):
    folder = series(tmp_path / "scan")
    (folder / "notes.txt").write_text("no DICOM")
    (folder / "deeper").mkdir()
    os.mkfifo(folder / "pipe")
    image = read_volume(folder, space=space)
    assert image.GetDimensions() == SHAPE
    assert (samples_of(image) == VALUES).all() and samples_of(image).dtype == np.int16
    assert lies_at(image, turn @ oblique())


@gdcm
def test_a_dicom_series_and_its_nifti_lie_in_one_place(tmp_path):
    nibabel = pytest.importorskip("nibabel")
    nibabel.save(nibabel.Nifti1Image(VALUES, LPS_TO_RAS @ oblique()), str(tmp_path / "v.nii"))
    first, second = read_volume(series(tmp_path / "scan")), read_volume(tmp_path / "v.nii")
    assert (samples_of(first) == samples_of(second)).all()
    for index in np.ndindex(SHAPE):
        assert np.abs(world_of(first, index) - world_of(second, index)).max() < 1e-4


@gdcm
def test_each_slice_has_its_own_slope_and_intercept(tmp_path):
    folder = tmp_path / "pet"
    folder.mkdir()
    for k in range(SHAPE[2]):
        scale = [element(0x00281052, "DS", str(k)), element(0x00281053, "DS", str(0.5 * k + 1))]
        (folder / f"{k}.dcm").write_bytes(dicom(VALUES[:, :, k], oblique(), k, more=scale))
    expected = VALUES * (0.5 * np.arange(SHAPE[2]) + 1) + np.arange(SHAPE[2])
    assert np.allclose(samples_of(read_volume(folder)), expected)


@gdcm
@pytest.mark.parametrize("kind", ["u1", "i1", "u2", "i2", "u4", "i4"])
def test_dicom_types(tmp_path, kind):
    image = read_volume(series(tmp_path / "scan", values=VALUES.astype(kind)))
    assert (samples_of(image) == VALUES).all() and samples_of(image).dtype == np.dtype(kind)


def rle(values):
    """Samples [columns, rows] of 16 bits in DICOM's run length encoding, as one run without repetition for each byte."""
    raw = values.astype("<i2").ravel(order="F").view(np.uint8).reshape(-1, 2)
    segments = [bytes([len(raw) - 1]) + raw[:, k].tobytes() for k in (1, 0)]
    segments = [segment + b"\0" * (len(segment) % 2) for segment in segments]
    head = struct.pack("<16I", 2, 64, 64 + len(segments[0]), *[0] * 13)
    frame = head + b"".join(segments)
    items = struct.pack("<HHI", 0xFFFE, 0xE000, 0) + struct.pack("<HHI", 0xFFFE, 0xE000, len(frame)) + frame
    items += struct.pack("<HHI", 0xFFFE, 0xE0DD, 0)
    return struct.pack("<HH2s2xI", 0x7FE0, 0x0010, b"OB", 0xFFFFFFFF) + items


#: Compresses a DICOM file with GDCM: source, target, transfer syntax.
_COMPRESS = """
import sys, gdcm
reader = gdcm.ImageReader()
reader.SetFileName(sys.argv[1])
assert reader.Read()
change = gdcm.ImageChangeTransferSyntax()
change.SetTransferSyntax(gdcm.TransferSyntax(getattr(gdcm.TransferSyntax, sys.argv[3])))
change.SetInput(reader.GetImage())
assert change.Change()
writer = gdcm.ImageWriter()
writer.SetFileName(sys.argv[2])
writer.SetFile(reader.GetFile())
writer.SetImage(change.GetOutput())
assert writer.Write()
"""


@gdcm
@pytest.mark.parametrize(
    "syntax, kind, error",
    [
        ("JPEGLosslessProcess14_1", "i2", 0), ("JPEGLSLossless", "i2", 0), ("JPEG2000Lossless", "i2", 0), ("RLELossless", "i2", 0),
        ("JPEGBaselineProcess1", "u1", 6), ("JPEGLSNearLossless", "i2", 6), ("JPEG2000", "i2", 6),
    ],
)  # fmt: skip
def test_compressed_files_of_gdcm_are_read(tmp_path, syntax, kind, error):
    i, j = np.meshgrid(np.arange(64), np.arange(48), indexing="ij")
    values = np.round(100 + 80 * np.sin(i / 9) * np.cos(j / 7)).astype(kind)
    (tmp_path / "plain.dcm").write_bytes(dicom(values, oblique()))
    subprocess.run(
        [sys.executable, "-c", _COMPRESS, tmp_path / "plain.dcm", tmp_path / "packed.dcm", syntax], check=True
    )
    assert (tmp_path / "packed.dcm").stat().st_size < 0.9 * (tmp_path / "plain.dcm").stat().st_size
    image = read_volume(tmp_path / "packed.dcm", space="LPS")
    assert samples_of(image).dtype == kind and lies_at(image, oblique())
    assert np.abs(samples_of(image)[:, :, 0].astype(int) - values).max() <= error


@gdcm
def test_compressed_samples_and_samples_of_12_bits(tmp_path):
    values = VALUES[:, :, 3] - 40  # of both signs
    (tmp_path / "a.dcm").write_bytes(dicom(values, oblique(), syntax="1.2.840.10008.1.2.5", pixels=rle(values)))
    assert (samples_of(read_volume(tmp_path / "a.dcm"))[:, :, 0] == values).all()
    for kind in ("i2", "u2"):
        bits = {
            "stored": element(0x00280101, "US", struct.pack("<H", 12)), "high": element(0x00280102, "US", struct.pack("<H", 11)),
            "pixels": element(0x7FE00010, "OW", (values.astype("u2") & 0x0FFF | 0x5000).tobytes(order="F")),
        }  # fmt: skip
        (tmp_path / "a.dcm").write_bytes(dicom(values.astype(kind), oblique(), **bits))
        expected = values if kind == "i2" else values.astype("u2") & 0x0FFF
        assert (samples_of(read_volume(tmp_path / "a.dcm"))[:, :, 0] == expected).all()


@gdcm
def test_one_dicom_file_and_one_with_many_frames(tmp_path):
    thickness = [element(0x00180050, "DS", "2.5")]
    (tmp_path / "one.dcm").write_bytes(dicom(VALUES[:, :, 0], oblique(), 0, more=thickness))
    image = read_volume(tmp_path / "one.dcm", space="LPS")
    assert image.GetDimensions() == (4, 3, 1) and image.GetSpacing()[2] == 2.5
    order, affine = [2, 0, 1, 4, 3], oblique()
    orientation, spacing = geometry(affine, 0)[1:]
    shared = [
        sequence(0x00209116, [element(0x00200037, "DS", decimals(orientation))]),
        sequence(0x00289110, [element(0x00280030, "DS", decimals(spacing))]),
        sequence(0x00289145, [element(0x00281052, "DS", "1"), element(0x00281053, "DS", "2")]),
    ]
    frames = [[sequence(0x00209113, [element(0x00200032, "DS", decimals(geometry(affine, k)[0]))])] for k in order]
    more = [element(0x00280008, "IS", "5"), sequence(0x52009229, shared), sequence(0x52009230, *frames)]
    pixels = element(0x7FE00010, "OW", VALUES[:, :, order].tobytes(order="F"))
    (tmp_path / "many.dcm").write_bytes(
        dicom(VALUES[:, :, 0], affine, pixels=pixels, more=more, position=None, orientation=None, spacing=None,
              **{"class": element(0x00080016, "UI", "1.2.840.10008.5.1.4.1.1.4.1")})
    )  # fmt: skip
    image = read_volume(tmp_path / "many.dcm", space="LPS")
    assert (samples_of(image) == 2 * VALUES + 1).all()
    assert lies_at(image, affine)


@gdcm
def test_of_several_series_one_is_chosen(tmp_path):
    folder = series(tmp_path / "scan")
    for k in range(2):
        other = {"number": element(0x00200011, "IS", "7"), "description": element(0x0008103E, "LO", "T2")}
        (folder / f"T2-{k}").write_bytes(dicom(VALUES[:, :, k] + 100, oblique(), k, uid="1.2.9", **other))
    with pytest.raises(FormatError, match=r"2 series; choose one .*: 4 \(5 files, T1\); 7 \(2 files, T2\)"):
        read_volume(folder)
    assert read_volume(folder, series=7).GetDimensions() == (4, 3, 2)
    assert (samples_of(read_volume(folder, series="1.2.3")) == VALUES).all()
    with pytest.raises(ValueError, match="series 5 names 0 series"):
        read_volume(folder, series=5)


@gdcm
def test_times_at_one_place_give_the_first_volume(tmp_path):
    folder = series(tmp_path / "scan")
    for k in range(SHAPE[2]):
        later = {"instance": element(0x00200013, "IS", str(k + 101))}
        (folder / f"A{k}").write_bytes(dicom(VALUES[:, :, k] + 100, oblique(), k, **later))
    with pytest.warns(SurfaceSynthesisWarning, match="the first of 2 volumes is read"):
        assert (samples_of(read_volume(folder)) == VALUES).all()


def sheared():
    affine = np.diag([1.0, 1.0, 2.0, 1.0])
    affine[1, 2] = 0.5  # a tilted gantry
    return affine


BAD_SERIES = {
    "a slice is missing": dict(order=(0, 1, 3, 4)),
    "the axes of the volume are sheared": dict(affine=sheared()),
    "the position of a slice is missing": dict(position=None),
    "the orientation of a slice is '1.0.0'": dict(orientation=element(0x00200037, "DS", "1\\0\\0")),
    "the spacing of a slice is 'a": dict(spacing=element(0x00280030, "DS", "a\\1")),
    "the samples are colors": dict(photometric=element(0x00280004, "CS", "RGB")),
    "samples of 12 bits": dict(allocated=element(0x00280100, "US", struct.pack("<H", 12))),
    "the file is cut off: its header announces 25165824 bytes": dict(
        rows=element(0x00280010, "US", struct.pack("<H", 4096)), columns=element(0x00280011, "US", struct.pack("<H", 3072))
    ),
    "orientation or the spacing of a slice is 0": dict(orientation=element(0x00200037, "DS", "0\\0\\0\\0\\0\\0")),
    "999999999 frames have 0 places": dict(more=[element(0x00280008, "IS", "999999999")]),
}


@gdcm
@pytest.mark.parametrize("text", BAD_SERIES)
def test_bad_dicom_series_are_named(tmp_path, text):
    with pytest.raises(FormatError, match=text):
        read_volume(series(tmp_path / "scan", **BAD_SERIES[text]))


@gdcm
def test_damaged_dicom_files_end_in_an_error_and_no_crash(tmp_path, capfd):
    whole = dicom(VALUES[:, :, 0], oblique())
    damaged = [whole[:length] for length in (132, 140, 300, 500, len(whole) - 1)]
    wrong = {"samples": element(0x00280002, "US", struct.pack("<H", 2))}  # GDCM ends the process
    damaged.append(dicom(VALUES[:, :, 0], oblique(), photometric=None, **wrong))
    for data in damaged:
        (tmp_path / "bad.dcm").write_bytes(data)
        with pytest.raises(FormatError, match="bad.dcm"):
            read_volume(tmp_path / "bad.dcm")
    os.mkfifo(tmp_path / "pipe.dcm")
    with pytest.raises(FormatError, match="no regular file"):
        read_volume(tmp_path / "pipe.dcm")
    (tmp_path / "empty").mkdir()
    with pytest.raises(FormatError, match="no DICOM file is here"):
        read_volume(tmp_path / "empty")
    assert capfd.readouterr() == ("", "")


@gdcm
def test_random_changes_of_dicom_files_end_in_an_error_or_an_image(tmp_path, capfd):
    generator = np.random.default_rng(3)
    whole = dicom(VALUES[:, :, 0], oblique())
    for _ in range(12):
        changed = bytearray(whole)
        for place in generator.integers(132, len(changed), 6):
            changed[place] = generator.integers(256)
        (tmp_path / "changed.dcm").write_bytes(bytes(changed))
        try:
            read_volume(tmp_path / "changed.dcm")
        except FormatError:
            continue
    assert capfd.readouterr() == ("", "")


def test_missing_modules_are_named(tmp_path, monkeypatch):
    (tmp_path / "gdcm.py").write_text("raise ImportError")
    (tmp_path / "one.dcm").write_bytes(dicom(VALUES[:, :, 0], oblique()))
    monkeypatch.syspath_prepend(str(tmp_path))
    with pytest.raises(surfacesynthesis.SurfaceSynthesisError, match="python3-gdcm"):
        read_volume(tmp_path / "one.dcm")
    monkeypatch.setitem(sys.modules, "nibabel", None)
    (tmp_path / "a.mgh").write_bytes(mgh())
    with pytest.raises(surfacesynthesis.SurfaceSynthesisError, match="python3-nibabel"):
        read_volume(tmp_path / "a.mgh")
    with pytest.raises(surfacesynthesis.SurfaceSynthesisError, match="python3-nibabel"):
        write_mesh(polydata_of(*icosphere(1)), tmp_path / "a.gii")


# -- FreeSurfer --------------------------------------------------------------------------------------------------------


def mgh(values=VALUES, affine=None, frames=1, kind=4, dimensions=SHAPE):
    """The bytes of an MGH file with the affine (RAS)."""
    affine = LPS_TO_RAS @ oblique() if affine is None else affine
    spacing = np.linalg.norm(affine[:3, :3], axis=0)
    center = affine @ [*(np.array(SHAPE) / 2), 1]
    header = struct.pack(">7ih", 1, *dimensions, frames, kind, 0, 1)
    header += struct.pack(">3f9f3f", *spacing, *(affine[:3, :3] / spacing).T.ravel(), *center[:3])
    return header.ljust(284, b"\0") + values.astype(values.dtype.newbyteorder(">")).tobytes(order="F")


@pytest.mark.parametrize("suffix", [".mgh", ".mgz"])
def test_mgh_volumes_lie_where_nibabel_puts_them(tmp_path, suffix):
    nibabel = pytest.importorskip("nibabel")
    path = tmp_path / f"v{suffix}"
    path.write_bytes(gzip.compress(mgh()) if suffix == ".mgz" else mgh())
    image, expected = read_volume(path), nibabel.load(str(path))
    assert (samples_of(image) == np.asarray(expected.dataobj)).all() and (samples_of(image) == VALUES).all()
    assert lies_at(image, expected.affine) and lies_at(image, LPS_TO_RAS @ oblique())
    assert lies_at(read_volume(path, space="LPS"), oblique())


BAD_MGH = {
    "this is no MGH file": b"MGH",
    "does not begin with the version 1": b"\0\0\0\2" + bytes(280),
    "samples of the type 7": mgh(kind=7),
    "announces 120 bytes of samples, 119 follow": mgh()[:-1],
    "announces 16000000000000000 bytes|compressed bytes follow": mgh(dimensions=(2 * 10**5, 2 * 10**5, 2 * 10**5)),
    "has the dimensions 4, -3, 5": mgh(dimensions=(4, -3, 5)),
}


@pytest.mark.parametrize("text", BAD_MGH)
@pytest.mark.parametrize("suffix", [".mgh", ".mgz"])
def test_bad_mgh_files_are_named(tmp_path, text, suffix):
    pytest.importorskip("nibabel")
    path = tmp_path / f"bad{suffix}"
    path.write_bytes(gzip.compress(BAD_MGH[text]) if suffix == ".mgz" else BAD_MGH[text])
    with pytest.raises(FormatError, match=text):
        read_volume(path)
    os.mkfifo(tmp_path / f"pipe{suffix}")
    with pytest.raises(FormatError, match="no regular file"):
        read_volume(tmp_path / f"pipe{suffix}")


def freesurfer_info(affine):
    """A surface's description of its volume."""
    spacing = np.linalg.norm(affine[:3, :3], axis=0)
    axes = affine[:3, :3] / spacing
    center = (affine @ [*(np.array(SHAPE) / 2), 1])[:3]
    return {
        "head": [2, 0, 20], "valid": "1  # volume info valid", "filename": "v.mgz", "volume": np.array(SHAPE),
        "voxelsize": spacing, "xras": axes[:, 0], "yras": axes[:, 1], "zras": axes[:, 2], "cras": center,
    }  # fmt: skip


def test_freesurfer_surfaces_lie_on_their_volume(tmp_path):
    nibabel = pytest.importorskip("nibabel")
    points, triangles = icosphere(1)
    (tmp_path / "v.mgz").write_bytes(gzip.compress(mgh()))
    header = nibabel.load(str(tmp_path / "v.mgz")).header
    # from the surface's coordinates to those of the scanner, through the samples
    matrix = header.get_affine() @ np.linalg.inv(header.get_vox2ras_tkr())
    path = str(tmp_path / "lh.pial")
    nibabel.freesurfer.write_geometry(path, points, triangles, volume_info=freesurfer_info(LPS_TO_RAS @ oblique()))
    mesh = read_mesh(path)
    expected = points @ matrix[:3, :3].T + matrix[:3, 3]
    assert np.abs(vtk_to_numpy(mesh.GetPoints().GetData()) - expected).max() < 1e-5
    nibabel.freesurfer.write_geometry(path, points, triangles)  # without a volume
    mesh = read_mesh(path)
    assert np.abs(vtk_to_numpy(mesh.GetPoints().GetData()) - points).max() < 1e-6
    assert (vtk_to_numpy(mesh.GetPolys().GetConnectivityArray()).reshape(-1, 3) == triangles).all()
    nibabel.freesurfer.write_morph_data(str(tmp_path / "lh.thickness"), points[:, 2])
    mesh = read_mesh(path, point_data=tmp_path / "lh.thickness")
    assert np.allclose(vtk_to_numpy(mesh.GetPointData().GetArray("thickness")), points[:, 2])
    with pytest.raises(ValueError, match="can be read, but not written"):
        write_mesh(mesh, path)
    data = (tmp_path / "lh.pial").read_bytes()
    values = (tmp_path / "lh.thickness").read_bytes()
    begin = data.index(b"\n\n") + 2
    for words, bad in (
        ("no surface of triangles", data[:10]), ("no surface of triangles", b"\xff\xff\xff" + data[3:]),
        ("the file is cut off", data[:-5]),
        ("the file is cut off", data[:begin] + b"\x7f\xff\xff\xff" + data[begin + 4 :]),
        ("triangles name points", data[:-4] + struct.pack(">i", len(points))),
    ):  # fmt: skip
        (tmp_path / "bad.pial").write_bytes(bad)
        with pytest.raises(FormatError, match=words):
            read_mesh(tmp_path / "bad.pial")
    for words, bad in (
        ("no values of points", values[:10]), ("cut off", values[:-1]),
        ("42 values of 2", values[:11] + b"\0\0\0\2" + values[15:]), ("41 values", values[:3] + struct.pack(">i", 41) + values[7:]),
    ):  # fmt: skip
        (tmp_path / "bad.curv").write_bytes(bad)
        with pytest.raises(FormatError, match=words):
            read_mesh(path, point_data=[tmp_path / "bad.curv"])


# -- GIFTI -------------------------------------------------------------------------------------------------------------


def test_gifti_surfaces_and_values(tmp_path):
    nibabel = pytest.importorskip("nibabel")
    points, triangles = icosphere(1)
    mesh = polydata_of(points, triangles)
    add_array(mesh.GetPointData(), "height", points[:, 2])
    add_array(mesh.GetPointData(), "parcel", np.arange(len(points)))
    add_array(mesh.GetPointData(), "direction", points.astype(np.float32))
    path = tmp_path / "lh.surf.gii"
    write_mesh(mesh, path)
    image = nibabel.load(str(path))
    assert np.allclose(image.agg_data("pointset"), points) and (image.agg_data("triangle") == triangles).all()
    result = read_mesh(path)
    assert (vtk_to_numpy(result.GetPolys().GetConnectivityArray()).reshape(-1, 3) == triangles).all()
    for name, values in (("height", points[:, 2]), ("parcel", np.arange(len(points))), ("direction", points)):
        assert np.allclose(vtk_to_numpy(result.GetPointData().GetArray(name)), values), name
    times = nibabel.gifti.GiftiImage()
    for k in range(3):
        times.add_gifti_data_array(
            nibabel.gifti.GiftiDataArray(np.float32(k + points[:, 0]), "NIFTI_INTENT_TIME_SERIES", "NIFTI_TYPE_FLOAT32")
        )
    nibabel.save(times, str(tmp_path / "lh.func.gii"))
    result = read_mesh(path, point_data=[tmp_path / "lh.func.gii"])
    assert np.allclose(vtk_to_numpy(result.GetPointData().GetArray("TimeSeries")), points[:, :1] + [[0, 1, 2]])
    with pytest.raises(FormatError, match="0 sets of points .* read_mesh"):
        read_mesh(tmp_path / "lh.func.gii")
    write_mesh(polydata_of(*icosphere(0)), tmp_path / "other.gii")
    with pytest.raises(FormatError, match="there are 42 values '.*' for 12 points"):
        read_mesh(tmp_path / "other.gii", point_data=[tmp_path / "lh.func.gii"])


def label_file(path, values):
    """A GIFTI file of labels with a table of two names."""
    nibabel = pytest.importorskip("nibabel")
    image = nibabel.gifti.GiftiImage()
    array = nibabel.gifti.GiftiDataArray(np.int32(values), "NIFTI_INTENT_LABEL", "NIFTI_TYPE_INT32")
    array.meta = nibabel.gifti.GiftiMetaData({"Name": "regions"})
    image.add_gifti_data_array(array)
    for key, name in ((0, "unknown"), (9182740, "cuneus")):
        label = nibabel.gifti.GiftiLabel(key, 1, 0, 0, 1)
        label.label = name
        image.labeltable.labels.append(label)
    nibabel.save(image, str(path))


def test_gifti_labels_are_numbers_with_names(tmp_path):
    points, triangles = icosphere(0)
    values = np.where(points[:, 2] > 0, 9182740, 0)
    label_file(tmp_path / "lh.label.gii", values)
    write_mesh(polydata_of(points, triangles), tmp_path / "lh.ply")
    mesh = read_mesh(tmp_path / "lh.ply", point_data=tmp_path / "lh.label.gii")
    write_mesh(mesh, tmp_path / "lh.vtp")
    for result in (mesh, read_mesh(tmp_path / "lh.vtp")):
        regions = vtk_to_numpy(result.GetPointData().GetArray("regions"))
        assert regions.dtype == np.int32 and (regions == values).all()
        names = result.GetFieldData().GetAbstractArray("regionsLabelNames")
        numbers = result.GetFieldData().GetArray("regionsLabelValues")
        table = {numbers.GetValue(k): names.GetValue(k) for k in range(names.GetNumberOfValues())}
        assert table == {0: "unknown", 9182740: "cuneus"}


def test_commands_take_values_of_points_and_seams(tmp_path):
    points, triangles = icosphere(0)
    label_file(tmp_path / "lh.label.gii", np.arange(12))
    write_mesh(polydata_of(points, triangles), tmp_path / "lh.ply")
    done = run_command("noise", "lh.ply", "out.vtp", "--point-data", "lh.label.gii", "--range", "1", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (vtk_to_numpy(read_mesh(tmp_path / "out.vtp").GetPointData().GetArray("regions")) == np.arange(12)).all()
    done = run_command("noise", "lh.ply", "out.vtp", "--point-data", "lh.ply", cwd=tmp_path)
    assert done.returncode == 2 and "values of points are read from .gii" in done.stderr
    done = run_command("report", "lh.label.gii", cwd=tmp_path)
    assert done.returncode == 1 and "with their surface: the surface as INPUT, and --point-data FILE" in done.stderr

    (tmp_path / "seam.obj").write_text(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nvt 1 1\nf 1/1 2/2 3/3\nf 2/1 4/4 3/2\n"
    )
    for options, count, words in (([], 4, "--seams split makes a point for each"), (["--seams", "split"], 6, "")):
        done = run_command("noise", "seam.obj", "out.vtp", "--range", "1", *options, cwd=tmp_path)
        assert done.returncode == 0 and words in done.stderr, done.stderr
        assert read_mesh(tmp_path / "out.vtp").GetNumberOfPoints() == count


def gifti(size=(3, 3), data=None, kind="NIFTI_TYPE_FLOAT32", encoding="GZipBase64Binary", more="", corner=2):
    """A GIFTI file of one triangle, the points of which are as the arguments say."""
    if data is None:
        data = base64.b64encode(zlib.compress(np.eye(3, dtype=np.float32).tobytes())).decode()
    array = (
        '<DataArray Intent="{}" DataType="{}" ArrayIndexingOrder="RowMajorOrder" Dimensionality="2" Dim0="{}" Dim1="{}" '
        'Encoding="{}" Endian="LittleEndian" ExternalFileName="" ExternalFileOffset=""{}><Data>{}</Data></DataArray>'
    )
    return (
        '<?xml version="1.0"?><GIFTI Version="1.0" NumberOfDataArrays="2">'
        + array.format("NIFTI_INTENT_POINTSET", kind, *size, encoding, more, data)
        + array.format("NIFTI_INTENT_TRIANGLE", "NIFTI_TYPE_INT32", 1, 3, "ASCII", "", f"0 1 {corner}")
        + "</GIFTI>"
    )


BOMB = base64.b64encode(zlib.compress(bytes(1 << 26))).decode()
BAD_GIFTI = {
    "cut off, or no GIFTI file": gifti()[:-30],
    "cut off, or no GIFTI file: no element": "",
    "it is of the kind VTKFile": "<VTKFile></VTKFile>",
    "3000000000000000 values are announced|is no size": gifti(size=(10**9, 3 * 10**6)),
    "no size of values": gifti(size=("-3", 3)),
    "36 bytes of values are announced; the data has more than 36": gifti(data=BOMB),
    "48 bytes of values are announced; the data has 36": gifti(size=(4, 3)),
    "the compressed data is damaged": gifti(data="AAAAAAAA"),
    "values of the type NIFTI_TYPE_COMPLEX64": gifti(kind="NIFTI_TYPE_COMPLEX64"),
    "values in another file": gifti(encoding="ExternalFileBinary"),
    "triangles name points": gifti(corner=3),
    "points have three coordinates": gifti(size=(9, 1)),
    "no entities": '<!DOCTYPE GIFTI [<!ENTITY a "b">]>' + gifti().partition("?>")[2],
}


@pytest.mark.parametrize("text", BAD_GIFTI)
def test_bad_gifti_files_are_named(tmp_path, text, capfd):
    pytest.importorskip("nibabel")
    (tmp_path / "good.gii").write_text(gifti())
    assert read_mesh(tmp_path / "good.gii").GetNumberOfPoints() == 3
    (tmp_path / "bad.gii").write_text(BAD_GIFTI[text])
    with pytest.raises(FormatError, match=text):
        read_mesh(tmp_path / "bad.gii")
    assert capfd.readouterr() == ("", "")


def test_random_changes_of_gifti_files_end_in_an_error_or_a_mesh(tmp_path, capfd):
    pytest.importorskip("nibabel")
    generator = np.random.default_rng(4)
    whole = gifti().encode()
    for _ in range(300):
        changed = bytearray(whole)
        for place in generator.integers(0, len(changed), 2):
            changed[place] = generator.integers(32, 127)
        (tmp_path / "changed.gii").write_bytes(bytes(changed))
        try:
            read_mesh(tmp_path / "changed.gii")
        except FormatError:
            continue
    assert capfd.readouterr() == ("", "")


# -- arrays ------------------------------------------------------------------------------------------------------------


def test_a_volume_from_numpy_lies_where_nibabel_puts_it(tmp_path):
    nibabel = pytest.importorskip("nibabel")
    affine = LPS_TO_RAS @ oblique()
    source = nibabel.Nifti1Image(VALUES, affine)
    nibabel.save(source, str(tmp_path / "v.nii"))
    image = volume_from_numpy(np.asarray(source.dataobj), source.affine)
    read = read_volume(tmp_path / "v.nii")
    assert (samples_of(image) == VALUES).all() and (samples_of(read) == VALUES).all()
    for index in np.ndindex(SHAPE):
        expected = nibabel.affines.apply_affine(source.affine, index)
        assert np.abs(world_of(image, index) - expected).max() < 1e-5
        assert np.abs(world_of(read, index) - expected).max() < 1e-5
    assert lies_at(volume_from_numpy(VALUES, oblique(), space="LPS"), affine)
    assert image.GetPointData().GetScalars().GetName() == "Scalars"


def test_arrays_of_all_orders_and_types_become_volumes():
    for kind in ("u1", "i2", ">i4", "f2", "f4", ">f8", "?"):
        for values in (VALUES.astype(kind), np.ascontiguousarray(VALUES).astype(kind)[::-1]):
            image = volume_from_numpy(values, np.eye(4), name="mask")
            assert (samples_of(image) == values).all(), kind
            assert image.GetPointData().GetScalars().GetName() == "mask"
    values = VALUES.copy()
    image = volume_from_numpy(values, np.eye(4)[:3])
    values[:] = 0
    assert (samples_of(image) == VALUES).all()
    assert volume_from_numpy(VALUES[:, :, 0], np.eye(4)).GetDimensions() == (4, 3, 1)


@pytest.mark.parametrize(
    "array, affine, space, words",
    [
        (VALUES, np.eye(3), "RAS", "affine is no matrix"),
        (VALUES, np.ones((4, 4)), "RAS", "affine is no matrix"),
        (VALUES, np.eye(4), "file", "space is 'file'; RAS or LPS"),
        (VALUES, np.diag([1, 0, 1, 1]), "RAS", "larger than 0 is needed"),
        (VALUES, sheared(), "RAS", "sheared"),
        (np.zeros((2, 2, 2, 2)), np.eye(4), "RAS", "shape .2, 2, 2, 2."),
        (np.zeros((0, 2, 2)), np.eye(4), "RAS", "shape .0, 2, 2."),
        (np.zeros((2, 2, 2), dtype=complex), np.eye(4), "RAS", "complex128"),
    ],
)
def test_arrays_that_are_no_volumes_are_errors(array, affine, space, words):
    with pytest.raises(ValueError, match=words):
        volume_from_numpy(array, affine, space)


# -- arrays of cells ---------------------------------------------------------------------------------------------------


def image_of_cells(path):
    """A .vti file with a ball as values of cells beside values of points; its affine."""
    from vtkmodules.vtkIOXML import vtkXMLImageDataWriter

    affine = LPS_TO_RAS @ oblique()
    image = volume_from_numpy(np.zeros((13, 11, 9)), affine, name="points")
    centers = np.stack(np.meshgrid(*(np.arange(size) - (size - 1) / 2 for size in (12, 10, 8)), indexing="ij"))
    ball = 3.0 - np.linalg.norm(centers, axis=0)
    add_array(image.GetCellData(), "ball", ball.reshape(-1, order="F"))
    writer = vtkXMLImageDataWriter()
    writer.SetFileName(str(path))
    writer.SetInputData(image)
    writer.Write()
    return image, ball, affine


def test_arrays_of_cells_are_chosen_by_their_names(tmp_path):
    given, ball, affine = image_of_cells(tmp_path / "v.vti")
    image = read_volume(tmp_path / "v.vti", array="ball")
    assert np.allclose(samples_of(image), ball)
    centers = affine.copy()
    centers[:3, 3] += affine[:3, :3] @ [0.5, 0.5, 0.5]
    assert lies_at(image, centers)
    assert read_volume(tmp_path / "v.vti").GetDimensions() == (13, 11, 9)
    assert read_volume(tmp_path / "v.vti", array="points").GetPointData().GetScalars().GetName() == "points"
    with pytest.raises(ValueError, match="there is no array 'bal'; there are points, ball"):
        read_volume(tmp_path / "v.vti", array="bal")
    with pytest.raises(ValueError, match="array chooses among the arrays of .vti files"):
        read_volume(tmp_path / "v.nii", array="bal")
    with pytest.raises(ValueError, match="series chooses"):
        read_volume(tmp_path / "v.nii", series=1)
    if hasattr(surfacesynthesis, "vtkVDBSurfaceFilter"):
        surface = surfacesynthesis.vdb_surface(given, iso_value=0.0, array="ball")
        assert surface.GetNumberOfPolys() > 100
        middle = affine @ [6, 5, 4, 1]
        assert np.abs(np.array(surface.GetCenter()) - middle[:3]).max() < 0.2
        output = tmp_path / "ball.glb"
        done = run_command("surface", tmp_path / "v.vti", output, "--array", "ball", "--iso-value", 0, "--no-progress")
        assert done.returncode == 0, done
        assert np.allclose(read_mesh(output).GetBounds(), surface.GetBounds(), atol=1e-3)
        done = run_command("surface", tmp_path / "v.vti", output, "--array", "bal", "--no-progress")
        assert done.returncode == 2 and "there is no array 'bal'" in done.stderr


@gdcm
def test_the_command_line_reads_a_dicom_series(tmp_path):
    if not hasattr(surfacesynthesis, "vtkVDBSurfaceFilter"):
        pytest.skip("built without OpenVDB")
    centers = np.stack(np.meshgrid(*(np.arange(size) - (size - 1) / 2 for size in (16, 14, 8)), indexing="ij"))
    ball = (1000 * (3.0 - np.linalg.norm(centers, axis=0))).astype(np.int16)
    folder = series(tmp_path / "scan", values=ball, order=range(8))
    done = run_command("surface", folder, tmp_path / "ball.vtp", "--iso-value", 0, "--series", 4, "--no-progress")
    assert done.returncode == 0, done
    expected = LPS_TO_RAS @ oblique() @ [7.5, 6.5, 3.5, 1]
    assert np.abs(np.array(read_mesh(tmp_path / "ball.vtp").GetCenter()) - expected[:3]).max() < 0.3
    done = run_command("surface", folder, tmp_path / "ball.vtp", "--series", 5, "--no-progress")
    assert done.returncode == 2 and "series 5 names 0 series" in done.stderr

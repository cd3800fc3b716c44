# SPDX-License-Identifier: BSD-3-Clause
"""read_volume(): world coordinates, and what is said of files that are damaged."""

import gzip
import os
import struct
import subprocess
import sys
import textwrap
import tracemalloc
import warnings
import zlib

import numpy as np
import pytest
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOImage import vtkNIFTIImageReader

import surfacesynthesis
from surfacesynthesis import FormatError, SurfaceSynthesisWarning, read_volume

SHAPE = (4, 3, 2)  # i, j, k
VALUES = np.arange(24, dtype=np.int16).reshape(SHAPE, order="F")


def nifti(values=VALUES, order="<", code=4, sform=None, qform=None, pixdim=(1, 1, 1, 1), **changes):
    """The bytes of a NIfTI-1 file."""
    fields = {
        "size": 348, "dim": [values.ndim, *values.shape] + [1] * (7 - values.ndim), "datatype": code,
        "bitpix": 8 * values.dtype.itemsize, "vox_offset": 352.0, "slope": 0.0, "inter": 0.0, "magic": b"n+1\0",
    }  # fmt: skip
    fields.update(changes)
    header = bytearray(352)
    pack = lambda offset, form, *numbers: struct.pack_into(order + form, header, offset, *numbers)  # noqa: E731
    pack(0, "i", fields["size"])
    pack(40, "8h", *fields["dim"])
    pack(70, "hh", fields["datatype"], fields["bitpix"])
    pack(76, "8f", *pixdim, *[1.0] * (8 - len(pixdim)))
    pack(108, "3f", fields["vox_offset"], fields["slope"], fields["inter"])
    if qform is not None:
        pack(252, "h", 1)
        pack(256, "6f", *qform)
    if sform is not None:
        pack(254, "h", 2)
        pack(280, "12f", *np.ravel(sform))
    header[344:348] = fields["magic"]
    return bytes(header) + values.astype(values.dtype.newbyteorder(order)).tobytes(order="F")


def written(folder, name, data):
    path = folder / name
    path.write_bytes(gzip.compress(data) if name.endswith(".gz") else data)
    return path


def world_of(image, index):
    """Where VTK puts a sample."""
    point = [0.0, 0.0, 0.0]
    image.TransformContinuousIndexToPhysicalPoint([float(i) for i in index], point)
    return np.array(point)


def samples_of(image):
    return vtk_to_numpy(image.GetPointData().GetScalars()).reshape(image.GetDimensions(), order="F")


def rotation():
    a, b = 0.3, -0.8
    about_x = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
    about_z = np.array([[np.cos(b), -np.sin(b), 0], [np.sin(b), np.cos(b), 0], [0, 0, 1]])
    return about_z @ about_x


AFFINES = {
    "plain": np.column_stack([np.diag([1.0, 2.0, 3.0]), [10.0, 20.0, 30.0]]),
    "flipped": np.column_stack([np.diag([-1.5, 2.0, 0.5]), [90.0, -126.0, -72.0]]),
    "permuted": np.array([[0, 0, 2.0, -5], [1.0, 0, 0, 6], [0, -3.0, 0, 7]]),
    "oblique": np.column_stack([rotation() * [0.5, 0.75, 2.0], [1.0, -2.0, 3.5]]),
    "oblique, left-handed": np.column_stack([rotation() * [-0.5, 0.75, 2.0], [1.0, -2.0, 3.5]]),
}


@pytest.mark.parametrize("name", AFFINES)
@pytest.mark.parametrize("suffix", [".nii", ".nii.gz"])
def test_samples_lie_where_the_sform_says(tmp_path, name, suffix):
    affine = AFFINES[name].astype(np.float32)
    other = (0.5, 0.5, 0.5, 7, 8, 9)  # a qform that contradicts: the sform is preferred
    image = read_volume(written(tmp_path, "v" + suffix, nifti(sform=affine, qform=other)))
    assert image.GetDimensions() == SHAPE
    assert (samples_of(image) == VALUES).all()
    for index in np.ndindex(SHAPE):
        expected = affine.astype(float) @ [*index, 1.0]
        assert np.abs(world_of(image, index) - expected).max() < 1e-5


def test_samples_lie_where_the_qform_says_when_there_is_no_sform(tmp_path):
    # A half turn about x, worked by hand: quaternion (a, b, c, d) = (0, 1, 0, 0) is diag(1, -1, -1).
    half_turn = (1.0, 0.0, 0.0, 5.0, 6.0, 7.0)
    image = read_volume(written(tmp_path, "q.nii", nifti(qform=half_turn, pixdim=(1, 2, 3, 4))))
    assert np.allclose(world_of(image, (1, 1, 1)), [5 + 2, 6 - 3, 7 - 4])
    # qfac = -1 turns the third axis round.
    image = read_volume(written(tmp_path, "q.nii", nifti(qform=half_turn, pixdim=(-1, 2, 3, 4))))
    assert np.allclose(world_of(image, (1, 1, 1)), [5 + 2, 6 - 3, 7 + 4])
    # A quarter turn about z: a = d = sqrt(1/2), x to y and y to -x.
    quarter = (0.0, 0.0, np.sqrt(0.5), 0.0, 0.0, 0.0)
    image = read_volume(written(tmp_path, "q.nii", nifti(qform=quarter, pixdim=(1, 2, 3, 4))))
    assert np.allclose(world_of(image, (1, 0, 0)), [0, 2, 0], atol=1e-6)
    assert np.allclose(world_of(image, (0, 1, 0)), [-3, 0, 0], atol=1e-6)
    image = read_volume(written(tmp_path, "plain.nii", nifti(pixdim=(1, 2, 3, 4))))
    assert np.allclose(world_of(image, (1, 1, 1)), [2, 3, 4])


@pytest.mark.parametrize("order", "<>")
@pytest.mark.parametrize("code, kind", [(2, "u1"), (4, "i2"), (8, "i4"), (16, "f4"), (64, "f8"), (256, "i1"),
                                        (512, "u2"), (768, "u4"), (1024, "i8"), (1280, "u8")])  # fmt: skip
def test_every_type_and_byte_order_gives_the_values(tmp_path, order, code, kind):
    image = read_volume(written(tmp_path, "v.nii", nifti(VALUES.astype(kind), order, code)))
    assert (samples_of(image) == VALUES).all()


def test_slope_and_intercept_are_applied(tmp_path):
    image = read_volume(written(tmp_path, "v.nii", nifti(slope=0.5, inter=-3.0)))
    assert (samples_of(image) == VALUES * 0.5 - 3.0).all()


def test_values_are_those_of_vtks_reader(tmp_path):
    path = written(tmp_path, "v.nii", nifti(pixdim=(1, 2, 3, 4)))
    reader = vtkNIFTIImageReader()
    reader.SetFileName(str(path))
    reader.Update()
    assert (samples_of(reader.GetOutput()) == samples_of(read_volume(path))).all()


def test_nifti_2_and_series(tmp_path):
    header = bytearray(544)
    struct.pack_into("<i8s", header, 0, 540, b"n+2\0\r\n\032\n")
    struct.pack_into("<hh8q", header, 12, 4, 16, 3, *SHAPE, 1, 1, 1, 1)
    struct.pack_into("<q", header, 168, 544)
    struct.pack_into("<i", header, 348, 1)
    struct.pack_into("<12d", header, 400, *AFFINES["oblique"].ravel())
    image = read_volume(written(tmp_path, "two.nii", bytes(header) + VALUES.tobytes(order="F")))
    assert np.allclose(world_of(image, (3, 2, 1)), AFFINES["oblique"] @ [3, 2, 1, 1])
    series = np.stack([VALUES, VALUES + 100], axis=3)
    with pytest.warns(SurfaceSynthesisWarning, match="the first of 2 volumes is read"):
        image = read_volume(written(tmp_path, "series.nii", nifti(series)))
    assert (samples_of(image) == VALUES).all()


BAD_NIFTI = {
    "this is no NIfTI file": b"not at all" * 100,
    "does not begin with the length of such a header": b"",
    "is not marked as one": nifti(magic=b"abc\0"),
    "lie in two files": nifti(magic=b"ni1\0"),
    "the volume has 0 dimensions": nifti(dim=[0] * 8),
    "the volume has 9 dimensions": nifti(dim=[9] + [1] * 7),
    "has the dimensions 4, -3, 2": nifti(dim=[3, 4, -3, 2, 1, 1, 1, 1]),
    "has the dimensions 0, 3, 2": nifti(dim=[3, 0, 3, 2, 1, 1, 1, 1]),
    "there are 5 numbers at each voxel": nifti(dim=[5, 4, 3, 2, 1, 5, 1, 1]),
    "samples of the type 128 cannot be read": nifti(datatype=128),
    "gives 8 bits to samples of the type 4": nifti(bitpix=8),
    "cannot begin at byte 0": nifti(vox_offset=0.0),
    "cannot begin at byte nan": nifti(vox_offset=float("nan")),
    "cannot begin at byte 1e\\+30": nifti(vox_offset=1e30),
    "announces 48 bytes of samples, 47 follow": nifti()[:-1],
    "announces 70362301923326 bytes": nifti(dim=[3, 32767, 32767, 32767, 1, 1, 1, 1]),
    "the axes of the volume are sheared: the cosine": nifti(sform=[[1, 0.5, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]),
    "larger than 0 is needed": nifti(sform=np.zeros((3, 4))),
    "have the lengths nan": nifti(sform=np.full((3, 4), np.nan)),
    "is no rotation": nifti(qform=(1.0, 1.0, 1.0, 0, 0, 0)),
}


@pytest.mark.parametrize("text", BAD_NIFTI)
@pytest.mark.parametrize("suffix", [".nii", ".nii.gz"])
def test_bad_nifti_files_are_named(tmp_path, text, suffix):
    path = written(tmp_path, "bad" + suffix, BAD_NIFTI[text])
    with pytest.raises(FormatError, match=text) as caught:
        read_volume(path)
    assert str(path) in str(caught.value)


def test_every_truncation_and_many_changes_end_in_an_error_or_an_image(tmp_path, capfd):
    data = nifti(sform=AFFINES["oblique"])
    packed = gzip.compress(data)
    generator = np.random.default_rng(1)
    for length in list(range(0, 400, 7)):
        with pytest.raises(FormatError):
            read_volume(written(tmp_path, "cut.nii", data[:length]))
    for length in range(0, len(packed), 5):
        (tmp_path / "cut.nii.gz").write_bytes(packed[:length])
        try:
            read_volume(tmp_path / "cut.nii.gz")
        except FormatError:
            continue
    for _ in range(400):
        changed = bytearray(data if generator.integers(2) else packed)
        for place in generator.integers(0, len(changed), 3):
            changed[place] = generator.integers(256)
        (tmp_path / "changed.nii").write_bytes(bytes(changed))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                read_volume(tmp_path / "changed.nii")
            except FormatError:
                continue
    assert capfd.readouterr() == ("", "")


def flipped_oblique():
    """An affine whose axes are oblique, permuted and flipped, as scanners give them."""
    return np.column_stack([(rotation() * [-0.5, 0.75, 2.0])[:, [2, 0, 1]], [1.0, -2.0, 3.5]])


def in_lps(affine):
    return np.diag([-1.0, -1.0, 1.0]) @ affine


@pytest.mark.parametrize("space", ["RAS", "LPS", "file"])
def test_one_box_lies_in_one_place_whatever_its_format(tmp_path, space):
    affine = flipped_oblique()
    lps = in_lps(affine)
    spacing = np.linalg.norm(lps[:, :3], axis=0)
    listed = lambda numbers: " ".join(f"{number:.17g}" for number in np.ravel(numbers))  # noqa: E731
    vectors = lambda rows: " ".join("(" + ",".join(f"{x:.17g}" for x in row) + ")" for row in rows)  # noqa: E731
    files = {
        "RAS": written(tmp_path, "v.nii.gz", nifti(sform=affine)),
        "LPS": written(tmp_path, "v.mha", metaimage(
            ElementSpacing=listed(spacing), Offset=listed(lps[:, 3]),
            TransformMatrix=listed((lps[:, :3] / spacing).T))),
        "LPS ": written(tmp_path, "l.nrrd", nrrd(
            space_directions=vectors(lps[:, :3].T), space_origin=vectors([lps[:, 3]]))),
        "RAS ": written(tmp_path, "r.nrrd", nrrd(
            space="RAS", space_directions=vectors(affine[:, :3].T), space_origin=vectors([affine[:, 3]]))),
    }  # fmt: skip
    for written_in, path in files.items():
        found = written_in.strip() if space == "file" else space
        expected = affine if found == "RAS" else lps
        image = read_volume(path, space=space)
        assert (samples_of(image) == VALUES).all()
        for index in np.ndindex(SHAPE):
            assert np.abs(world_of(image, index) - expected @ [*index, 1.0]).max() < 1e-5, (path, index)


def test_an_oblique_flipped_scan_lies_where_nibabel_puts_it(tmp_path):
    nibabel = pytest.importorskip("nibabel")
    affine = np.vstack([flipped_oblique(), [0, 0, 0, 1]])
    image = nibabel.Nifti1Image(VALUES, affine)
    image.header.set_xyzt_units("mm")
    nibabel.save(image, str(tmp_path / "v.nii.gz"))
    expected = nibabel.load(str(tmp_path / "v.nii.gz"))
    found = read_volume(tmp_path / "v.nii.gz")
    assert (samples_of(found) == np.asarray(expected.dataobj)).all()
    for index in np.ndindex(SHAPE):
        assert np.abs(world_of(found, index) - nibabel.affines.apply_affine(expected.affine, index)).max() < 1e-5


def test_compressed_volumes_are_not_inflated_beyond_their_samples(tmp_path):
    packed = gzip.compress(nifti() + bytes(1 << 27), 1)
    (tmp_path / "v.nii.gz").write_bytes(packed)
    tracemalloc.start()
    try:
        assert (samples_of(read_volume(tmp_path / "v.nii.gz")) == VALUES).all()
        assert tracemalloc.get_traced_memory()[1] < 40e6  # a block of 16 MiB, twice
    finally:
        tracemalloc.stop()


def test_units_of_nifti_become_millimetres(tmp_path):
    for code, scale in ((0, 1.0), (2, 1.0), (1, 1000.0), (3, 1e-3), (2 + 8, 1.0), (3 + 16, 1e-3)):
        data = bytearray(nifti(sform=AFFINES["plain"]))
        data[123] = code
        image = read_volume(written(tmp_path, "v.nii", bytes(data)))
        assert np.allclose(world_of(image, (1, 1, 1)), scale * np.array([11, 22, 33])), code


def test_an_unknown_space_is_an_error(tmp_path):
    with pytest.raises(ValueError, match="space is 'ras'; one of RAS, LPS, file is needed"):
        read_volume(written(tmp_path, "v.nii", nifti()), space="ras")


def test_samples_that_are_not_finite_are_told(tmp_path):
    values = VALUES.astype(np.float32)
    values[1, 1, 1], values[2, 0, 0] = np.nan, np.inf
    with pytest.warns(SurfaceSynthesisWarning, match="v.nii: 2 of 24 samples are NaN or infinite"):
        read_volume(written(tmp_path, "v.nii", nifti(values, code=16)))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        read_volume(written(tmp_path, "v.nii", nifti(VALUES.astype(np.float32), code=16)))


def test_a_pipe_is_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "pipe.nii")
    with pytest.raises(FormatError, match="no regular file"):
        read_volume(tmp_path / "pipe.nii")


def metaimage(values=VALUES, data="LOCAL", **changes):
    fields = {"ObjectType": "Image", "NDims": 3, "BinaryData": "True", "DimSize": "4 3 2", "ElementSpacing": "1 2 3",
              "Offset": "10 20 30", "TransformMatrix": "0 1 0 -1 0 0 0 0 1", "ElementType": "MET_SHORT"}  # fmt: skip
    fields.update(changes)
    text = "".join(f"{key} = {value}\n" for key, value in fields.items() if value is not None)
    raw = values.tobytes(order="F")
    if fields.get("CompressedData") == "True":
        raw = zlib.compress(raw)
    return f"{text}ElementDataFile = {data}\n".encode() + (raw if data == "LOCAL" else b"")


@pytest.mark.parametrize("compressed", ["False", "True"])
def test_metaimages_lie_where_their_header_says(tmp_path, compressed):
    image = read_volume(written(tmp_path, "v.mha", metaimage(CompressedData=compressed)), space="file")
    assert (samples_of(image) == VALUES).all()
    # The first axis points along y, the second along -x.
    assert np.allclose(world_of(image, (1, 1, 1)), [10 - 2, 20 + 1, 30 + 3])
    (tmp_path / "v.raw").write_bytes(VALUES.tobytes(order="F"))
    image = read_volume(written(tmp_path, "v.mhd", metaimage(data="v.raw")))
    assert (samples_of(image) == VALUES).all()


def test_bytes_before_the_samples_of_a_metaimage_are_skipped(tmp_path):
    raw = VALUES.tobytes(order="F")
    for size, before in ((7, 7), (-1, 13), (0, 0)):  # -1: the samples end the file
        (tmp_path / "v.raw").write_bytes(b"\xff" * before + raw)
        image = read_volume(written(tmp_path, "v.mhd", metaimage(data="v.raw", HeaderSize=size)))
        assert (samples_of(image) == VALUES).all(), size


BAD_METAIMAGES = {
    "no field ElementDataFile": b"\x00\x01binary",
    "no field DimSize": metaimage(DimSize=None),
    "has 1 dimensions": metaimage(DimSize="24"),
    "are no numbers": metaimage(DimSize="4 three 2"),
    "has the dimensions 4, 0, 2": metaimage(DimSize="4 0 2"),
    "DimSize has a number of 400 digits; numbers below 2\\^31": metaimage(DimSize=f"4 {'9' * 400} 2"),
    "there are 3 numbers at each voxel": metaimage(ElementNumberOfChannels=3),
    "samples of the type 'MET_NONE'": metaimage(ElementType="MET_NONE"),
    "announces 48 bytes of samples, 40 follow": metaimage()[:-8],
    "ElementSpacing has 2 numbers; 3 are needed": metaimage(ElementSpacing="1 2"),
    "sheared": metaimage(TransformMatrix="1 0 0 1 1 0 0 0 1"),
    "or a file in the same folder is needed": metaimage(data="../secret.raw"),
    "the file gone.raw with the samples is missing": metaimage(data="gone.raw"),
    "samples as text cannot be read": metaimage(BinaryData="False"),
    "HeaderSize = -2 is no place": metaimage(HeaderSize=-2),
}


@pytest.mark.parametrize("text", BAD_METAIMAGES)
def test_bad_metaimages_are_named(tmp_path, text):
    with pytest.raises(FormatError, match=text):
        read_volume(written(tmp_path, "bad.mha", BAD_METAIMAGES[text]))


def nrrd(values=VALUES, **changes):
    fields = {"type": "int16", "dimension": 3, "space": "left-posterior-superior", "sizes": "4 3 2", "encoding": "raw",
              "space directions": "(0,1,0) (-2,0,0) (0,0,3)", "space origin": "(10,20,30)", "endian": "little"}  # fmt: skip
    fields.update({key.replace("_", " "): value for key, value in changes.items()})
    text = "".join(f"{key}: {value}\n" for key, value in fields.items() if value is not None)
    raw = values.tobytes(order="F")
    return f"NRRD0004\n# a comment\n{text}\n".encode() + (gzip.compress(raw) if fields["encoding"] == "gzip" else raw)


@pytest.mark.parametrize("encoding", ["raw", "gzip"])
def test_nrrd_files_lie_where_their_header_says(tmp_path, encoding):
    image = read_volume(written(tmp_path, "v.nrrd", nrrd(encoding=encoding)), space="file")
    assert (samples_of(image) == VALUES).all()
    assert np.allclose(world_of(image, (1, 1, 1)), [10 - 2, 20 + 1, 30 + 3])


@pytest.mark.parametrize(
    "fields, first, step",
    [
        ({"spacings": "1 2 3", "axis_mins": "5 6 7", "centers": "node node node"}, (5, 6, 7), (1, 2, 3)),
        ({"spacings": "1 2 3", "axis_mins": "5 6 7", "centers": "cell node cell"}, (5.5, 6, 8.5), (1, 2, 3)),
        ({"axis_mins": "0 0 0", "axis_maxs": "6 4 5", "centers": "node node node"}, (0, 0, 0), (2, 2, 5)),
        ({"axis_mins": "0 0 0", "axis_maxs": "4 6 8"}, (0.5, 1, 2), (1, 2, 4)),
        ({"axis_mins": "4 6 8", "axis_maxs": "0 0 0"}, (3.5, 5, 6), (-1, -2, -4)),
        ({"spacings": "-1 2 3"}, (0, 0, 0), (1, 2, 3)),
        ({"spacings": "1 nan 3"}, (0, 0, 0), (1, 1, 3)),
    ],
)
def test_axes_of_nrrd_files_without_directions(tmp_path, fields, first, step):
    data = nrrd(space=None, space_directions=None, space_origin=None, **fields)
    image = read_volume(written(tmp_path, "v.nrrd", data))
    assert np.allclose(world_of(image, (0, 0, 0)), first)
    assert np.allclose(world_of(image, (1, 1, 1)), np.add(first, step))


BAD_NRRD = {
    "this is no NRRD file": b"NRRD",
    "samples of the type 'block'": nrrd(type="block"),
    "the field 'sizes' has no numbers": nrrd(sizes="4 -3 2"),
    "the field 'sizes' has a number of 400 digits; numbers below 2\\^31": nrrd(sizes=f"4 {'9' * 400} 2"),
    "has 2 dimensions": nrrd(sizes="4 3"),
    "in the encoding 'bzip2'": nrrd(encoding="bzip2"),
    "lie in another file": nrrd(data_file="v.raw"),
    "cut off": nrrd()[:-3],
    "vectors of 3 numbers are needed": nrrd(space_directions="(1,0) (0,1) (0,0)"),
    "is no vector": nrrd(space_origin="(a,b,c)"),
    "2 space directions; 3 are needed": nrrd(space_directions="(1,0,0) (0,1,0)"),
    "the axis mins '1 2' are not 3 numbers": nrrd(space_directions=None, axis_mins="1 2"),
    "sheared": nrrd(space_directions="(1,0,0) (1,1,0) (0,0,1)"),
}


@pytest.mark.parametrize("text", BAD_NRRD)
def test_bad_nrrd_files_are_named(tmp_path, text):
    with pytest.raises(FormatError, match=text):
        read_volume(written(tmp_path, "bad.nrrd", BAD_NRRD[text]))


def test_vti_files_and_other_names(tmp_path, capfd):
    from vtkmodules.vtkIOXML import vtkXMLImageDataWriter

    image = read_volume(written(tmp_path, "v.nii", nifti(sform=AFFINES["oblique"])))
    writer = vtkXMLImageDataWriter()
    writer.SetFileName(str(tmp_path / "v.vti"))
    writer.SetInputData(image)
    writer.Write()
    again = read_volume(tmp_path / "v.vti")
    assert (samples_of(again) == VALUES).all()
    assert np.allclose(world_of(again, (3, 2, 1)), world_of(image, (3, 2, 1)))
    data = (tmp_path / "v.vti").read_bytes()
    with pytest.raises(FormatError):
        read_volume(written(tmp_path, "cut.vti", data[: len(data) // 3]))
    with pytest.raises(ValueError, match="no name of a volume"):
        read_volume(tmp_path / "v.png")
    with pytest.raises(FileNotFoundError):
        read_volume(tmp_path / "gone.nii.gz")
    assert capfd.readouterr() == ("", "")


def test_a_build_without_openvdb_says_so():
    code = """
    import sys, types
    from vtkmodules.vtkCommonCore import vtkObject
    meshing = types.ModuleType("surfacesynthesis.vtkSurfaceSynthesisMeshing")  # as it is without OpenVDB, CGAL and TetGen
    meshing.vtkTopologyReport = meshing.vtkLabelSurfaceFilter = vtkObject
    meshing.vtkDisplacementMapFilter = types.SimpleNamespace(OBJECT=0, TANGENT=1, AUTOMATIC=0, NORMALS=1)
    sys.modules["surfacesynthesis.vtkSurfaceSynthesisMeshing"] = meshing
    import surfacesynthesis
    assert not hasattr(surfacesynthesis, "vtkVDBSurfaceFilter")
    try:
        surfacesynthesis.vdb_surface(None)
    except surfacesynthesis.SurfaceSynthesisError as error:
        assert "no OpenVDB" in str(error)
    else:
        sys.exit("no error")
    """
    done = subprocess.run([sys.executable, "-c", textwrap.dedent(code)], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, ""), done


HEAD = "/usr/share/mricron/templates/ch2bet.nii.gz"


@pytest.mark.skipif(not os.path.exists(HEAD), reason="mricron-data is not installed")
def test_a_brain_becomes_a_closed_surface_in_scanner_coordinates():
    brain = read_volume(HEAD)
    # The rows of its sform: (1, 0, 0, -90), (0, 1, 0, -125), (0, 0, 1, -71).
    assert brain.GetDimensions() == (181, 217, 181)
    assert np.allclose(world_of(brain, (0, 0, 0)), [-90, -125, -71])
    surface = surfacesynthesis.vdb_surface(brain, voxel_size=3.0, largest_component=True, fill_cavities=True)
    bounds = np.array(surface.GetBounds()).reshape(3, 2)
    assert (np.ptp(bounds, axis=1) > [120, 150, 100]).all() and (np.ptp(bounds, axis=1) < [160, 200, 160]).all()

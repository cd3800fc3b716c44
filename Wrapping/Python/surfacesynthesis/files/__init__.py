# SPDX-License-Identifier: BSD-3-Clause
"""Reads and writes meshes: STL, PLY, OBJ, OFF, glTF, GIFTI, VTK's XML and legacy formats, VTM for composite datasets;
reads FreeSurfer's surfaces. Reads volumes: NIfTI, DICOM, MGH, MetaImage, NRRD and VTK's XML images."""

import os
import shutil
import stat
import tempfile
import warnings

import numpy as np
from vtkmodules.vtkCommonCore import vtkStringArray
from vtkmodules.vtkCommonDataModel import (
    vtkCompositeDataSet,
    vtkDataObjectTree,
    vtkImageData,
    vtkMultiBlockDataSet,
    vtkPolyData,
    vtkUnstructuredGrid,
)
from vtkmodules.vtkIOGeometry import vtkSTLReader, vtkSTLWriter
from vtkmodules.vtkIOLegacy import vtkGenericDataObjectReader, vtkGenericDataObjectWriter
from vtkmodules.vtkIOXML import (
    vtkXMLImageDataReader,
    vtkXMLMultiBlockDataReader,
    vtkXMLMultiBlockDataWriter,
    vtkXMLPolyDataReader,
    vtkXMLPolyDataWriter,
    vtkXMLUnstructuredGridReader,
    vtkXMLUnstructuredGridWriter,
)
from vtkmodules.vtkFiltersCore import vtkTriangleFilter

from ..errors import FormatError, SurfaceSynthesisError, SurfaceSynthesisWarning
from ..pipeline import HeldSignals, silent_console
from ..supervision import unfinished_name
from .corners import SEAMS
from .dicom import read_dicom
from .freesurfer import SURFACES, VALUES, read_mgh, read_surface, read_values
from .gifti import read_gifti, read_gifti_values, write_gifti
from .gltf import read_gltf, write_gltf
from .metaimage import read_metaimage
from .nifti import read_nifti
from .nrrd import read_nrrd
from .obj import read_obj, write_obj
from .off import read_off, write_off
from .ply import read_ply, write_ply
from .optional import nibabel_of
from .polygons import add_array, from_polydata, named_by_role, to_polydata
from .volumes import SPACES, to_image, with_array
from .vtk_xml import check_vtk_xml

#: Extensions that read_mesh() and write_mesh() know, with their readers and writers.
FORMATS = {
    ".stl": "STL, text or binary",
    ".ply": "PLY, text or binary",
    ".obj": "Wavefront OBJ",
    ".off": "Object File Format",
    ".vtp": "VTK XML polydata",
    ".vtu": "VTK XML unstructured grid",
    ".vtk": "VTK legacy polydata, unstructured grid or multi-block dataset",
    ".vtm": "VTK XML multi-block dataset",
    ".gii": "GIFTI, with nibabel",
    ".glb": "glTF 2.0, binary",
    ".gltf": "glTF 2.0, text",
    **{kind: "FreeSurfer surface, with nibabel; read only" for kind in SURFACES},
}
#: Extensions that read_volume() knows, with their readers.
VOLUME_FORMATS = {
    ".nii": "NIfTI",
    ".nii.gz": "NIfTI, compressed",
    ".mha": "MetaImage",
    ".mhd": "MetaImage with the samples in a file of their own",
    ".nrrd": "NRRD",
    ".vti": "VTK XML image data",
    ".mgh": "FreeSurfer volume, with nibabel",
    ".mgz": "FreeSurfer volume, compressed, with nibabel",
    ".dcm": "DICOM, one file, with GDCM; a folder is a series",
}
#: Formats without room for point arrays (OBJ has texture coordinates, normals and colors only).
GEOMETRY_ONLY = (".stl", ".obj", ".off")

#: Readers and writers of a PolygonMesh; those with texture coordinates at the corners of faces.
_READ = {".off": read_off, ".gii": read_gifti, **dict.fromkeys(SURFACES, read_surface)}
_READ_WITH_SEAMS = {".obj": read_obj, ".ply": read_ply}
_WRITE = {".obj": write_obj, ".off": write_off, ".ply": write_ply, ".gii": write_gifti}
_WRITE_SCENE = (".glb", ".gltf")
_READ_VOLUME = {
    ".nii": read_nifti, ".nii.gz": read_nifti, ".mha": read_metaimage, ".mhd": read_metaimage, ".nrrd": read_nrrd,
    ".mgh": read_mgh, ".mgz": read_mgh,
}  # fmt: skip


def extension(path):
    """The extension of a file name in lower case; raises ValueError when it is none of FORMATS."""
    found = os.path.splitext(os.fspath(path))[1].lower()
    if found not in FORMATS:
        known = ", ".join(sorted(FORMATS))
        raise ValueError(f"{os.fspath(path)}: the extension '{found}' is not known; use one of {known}")
    return found


def volume_extension(path):
    """The extension of a volume's file name in lower case, ".dcm" for a folder, or None when it is none of
    VOLUME_FORMATS."""
    name = os.fspath(path).lower()
    if os.path.isdir(name):
        return ".dcm"
    return next((kind for kind in VOLUME_FORMATS if name.endswith(kind)), None)


def require_file(path):
    """Raises OSError, in the operating system's own words, when a file is missing or unreadable, and FormatError when it
    is none: a pipe would be waited for, a device read without end."""
    mode = os.stat(path).st_mode
    if not stat.S_ISREG(mode) and not stat.S_ISDIR(mode):
        raise FormatError(f"{path}: this is no regular file, but a pipe, socket or device")
    with open(path, "rb"):
        pass


def read_volume(path, space="RAS", array=None, series=None):
    """Reads a volume: a vtkImageData with the point scalars "Scalars" (.vti: its own arrays), whose origin, spacing and
    direction matrix map samples to world coordinates.

    ``space`` is that of the world coordinates: "RAS" (default; x to the patient's right, y to the front, z upwards, as
    NIfTI has it), "LPS" (x to the left, y to the back, as DICOM and ITK have it) or "file" (those of the file). Files
    that do not say whose right is meant stay as they are: .vti, and NRRD without the field ``space``. MetaImages are
    LPS, as ITK writes them.

    ``array`` is the name of the array of a .vti file that becomes the scalars. Values of cells become values of points at
    the centers of the cells; without a name those of the points come first. ``series`` is the number or the UID of a
    DICOM series, for folders with several.

    NIfTI's sform is used where there is one, else its qform; its metres and micrometres become millimetres. Slices of
    DICOM lie by their positions, with the slope and intercept of each. The format follows from the extension;
    VOLUME_FORMATS lists them; a folder is a DICOM series. Warns of samples that are not finite. Raises ValueError for
    another extension, space, array or series, OSError when the file cannot be opened, SurfaceSynthesisError when nibabel or GDCM is needed
    and not installed, and FormatError when the file does not follow its format, is cut off, is no regular file, has
    more than one number per voxel or axes that are sheared.
    """
    path = os.fspath(path)
    if space not in SPACES:
        raise ValueError(f"space is {space!r}; one of {', '.join(SPACES)} is needed")
    kind = volume_extension(path)
    if kind is None:
        known = ", ".join(VOLUME_FORMATS)
        raise ValueError(f"{path}: this is no name of a volume; it ends with one of {known}, or is a folder")
    if array is not None and kind != ".vti":
        raise ValueError(f"{path}: array chooses among the arrays of .vti files; this one has no names")
    if series is not None and kind != ".dcm":
        raise ValueError(f"{path}: series chooses among the DICOM series in a folder")
    if kind == ".dcm":
        if not os.path.isdir(path):
            require_file(path)
        return to_image(path, read_dicom(path, series), space)
    require_file(path)
    if kind == ".vti":
        check_vtk_xml(path)
        return with_array(path, _read_with_vtk(vtkXMLImageDataReader(), path, (vtkImageData,)), array)
    return to_image(path, _READ_VOLUME[kind](path), space)


def read_mesh(path, seams="join", point_data=()):
    """Reads a mesh: a vtkPolyData; a vtkUnstructuredGrid from .vtu, a vtkMultiBlockDataSet from .vtm, either from .vtk; a
    vtkMultiBlockDataSet from glTF with several meshes.

    The format follows from the extension; FORMATS lists them. Corners of STL triangles with the same coordinates become
    one point. Normals, texture coordinates and colors of OBJ, PLY and glTF are the point arrays "Normals", "TCoords" and
    "RGB" or "RGBA"; of several normals at a point the mean is kept. ``seams`` says what becomes of points with several
    texture coordinates, in OBJ and PLY: "join" (default) keeps one point with the first of them, and warns; "split" makes
    a point of each, which opens the surface there. FreeSurfer's surfaces are moved to the scanner coordinates of the
    volume that they describe.

    ``point_data`` are files with values of the points, which become point arrays: GIFTI (.func.gii, .shape.gii,
    .label.gii) or FreeSurfer's (.area .curv .sulc .thickness .volume). Labels are numbers; the arrays "<name>LabelNames" and
    "<name>LabelValues" of the field data hold the table of their names.

    Raises ValueError for another extension, OSError when a file cannot be opened, SurfaceSynthesisError when nibabel is
    needed and not installed, and FormatError, with the file and where possible the line, when it does not follow its
    format or is no regular file.
    """
    path = os.fspath(path)
    if seams not in SEAMS:
        raise ValueError(f"seams is {seams!r}; one of {', '.join(SEAMS)} is needed")
    mesh = _read_mesh(path, extension(path), seams)
    for source in (point_data,) if isinstance(point_data, (str, os.PathLike)) else point_data:
        _add_point_data(mesh, path, os.fspath(source))
    return mesh


def _read_mesh(path, kind, seams):
    require_file(path)
    if kind in _READ:
        return to_polydata(_READ[kind](path))
    if kind in _READ_WITH_SEAMS:
        return to_polydata(_READ_WITH_SEAMS[kind](path, seams))
    if kind in (".glb", ".gltf"):
        return _blocks(path, read_gltf(path))
    if kind == ".stl":
        _check_binary_stl(path)
    elif kind == ".vtk":
        _check_legacy(path)
    else:
        check_vtk_xml(path)
    reader = {
        ".stl": vtkSTLReader,
        ".vtp": vtkXMLPolyDataReader,
        ".vtu": vtkXMLUnstructuredGridReader,
        ".vtm": vtkXMLMultiBlockDataReader,
        ".vtk": vtkGenericDataObjectReader,
    }[kind]()
    return _read_with_vtk(reader, path)


def _blocks(path, meshes):
    """The vtkPolyData of the only mesh, or a vtkMultiBlockDataSet."""
    if not meshes:
        raise FormatError(f"{path}: the scene has no triangles")
    if len(meshes) == 1:
        return to_polydata(meshes[0][1])
    blocks = vtkMultiBlockDataSet()
    for number, (name, mesh) in enumerate(meshes):
        blocks.SetBlock(number, to_polydata(mesh))
        blocks.GetMetaData(number).Set(vtkCompositeDataSet.NAME(), name)
    return blocks


def _add_point_data(mesh, path, source):
    """Adds the values of points in a file as point arrays."""
    require_file(source)
    if isinstance(mesh, vtkDataObjectTree):
        raise ValueError(f"{path}: values of points are for one surface, not for a composite dataset")
    name = os.path.basename(source)
    kind = os.path.splitext(name)[1].lower()
    labels = {}
    if kind == ".gii":
        arrays, labels = read_gifti_values(source, mesh.GetNumberOfPoints())
    elif kind in VALUES:
        arrays = {kind[1:]: read_values(source, mesh.GetNumberOfPoints())}
    else:
        raise ValueError(f"{source}: values of points are read from .gii, {', '.join(VALUES)}")
    for name, values in arrays.items():
        add_array(mesh.GetPointData(), name, values)
        if name in labels:
            _add_labels(mesh, name, labels[name])


def _add_labels(mesh, name, labels):
    """Adds the names of labels and their values as arrays of the field data."""
    names = vtkStringArray()
    names.SetName(f"{name}LabelNames")
    for text in labels.values():
        names.InsertNextValue(text)
    mesh.GetFieldData().AddArray(names)
    add_array(mesh.GetFieldData(), f"{name}LabelValues", np.array([*labels], dtype=np.int32))


def _read_with_vtk(reader, path, expected=(vtkPolyData, vtkUnstructuredGrid, vtkDataObjectTree)):
    reader.SetFileName(path)
    with silent_console() as collected:
        reader.Update()
        errors, remarks = collected()
    # VTK's legacy reader reports unreadable numbers as warnings, and returns arrays that were never filled
    errors += [text for text in remarks if "rror reading" in text]
    if errors or reader.GetErrorCode():
        texts = dict.fromkeys(errors) or ["the file cannot be read"]  # each once, in order
        raise FormatError(*[f"{path}: {text}" for text in texts])
    output = reader.GetOutputDataObject(0)
    if not isinstance(output, expected):
        found = output.GetClassName() if output is not None else "nothing"
        wanted = [kind.__name__.replace("vtkDataObjectTree", "vtkMultiBlockDataSet") for kind in expected]
        raise FormatError(f"{path}: expected {' or '.join(wanted)}, found {found}")
    for text in remarks:
        warnings.warn(f"{path}: {text}", SurfaceSynthesisWarning, stacklevel=3)
    result = output.NewInstance()
    result.ShallowCopy(output)
    return result


def _check_binary_stl(path):
    """vtkSTLReader takes any bytes for a binary STL file, so the length is compared with the number of triangles."""
    size = os.path.getsize(path)
    with open(path, "rb") as file:
        head = file.read(84)
    is_text = head.lstrip()[:5].lower() == b"solid"
    expected = 84 + 50 * int.from_bytes(head[80:84], "little")
    if is_text and size != expected:
        return  # vtkSTLReader checks every line
    if len(head) < 84 or size < expected:
        raise FormatError(f"{path}: this is no complete STL file: {size} bytes, where {expected} are announced")


def _check_legacy(path):
    """vtkGenericDataObjectReader quotes what it cannot read, which is of no use when it is binary."""
    with open(path, "rb") as file:
        head = file.read(14)
    if head != b"# vtk DataFile":
        raise FormatError(f"{path}:1: a legacy VTK file starts with '# vtk DataFile'")


def check_writable(mesh, path):
    """Raises TypeError, ValueError or OSError when ``mesh`` cannot go to ``path``: no dataset, unknown extension, a
    composite dataset for a format of one surface, a folder that does not exist or cannot be written to. Leaves nothing
    behind."""
    if not isinstance(mesh, (vtkPolyData, vtkUnstructuredGrid, vtkDataObjectTree)):
        raise TypeError(
            "mesh must be a vtkPolyData, a vtkUnstructuredGrid or a vtkMultiBlockDataSet, not "
            f"{getattr(mesh, 'GetClassName', lambda: type(mesh).__name__)()}"
        )
    kind = extension(path)
    path = os.path.realpath(path)
    if kind in SURFACES:
        raise ValueError(f"{path}: {kind} can be read, but not written; use .gii")
    if kind == ".gii":
        nibabel_of("GIFTI files")
    composite = isinstance(mesh, vtkDataObjectTree)
    if composite and kind not in (".vtm", ".vtk", *_WRITE_SCENE):
        raise ValueError(f"{path}: a composite dataset can be written to .vtm, .vtk, .glb or .gltf only")
    if composite and kind in _WRITE_SCENE and not all(isinstance(item, vtkPolyData) for item in _leaves(mesh)):
        raise ValueError(f"{path}: of composite datasets only those of vtkPolyData can be written to {kind}")
    grid = isinstance(mesh, vtkUnstructuredGrid)
    if grid and kind not in (".vtu", ".vtk"):
        raise ValueError(f"{path}: an unstructured grid can be written to .vtu or .vtk only")
    if not grid and kind == ".vtu":
        raise ValueError(f"{path}: .vtu is for unstructured grids; use .vtp")
    if not composite and kind == ".vtm":
        raise ValueError(f"{path}: .vtm is for composite datasets; use .vtp")
    if composite and not isinstance(mesh, vtkMultiBlockDataSet):
        raise ValueError(f"{path}: of composite datasets only vtkMultiBlockDataSet can be written")
    folder = os.path.dirname(path)
    if not os.path.isdir(folder):
        raise FileNotFoundError(f"the folder {folder} does not exist")
    try:
        os.rmdir(temporary_folder(folder))
    except OSError as error:
        raise OSError(f"the folder {folder} is not writable: {error.strerror}") from None
    if os.path.exists(path) and not os.path.isfile(path):
        raise IsADirectoryError(f"{path} exists and is not a file")


def write_mesh(mesh, path):
    """Writes a vtkPolyData, a vtkUnstructuredGrid to .vtu or .vtk, or a vtkMultiBlockDataSet to .vtm, .vtk, .glb or .gltf;
    the format follows from the extension.

    PLY, GIFTI and glTF keep all point arrays (glTF those of up to four components), OBJ texture coordinates, normals and
    the array "RGB"; STL and OFF keep the shape only. STL, GIFTI and glTF have triangles, in single precision. The file
    appears under its name when it is complete: until then, and after a failure, a file that was there before stays as it
    was. Raises TypeError for other data, ValueError, OSError, or SurfaceSynthesisError with VTK's text.
    """
    write_meshes([(mesh, path)])


def write_meshes(meshes):
    """write_mesh() for several pairs (mesh, path); none appears unless all could be written."""
    meshes = [(mesh, os.path.realpath(path)) for mesh, path in meshes]
    for mesh, path in meshes:
        check_writable(mesh, path)
    folders, moves = [], []
    try:
        for mesh, path in meshes:
            folders.append(temporary_folder(os.path.dirname(path)))
            try:
                moves += _write(mesh, os.path.join(folders[-1], os.path.basename(path)), os.path.dirname(path))
            except OSError as error:  # which knows no file, or the temporary one
                raise OSError(error.errno, error.strerror, path) from None
        for source, target in moves:
            os.makedirs(os.path.dirname(target), exist_ok=True)
            os.replace(source, target)
    finally:
        for folder in folders:
            shutil.rmtree(folder, ignore_errors=True)


def temporary_folder(folder):
    """A new folder beside the file to be written, so that the file can be moved to its name and is never copied."""
    path = unfinished_name(folder)
    os.mkdir(path, 0o700)
    return path


def _write(mesh, path, folder):
    """Writes ``path`` and returns what to move into ``folder``, the pieces of a composite dataset before its index."""
    kind = extension(path)
    if kind in _WRITE:
        arrays = from_polydata(named_by_role(mesh), triangles=kind == ".gii")
        with open(path, "wb") as file:
            _WRITE[kind](arrays, file)
    elif kind in _WRITE_SCENE:
        leaves = _leaves(mesh) if isinstance(mesh, vtkDataObjectTree) else [mesh]
        arrays = [from_polydata(named_by_role(item), triangles=True) for item in leaves]
        with open(path, "wb") as file:
            write_gltf([(f"Mesh {k}", item) for k, item in enumerate(arrays)], file, kind == ".glb")
    elif kind == ".stl" and mesh.GetNumberOfPolys() + mesh.GetNumberOfStrips() == 0:
        with open(path, "wb") as file:  # vtkSTLWriter refuses
            file.write(bytes(84))
    elif kind == ".stl":
        _write_with_vtk(vtkSTLWriter(), _triangles(mesh), path)
    elif kind == ".vtm":
        _write_with_vtk(vtkXMLMultiBlockDataWriter(), mesh, path)
    elif kind == ".vtu":
        _write_with_vtk(vtkXMLUnstructuredGridWriter(), mesh, path)
    elif kind == ".vtp":
        _write_with_vtk(vtkXMLPolyDataWriter(), mesh, path)
    else:
        _write_with_vtk(vtkGenericDataObjectWriter(), mesh, path)
    written = [os.path.join(top, name) for top, _, names in os.walk(os.path.dirname(path)) for name in names]
    for name in written:
        with open(name, "rb+") as file:
            os.fsync(file.fileno())
    written.sort(key=lambda name: name == path)
    return [(name, os.path.join(folder, os.path.relpath(name, os.path.dirname(path)))) for name in written]


def _leaves(mesh):
    """The datasets in a composite dataset."""
    iterator = mesh.NewTreeIterator()
    iterator.InitTraversal()
    found = []
    while not iterator.IsDoneWithTraversal():
        found.append(iterator.GetCurrentDataObject())
        iterator.GoToNextItem()
    return found


def _require_space(folder, size):
    """Raises the OSError of a full disk, or of a limit of file sizes, when a file of this size cannot be written."""
    with tempfile.TemporaryFile(dir=folder) as file:
        os.posix_fallocate(file.fileno(), 0, max(size, 1))


def _triangles(mesh):
    triangulate = vtkTriangleFilter()
    triangulate.SetInputData(mesh)
    triangulate.PassVertsOff()
    triangulate.PassLinesOff()
    triangulate.Update()
    return triangulate.GetOutput()


def _write_with_vtk(writer, mesh, path):
    writer.SetFileName(path)
    writer.SetInputData(mesh)
    if hasattr(writer, "SetFileTypeToBinary"):
        writer.SetFileTypeToBinary()
    if hasattr(writer, "SetCompressorTypeToLZ4"):  # ten times as fast as ZLib, and noise hardly shrinks with either
        writer.SetCompressorTypeToLZ4()
        # Inline: ParaView 5.11 with Debian 12's Expat cannot read data that are appended. VTK's writer of inline data
        # crashes when the disk is full.
        writer.SetDataModeToBinary()
        _require_space(os.path.dirname(path), mesh.GetActualMemorySize() * 1024)
    with HeldSignals() as signals, silent_console() as collected:
        writer.AddObserver(
            "ProgressEvent", lambda sender, _: sender.SetAbortExecute(0 if signals.pending is None else 1)
        )
        written = writer.Write()
        errors, _ = collected()
    signals.deliver()
    if errors or not written or writer.GetErrorCode() or not os.path.isfile(path):
        _require_space(os.path.dirname(path), mesh.GetActualMemorySize() * 1024)
        raise SurfaceSynthesisError(*errors or [f"{path} could not be written; is the disk full?"])

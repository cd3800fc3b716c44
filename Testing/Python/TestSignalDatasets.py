# SPDX-License-Identifier: BSD-3-Clause
"""poses(), gaussian_mixtures(), dataset files, and the command ``dataset``."""

import importlib.util
import json
import pathlib
import resource

import numpy as np
import pytest
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkFiltersSources import vtkSphereSource

import surfacesynthesis
from surfacesynthesis import (
    Cancelled,
    FormatError,
    SurfaceSynthesisError,
    SurfaceSynthesisWarning,
    gaussian_mixtures,
    poses,
    read_signal_dataset,
    write_mesh,
    write_signal_dataset,
)
from surfacesynthesis.command_line import main
from surfacesynthesis.datasets import given_dataset
from surfacesynthesis.pipeline import apply_filter

needs_cgal = pytest.mark.skipif(not hasattr(surfacesynthesis, "vtkPoseEnsembleFilter"), reason="built without CGAL")


@pytest.fixture
def ball():
    source = vtkSphereSource()
    source.SetThetaResolution(20)
    source.SetPhiResolution(20)
    source.Update()
    return source.GetOutput()


@pytest.fixture
def pair(ball):
    points = vtk_to_numpy(ball.GetPoints().GetData()).astype(np.float64)
    return points, vtk_to_numpy(ball.GetPolys().GetConnectivityArray()).reshape(-1, 3)


@needs_cgal
def test_poses_are_positions_and_the_same_alone_and_in_a_batch(ball, pair):
    before = pair[0].copy()
    made = poses(pair, 5, seed=2)
    assert made.shape == (5, len(pair[0]), 3) and made.dtype == np.float64
    assert np.array_equal(poses(pair, 1, seed=2, first_sample=3)[0], made[3])
    assert np.array_equal(pair[0], before)
    assert np.abs(made - before).max() > 0.01  # and something moves
    assert poses(ball, 1).dtype == np.float32  # the precision of the points


@needs_cgal
def test_poses_in_parts_are_the_poses_together(pair, monkeypatch):
    together = poses(pair, 5)
    monkeypatch.setattr("surfacesynthesis.sampling.TOGETHER", 2)
    fractions = []
    assert np.array_equal(poses(pair, 5, progress=fractions.append), together)
    assert fractions == sorted(fractions) and fractions[-1] == 1.0


@needs_cgal
def test_a_template_gives_the_handles(pair):
    assert np.array_equal(poses(pair, 2, template=pair), poses(pair, 2))
    with pytest.raises(SurfaceSynthesisError, match="The template: "):
        poses(pair, 1, template=(pair[0], pair[1][:, [0, 0, 1]]))


@needs_cgal
@pytest.mark.parametrize(
    "parameters, text",
    [
        ({"samples": 0}, "samples must be from 1"),
        ({"first_sample": 2**31 - 1}, "first_sample \\+ samples must be at most"),
        ({"handles": 101}, "handles must be at most 100"),
        ({"maximum_angle": 181.0}, "maximum_angle must be from 0 to 180"),
        ({"maximum_twist": -1.0}, "maximum_twist must be from 0 to 180"),
        ({"handle_radius": 0.0}, "handle_radius must be from 0.001 to 1"),
        ({"anchor_radius": 2.0}, "anchor_radius must be from 0.001 to 1"),
        ({"pivot_position": 1.1}, "pivot_position must be from 0 to 1"),
        ({"iterations": 0}, "iterations must be from 1"),
        ({"stiffness": float("nan")}, "stiffness must be from 0 to 1"),
    ],
)
def test_poses_refuses_arguments_out_of_range(pair, parameters, text):
    with pytest.raises(ValueError, match=text):
        poses(pair, **{"samples": 2, **parameters})


@needs_cgal
def test_more_poses_than_fit_are_refused(pair):
    with pytest.raises(SurfaceSynthesisError, match=r"A NumberOfSamples of \d+ fits"):
        poses(pair, 2**31 - 1)
    algorithm = surfacesynthesis.vtkPoseEnsembleFilter()
    algorithm.SetNumberOfSamples(2**31 - 1)
    algorithm.SetMemoryLimit(1)
    with pytest.raises(SurfaceSynthesisError, match="at most 0.000976562 GiB") as error:
        apply_filter(algorithm, given_dataset(pair))
    algorithm.SetNumberOfSamples(int(str(error.value).split("A NumberOfSamples of ")[1].split()[0]))
    block = apply_filter(algorithm, given_dataset(pair))[0].GetBlock(0)
    assert block.GetPointData().GetVectors().GetName() == "Displacement"


@needs_cgal
def test_poses_names_what_is_wrong_with_the_mesh(pair):
    with pytest.raises(SurfaceSynthesisError, match="vtkSurfaceRepairFilter"):
        poses((pair[0], np.concatenate((pair[1], pair[1][:1]))), 1)
    with pytest.raises(SurfaceSynthesisError, match="empty"):
        poses((np.zeros((0, 3)), np.zeros((0, 3), dtype=int)), 1)
    with pytest.raises(Cancelled):
        poses(pair, 3, progress=lambda fraction: False)


def test_mixtures_are_bumps_of_height_1(pair):
    made = gaussian_mixtures(pair, 20, seed=4)
    assert made.shape == (20, len(pair[0])) and made.dtype == np.float64
    assert made.min() >= 0.0 and np.all((made.max(axis=1) >= 1.0) & (made.max(axis=1) < 1.01))
    assert np.array_equal(gaussian_mixtures(pair, 1, seed=4, first_sample=7)[0], made[7])
    assert len(np.unique(made, axis=0)) == 20
    wide = gaussian_mixtures(pair, 20, seed=4, centers=1, gaussian_width=0.2)
    assert wide.mean() > made.mean() / 3
    with pytest.warns(DeprecationWarning, match="keyword centres of gaussian_mixtures.*: use centers"):
        assert np.array_equal(gaussian_mixtures(pair, 20, seed=4, centres=1, gaussian_width=0.2), wide)


@pytest.mark.parametrize(
    "parameters, text",
    [
        ({"centers": 0}, "centers must be from 1"),
        ({"centers": 1001}, "centers must be at most 1000"),
        ({"gaussian_width": 0.0}, "gaussian_width must be a finite number larger than 0"),
        ({"separation": -1.0}, "separation must be at least 0"),
    ],
)
def test_mixtures_refuses_arguments_out_of_range(pair, parameters, text):
    with pytest.raises(ValueError, match=text):
        gaussian_mixtures(pair, 2, **parameters)


def test_a_file_gives_back_what_was_written(tmp_path, ball, pair):
    path = tmp_path / "signals.safetensors"
    first = np.random.default_rng(1).normal(size=(3, len(pair[0]), 2))
    corner = (np.eye(3), np.array([[0, 1, 2]]))
    write_signal_dataset(path, [(ball, first), (corner, np.ones((5, 3, 2)))], "Velocity")
    name, sources = read_signal_dataset(path)
    assert name == "Velocity" and len(sources) == 2
    assert np.array_equal(sources[0].points, pair[0]) and sources[0].points.dtype == np.float64
    assert np.array_equal(sources[0].triangles, pair[1]) and sources[0].triangles.dtype == np.int64
    assert np.array_equal(sources[0].signals, first.astype(np.float32)) and sources[0].signals.dtype == np.float32
    assert sources[1].signals.shape == (5, 3, 2)
    content = path.read_bytes()
    write_signal_dataset(path, [(ball, first), (corner, np.ones((5, 3, 2)))], "Velocity")
    assert path.read_bytes() == content


def test_positions_far_from_the_origin_warn_of_lost_digits(tmp_path, pair, recwarn):
    points, triangles = pair
    for shift in (0.0, 1e3):
        write_signal_dataset(tmp_path / "near.safetensors", [(pair, points[None] + shift)], "Position")
    write_signal_dataset(tmp_path / "near.safetensors", [(pair, np.full((1, len(points)), 0.1))], "Constant")
    assert not recwarn.list
    with pytest.warns(SurfaceSynthesisWarning, match="over the surface, and float32 changes them by 0.03"):
        write_signal_dataset(tmp_path / "far.safetensors", [(pair, points[None] + 1e6)], "Position")


def test_the_file_follows_the_agreed_format(tmp_path, pair):
    path = tmp_path / "signals.safetensors"
    write_signal_dataset(path, [(pair, np.zeros((2, len(pair[0]))))], "Mixture")
    content = path.read_bytes()
    header = json.loads(content[8 : 8 + int.from_bytes(content[:8], "little")])
    assert header["__metadata__"] == {
        "content": "surface_signals",
        "format_version": "1",
        "signal_name": "Mixture",
        "producer": "SurfaceSynthesis",
    }
    points, triangles = len(pair[0]), len(pair[1])
    described = {name: (entry["dtype"], entry["shape"]) for name, entry in header.items() if name != "__metadata__"}
    assert described == {
        "sources.0.points": ("F64", [points, 3]),
        "sources.0.triangles": ("I64", [triangles, 3]),
        "sources.0.signals": ("F32", [2, points, 1]),
    }


@pytest.mark.parametrize(
    "samples, error, text",
    [
        (np.zeros((2, 5)), ValueError, r"shape \[2, 5\]"),
        (np.zeros((0, 3, 1)), ValueError, "shape"),
        (np.full((1, 3, 1), np.nan), ValueError, "not finite"),
        (np.full((1, 3, 1), 1e300), ValueError, "too large for float32"),
        (np.zeros((1, 3, 1), dtype=complex), TypeError, "real numbers"),
    ],
)
def test_samples_that_do_not_fit_are_refused(tmp_path, samples, error, text):
    path = tmp_path / "signals.safetensors"
    with pytest.raises(error, match=text):
        write_signal_dataset(path, [((np.eye(3), np.array([[0, 1, 2]])), samples)], "x")
    assert not path.exists()
    with pytest.raises(ValueError, match="sources is empty"):
        write_signal_dataset(path, [], "x")


def _with_header(change):
    """The bytes of a small dataset whose header ``change`` has edited."""

    def edited(content):
        size = int.from_bytes(content[:8], "little")
        header = json.loads(content[8 : 8 + size])
        change(header)
        text = json.dumps(header).encode()
        return len(text).to_bytes(8, "little") + text + content[8 + size :]

    return edited


def _set(tensor, key, value):
    return _with_header(lambda header: header[tensor].__setitem__(key, value))


@pytest.mark.parametrize(
    "change, text",
    [
        (lambda content: content[:7], "no safetensors file"),
        (lambda content: content[:-1], "do not fit"),
        (lambda content: content + b"\0", "bytes, not"),
        (lambda content: (2**40).to_bytes(8, "little") + content[8:], "no safetensors file"),
        (lambda content: content.replace(b"{", b"[", 1), "no JSON object"),
        (_set("__metadata__", "content", "other"), "the content is 'other'"),
        (_set("__metadata__", "format_version", "2"), "the format_version is '2'"),
        (_set("__metadata__", "producer", 1), "metadata"),
        (_with_header(lambda header: header["__metadata__"].pop("signal_name")), "no signal_name"),
        (_set("sources.0.points", "dtype", "F16"), "has the type F16"),
        (_set("sources.0.points", "shape", [-3, 3]), "no list of up to 8 sizes"),
        (_set("sources.0.points", "shape", [1, 9]), "are needed"),
        (_set("sources.0.points", "data_offsets", [8, 80]), "do not fit"),
        (_with_header(lambda header: header.__setitem__("other", header.pop("sources.0.points"))), "missing or has no"),
    ],
)
def test_broken_files_are_refused(tmp_path, change, text):
    path = tmp_path / "signals.safetensors"
    write_signal_dataset(path, [((np.eye(3), np.array([[0, 1, 2]])), np.zeros((2, 3)))], "x")
    path.write_bytes(change(path.read_bytes()))
    with pytest.raises(FormatError, match=text):
        read_signal_dataset(path)


def test_files_are_judged_by_their_headers(tmp_path):
    path = tmp_path / "signals.safetensors"
    write_signal_dataset(path, [((np.eye(3), np.array([[0, 1, 2]])), np.zeros((2, 3)))], "x")
    content = path.read_bytes()
    samples = 2**32  # 48 GiB of zeros, which take no space on the disk

    def sparse(change):
        def longer(header):
            entry = header["sources.0.signals"]
            entry["shape"] = [samples, 3, 1]
            entry["data_offsets"][1] = entry["data_offsets"][0] + 12 * samples
            change(header)

        changed = _with_header(longer)(content)
        path.write_bytes(changed)
        with open(path, "r+b") as file:
            file.truncate(len(changed) - 24 + 12 * samples)
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        with pytest.raises(FormatError) as error:
            read_signal_dataset(path)
        assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 64 * 1024  # KiB
        return str(error.value)

    assert "the content is 'other'" in sparse(lambda header: header["__metadata__"].update(content="other"))
    assert "signals [4294967296, 3, 1]" in sparse(lambda header: header["sources.0.points"].update(shape=[1, 9]))
    samples = 2**40  # 12 TiB, more than any memory
    assert "GB of memory" in sparse(lambda header: None)


def test_triangles_of_points_that_do_not_exist_are_refused(tmp_path):
    path = tmp_path / "signals.safetensors"
    write_signal_dataset(path, [((np.eye(3), np.array([[0, 1, 2]])), np.zeros((2, 3)))], "x")
    content = path.read_bytes()
    triangles = np.array([0, 1, 2], dtype="<i8").tobytes()
    path.write_bytes(content.replace(triangles, np.array([0, 1, 3], dtype="<i8").tobytes()))
    with pytest.raises(FormatError, match="names a point that does not exist"):
        read_signal_dataset(path)


@needs_cgal
def test_the_command_writes_poses(tmp_path, ball, pair, capsys):
    surface, output = tmp_path / "ball.vtp", tmp_path / "poses.safetensors"
    write_mesh(ball, surface)
    options = ["--samples", "3", "--seed", "5", "--first-sample", "2", "--maximum-angle", "30"]
    options += ["--template", str(surface)]
    assert main(["dataset", "poses", str(surface), str(output), *options]) == 0
    assert "3 samples on 362 points" in capsys.readouterr().out
    name, (source,) = read_signal_dataset(output)
    expected = poses(ball, 3, seed=5, first_sample=2, maximum_angle=30.0)
    assert name == "Position" and np.array_equal(source.signals, expected.astype(np.float32))


@needs_cgal
def test_the_command_remeshes_first(tmp_path, ball):
    surface, output = tmp_path / "ball.vtp", tmp_path / "mixtures.safetensors"
    write_mesh(ball, surface)
    assert main(["dataset", "mixtures", str(surface), str(output), "--samples", "4", "--points", "200"]) == 0
    name, (source,) = read_signal_dataset(output)
    assert name == "Mixture" and source.signals.shape[::2] == (4, 1) and abs(len(source.points) - 200) <= 4


@pytest.mark.parametrize(
    "arguments, status, text",
    [
        (["--samples", "0"], 2, "samples must be from 1"),
        (["--gaussian-width", "-1"], 2, "gaussian_width must be"),
        (["--gaussian-width", "1"], 1, "no vertex is left for a centre"),
    ],
)
def test_the_command_says_what_is_wrong(tmp_path, ball, capsys, arguments, status, text):
    surface, output = tmp_path / "ball.vtp", tmp_path / "mixtures.safetensors"
    write_mesh(ball, surface)
    assert main(["dataset", "mixtures", str(surface), str(output), *arguments]) == status
    assert text in capsys.readouterr().err
    assert not output.exists()
    assert main(["dataset", "mixtures", str(surface), str(tmp_path / "mixtures.csv")]) == 2


@needs_cgal
def test_the_example_makes_its_fourteen_files(tmp_path, ball, monkeypatch):
    example = pathlib.Path(__file__).parents[2] / "Examples" / "Training" / "make_datasets.py"
    spec = importlib.util.spec_from_file_location("make_datasets", example)
    make_datasets = importlib.util.module_from_spec(spec)
    monkeypatch.syspath_prepend(example.parent)
    spec.loader.exec_module(make_datasets)
    surface = tmp_path / "ball.vtp"
    write_mesh(ball, surface)
    counts = {"--poses": 3, "--test-poses": 2, "--full-poses": 1, "--mixtures": 4, "--test-mixtures": 2}
    counts.update({"--coarse-poses": 5, "--many-poses": 2})
    sizes = {"--uneven-pose-vertices": 250}
    sizes.update({"--pose-vertices": 300, "--mixture-vertices": 300, "--test-vertices": 400, "--coarse-mixture-vertices": 100})
    options = [str(word) for item in {**counts, **sizes}.items() for word in item]
    options += ["--coarse-pose-vertices", "150", "60"]
    make_datasets.main([str(tmp_path), "--armadillo", str(surface), "--bunny", str(surface), *options])
    expected = {
        "armadillo_poses": ("Position", 3, 300),
        "armadillo_uneven": ("Position", 3, 250),
        "armadillo_medium": ("Position", 5, 150),
        "armadillo_coarse": ("Position", 5, 60),
        "armadillo_test": ("Position", 2, 400),
        "armadillo_full_test": ("Position", 1, 362),
        "bunny_mixtures": ("Mixture", 4, 300),
        "bent_medium": ("Position", 5, 150),
        "bent_coarse": ("Position", 5, 60),
        "bent_test": ("Position", 2, 400),
        "bunny_coarse": ("Mixture", 4, 100),
        "bunny_test": ("Mixture", 2, 400),
    }
    for file, alone in (("armadillo_many", "armadillo_medium"), ("bent_many", "bent_medium")):
        name, sources = read_signal_dataset(tmp_path / f"{file}.safetensors")
        assert name == "Position" and all(len(source.signals) == 2 for source in sources)
        assert [len(source.points) for source in sources] == pytest.approx([150, 300, 180, 480, 180, 250], rel=0.1)
        (source,) = read_signal_dataset(tmp_path / f"{alone}.safetensors").sources
        assert np.array_equal(sources[0].signals, source.signals[:2]), "the same poses on each"
    for file, (signal, samples, points) in expected.items():
        name, (source,) = read_signal_dataset(tmp_path / f"{file}.safetensors")
        assert name == signal and len(source.signals) == samples
        assert len(source.points) == pytest.approx(points, rel=0.05)

# SPDX-License-Identifier: BSD-3-Clause
"""``python3 -m surfacesynthesis``"""

import errno
import io
import itertools
import os
import pty
import re
import resource
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
import surfacesynthesis
from conftest import files_in, icosphere, polydata_of, read_terminal, run_command
from surfacesynthesis import matern_noise, read_mesh, write_mesh
from surfacesynthesis.command_line import build_parser, main
from surfacesynthesis.commands import FORMER_COMMANDS
from surfacesynthesis.commands.common import ProgressBar
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import VTK_TETRA, vtkMultiBlockDataSet, vtkUnstructuredGrid


@pytest.fixture
def surface(pair, tmp_path):
    path = tmp_path / "in.off"
    write_mesh(polydata_of(*pair), path)
    return path


def values_of(path, name="MaternNoise"):
    return vtk_to_numpy(read_mesh(path).GetPointData().GetArray(name))


def points_of(path):
    return vtk_to_numpy(read_mesh(path).GetPoints().GetData()).astype(float)


def fails(arguments, status, words, folder):
    """Runs a command that must fail with one line on stderr and leave no file behind."""
    before = files_in(folder)
    done = run_command(*arguments, cwd=folder)
    assert done.returncode == status, done
    assert done.stdout == ""
    assert re.fullmatch(r"surfacesynthesis: [^\n]+\n", done.stderr), done.stderr
    assert words in done.stderr, done.stderr
    assert files_in(folder) == before
    return done


# -- messages ----------------------------------------------------------------------------------------------------------


def test_messages_speak_of_options_and_commands(surface, tmp_path):
    """Names of options and commands take the place of properties and classes."""
    opened = tmp_path / "open.off"
    points, triangles = icosphere(2)
    write_mesh(polydata_of(points, triangles[1:]), opened)
    for arguments, words, not_words in (
        (["remesh", opened, "x.vtp", "--edge-length", "1e-7"], "--maximum-points", "MaximumNumberOfPoints"),
        (["remesh", opened, "x.vtp", "--edge-length", "50"], "longer than the surface", "TargetEdgeLength"),
        (["surface", opened, "x.vtp", "--voxel-size", "1e-7"], "--maximum-voxels raises", "MaximumNumberOfVoxels"),
        (["tetrahedralize", opened, "x.vtu"], "the command repair with --holes all", "vtkSurfaceRepairFilter"),
    ):
        if arguments[0] in build_parser()._subparsers._group_actions[0].choices:
            done = fails([str(argument) for argument in arguments], 1, words, tmp_path)
            assert not_words not in done.stderr, done.stderr


# -- from file to file -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", [".stl", ".ply", ".obj", ".off", ".vtp", ".vtk"])
def test_every_input_format(kind, pair, tmp_path, capsys):
    source = tmp_path / f"in{kind}"
    write_mesh(polydata_of(*pair), source)
    assert main(["noise", str(source), str(tmp_path / "out.vtp"), "--range", "1"]) == 0
    points = points_of(source)
    expected = np.sort(matern_noise((points, vtk_to_numpy(read_mesh(source).GetPolys().GetConnectivityArray())
                                     .reshape(-1, 3)), range=1.0))  # fmt: skip
    assert np.array_equal(np.sort(values_of(tmp_path / "out.vtp")), expected)
    assert "642 points, 1,280 cells, tau 8, range 1, residual" in capsys.readouterr().out


@pytest.mark.parametrize("kind", [".vtp", ".vtk", ".ply"])
def test_formats_that_hold_the_noise(kind, surface, pair, tmp_path):
    output = tmp_path / f"out{kind}"
    done = run_command("noise", surface, output, "--range", "1", "--samples", "3", "--seed", "-4")
    assert (done.returncode, done.stderr) == (0, "")
    assert re.fullmatch(r"642 points, 1,280 cells, tau 8, range 1, residual \S+, \S+ s -> \S+\n", done.stdout)
    expected = matern_noise(pair, range=1.0, samples=3, seed=-4)
    for k in range(3):
        assert np.array_equal(values_of(output, f"MaternNoise_{k}"), expected[k])


@pytest.mark.parametrize("kind", [".stl", ".obj", ".off", ".vtp", ".vtk", ".ply"])
def test_warp_moves_the_points_along_the_normals(kind, surface, pair, tmp_path):
    output = tmp_path / f"out{kind}"
    assert main(["noise", str(surface), str(output), "--range", "1", "--warp", "0.05", "--quiet"]) == 0
    radius = np.sort(np.linalg.norm(points_of(output), axis=1))
    expected = np.sort(1 + 0.05 * matern_noise(pair, range=1.0))
    assert np.allclose(radius, expected, atol=1e-4)  # the normals are those of the triangles
    assert radius[-1] - radius[0] > 0.1


def test_warp_by_three_components_moves_along_the_noise(surface, pair, tmp_path):
    output = tmp_path / "out.off"
    assert main(["noise", str(surface), str(output), "--range", "1", "--warp", "-2", "--components", "3"]) == 0
    assert np.allclose(points_of(output), pair[0] - 2 * matern_noise(pair, range=1.0, components=3), atol=1e-12)


def test_warp_of_several_samples_writes_a_file_for_each(surface, pair, tmp_path):
    command = ["noise", str(surface), str(tmp_path / "out.off"), "--range", "1", "--warp", "0.1", "--samples", "2"]
    assert main(command + ["--first-sample", "3", "--components", "3"]) == 0
    assert files_in(tmp_path) == ["in.off", "out_3.off", "out_4.off"]
    expected = matern_noise(pair, range=1.0, samples=2, first_sample=3, components=3)
    assert np.allclose(points_of(tmp_path / "out_4.off"), pair[0] + 0.1 * expected[1], atol=1e-12)


def test_composite_dataset(pair, tmp_path, capsys):
    blocks = vtkMultiBlockDataSet()
    blocks.SetBlock(0, polydata_of(*pair))
    blocks.SetBlock(1, polydata_of(*pair))
    write_mesh(blocks, tmp_path / "in.vtm")
    for extra in ([], ["--warp", "0.1"]):
        assert main(["noise", str(tmp_path / "in.vtm"), str(tmp_path / "out.vtm"), "--range", "1", *extra]) == 0
        result = read_mesh(tmp_path / "out.vtm")
        first, second = (
            vtk_to_numpy(result.GetBlock(k).GetPointData().GetArray("MaternNoise")) for k in range(2)
        )  # fmt: skip
        assert not np.array_equal(first, second)
    points = vtk_to_numpy(result.GetBlock(1).GetPoints().GetData())
    assert np.allclose(np.linalg.norm(points, axis=1) - 1, 0.1 * second, atol=1e-3)
    assert "1,284 points" in capsys.readouterr().out


def test_all_options_reach_the_filter(surface, pair, tmp_path):
    cases = [
        (["--range", "1", "--standard-deviation", "2.5"], {"range": 1.0, "standard_deviation": 2.5}),
        (["--screening", "30"], {"screening": 30.0}),
        (["--normalized-screening", "1e-3"], {"normalized_screening": 1e-3}),
        (["--noise-model", "per_vertex", "--standard-deviation", "0.5"],
         {"noise_model": "per_vertex", "standard_deviation": 0.5}),
        (["--noise-model", "white"], {"noise_model": "white"}),
        (["--operator-power", "4", "--variance-correction"], {"operator_power": 4, "variance_correction": True}),
        (["--range", "1", "--operator-power", "2.5"], {"range": 1.0, "operator_power": 2.5}),
        (["--screening", "9", "--operator-power", "1"], {"screening": 9.0, "operator_power": 1}),
        (["--boundary-condition", "robin", "--robin-coefficient", "2"],
         {"boundary_condition": "robin", "robin_coefficient": 2.0}),
        (["--noise-model", "unscreened"], {"noise_model": "unscreened"}),
        (["--noise-model", "spectral", "--eigenpairs", "20"], {"noise_model": "spectral", "eigenpairs": 20}),
        (["--first-sample", "7"], {"first_sample": 7}),
        (["--components", "3", "--threads", "1"], {"components": 3}),
        (["--name", "f", "--seed", "9"], {"name": "f", "seed": 9}),
    ]
    for options, parameters in cases:
        assert main(["noise", str(surface), str(tmp_path / "out.vtp"), "--quiet", *options]) == 0
        found = values_of(tmp_path / "out.vtp", parameters.get("name", "MaternNoise"))
        expected = matern_noise(pair, **parameters)
        assert np.allclose(found, expected, rtol=1e-9, atol=1e-9), options
        if "spectral" not in options:
            assert np.array_equal(found, expected), options


def test_output_may_be_the_input(pair, tmp_path):
    path = tmp_path / "s.vtp"
    write_mesh(polydata_of(*pair), path)
    assert main(["noise", str(path), str(path), "--range", "1", "--quiet"]) == 0
    assert np.array_equal(values_of(path), matern_noise(pair, range=1.0))


def test_warnings_are_one_line_and_quiet_leaves_them_out(surface, tmp_path):
    done = run_command("noise", surface, tmp_path / "out.vtp", "--range", "0.05")
    assert done.returncode == 0
    assert re.fullmatch(r"surfacesynthesis: warning: The longest edge[^\n]+\n", done.stderr)
    done = run_command("noise", surface, tmp_path / "out.vtp", "--range", "0.05", "--quiet")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


# -- help --------------------------------------------------------------------------------------------------------------


def test_help_and_version():
    done = run_command("--help")
    assert done.returncode == 0 and "noise" in done.stdout and done.stderr == ""
    done = run_command("noise", "--help")
    assert done.returncode == 0
    options = ("range", "screening", "normalized-screening", "standard-deviation", "noise-model", "seed", "samples",
               "quiet", "first-sample", "components", "eigenpairs", "name", "warp", "threads", "no-progress")  # fmt: skip
    for option in options:
        assert f"--{option}" in done.stdout
    assert ".vtp .vtk .ply" in done.stdout and "examples:" in done.stdout
    done = run_command("--version")
    assert done.stdout == f"surfacesynthesis {surfacesynthesis.__version__}\n"
    assert re.fullmatch(r"\d+\.\d+\.\d+", surfacesynthesis.__version__)


# -- what goes wrong ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "arguments, words",
    [
        ([], "COMMAND"),
        (["paint"], "invalid choice: 'paint'"),
        (["noise"], "INPUT, OUTPUT"),
        (["noise", "in.off", "out.vtp", "--colour"], "unrecognized arguments: --colour"),
        (["noise", "in.off", "out.vtp", "--range", "wide"], "invalid float value: 'wide'"),
        (["noise", "in.off", "out.vtp", "--range", "-1"], "range must be a finite number larger than 0"),
        (["noise", "in.off", "out.vtp", "--range", "1", "--screening", "2"], "not allowed with argument --range"),
        (["noise", "in.off", "out.vtp", "--screening", "1", "--standard-deviation", "2"],
         "standard_deviation goes with range"),
        (["noise", "in.off", "out.vtp", "--noise-model", "perlin"], "invalid choice: 'perlin'"),
        (["noise", "in.off", "out.vtp", "--noise-model", "white", "--range", "1"], "no meaning for the model 'white'"),
        (["noise", "in.off", "out.vtp", "--seed", "3000000000"], "seed must be"),
        (["noise", "in.off", "out.vtp", "--samples", "0"], "samples must be"),
        (["noise", "in.off", "out.vtp", "--threads", "0"], "--threads must be"),
        (["noise", "in.off", "out.vtp", "--name", ""], "name must be"),
        (["noise", "in.off", "out.xyz"], "the extension '.xyz' is not known"),
        (["noise", "in.txt", "out.vtp"], "the extension '.txt' is not known"),
        (["noise", "in.off", "out.vtm"], ".vtm is for composite datasets"),
        (["noise", "in.off", "out.stl"], ".stl files cannot hold the noise: write .vtp, .vtk or .ply, or move"),
        (["noise", "in.off", "out.obj"], "--warp SCALE"),
        (["noise", "in.off", "out.off"], "--warp SCALE"),
        (["noise", "in.off", "out.stl", "--warp", "1", "--components", "2"], "--warp needs 1 or 3 components, not 2"),
        (["noise", "in.off", "out.stl", "--warp", "nan"], "--warp must be a finite number"),
    ],
)
def test_wrong_usage_is_one_line_and_status_2(arguments, words, surface, tmp_path):
    fails(arguments, 2, words, tmp_path)


def test_formats_without_arrays_are_refused_before_anything_is_read(tmp_path):
    fails(["noise", "no such file.off", "out.stl"], 2, "cannot hold the noise", tmp_path)


def test_missing_and_malformed_inputs_are_one_line_and_status_1(surface, pair, tmp_path):
    (tmp_path / "folder.off").mkdir()
    (tmp_path / "cut.off").write_text("OFF\n3 1 0\n0 0 0\n1 0\n")
    (tmp_path / "empty.off").write_text("OFF\n0 0 0\n")
    (tmp_path / "points.off").write_text("OFF\n1 0 0\n0 0 0\n")
    (tmp_path / "cut.vtp").write_text("<VTKFile type='PolyData'><PolyData>")
    (tmp_path / "junk.stl").write_bytes(os.urandom(2000))
    broken = pair[0].copy()
    broken[5, 2] = np.nan
    write_mesh(polydata_of(broken, pair[1]), tmp_path / "nan.vtp")
    for name, words in [
        ("none.off", "none.off: No such file or directory"),
        ("folder.off", "Is a directory"),
        ("cut.off", "cut.off: the file ends after 2 of 3 vertices"),
        ("empty.off", "empty.off: the file holds no points"),
        ("points.off", "no polygon"),
        ("cut.vtp", "cut.vtp: Error parsing XML"),
        ("junk.stl", "junk.stl: this is no complete STL file"),
        ("nan.vtp", "NaN or infinite"),
    ]:
        fails(["noise", name, "out.vtp"], 1, words, tmp_path)


def test_all_bad_blocks_are_in_the_one_line(pair, tmp_path):
    broken = pair[0].copy()
    broken[5, 2] = np.nan
    blocks = vtkMultiBlockDataSet()
    for k in range(3):
        blocks.SetBlock(k, polydata_of(broken if k else pair[0], pair[1]))
    write_mesh(blocks, tmp_path / "in.vtm")
    done = fails(["noise", "in.vtm", "out.vtm"], 1, "Block 2: ", tmp_path)
    assert "Block 3: " in done.stderr and "Block 1" not in done.stderr


def test_bad_blocks_are_named(pair, tmp_path):
    broken = pair[0].copy()
    broken[5, 2] = np.nan
    blocks = vtkMultiBlockDataSet()
    blocks.SetBlock(0, polydata_of(broken, pair[1]))
    blocks.GetMetaData(0).Set(vtkMultiBlockDataSet.NAME(), "LeftHand")
    write_mesh(blocks, tmp_path / "in.vtm")
    fails(["noise", "in.vtm", "out.vtm"], 1, 'Block 1 "LeftHand": ', tmp_path)


@pytest.mark.parametrize("command", ["remesh", "tetrahedralize", "repair", "surface", "report"])
def test_a_volume_mesh_has_the_same_message_whatever_the_output(command, tmp_path):
    grid = vtkUnstructuredGrid()
    grid.SetPoints(polydata_of(np.eye(4)[:, :3], np.zeros((0, 3), int)).GetPoints())
    grid.InsertNextCell(VTK_TETRA, 4, [0, 1, 2, 3])
    write_mesh(grid, tmp_path / "in.vtu")
    write_mesh(grid, tmp_path / "in.vtk")
    for name in ("in.vtu", "in.vtk"):
        for output in [[]] if command == "report" else [["out.vtu"], ["out.vtk"]]:
            words = f"surfacesynthesis: {name}: a volume mesh was found where a surface is needed; "
            fails([command, name, *output], 1, words, tmp_path)


def box_of_tetrahedra(cells=4):
    """The unit cube as a grid of 6 cells^3 tetrahedra."""
    side = cells + 1
    corners = np.stack(np.meshgrid(*3 * [np.arange(side)], indexing="ij"), axis=-1).reshape(-1, 3)
    lower = corners[(corners < cells).all(axis=1)]
    steps = np.eye(3, dtype=int)
    tetrahedra = []
    for path in itertools.permutations(range(3)):
        steps_along = np.vstack((np.zeros((1, 3), int), np.cumsum(steps[list(path)], axis=0)))
        corners_of_cells = (lower[:, None, :] + steps_along) @ [side * side, side, 1]
        is_even = np.linalg.det(steps[list(path)]) > 0.0
        tetrahedra.append(corners_of_cells if is_even else corners_of_cells[:, [0, 1, 3, 2]])
    return corners / cells, np.concatenate(tetrahedra)


def test_noise_in_a_volume_is_that_of_the_function(tmp_path):
    points, tetrahedra = box_of_tetrahedra()
    grid = vtkUnstructuredGrid()
    grid.SetPoints(polydata_of(points, np.zeros((0, 3), int)).GetPoints())
    for cell in tetrahedra:
        grid.InsertNextCell(VTK_TETRA, 4, cell.tolist())
    write_mesh(grid, tmp_path / "in.vtu")
    options = ["--range", "2", "--seed", "3", "--variance-correction"]
    done = run_command("noise", "in.vtu", "out.vtu", *options, cwd=tmp_path)
    assert done.returncode == 0, done
    output = read_mesh(tmp_path / "out.vtu")
    assert output.GetNumberOfCells() == len(tetrahedra)
    expected = surfacesynthesis.matern_noise((points, tetrahedra), range=2.0, seed=3, variance_correction=True)
    assert np.array_equal(vtk_to_numpy(output.GetPointData().GetArray("MaternNoise")), expected)
    fails(["noise", "in.vtu", "out.vtu", "--warp", "1"], 2, "--warp moves the points of a surface", tmp_path)


def test_an_isovalue_for_a_surface_is_wrong_usage(surface, tmp_path):
    fails(["surface", surface, "out.vtp", "--iso-value", "3"], 2, "--iso-value is a value of a volume", tmp_path)


def test_samples_and_tetrahedra_that_do_not_fit_are_refused_in_words_of_options(surface, tmp_path):
    fails(["noise", surface, "out.vtp", "--samples", str(2**31 - 1)], 1, "A --samples of ", tmp_path)
    fails(["dataset", "mixtures", surface, "o.safetensors", "--samples", str(10**9)], 1, "A --samples of ", tmp_path)
    words = "at most 1000 (--maximum-tetrahedra) are allowed. A --edge-length of "
    arguments = ["tetrahedralize", surface, "out.vtu", "--edge-length", "1e-3", "--maximum-tetrahedra", "1000"]
    fails(arguments, 1, words, tmp_path)


def test_unwritable_outputs(surface, tmp_path):
    fails(["noise", "in.off", "no folder/out.vtp"], 1, "does not exist", tmp_path)
    fails(["noise", "in.off", "/proc/out.vtp"], 1, "the folder /proc is not writable", tmp_path)
    (tmp_path / "taken.vtp").mkdir()
    fails(["noise", "in.off", "taken.vtp"], 1, "is not a file", tmp_path)


@pytest.mark.parametrize("kind", [".vtp", ".ply", ".vtk", ".off"])
def test_full_disk_leaves_the_old_file(kind, surface, tmp_path):
    def limit():
        resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))

    (tmp_path / f"out{kind}").write_text("old")
    extra = ["--warp", "0.1"] if kind == ".off" else []
    command = [sys.executable, "-m", "surfacesynthesis", "noise", surface, tmp_path / f"out{kind}", "--range", "1", *extra]
    done = subprocess.run(command, preexec_fn=limit, capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 1 and done.stdout == ""
    assert done.stderr == f"surfacesynthesis: {tmp_path / f'out{kind}'}: {os.strerror(errno.EFBIG)}\n"
    assert files_in(tmp_path) == ["in.off", f"out{kind}"]
    assert (tmp_path / f"out{kind}").read_text() == "old"


def long_command(folder):
    """A command that takes many seconds."""
    write_mesh(polydata_of(*icosphere(6)), folder / "in.ply")
    return [sys.executable, "-m", "surfacesynthesis", "noise", "in.ply", "out.vtp", "--range", "1", "--samples", "2000"]


@pytest.mark.parametrize("number, status", [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_interruption_ends_at_once_and_leaves_nothing(number, status, tmp_path):
    ours, theirs = pty.openpty()
    with subprocess.Popen(long_command(tmp_path), cwd=tmp_path, stdout=subprocess.PIPE, stderr=theirs) as process:
        os.close(theirs)
        os.read(ours, 1)  # the progress bar: the filter works
        process.send_signal(number)
        started = time.monotonic()
        err = read_terminal(ours).decode()
        out = process.communicate(timeout=60)[0]
        waited = time.monotonic() - started
    assert process.returncode == status, "the command was over before it could be interrupted"
    assert out == b"" and "Traceback" not in err and "100 %" not in err
    assert waited < 5, f"{waited:.1f} s after the signal"
    assert files_in(tmp_path) == ["in.ply"]


@pytest.mark.parametrize("library", ["_multiarray_umath", "libvtkCommonCore", "vtkSurfaceSynthesisEnsembles"])
def test_interruption_while_modules_are_loaded_is_one_line(library, tmp_path):
    command = long_command(tmp_path)
    with subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        with open(f"/proc/{process.pid}/maps", encoding="utf-8") as maps:
            while library not in maps.read():
                maps.seek(0)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=60)
    assert (process.returncode, out, err) == (130, "", "surfacesynthesis: interrupted\n")
    assert files_in(tmp_path) == ["in.ply"]


_STUCK = """
import os, signal, sys, time
from surfacesynthesis.supervision import run_supervised, unfinished_name

def work():
    path = unfinished_name(".")
    os.mkdir(path)
    open(os.path.join(path, "half"), "w").close()
    open(unfinished_name(".", ".part"), "w").close()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)  # as a library that does not ask whether to stop
    print("working", flush=True)
    time.sleep(60)

sys.exit(run_supervised(work, lambda text: print(text, file=sys.stderr)))
"""


@pytest.mark.parametrize(
    "number, status, text", [(signal.SIGINT, 130, "interrupted\n"), (signal.SIGTERM, 143, "terminated\n")]
)
def test_a_command_that_does_not_stop_is_ended_and_its_unfinished_files_go(number, status, text, tmp_path):
    with subprocess.Popen(
        [sys.executable, "-c", _STUCK], cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout.readline() == "working\n"
        assert len(files_in(tmp_path)) == 2
        process.send_signal(number)
        started = time.monotonic()
        out, err = process.communicate(timeout=60)
        assert time.monotonic() - started < 5
    assert (process.returncode, out, err) == (status, "", text)
    assert files_in(tmp_path) == []


@pytest.mark.parametrize(
    "work, status, text",
    [("7", 7, ""), ("sys.exit(3)", 3, ""), ("os.kill(os.getpid(), 9)", 137, "SIGKILL, as a rule because the memory")],
)
def test_the_status_of_a_command_is_passed_on(work, status, text, tmp_path):
    script = f"""
import os, sys
from surfacesynthesis.supervision import run_supervised
sys.exit(run_supervised(lambda: {work}, lambda text: print(text, file=sys.stderr)))
"""
    done = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == status and text in done.stderr and bool(text) == bool(done.stderr)


# -- progress ----------------------------------------------------------------------------------------------------------


def on_terminal(command, folder):
    """Standard error of a command whose standard error is a terminal."""
    ours, theirs = pty.openpty()
    with subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=theirs) as process:
        os.close(theirs)
        text = read_terminal(ours)
        process.communicate(timeout=60)
    assert process.returncode == 0
    return text.decode()


def test_progress_bar_on_a_terminal_only(surface, tmp_path):
    command = [sys.executable, "-m", "surfacesynthesis", "noise", "in.off", "out.vtp", "--range", "1"]
    shown = on_terminal(command, tmp_path)
    percents = [int(percent) for percent in re.findall(r"(\d+) %", shown)]
    assert percents and percents == sorted(percents) and percents[-1] == 100
    assert shown.rstrip(" ").endswith("\r"), "the bar stays on the terminal"
    assert on_terminal(command + ["--no-progress"], tmp_path) == ""
    assert on_terminal(command + ["--quiet"], tmp_path) == ""
    assert run_command("noise", surface, tmp_path / "out.vtp", "--range", "1").stderr == ""


def test_bar_draws_each_percent_once():
    class Terminal(io.StringIO):
        def isatty(self):
            return True

    stream = Terminal()
    bar = ProgressBar(stream, True)
    for fraction in (0.0, 0.001, 0.5, 0.501, 1.0, 1.5):
        bar(fraction)
    bar.clear()
    assert re.findall(r"(\d+) %", stream.getvalue()) == ["0", "50", "100"]
    assert "[####################                    ]  50 %" in stream.getvalue()


def test_bar_shows_the_time_that_is_left():
    class Terminal(io.StringIO):
        def isatty(self):
            return True

    seconds = iter((100.0, 101.0, 110.0, 120.0, 500.0, 500.0))
    stream = Terminal()
    bar = ProgressBar(stream, True, clock=lambda: next(seconds))
    for fraction in (0.5, 0.1, 0.25, 0.05, 1.0):
        bar(fraction)
    shown = stream.getvalue().split("\r")[1:]
    assert "left" not in shown[0], "not in the first seconds"
    assert shown[1].endswith(" 10 %, 1:30 left") and shown[2].rstrip().endswith(" 25 %, 1:00 left")
    assert shown[3].endswith("  5 %, 2:06:40 left") and shown[4].rstrip().endswith("100 %")
    assert len(shown[4]) >= len(shown[3]), "nothing is left of a longer line"


def test_closed_output_pipe_is_no_traceback(surface, tmp_path):
    command = f"{sys.executable} -m surfacesynthesis noise in.off out.vtp --range 1 | true"
    done = subprocess.run(["bash", "-c", command], cwd=tmp_path, capture_output=True, text=True, check=False, timeout=60)
    assert "Traceback" not in done.stderr and "Exception" not in done.stderr
    assert (tmp_path / "out.vtp").exists()


# -- former names ------------------------------------------------------------------------------------------------------


def test_former_options_work_with_a_warning(surface, tmp_path):
    new = ["--range", "1", "--standard-deviation", "2", "--noise-model", "matern"]
    done = run_command("noise", surface, tmp_path / "new.vtp", *new)
    assert (done.returncode, done.stderr) == (0, "")
    done = run_command("noise", surface, tmp_path / "old.vtp", "--range", "1", "--std", "2", "--model", "matern")
    assert done.returncode == 0 and done.stderr.splitlines() == [
        "surfacesynthesis: warning: --std is deprecated: use --standard-deviation",
        "surfacesynthesis: warning: --model is deprecated: use --noise-model",
    ]
    assert np.array_equal(values_of(tmp_path / "new.vtp"), values_of(tmp_path / "old.vtp"))
    done = run_command("noise", surface, tmp_path / "old.vtp", "--range", "1", "--std", "2", "--quiet")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_former_spellings_of_options_work():
    parsed = build_parser().parse_args(["dataset", "mixtures", "a", "b", "--centres", "5"])
    assert (parsed.centers, parsed.remarks) == (5, ["--centres is deprecated: use --centers"])
    parsed = build_parser().parse_args(["poisson-net", "a", "b", "--model", "m", "--normalisation", "none"])
    assert (parsed.normalization, parsed.remarks) == ("none", ["--normalisation is deprecated: use --normalization"])


@pytest.mark.parametrize("number", ["-1", "-0.5", "-.5", "-2.", "-1e-3", "-1.5E+2", "-inf"])
def test_negative_numbers_are_values_of_options(number):
    parsed = build_parser().parse_args(["noise", "a", "b", "--warp", number])
    assert parsed.warp == float(number)


def test_former_flags_stand_for_a_value():
    parsed = build_parser().parse_args(["surface", "a", "b", "--below", "--largest", "--iterations", "2", "--iso", "1"])
    assert (parsed.inside, parsed.largest_component) == ("below", True)
    assert (parsed.smoothing_iterations, parsed.iso_value) == (2, 1.0)
    assert parsed.remarks[0] == "--below is deprecated: use --inside below"
    parsed = build_parser().parse_args(["surface", "a", "b"])
    assert (parsed.inside, parsed.largest_component, hasattr(parsed, "remarks")) == ("above", False, False)


@pytest.mark.parametrize("former, successor", FORMER_COMMANDS.items())
def test_former_commands_work_with_a_warning(former, successor, capsys):
    with pytest.raises(SystemExit) as ended:
        main([former, "--help"])
    assert ended.value.code == 0 and f"surfacesynthesis {successor} " in capsys.readouterr().out
    missing = {"texture-distance": ["none.ply", "none.ply"]}.get(former, ["none.ply", "none.vtp", "--model", "none"])
    assert main([former, *missing]) == 1
    first, last = capsys.readouterr().err.splitlines()
    assert first == f"surfacesynthesis: warning: the command {former} is deprecated: use {successor}"
    assert "none" in last
    assert not re.search(rf"^ +{former} ", build_parser().format_help(), re.MULTILINE), "former commands are not listed"


def test_former_keywords_and_functions_work_with_a_warning(pair):
    with pytest.warns(DeprecationWarning, match="keyword model of matern_noise.*: use noise_model") as caught:
        old = matern_noise(pair, model="white")
    assert [warning.filename for warning in caught] == [__file__]
    assert np.array_equal(old, matern_noise(pair, noise_model="white"))
    with pytest.raises(TypeError, match="got noise_model and model, which is its former name"):
        matern_noise(pair, model="white", noise_model="white")
    with pytest.warns(DeprecationWarning, match="use surfacesynthesis.geometric_texture_distance") as caught:
        assert surfacesynthesis.texture_distance is surfacesynthesis.geometric_texture_distance
        assert surfacesynthesis.MODELS is surfacesynthesis.NOISE_MODELS
        assert surfacesynthesis.NORMALISATIONS is surfacesynthesis.NORMALIZATIONS
    assert [warning.filename for warning in caught] == [__file__] * 3
    with pytest.warns(DeprecationWarning, match='use report.valid|use report."valid"') as caught:
        report = surfacesynthesis.topology_report(pair)
        assert report.sound is report["sound"] is report.valid is True
    assert len(caught) == 2

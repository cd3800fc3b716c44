# SPDX-License-Identifier: BSD-3-Clause
"""Surfaces and samples on 1 to 4 MPI ranks: what pvbatch finds there is what one process finds, bit for bit.

    pvpython TestRanks.py --write    writes the surfaces and the expected arrays into the current folder
    python3 TestRanks.py 1 2 3 4     starts this file again under mpiexec with pvbatch, for each number of ranks

A run that hangs is ended and fails.
"""

import os
import re
import subprocess
import sys

from rank_parameters import FITTED, FROM_EXAMPLE, GENERATED, MIXTURES, NOISE, POSES, SAMPLES, TEXTURED

TIME_LIMIT = 240  # seconds, for one run of mpiexec; it takes a few, on a busy machine more than a minute
WITH_NETWORKS = os.environ.get("SURFACE_SYNTHESIS_LEARNING") == "1"
WITH_PETSC = os.environ.get("SURFACE_SYNTHESIS_PETSC") == "1"
NETWORK_CASES = ("predicted_points", "predicted_cells", "generated_samples", "generated_in_pieces", "compared",
                 "trained", "textured", "textured_blocks", "template_textured", "fitted", "texture_trained",
                 "textures_compared")
VALID_CASES = ("one_rank", "blocks", "redistributed", "distributed", "empty_rank", "mixtures", "posed", "from_example",
               *(("solved_in_pieces",) if WITH_PETSC else ()),
               *(NETWORK_CASES if WITH_NETWORKS else ()))
CASES = (*VALID_CASES, "corrected_in_pieces", "bad_piece", "bad_block", "cells_of_pieces", "mesh_on_one_rank", "mesh_in_pieces",
         "posed_in_pieces", "compared_in_pieces", "trained_in_pieces", "textured_in_pieces", "fitted_in_pieces",
         "texture_trained_in_pieces", "textures_compared_in_pieces", "from_example_in_pieces")


# ----------------------------------------------------------------------------------------------------------------------
# One process, without ParaView: surfaces and expected arrays.
def write_surfaces():
    import numpy as np
    import surfaces
    from vtkmodules.vtkCommonDataModel import vtkMultiBlockDataSet
    from vtkmodules.vtkIOXML import vtkXMLMultiBlockDataWriter

    whole = surfaces.armadillo()
    surfaces.write(whole, "whole.vtp")
    expected = surfaces.noise(whole, **NOISE)
    np.save("whole.npy", np.stack([surfaces.array(expected, f"MaternNoise_{k}") for k in range(SAMPLES)]))

    write_ensembles(surfaces, whole)
    write_example(surfaces)
    if WITH_NETWORKS:
        write_predictions(surfaces, whole)
        write_generated(surfaces, whole)
        write_textured(surfaces)
    blocks = vtkMultiBlockDataSet()
    for k in range(5):
        if k != 3:  # a hole
            blocks.SetBlock(k, surfaces.ball(8 + 2 * k, 3.0 * k))
    write_blocks(vtkXMLMultiBlockDataWriter, blocks, "blocks.vtm")
    expected = surfaces.noise(blocks, CorrelationRange=1.5, Seed=11)
    for k in (0, 1, 2, 4):
        np.save(f"block{k}.npy", surfaces.array(expected.GetBlock(k)))
    blocks.SetBlock(3, surfaces.fin())
    write_blocks(vtkXMLMultiBlockDataWriter, blocks, "bad_blocks.vtm")

    # four pieces by the angle around the axis, point and cell ids those of the whole; and the same with an empty piece
    points = np.array([whole.GetPoint(p) for p in range(whole.GetNumberOfPoints())])
    triangles = surfaces.vtk_to_numpy(whole.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    center = points[triangles].mean(axis=1) - points.mean(axis=0)
    quarter = np.floor((np.arctan2(center[:, 2], center[:, 0]) + np.pi) / (0.5 * np.pi)).astype(int) % 4
    for name, shares in (("quarters", [0, 1, 2, 3]), ("with_empty", [0, 1, -1, 3])):
        owner = np.where(quarter == 2, 1, quarter) if name == "with_empty" else quarter
        pieces = [piece_of(surfaces, points, triangles, np.flatnonzero(owner == share)) for share in shares]
        write_pieces(surfaces, pieces, name)
    bad = [piece_of(surfaces, points, triangles, np.flatnonzero(quarter == share)) for share in range(4)]
    fin = surfaces.mesh_of([[500, 0, 0], [501, 0, 0], [500, 1, 0], [500, -1, 0], [500, 0, 1]],
                           [[0, 1, 2], [1, 0, 3], [0, 1, 4]])
    bad[1] = with_ids(surfaces, fin, len(points) + np.arange(5), len(triangles) + np.arange(3))
    write_pieces(surfaces, bad, "bad")


def write_ensembles(surfaces, whole):
    """Mixtures on the whole surface, and poses of a shape with two extremities."""
    import numpy as np
    import surfacesynthesis
    from proxies import made_by

    mixtures = made_by(surfacesynthesis.vtkGaussianMixtureFilter(), whole, **MIXTURES)
    np.save("mixtures.npy", np.stack([surfaces.array(mixtures, f"Mixture_{k}") for k in range(2)]))
    long = surfaces.long_ball()
    surfaces.write(long, "long.vtp")
    if hasattr(surfacesynthesis, "vtkPoseEnsembleFilter"):
        poses = made_by(surfacesynthesis.vtkPoseEnsembleFilter(), long, **POSES)
        points = [surfaces.vtk_to_numpy(poses.GetBlock(k).GetPoints().GetData()) for k in range(3)]
        np.save("poses.npy", np.stack(points))


def write_example(surfaces):
    """An example with waves, the same without them, a target, and the texture on it."""
    import numpy as np
    from proxies import made_by
    from surfacesynthesis import vtkGeometricTextureFromExample

    def points_of(mesh):
        return surfaces.vtk_to_numpy(mesh.GetPoints().GetData())

    plain, waves, target = surfaces.ball(16), surfaces.ball(16), surfaces.ball(10)
    heights = 0.03 * np.prod(np.sin(9.0 * points_of(plain)), axis=1)
    points_of(waves)[:] *= (1.0 + heights)[:, None]
    for name, mesh in (("plain", plain), ("waves", waves), ("target", target)):
        surfaces.write(mesh, name + ".vtp")
    algorithm = vtkGeometricTextureFromExample()
    algorithm.SetExampleData(waves)
    algorithm.SetPlainExampleData(plain)
    np.save("from_example.npy", points_of(made_by(algorithm, target, **FROM_EXAMPLE)))


def write_generated(surfaces, whole):
    """Samples of a flow matching model with random weights, and an ensemble to train on."""
    import numpy as np
    from flow_models import model
    from proxies import made_by
    from surfacesynthesis import vtkFlowMatchingSampler, vtkGaussianMixtureFilter

    model(GENERATED["ModelFileName"], components=2)
    made = made_by(vtkFlowMatchingSampler(), whole, NumberOfSamples=3, **GENERATED)
    np.save("generated.npy", np.stack([surfaces.array(made.GetBlock(k), "Mixture") for k in range(3)]))
    surfaces.write(made_by(vtkGaussianMixtureFilter(), surfaces.ball(6), **MIXTURES), "ensemble.vtp")


def write_textured(surfaces):
    """A geometric texture with random weights, what it makes of surfaces, and a surface that was fitted."""
    import numpy as np
    import texture_models
    from proxies import made_by
    from surfacesynthesis import geometric_texture_distance, vtkGeometricTextureSynthesizer, vtkMultiscaleMeshFitter
    from vtkmodules.vtkCommonDataModel import vtkMultiBlockDataSet

    def points_of(mesh):
        return surfaces.vtk_to_numpy(mesh.GetPoints().GetData())

    texture_models.model(TEXTURED["ModelFileName"])
    balls = surfaces.ball(6), surfaces.ball(8, 3.0)
    blocks = vtkMultiBlockDataSet()
    for k, ball in enumerate(balls):
        blocks.SetBlock(k, ball)
        surfaces.write(ball, f"ball{k}.vtp")
    np.save("textured.npy", points_of(made_by(vtkGeometricTextureSynthesizer(), balls[0], **TEXTURED)))
    made = made_by(vtkGeometricTextureSynthesizer(), blocks, **TEXTURED)
    np.savez("textured_blocks.npz", *(points_of(made.GetBlock(k)) for k in range(2)))
    levels = made_by(vtkMultiscaleMeshFitter(), balls[0], **FITTED)
    np.savez("fitted.npz", *(points_of(levels.GetBlock(k)) for k in range(2)))
    np.save("distance.npy", geometric_texture_distance(*balls))


def write_predictions(surfaces, whole):
    """Networks with random weights, and what they say of the whole surface."""
    import numpy as np
    from surfacesynthesis import poisson_net
    from surfacesynthesis.conversion import describe, expected_tensors
    from surfacesynthesis.safetensors import write_safetensors

    random = np.random.default_rng(4)
    for place in ("vertices", "faces", "global_mean"):
        metadata, network = describe({"head": "linear", "n_blocks": 1, "C_width": 8, "cmlp_nlayers": 1,
                                      "outputs_at": place, "last_activation": "log_softmax", "classes": ["arm", "head", "leg"],
                                      "input_normalisation": "surface_area"})
        tensors = {name: random.uniform(-0.3, 0.3, shape) for name, shape in expected_tensors(network).items()}
        write_safetensors(place + ".safetensors", tensors, metadata)
        pair = (surfaces.vtk_to_numpy(whole.GetPoints().GetData()),
                surfaces.vtk_to_numpy(whole.GetPolys().GetConnectivityArray()).reshape(-1, 3))
        if place != "global_mean":  # each class somewhere
            tensors["head.bias"] -= poisson_net(pair, place + ".safetensors").values.mean(axis=0)
            write_safetensors(place + ".safetensors", tensors, metadata)
        np.savez(place + ".npz", **poisson_net(pair, place + ".safetensors")._asdict())


def write_blocks(writer_class, blocks, path):
    writer = writer_class()
    writer.SetInputDataObject(blocks)
    writer.SetFileName(path)
    writer.SetDataModeToBinary()  # as in surfaces.write()
    assert writer.Write() == 1


def piece_of(surfaces, points, triangles, cells):
    import numpy as np

    used, local = np.unique(triangles[cells], return_inverse=True)
    return with_ids(surfaces, surfaces.mesh_of(points[used], local.reshape(-1, 3)), used, cells)


def with_ids(surfaces, piece, point_ids, cell_ids):
    for ids, data, kind in ((point_ids, piece.GetPointData(), "Point"), (cell_ids, piece.GetCellData(), "Cell")):
        for name in (f"Global{kind}Ids", f"Serial{kind}"):
            array = surfaces.numpy_to_vtkIdTypeArray(ids.astype("int64"), deep=True)
            array.SetName(name)
            data.AddArray(array)
        data.SetActiveGlobalIds(f"Global{kind}Ids")
    return piece


def write_pieces(surfaces, pieces, name):
    for k, piece in enumerate(pieces):
        surfaces.write(piece, f"{name}_{k}.vtp")
    with open(name + ".pvtp", "w", encoding="ascii") as file:
        file.write(f"""<?xml version="1.0"?>
<VTKFile type="PPolyData" version="1.0" byte_order="LittleEndian" header_type="UInt32">
  <PPolyData GhostLevel="0">
    <PPointData GlobalIds="GlobalPointIds">
      <PDataArray type="Int64" IdType="1" Name="GlobalPointIds"/><PDataArray type="Int64" IdType="1" Name="SerialPoint"/>
    </PPointData>
    <PCellData GlobalIds="GlobalCellIds">
      <PDataArray type="Int64" IdType="1" Name="GlobalCellIds"/><PDataArray type="Int64" IdType="1" Name="SerialCell"/>
    </PCellData>
    <PPoints><PDataArray type="Float64" NumberOfComponents="3" Name="Points"/></PPoints>
    {"".join(f'<Piece Source="{name}_{k}.vtp"/>' for k in range(len(pieces)))}
  </PPolyData>
</VTKFile>
""")


# ----------------------------------------------------------------------------------------------------------------------
# One case in pvbatch. The script runs on the first rank, the pipeline on all.
def run_case(case):
    import rank_cases

    ranks = rank_cases.number_of_ranks()
    assert ranks == int(os.environ["SURFACE_SYNTHESIS_RANKS"]), f"there are {ranks} ranks"
    rank_cases.CASES[case](case, ranks)
    print(f"finished: {case} on {ranks} ranks", flush=True)


# ----------------------------------------------------------------------------------------------------------------------
# The driver.
def mpi_run(ranks, cases):
    """Runs cases in one process per rank; returns what they wrote, or ends with an assertion."""
    case = ", ".join(cases)
    command = [os.environ["SURFACE_SYNTHESIS_MPIEXEC"], "--allow-run-as-root", "--oversubscribe", "--bind-to", "none", "-n", str(ranks),
               os.environ["SURFACE_SYNTHESIS_PVBATCH"], os.path.abspath(__file__), *cases]
    # Ranks that wait leave the processors to those that work: there may be more ranks than processors.
    environment = dict(
        os.environ, SURFACE_SYNTHESIS_RANKS=str(ranks), OMP_NUM_THREADS="1", OMPI_MCA_mpi_yield_when_idle="1")
    process = subprocess.Popen(
        command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, start_new_session=True)
    try:
        output, _ = process.communicate(timeout=TIME_LIMIT)
    except subprocess.TimeoutExpired:
        import signal

        os.killpg(process.pid, signal.SIGKILL)
        output, _ = process.communicate()
        raise AssertionError(f"{case} on {ranks} ranks hangs:\n{output}") from None
    assert process.returncode == 0, f"{case} on {ranks} ranks ended with {process.returncode}:\n{output}"
    for case in cases:
        assert f"finished: {case} on {ranks} ranks" in output, f"{case} on {ranks} ranks did not finish:\n{output}"
    return output


def check_results(ranks):
    output = mpi_run(ranks, VALID_CASES)
    assert "ERR|" not in output, output


def errors_of(output, filter_name):
    return [line.split("): ", 1)[1] for line in output.splitlines() if re.search(rf"ERR\| {filter_name}\b", line)]


def check_refusals(ranks):
    """Refusals are told once by every rank, in the same words. Each case is of another filter, or of a block: one run
    for all."""
    cases = ["bad_block", "bad_piece", "corrected_in_pieces", "mesh_on_one_rank", "mesh_in_pieces", "posed_in_pieces"]
    cases += ["from_example_in_pieces"]
    if WITH_NETWORKS:
        cases += ["cells_of_pieces", "compared_in_pieces", "trained_in_pieces", "textured_in_pieces", "fitted_in_pieces"]
        cases += ["texture_trained_in_pieces", "textures_compared_in_pieces"]
    output = mpi_run(ranks, cases)
    of_noise = errors_of(output, "vtkMaternNoiseFilter")
    in_pieces = [error for error in of_noise if "GatherPieces is off" in error or "Gather Pieces is off" in error]
    expect_errors(in_pieces, "vtkMaternNoiseFilter", ranks if ranks > 1 else 0, "Correction" if WITH_PETSC else "PETSc")
    of_noise = [error for error in of_noise if error not in in_pieces]
    of_block = [error for error in of_noise if "lock 4" in error]
    assert of_block and len(set(of_block)) == 1 and "non-manifold edge" in of_block[0], of_noise
    expect_errors([error for error in of_noise if error not in of_block], "vtkMaternNoiseFilter", ranks,
                  "non-manifold edge", "Feature Edges")
    # on one rank, a surface in pieces is whole: it is remeshed and compared, and posing refuses it or not for what it is
    in_pieces = ranks if ranks > 1 else 0
    if "no filter that makes another mesh" not in output:
        expect_refusal(output, "vtkSurfaceRepairFilter", in_pieces, "lies in pieces on", "Aggregate Dataset")
    if "no filter that makes poses" not in output and ranks > 1:
        expect_refusal(output, "vtkPoseEnsembleFilter", in_pieces, "lies in pieces on")
    expect_refusal(output, "vtkGeometricTextureFromExample", in_pieces, "lies in pieces on", "Aggregate Dataset")
    if WITH_NETWORKS:
        expect_refusal(output, "vtkPoissonNetFilter", ranks, "Prediction", "on one rank")
        words = "lies in pieces on", "Aggregate Dataset"
        expect_refusal(output, "vtkGeometricTextureSynthesizer", in_pieces, *words)
        for name in ("vtkEnsembleMetrics", "vtkFlowMatchingTrainer", "vtkMultiscaleMeshFitter",
                     "vtkGeometricTextureTrainer", "vtkGeometricTextureDistance"):
            if ranks > 1:
                expect_refusal(output, name, in_pieces, f"lie on {ranks} ranks", "Aggregate Dataset")


def expect_refusal(output, filter_name, times, *words):
    expect_errors(errors_of(output, filter_name), filter_name, times, *words)


def expect_errors(errors, filter_name, times, *words):
    assert len(errors) == times and len(set(errors)) <= 1, (filter_name, errors)
    assert all(word in error for word in words for error in errors), (filter_name, errors)


def main(ranks):
    checks = (check_results, check_refusals)
    failed = 0
    for count in ranks:
        for check in checks:
            try:
                check(count)
                print(f"passed: {check.__name__} on {count} ranks", flush=True)
            except AssertionError as error:
                print(f"FAILED: {check.__name__} on {count} ranks\n{error}", flush=True)
                failed += 1
    print(f"{len(ranks) * len(checks) - failed} of {len(ranks) * len(checks)} checks passed")
    return 1 if failed else 0


if __name__ == "__main__":
    if sys.argv[1:] == ["--write"]:
        write_surfaces()
    elif sys.argv[1:] and sys.argv[1] in CASES:
        try:
            for argument in sys.argv[1:]:
                run_case(argument)
        except BaseException:
            import traceback

            traceback.print_exc()
            sys.stderr.flush()
            os._exit(1)  # at once: other ranks wait for this one
    else:
        sys.exit(main([int(count) for count in sys.argv[1:]]))

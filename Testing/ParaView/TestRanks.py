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

TIME_LIMIT = 120  # seconds, for one run of mpiexec; it takes a few
SAMPLES = 7
RANGE = 24.0  # world units of the armadillo
WITH_NETWORKS = os.environ.get("SURFACE_SYNTHESIS_LEARNING") == "1"
NETWORK_CASES = ("predicted_points", "predicted_cells", "generated_samples", "generated_in_pieces", "compared",
                 "trained", "textured", "textured_blocks", "template_textured", "fitted", "texture_trained",
                 "textures_compared")
SOUND_CASES = ("one_rank", "blocks", "redistributed", "distributed", "empty_rank", "mixtures", "posed",
               *(NETWORK_CASES if WITH_NETWORKS else ()))
CASES = (*SOUND_CASES, "bad_piece", "bad_block", "cells_of_pieces", "mesh_on_one_rank", "mesh_in_pieces",
         "posed_in_pieces", "compared_in_pieces", "trained_in_pieces", "textured_in_pieces", "fitted_in_pieces",
         "texture_trained_in_pieces", "textures_compared_in_pieces")
MIXTURES = {"NumberOfCenters": 2, "Seed": 5, "NumberOfSamples": 2}
GENERATED = {"ModelFileName": "mixture.safetensors", "Seed": 5, "NumberOfSteps": 2}
POSES = {"NumberOfSamples": 3, "NumberOfHandles": 2, "NumberOfIterations": 5, "MaximumAngle": 30.0}
TRAINING = {"SignalArrayName": "Mixture", "Width": 8, "Blocks": 1, "ComplexLayers": 1, "BatchSize": 2, "Iterations": 2}
TEXTURED = {"ModelFileName": "texture.safetensors", "Seed": 5}
FITTED = {"NumberOfLevels": 2, "IcosphereLevel": 1, "Iterations": 2, "Samples": 50, "LearningRate": 1e-4}
TEXTURE_TRAINING = {"IterationsPerLevel": 2, "Layers": 3, "StartChannels": 4, "MinimumChannels": 4, "MaximumChannels": 4}


# ----------------------------------------------------------------------------------------------------------------------
# One process, without ParaView: surfaces and expected arrays.
def write_surfaces():
    import numpy as np
    import surfaces
    from vtkmodules.vtkCommonDataModel import vtkMultiBlockDataSet
    from vtkmodules.vtkIOXML import vtkXMLMultiBlockDataWriter

    whole = surfaces.armadillo()
    surfaces.write(whole, "whole.vtp")
    expected = surfaces.noise(whole, CorrelationRange=RANGE, NumberOfSamples=SAMPLES, Seed=11)
    np.save("whole.npy", np.stack([surfaces.array(expected, f"MaternNoise_{k}") for k in range(SAMPLES)]))

    write_ensembles(surfaces, whole)
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
    import numpy as np
    import surfaces
    from paraview import servermanager
    from paraview import simple as pv

    if not hasattr(pv, "MaternNoise"):
        pv.LoadPlugin(surfaces.plugin(), remote=False, ns=vars(pv))
    ranks = servermanager.vtkProcessModule.GetProcessModule().GetNumberOfLocalPartitions()
    assert ranks == int(os.environ["SURFACE_SYNTHESIS_RANKS"]), f"there are {ranks} ranks"
    parameters = {"CorrelationRange": RANGE, "NumberOfSamples": SAMPLES, "Seed": 11}
    whole = np.load("whole.npy")

    def update(proxy):
        proxy.UpdatePipeline()
        return servermanager.Fetch(proxy)

    def count_of_ranks_with_cells(proxy):
        ids = update(pv.ProcessIdScalars(Input=proxy))
        return len(np.unique(surfaces.array(ids, "ProcessId")))

    def compare_with_whole(found, points=None):
        points = surfaces.array(found, "SerialPoint") if points is None else points
        for k in range(SAMPLES):
            surfaces.assert_same(surfaces.array(found, f"MaternNoise_{k}"), whole[k][points], f"{case}, sample {k}")

    if case == "one_rank":
        reader = pv.XMLPolyDataReader(FileName=["whole.vtp"])
        assert count_of_ranks_with_cells(reader) == 1
        made = pv.MaternNoise(Input=reader, **parameters)
        compare_with_whole(update(made), np.arange(whole.shape[1]))
        for first, count in ((0, 1), (2, 5)):  # again, with fewer samples than ranks, and with others
            made.FirstSample, made.NumberOfSamples = first, count
            found = update(made)
            for k in range(first, first + count):
                name = f"MaternNoise_{k}" if count > 1 else "MaternNoise"
                surfaces.assert_same(surfaces.array(found, name), whole[k], f"{case}, sample {k} of {count}")
    elif case == "blocks":
        made = pv.MaternNoise(Input=pv.XMLMultiBlockDataReader(FileName=["blocks.vtm"]), CorrelationRange=1.5, Seed=11)
        made.UpdatePipeline()
        pv.SaveData(f"found_blocks_{ranks}.vtm", proxy=made)
        found = read_blocks(f"found_blocks_{ranks}.vtm")
        for k in (0, 1, 2, 4):
            surfaces.assert_same(surfaces.array(found[k]), np.load(f"block{k}.npy"), f"{case}, block {k}")
    elif case in ("distributed", "empty_rank"):
        name = "quarters" if case == "distributed" else "with_empty"
        reader = pv.XMLPartitionedPolydataReader(FileName=[name + ".pvtp"])
        assert count_of_ranks_with_cells(reader) == (min(ranks, 4) if case == "distributed" else min(ranks, 3))
        found = update(pv.MaternNoise(Input=reader, **parameters))
        points = surfaces.array(found, "SerialPoint")
        assert set(points) == set(range(whole.shape[1])), "a point is missing"
        assert found.GetNumberOfCells() == 52000, found.GetNumberOfCells()
        assert ranks == 1 or len(points) > whole.shape[1], "no point lies on two pieces"
        compare_with_whole(found)
    elif case == "redistributed":  # no ids: points on a cut are found by their coordinates
        reader = pv.XMLPolyDataReader(FileName=["whole.vtp"])
        pieces = pv.ExtractSurface(Input=pv.RedistributeDataSet(Input=reader))
        assert count_of_ranks_with_cells(pieces) == ranks
        found = update(pv.MaternNoise(Input=pieces, **parameters))
        places = np.array([found.GetPoint(p) for p in range(found.GetNumberOfPoints())])
        unique, first, point = np.unique(places, axis=0, return_index=True, return_inverse=True)
        assert len(unique) == whole.shape[1], (len(unique), whole.shape[1])
        assert ranks == 1 or len(places) > len(unique), "no point lies on two pieces"
        fields = np.stack([surfaces.array(found, f"MaternNoise_{k}") for k in range(SAMPLES)])
        assert (fields == fields[:, first][:, point]).all(), "a seam: one point has two values"
        deviation = np.sqrt(np.mean(fields[:, first] ** 2))
        assert 0.85 < deviation < 1.15, f"the standard deviation is {deviation}"
    elif case == "predicted_points":  # numbers and labels in their own types, and field data, on every piece
        reader = pv.XMLPartitionedPolydataReader(FileName=["quarters.pvtp"])
        expected = np.load("vertices.npz")
        found = update(pv.PoissonNet(Input=reader, ModelFileName="vertices.safetensors"))
        points = surfaces.array(found, "SerialPoint")
        surfaces.assert_same(surfaces.array(found, "Prediction"), expected["values"][points], case)
        surfaces.assert_same(surfaces.array(found, "Label"), expected["labels"][points], case)
        found = update(pv.PoissonNet(Input=reader, ModelFileName="global_mean.safetensors"))
        fields, expected = found.GetFieldData(), np.load("global_mean.npz")
        assert np.array_equal(surfaces.vtk_to_numpy(fields.GetArray("Prediction"))[0], expected["values"])
        names = fields.GetAbstractArray("ClassNames")
        assert [names.GetValue(k) for k in range(3)] == ["arm", "head", "leg"]
    elif case == "predicted_cells":  # of a surface that lies on one rank
        reader = pv.XMLPolyDataReader(FileName=["whole.vtp"])
        found = update(pv.PoissonNet(Input=reader, ModelFileName="faces.safetensors"))
        labels = surfaces.vtk_to_numpy(found.GetCellData().GetArray("Label"))
        surfaces.assert_same(labels, np.load("faces.npz")["labels"], case)
    elif case == "mixtures":  # of a surface on one rank, and of one in pieces
        expected = np.load("mixtures.npy")
        for reader in (pv.XMLPolyDataReader(FileName=["whole.vtp"]),
                       pv.XMLPartitionedPolydataReader(FileName=["quarters.pvtp"])):
            found = update(pv.GaussianMixture(Input=reader, **MIXTURES))
            points = surfaces.array(found, "SerialPoint") if "SerialPoint" in surfaces.names(found) else slice(None)
            for k in range(2):
                surfaces.assert_same(surfaces.array(found, f"Mixture_{k}"), expected[k][points], f"{case}, sample {k}")
    elif case == "posed":
        if hasattr(pv, "PoseEnsemble"):
            found = update(pv.PoseEnsemble(Input=pv.XMLPolyDataReader(FileName=["long.vtp"]), **POSES))
            for k, points in enumerate(np.load("poses.npy")):
                posed = surfaces.vtk_to_numpy(sample_in(found, k).GetPoints().GetData())
                surfaces.assert_same(posed, points, f"{case}, sample {k}")
    elif case == "posed_in_pieces":
        if hasattr(pv, "PoseEnsemble"):
            reader = pv.XMLPartitionedPolydataReader(FileName=["quarters.pvtp"])
            found = update(pv.PoseEnsemble(Input=reader, **POSES))
            assert ranks == 1 or found.GetNumberOfPoints() == 0, "an error leaves the output empty"
        else:
            print("no filter that makes poses is in this plugin")
    elif case == "generated_samples":  # sample k on rank k mod ranks
        made = pv.FlowMatchingSampler(
            Input=pv.XMLPolyDataReader(FileName=["whole.vtp"]), NumberOfSamples=3, **GENERATED)
        found = update(made)
        for k, values in enumerate(np.load("generated.npy")):
            surfaces.assert_same(surfaces.array(sample_in(found, k), "Mixture"), values, f"{case}, sample {k}")
    elif case == "generated_in_pieces":
        reader = pv.XMLPartitionedPolydataReader(FileName=["quarters.pvtp"])
        found = update(pv.FlowMatchingSampler(Input=reader, **GENERATED))
        values = np.load("generated.npy")[0][surfaces.array(found, "SerialPoint")]
        surfaces.assert_same(surfaces.array(found, "Mixture"), values, case)
    elif case in ("compared", "compared_in_pieces"):
        reader = (pv.XMLPolyDataReader(FileName=["ensemble.vtp"]) if case == "compared" else
                  pv.XMLPartitionedPolydataReader(FileName=["quarters.pvtp"]))
        table = update(pv.EnsembleMetrics(
            Input=reader, Reference=reader, ArrayName="Mixture" if case == "compared" else "SerialPoint"))
        expected_rows = 1 if case == "compared" or ranks == 1 else 0
        assert table.GetNumberOfRows() == expected_rows, table.GetNumberOfRows()
        assert expected_rows == 0 or table.GetValueByName(0, "MMD").ToDouble() == 0.0
    elif case in ("trained", "trained_in_pieces"):
        reader = (pv.XMLPolyDataReader(FileName=["ensemble.vtp"]) if case == "trained" else
                  pv.XMLPartitionedPolydataReader(FileName=["quarters.pvtp"]))
        name = f"{case}_{ranks}.safetensors"
        table = update(pv.FlowMatchingTrainer(
            Input=reader, Samples=reader, ModelFileName=name, Resume=0, Device="CPU", **TRAINING))
        trained = case == "trained"
        assert table.GetNumberOfRows() == (2 if trained else 0), table.GetNumberOfRows()
        assert os.path.exists(name) == trained
    elif case in ("textured", "textured_in_pieces"):
        reader = (pv.XMLPolyDataReader(FileName=["ball0.vtp"]) if case == "textured" else
                  pv.XMLPartitionedPolydataReader(FileName=["quarters.pvtp"]))
        found = update(pv.GeometricTextureSynthesizer(Input=reader, **TEXTURED))
        if case == "textured":
            points = surfaces.vtk_to_numpy(found.GetPoints().GetData())
            surfaces.assert_same(points, np.load("textured.npy"), case)
        else:
            assert (found.GetNumberOfPoints() > 0) == (ranks == 1), found.GetNumberOfPoints()
    elif case == "textured_blocks":  # noise depends on the block, not on where it lies
        readers = [pv.XMLPolyDataReader(FileName=[f"ball{k}.vtp"]) for k in range(2)]
        made = pv.GeometricTextureSynthesizer(Input=pv.GroupDatasets(Input=readers), **TEXTURED)
        made.UpdatePipeline()
        pv.SaveData(f"found_textured_{ranks}.vtm", proxy=made)
        expected = np.load("textured_blocks.npz")
        for k, block in enumerate(read_blocks(f"found_textured_{ranks}.vtm")):
            points = surfaces.vtk_to_numpy(block.GetPoints().GetData())
            surfaces.assert_same(points, expected[f"arr_{k}"], f"{case}, block {k}")
    elif case in ("fitted", "fitted_in_pieces"):
        reader = (pv.XMLPolyDataReader(FileName=["ball0.vtp"]) if case == "fitted" else
                  pv.XMLPartitionedPolydataReader(FileName=["quarters.pvtp"]))
        made = pv.MultiscaleMeshFitter(Input=reader, **FITTED)
        found = update(made)
        if case == "fitted":
            for k in range(2):
                points = surfaces.vtk_to_numpy(sample_in(found, k).GetPoints().GetData())
                # The bits of a fit depend on the threads. At each level a step of Adam moves points by about 1e-4 mean
                # edges of half a radius, and there are 10.
                apart = np.abs(points - np.load("fitted.npz")[f"arr_{k}"]).max()
                assert apart < 2 * (k + 1) * 10 * 0.5e-4, f"{case}, level {k}: {apart}"
        else:
            assert (found.GetNumberOfPoints() > 0) == (ranks == 1), found.GetNumberOfPoints()
    elif case in ("texture_trained", "texture_trained_in_pieces"):
        reader = (pv.XMLPolyDataReader(FileName=["ball0.vtp"]) if case == "texture_trained" else
                  pv.XMLPartitionedPolydataReader(FileName=["quarters.pvtp"]))
        name = f"{case}_{ranks}.safetensors"
        table = update(
            pv.GeometricTextureTrainer(Input=reader, ModelFileName=name, Resume=0, Device="CPU", **TEXTURE_TRAINING))
        trained = case == "texture_trained" or ranks == 1
        assert table.GetNumberOfRows() == (2 if trained else 0), table.GetNumberOfRows()
        assert os.path.exists(name) == trained
    elif case == "template_textured":  # the reference of a training, without input
        pv.GeometricTextureTrainer(
            Input=pv.XMLPolyDataReader(FileName=["ball0.vtp"]), ModelFileName=f"template_{ranks}.safetensors", Resume=0,
            Device="CPU", **TEXTURE_TRAINING).UpdatePipeline()
        pv.SetActiveSource(None)
        found = update(pv.GeometricTextureSynthesizer(ModelFileName=f"template_{ranks}.safetensors"))
        assert found.GetNumberOfPolys() == 432, "one level of the ball, once"
    elif case in ("textures_compared", "textures_compared_in_pieces"):
        reader = (pv.XMLPolyDataReader(FileName=["ball0.vtp"]) if case == "textures_compared" else
                  pv.XMLPartitionedPolydataReader(FileName=["quarters.pvtp"]))
        table = update(pv.GeometricTextureDistance(
            Input=reader, Reference=pv.XMLPolyDataReader(FileName=["ball1.vtp"]), NumberOfProjections=128))
        expected_rows = 1 if case == "textures_compared" or ranks == 1 else 0
        assert table.GetNumberOfRows() == expected_rows, table.GetNumberOfRows()
        if case == "textures_compared":
            assert table.GetValueByName(0, "Distance").ToDouble() == np.load("distance.npy")
    elif case == "cells_of_pieces":
        reader = pv.XMLPartitionedPolydataReader(FileName=["quarters.pvtp"])
        found = update(pv.PoissonNet(Input=reader, ModelFileName="faces.safetensors"))
        assert found.GetNumberOfPoints() == 0, "an error leaves the output empty"
    elif case == "bad_piece":
        found = update(pv.MaternNoise(Input=pv.XMLPartitionedPolydataReader(FileName=["bad.pvtp"]), **parameters))
        assert found.GetNumberOfPoints() == 0, "an error leaves the output empty"
    elif case == "bad_block":
        made = pv.MaternNoise(
            Input=pv.XMLMultiBlockDataReader(FileName=["bad_blocks.vtm"]), CorrelationRange=1.5, Seed=11)
        made.UpdatePipeline()
        pv.SaveData(f"found_bad_blocks_{ranks}.vtm", proxy=made)
        found = read_blocks(f"found_bad_blocks_{ranks}.vtm")
        for k in (0, 1, 2, 4):
            surfaces.assert_same(surfaces.array(found[k]), np.load(f"block{k}.npy"), f"{case}, block {k}")
        assert found[3] is None or found[3].GetNumberOfPoints() == 0
    elif case == "mesh_on_one_rank":  # a filter that makes another mesh works where the surface lies
        if hasattr(pv, "SurfaceRepair"):
            found = update(pv.SurfaceRepair(Input=pv.XMLPolyDataReader(FileName=["whole.vtp"])))
            assert found.GetNumberOfPoints() == whole.shape[1] and found.GetNumberOfCells() == 52000
    elif case == "mesh_in_pieces":  # and says so when it lies on several
        if hasattr(pv, "SurfaceRepair"):
            found = update(pv.SurfaceRepair(Input=pv.XMLPartitionedPolydataReader(FileName=["quarters.pvtp"])))
            assert (found.GetNumberOfPoints() > 0) == (ranks == 1), found.GetNumberOfPoints()
        else:
            print("no filter that makes another mesh is in this plugin")
    else:
        raise ValueError(case)
    print(f"finished: {case} on {ranks} ranks", flush=True)


def read_blocks(path):
    """The blocks of a file by their place; a block that is cut into pieces fails."""
    from vtkmodules.vtkCommonDataModel import vtkPolyData
    from vtkmodules.vtkIOXML import vtkXMLMultiBlockDataReader

    reader = vtkXMLMultiBlockDataReader()
    reader.SetFileName(path)
    reader.Update()
    blocks = reader.GetOutputDataObject(0)
    found = []
    for k in range(blocks.GetNumberOfBlocks()):
        block = blocks.GetBlock(k)
        if block is not None and not block.IsA("vtkPolyData"):
            pieces = [block.GetPartition(p) if hasattr(block, "GetPartition") else block.GetBlock(p)
                      for p in range(block.GetNumberOfChildren())]
            pieces = [piece for piece in pieces if piece is not None and piece.GetNumberOfPoints() > 0]
            assert len(pieces) <= 1, f"block {k} has {len(pieces)} pieces"
            block = pieces[0] if pieces else vtkPolyData()
        found.append(block)
    return found


def sample_in(found, k):
    """Sample k of an ensemble that was fetched: from several ranks it comes in a block for each of them."""
    of_ranks = [found.GetBlock(r) for r in range(found.GetNumberOfBlocks())]
    if not all(block is None or block.IsA("vtkMultiBlockDataSet") for block in of_ranks):
        of_ranks = [found]
    samples = [blocks.GetBlock(k) for blocks in of_ranks if blocks is not None and blocks.GetNumberOfBlocks() > k]
    samples = [sample for sample in samples if sample is not None and sample.GetNumberOfPoints() > 0]
    assert len(samples) == 1, f"sample {k} lies on {len(samples)} ranks"
    return samples[0]


# ----------------------------------------------------------------------------------------------------------------------
# The driver.
def mpi_run(ranks, cases):
    """Runs cases in one process per rank; returns what they wrote, or ends with an assertion."""
    case = ", ".join(cases)
    command = [os.environ["SURFACE_SYNTHESIS_MPIEXEC"], "--allow-run-as-root", "--oversubscribe", "--bind-to", "none", "-n", str(ranks),
               os.environ["SURFACE_SYNTHESIS_PVBATCH"], os.path.abspath(__file__), *cases]
    environment = dict(os.environ, SURFACE_SYNTHESIS_RANKS=str(ranks), OMP_NUM_THREADS="1")
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


def check_sound(ranks):
    output = mpi_run(ranks, SOUND_CASES)
    assert "ERR|" not in output, output


def errors_of(output, filter_name):
    return [line.split("): ", 1)[1] for line in output.splitlines() if re.search(rf"ERR\| {filter_name}\b", line)]


def check_bad_block(ranks):
    """The other blocks are not affected."""
    errors = errors_of(mpi_run(ranks, ["bad_block"]), "vtkMaternNoiseFilter")
    assert errors and len(set(errors)) == 1, errors
    assert "non-manifold edge" in errors[0] and "lock 4" in errors[0], errors


def check_refusals(ranks):
    """Refusals are told once by every rank, in the same words. Each case is of another filter: one run for all."""
    cases = ["bad_piece", "mesh_on_one_rank", "mesh_in_pieces", "posed_in_pieces"]
    if WITH_NETWORKS:
        cases += ["cells_of_pieces", "compared_in_pieces", "trained_in_pieces", "textured_in_pieces", "fitted_in_pieces"]
        cases += ["texture_trained_in_pieces", "textures_compared_in_pieces"]
    output = mpi_run(ranks, cases)
    expect_refusal(output, "vtkMaternNoiseFilter", ranks, "non-manifold edge", "Feature Edges")
    # on one rank, a surface in pieces is whole: it is remeshed and compared, and posing refuses it or not for what it is
    in_pieces = ranks if ranks > 1 else 0
    if "no filter that makes another mesh" not in output:
        expect_refusal(output, "vtkSurfaceRepairFilter", in_pieces, "lies in pieces on", "Aggregate Dataset")
    if "no filter that makes poses" not in output and ranks > 1:
        expect_refusal(output, "vtkPoseEnsembleFilter", in_pieces, "lies in pieces on")
    if WITH_NETWORKS:
        expect_refusal(output, "vtkPoissonNetFilter", ranks, "Prediction", "on one rank")
        words = "lies in pieces on", "Aggregate Dataset"
        expect_refusal(output, "vtkGeometricTextureSynthesizer", in_pieces, *words)
        for name in ("vtkEnsembleMetrics", "vtkFlowMatchingTrainer", "vtkMultiscaleMeshFitter",
                     "vtkGeometricTextureTrainer", "vtkGeometricTextureDistance"):
            if ranks > 1:
                expect_refusal(output, name, in_pieces, f"lie on {ranks} ranks", "Aggregate Dataset")


def expect_refusal(output, filter_name, times, *words):
    errors = errors_of(output, filter_name)
    assert len(errors) == times and len(set(errors)) <= 1, (filter_name, errors)
    assert all(word in error for word in words for error in errors), (filter_name, errors)


def main(ranks):
    checks = (check_sound, check_bad_block, check_refusals)
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

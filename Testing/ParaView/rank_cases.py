# SPDX-License-Identifier: BSD-3-Clause
"""The cases of TestRanks.py: pipelines on all ranks, compared with the arrays of one process."""

import os

import numpy as np
import surfaces
from paraview import servermanager
from paraview import simple as pv
from rank_parameters import FITTED, FROM_EXAMPLE, GENERATED, MIXTURES, NOISE, POSES, SAMPLES, TEXTURED, TEXTURE_TRAINING, TRAINING

if not hasattr(pv, "MaternNoise"):
    pv.LoadPlugin(surfaces.plugin(), remote=False, ns=vars(pv))


def number_of_ranks():
    return servermanager.vtkProcessModule.GetProcessModule().GetNumberOfLocalPartitions()


def read_surface(name):
    return pv.XMLPolyDataReader(FileName=[name])


def read_pieces(name):
    return pv.XMLPartitionedPolydataReader(FileName=[name])


def reader_of(name, case):
    """A surface, or for cases "..._in_pieces" one that lies in pieces."""
    return read_pieces("quarters.pvtp") if case.endswith("_in_pieces") else read_surface(name)


def update(proxy):
    proxy.UpdatePipeline()
    return servermanager.Fetch(proxy)


def count_of_ranks_with_cells(proxy):
    ids = update(pv.ProcessIdScalars(Input=proxy))
    return len(np.unique(surfaces.array(ids, "ProcessId")))


def compare_with_whole(case, found, points=None):
    whole = np.load("whole.npy")
    points = surfaces.array(found, "SerialPoint") if points is None else points
    for k in range(SAMPLES):
        surfaces.assert_same(surfaces.array(found, f"MaternNoise_{k}"), whole[k][points], f"{case}, sample {k}")


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


def one_rank(case, ranks):
    whole = np.load("whole.npy")
    reader = read_surface("whole.vtp")
    assert count_of_ranks_with_cells(reader) == 1
    made = pv.MaternNoise(Input=reader, **NOISE)
    compare_with_whole(case, update(made), np.arange(whole.shape[1]))
    for first, count in ((0, 1), (2, 5)):  # again, with fewer samples than ranks, and with others
        made.FirstSample, made.NumberOfSamples = first, count
        found = update(made)
        for k in range(first, first + count):
            name = f"MaternNoise_{k}" if count > 1 else "MaternNoise"
            surfaces.assert_same(surfaces.array(found, name), whole[k], f"{case}, sample {k} of {count}")


def blocks(case, ranks):
    made = pv.MaternNoise(Input=pv.XMLMultiBlockDataReader(FileName=["blocks.vtm"]), CorrelationRange=1.5, Seed=11)
    made.UpdatePipeline()
    pv.SaveData(f"found_blocks_{ranks}.vtm", proxy=made, DataMode="Binary")
    found = read_blocks(f"found_blocks_{ranks}.vtm")
    for k in (0, 1, 2, 4):
        surfaces.assert_same(surfaces.array(found[k]), np.load(f"block{k}.npy"), f"{case}, block {k}")


def distributed(case, ranks):
    whole = np.load("whole.npy")
    name = "quarters" if case == "distributed" else "with_empty"
    reader = read_pieces(name + ".pvtp")
    assert count_of_ranks_with_cells(reader) == (min(ranks, 4) if case == "distributed" else min(ranks, 3))
    found = update(pv.MaternNoise(Input=reader, **NOISE))
    points = surfaces.array(found, "SerialPoint")
    assert set(points) == set(range(whole.shape[1])), "a point is missing"
    assert found.GetNumberOfCells() == 52000, found.GetNumberOfCells()
    assert ranks == 1 or len(points) > whole.shape[1], "no point lies on two pieces"
    compare_with_whole(case, found)


def reads_appended_data():
    """Says if VTK's own files with appended data can be read: Expat 2.5.0-1+deb12u2 takes them for no XML."""
    from vtkmodules.vtkCommonCore import vtkObject
    from vtkmodules.vtkIOXML import vtkXMLPolyDataReader, vtkXMLPolyDataWriter

    writer, reader = vtkXMLPolyDataWriter(), vtkXMLPolyDataReader()
    writer.SetInputDataObject(surfaces.ball(4))
    writer.SetDataModeToAppended()
    writer.WriteToOutputStringOn()
    writer.Write()
    reader.ReadFromInputStringOn()
    reader.SetInputString(writer.GetOutputString())
    shown = vtkObject.GetGlobalWarningDisplay()
    vtkObject.SetGlobalWarningDisplay(0)
    reader.Update()
    vtkObject.SetGlobalWarningDisplay(shown)
    return reader.GetOutput().GetNumberOfPoints() > 0


def redistributed(case, ranks):
    """No ids: points on a cut are found by their coordinates."""
    whole = np.load("whole.npy")
    if reads_appended_data():
        pieces = pv.ExtractSurface(Input=pv.RedistributeDataSet(Input=read_surface("whole.vtp")))
    else:
        print("RedistributeDataSet sends appended XML, which this system's Expat refuses: pieces without ids are read")
        pieces = pv.PassArrays(Input=read_pieces("quarters.pvtp"), PointDataArrays=[], CellDataArrays=[])
        pieces = pv.Clean(Input=pieces, PieceInvariant=0)  # joins two pieces of one rank
    assert count_of_ranks_with_cells(pieces) == ranks
    found = update(pv.MaternNoise(Input=pieces, **NOISE))
    places = np.array([found.GetPoint(p) for p in range(found.GetNumberOfPoints())])
    unique, first, point = np.unique(places, axis=0, return_index=True, return_inverse=True)
    assert len(unique) == whole.shape[1], (len(unique), whole.shape[1])
    assert ranks == 1 or len(places) > len(unique), "no point lies on two pieces"
    fields = np.stack([surfaces.array(found, f"MaternNoise_{k}") for k in range(SAMPLES)])
    assert (fields == fields[:, first][:, point]).all(), "a seam: one point has two values"
    deviation = np.sqrt(np.mean(fields[:, first] ** 2))
    assert 0.85 < deviation < 1.15, f"the standard deviation is {deviation}"


def predicted_points(case, ranks):
    """Numbers and labels in their own types, and field data, on every piece."""
    reader = read_pieces("quarters.pvtp")
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


def predicted_cells(case, ranks):
    """Of a surface that lies on one rank."""
    reader = read_surface("whole.vtp")
    found = update(pv.PoissonNet(Input=reader, ModelFileName="faces.safetensors"))
    labels = surfaces.vtk_to_numpy(found.GetCellData().GetArray("Label"))
    surfaces.assert_same(labels, np.load("faces.npz")["labels"], case)


def mixtures(case, ranks):
    """Of a surface on one rank, and of one in pieces."""
    expected = np.load("mixtures.npy")
    for reader in (read_surface("whole.vtp"), read_pieces("quarters.pvtp")):
        found = update(pv.GaussianMixture(Input=reader, **MIXTURES))
        points = surfaces.array(found, "SerialPoint") if "SerialPoint" in surfaces.names(found) else slice(None)
        for k in range(2):
            surfaces.assert_same(surfaces.array(found, f"Mixture_{k}"), expected[k][points], f"{case}, sample {k}")


def posed(case, ranks):
    if hasattr(pv, "PoseEnsemble"):
        found = update(pv.PoseEnsemble(Input=read_surface("long.vtp"), **POSES))
        for k, points in enumerate(np.load("poses.npy")):
            posed = surfaces.vtk_to_numpy(sample_in(found, k).GetPoints().GetData())
            surfaces.assert_same(posed, points, f"{case}, sample {k}")


def posed_in_pieces(case, ranks):
    if hasattr(pv, "PoseEnsemble"):
        reader = read_pieces("quarters.pvtp")
        found = update(pv.PoseEnsemble(Input=reader, **POSES))
        assert ranks == 1 or found.GetNumberOfPoints() == 0, "an error leaves the output empty"
    else:
        print("no filter that makes poses is in this plugin")


def generated_samples(case, ranks):
    """Sample k on rank k mod ranks."""
    made = pv.FlowMatchingSampler(Input=read_surface("whole.vtp"), NumberOfSamples=3, **GENERATED)
    found = update(made)
    for k, values in enumerate(np.load("generated.npy")):
        surfaces.assert_same(surfaces.array(sample_in(found, k), "Mixture"), values, f"{case}, sample {k}")


def generated_in_pieces(case, ranks):
    reader = read_pieces("quarters.pvtp")
    found = update(pv.FlowMatchingSampler(Input=reader, **GENERATED))
    values = np.load("generated.npy")[0][surfaces.array(found, "SerialPoint")]
    surfaces.assert_same(surfaces.array(found, "Mixture"), values, case)


def compared(case, ranks):
    reader = reader_of("ensemble.vtp", case)
    table = update(pv.EnsembleMetrics(
        Input=reader, Reference=reader, ArrayName="Mixture" if case == "compared" else "SerialPoint"))
    expected_rows = 1 if case == "compared" or ranks == 1 else 0
    assert table.GetNumberOfRows() == expected_rows, table.GetNumberOfRows()
    assert expected_rows == 0 or table.GetValueByName(0, "MMD").ToDouble() == 0.0


def trained(case, ranks):
    reader = reader_of("ensemble.vtp", case)
    name = f"{case}_{ranks}.safetensors"
    table = update(pv.FlowMatchingTrainer(
        Input=reader, Samples=reader, ModelFileName=name, Resume=0, Device="CPU", **TRAINING))
    trained = case == "trained"
    assert table.GetNumberOfRows() == (2 if trained else 0), table.GetNumberOfRows()
    assert os.path.exists(name) == trained


def textured(case, ranks):
    reader = reader_of("ball0.vtp", case)
    found = update(pv.GeometricTextureSynthesizer(Input=reader, **TEXTURED))
    if case == "textured":
        points = surfaces.vtk_to_numpy(found.GetPoints().GetData())
        surfaces.assert_same(points, np.load("textured.npy"), case)
    else:
        assert (found.GetNumberOfPoints() > 0) == (ranks == 1), found.GetNumberOfPoints()


def textured_blocks(case, ranks):
    """Noise depends on the block, not on where it lies."""
    readers = [read_surface(f"ball{k}.vtp") for k in range(2)]
    made = pv.GeometricTextureSynthesizer(Input=pv.GroupDatasets(Input=readers), **TEXTURED)
    made.UpdatePipeline()
    pv.SaveData(f"found_textured_{ranks}.vtm", proxy=made, DataMode="Binary")
    expected = np.load("textured_blocks.npz")
    for k, block in enumerate(read_blocks(f"found_textured_{ranks}.vtm")):
        points = surfaces.vtk_to_numpy(block.GetPoints().GetData())
        surfaces.assert_same(points, expected[f"arr_{k}"], f"{case}, block {k}")


def from_example(case, ranks):
    """All ranks read the whole example."""
    if case != "from_example" and ranks == 1:
        return  # a surface in pieces is whole there, and a large one takes a minute
    examples = {"Example": read_surface("waves.vtp"), "PlainExample": read_surface("plain.vtp")}
    found = update(pv.GeometricTextureFromExample(Input=reader_of("target.vtp", case), **examples, **FROM_EXAMPLE))
    if case == "from_example":
        points = surfaces.vtk_to_numpy(found.GetPoints().GetData())
        surfaces.assert_same(points, np.load("from_example.npy"), case)
    else:
        assert found.GetNumberOfPoints() == 0, found.GetNumberOfPoints()


def fitted(case, ranks):
    reader = reader_of("ball0.vtp", case)
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


def texture_trained(case, ranks):
    reader = reader_of("ball0.vtp", case)
    name = f"{case}_{ranks}.safetensors"
    table = update(
        pv.GeometricTextureTrainer(Input=reader, ModelFileName=name, Resume=0, Device="CPU", **TEXTURE_TRAINING))
    trained = case == "texture_trained" or ranks == 1
    assert table.GetNumberOfRows() == (2 if trained else 0), table.GetNumberOfRows()
    assert os.path.exists(name) == trained


def template_textured(case, ranks):
    """The reference of a training, without input."""
    pv.GeometricTextureTrainer(
        Input=read_surface("ball0.vtp"), ModelFileName=f"template_{ranks}.safetensors", Resume=0,
        Device="CPU", **TEXTURE_TRAINING).UpdatePipeline()
    pv.SetActiveSource(None)
    found = update(pv.GeometricTextureSynthesizer(ModelFileName=f"template_{ranks}.safetensors"))
    assert found.GetNumberOfPolys() == 432, "one level of the ball, once"


def textures_compared(case, ranks):
    reader = reader_of("ball0.vtp", case)
    table = update(pv.GeometricTextureDistance(
        Input=reader, Reference=read_surface("ball1.vtp"), NumberOfProjections=128))
    expected_rows = 1 if case == "textures_compared" or ranks == 1 else 0
    assert table.GetNumberOfRows() == expected_rows, table.GetNumberOfRows()
    if case == "textures_compared":
        assert table.GetValueByName(0, "Distance").ToDouble() == np.load("distance.npy")


def cells_of_pieces(case, ranks):
    reader = read_pieces("quarters.pvtp")
    found = update(pv.PoissonNet(Input=reader, ModelFileName="faces.safetensors"))
    assert found.GetNumberOfPoints() == 0, "an error leaves the output empty"


def bad_piece(case, ranks):
    found = update(pv.MaternNoise(Input=read_pieces("bad.pvtp"), **NOISE))
    assert found.GetNumberOfPoints() == 0, "an error leaves the output empty"


def solved_in_pieces(case, ranks):
    """Solved where the pieces lie: the noise of the whole to 1e-8, on one rank its bits."""
    whole = np.load("whole.npy")
    for name in ("quarters", "with_empty"):
        made = pv.MaternNoise(Input=read_pieces(name + ".pvtp"), GatherPieces=0, Refinement=0, **dict(NOISE, NumberOfSamples=2))
        for seed in (12, NOISE["Seed"]):  # the second one on operators that are held
            made.Seed = seed
            found = update(made)
        points = surfaces.array(found, "SerialPoint")
        assert set(points) == set(range(whole.shape[1])), "a point is missing"
        for k in range(2):
            difference = np.abs(surfaces.array(found, f"MaternNoise_{k}") - whole[k][points]).max()
            assert difference <= 1e-8 * np.abs(whole[k]).max(), f"{name}, sample {k}: {difference}"


def corrected_in_pieces(case, ranks):
    found = update(pv.MaternNoise(
        Input=read_pieces("quarters.pvtp"), GatherPieces=0, Refinement=0, VarianceCorrection=1, CorrelationRange=24.0))
    assert (found.GetNumberOfPoints() == 0) == (ranks > 1), "an error leaves the output empty"


def bad_block(case, ranks):
    made = pv.MaternNoise(
        Input=pv.XMLMultiBlockDataReader(FileName=["bad_blocks.vtm"]), CorrelationRange=1.5, Seed=11)
    made.UpdatePipeline()
    pv.SaveData(f"found_bad_blocks_{ranks}.vtm", proxy=made, DataMode="Binary")
    found = read_blocks(f"found_bad_blocks_{ranks}.vtm")
    for k in (0, 1, 2, 4):
        surfaces.assert_same(surfaces.array(found[k]), np.load(f"block{k}.npy"), f"{case}, block {k}")
    assert found[3] is None or found[3].GetNumberOfPoints() == 0


def mesh_on_one_rank(case, ranks):
    """A filter that makes another mesh works where the surface lies."""
    whole = np.load("whole.npy")
    if hasattr(pv, "SurfaceRepair"):
        found = update(pv.SurfaceRepair(Input=read_surface("whole.vtp")))
        assert found.GetNumberOfPoints() == whole.shape[1] and found.GetNumberOfCells() == 52000


def mesh_in_pieces(case, ranks):
    """And says so when it lies on several."""
    if hasattr(pv, "SurfaceRepair"):
        found = update(pv.SurfaceRepair(Input=read_pieces("quarters.pvtp")))
        assert (found.GetNumberOfPoints() > 0) == (ranks == 1), found.GetNumberOfPoints()
    else:
        print("no filter that makes another mesh is in this plugin")


#: Function of each case, which takes the name of the case and the number of ranks.
CASES = {
    "one_rank": one_rank,
    "blocks": blocks,
    "distributed": distributed,
    "empty_rank": distributed,
    "redistributed": redistributed,
    "predicted_points": predicted_points,
    "predicted_cells": predicted_cells,
    "mixtures": mixtures,
    "posed": posed,
    "posed_in_pieces": posed_in_pieces,
    "generated_samples": generated_samples,
    "generated_in_pieces": generated_in_pieces,
    "compared": compared,
    "compared_in_pieces": compared,
    "trained": trained,
    "trained_in_pieces": trained,
    "textured": textured,
    "textured_in_pieces": textured,
    "textured_blocks": textured_blocks,
    "from_example": from_example,
    "from_example_in_pieces": from_example,
    "fitted": fitted,
    "fitted_in_pieces": fitted,
    "texture_trained": texture_trained,
    "texture_trained_in_pieces": texture_trained,
    "template_textured": template_textured,
    "textures_compared": textures_compared,
    "textures_compared_in_pieces": textures_compared,
    "cells_of_pieces": cells_of_pieces,
    "solved_in_pieces": solved_in_pieces,
    "corrected_in_pieces": corrected_in_pieces,
    "bad_piece": bad_piece,
    "bad_block": bad_block,
    "mesh_on_one_rank": mesh_on_one_rank,
    "mesh_in_pieces": mesh_in_pieces,
}

# SPDX-License-Identifier: BSD-3-Clause
"""Training through its proxy, in pvpython: the bytes of the class, from blocks and from a time series."""

import glob
import inspect
import os

import surfaces
from paraview import servermanager
from paraview.simple import *  # noqa: F403: as scripts of ParaView do
from proxies import TRAINING_PROPERTIES, check_properties, source_of
from surfacesynthesis import vtkFlowMatchingTrainer
from vtkmodules.vtkCommonDataModel import vtkMultiBlockDataSet

LoadPlugin(surfaces.plugin(), remote=False, ns=globals())

# property: (default, another value, what GetX() of the VTK class then returns)
PROPERTIES = {
    **TRAINING_PROPERTIES,
    "SignalArrayName": ("", "Heat", "Heat"),
    "EncoderFileName": ("", "encoder.safetensors", "encoder.safetensors"),
    "InitialModelFileName": ("", "initial.safetensors", "initial.safetensors"),
    "EncoderIterations": (0, 300, 300),
    "NumberOfEigenfunctions": (64, 8, 8),
    "EncoderEdgeSplits": (0.0, 0.5, 0.5),
    "WithoutEncoder": (0, 1, True),
    "Width": (64, 8, 8),
    "Blocks": (4, 2, 2),
    "ComplexLayers": (3, 2, 2),
    "InnerProducts": (0, 1, True),
    "Prediction": ("Automatic", "Velocity", vtkFlowMatchingTrainer.VELOCITY),
    "Optimizer": ("Muon", "Adam", vtkFlowMatchingTrainer.ADAM),
    "LearningRateSchedule": ("Cosine", "Milestones", vtkFlowMatchingTrainer.MILESTONES),
    "NoiseModel": ("Matern", "Per Vertex", vtkFlowMatchingTrainer.PER_VERTEX),
    "Screening": (100.0, 50.0, 50.0),
    "NoiseSmoothing": (-1.0, 0.5, 0.5),
    "NoiseScale": (0.0, 2.0, 2.0),
    "NumberOfEigenpairs": (256, 20, 20),
    "Iterations": (3000, 30, 30),
    "BatchSize": (32, 4, 4),
    "SourcesPerBatch": (1, 2, 2),
    "SourceMemory": (8192.0, 0.5, 0.5),
    "LearningRate": (0.02, 1e-3, 1e-3),
    "LearningRateFactor": (0.2, 0.5, 0.5),
    "GradientClip": (1.0, 0.0, 0.0),
    "VertexWeight": (1.0, 0.5, 0.5),
    "JacobianWeight": (1.0, 0.25, 0.25),
    "WeightAveraging": (0.99, 0.9, 0.9),
    "Device": ("Auto", "CUDA", vtkFlowMatchingTrainer.CUDA),
}
TINY = {"Width": 8, "Blocks": 2, "ComplexLayers": 2, "BatchSize": 2, "Iterations": 5}


def balls():
    blocks = vtkMultiBlockDataSet()
    for number, center in enumerate((0.0, 2.0, 5.0)):
        ball = surfaces.ball(size=4, center=center)
        points = ball.GetPoints()
        for k in range(points.GetNumberOfPoints()):
            x, y, z = points.GetPoint(k)
            points.SetPoint(k, x, (1.0 + 0.3 * number) * y, z)
        blocks.SetBlock(number, ball)
    return blocks


def trained(name, **options):
    made = FlowMatchingTrainer(ModelFileName=name, Device="CPU", **{**TINY, **options})
    made.UpdatePipeline()
    return made


def content(name):
    with open(name, "rb") as file:
        return file.read()


def properties_have_the_defaults_of_the_class_and_reach_it():
    made = FlowMatchingTrainer(Input=source_of(surfaces.ball()), Samples=source_of(balls()))
    check_properties(made, PROPERTIES)
    assert list(made.Milestones) == []
    made.Milestones = [10, 20]
    made.UpdateVTKObjects()
    algorithm = made.GetClientSideObject()
    assert [algorithm.GetMilestone(k) for k in range(algorithm.GetNumberOfMilestones())] == [10, 20]


def the_model_is_that_of_the_class():
    source, samples = surfaces.ball(size=4), balls()
    made = trained("proxy.safetensors", Input=source_of(source), Samples=source_of(samples), Milestones=[2])
    algorithm = vtkFlowMatchingTrainer()
    algorithm.SetInputDataObject(0, source)
    algorithm.SetInputDataObject(1, samples)
    for name, value in TINY.items():
        getattr(algorithm, "Set" + name)(value)
    algorithm.SetModelFileName("class.safetensors")
    algorithm.SetNumberOfMilestones(1)
    algorithm.SetMilestone(0, 2)
    algorithm.SetDeviceToCPU()
    algorithm.Update()
    assert content("proxy.safetensors") == content("class.safetensors")
    table, expected = servermanager.Fetch(made), algorithm.GetOutputDataObject(0)
    assert table.GetNumberOfRows() == expected.GetNumberOfRows() == 5
    for column in range(expected.GetNumberOfColumns()):
        assert table.GetColumnName(column) == expected.GetColumnName(column)
        for row in range(5):
            assert table.GetValue(row, column) == expected.GetValue(row, column), (row, column)
    made.UpdatePropertyInformation()
    assert made.GetProperty("NumberOfIterationsDone").GetData() == 5
    assert made.GetProperty("DeviceInUse").GetData() == "CPU"


def a_time_series_gives_the_model_of_its_blocks():
    source = source_of(surfaces.ball(size=4))
    trained("blocks.safetensors", Input=source, Samples=source_of(balls()))
    series = ProgrammableSource(OutputDataSetType="vtkPolyData")
    series.ScriptRequestInformation = """
executive = self.GetExecutive()
info = executive.GetOutputInformation(0)
info.Set(executive.TIME_STEPS(), [0.0, 1.0, 2.0], 3)
info.Set(executive.TIME_RANGE(), [0.0, 2.0], 2)
"""
    series.Script = f"""
import surfaces
from vtkmodules.vtkCommonDataModel import vtkMultiBlockDataSet
{inspect.getsource(balls)}
executive = self.GetExecutive()
time = executive.GetOutputInformation(0).Get(executive.UPDATE_TIME_STEP())
self.GetOutput().ShallowCopy(balls().GetBlock(int(time)))
"""
    trained("series.safetensors", Input=source, Samples=series)
    assert content("series.safetensors") == content("blocks.safetensors")


def inputs_can_be_taken_away():
    made = FlowMatchingTrainer(Input=source_of(surfaces.ball(size=4)), Samples=source_of(balls()))
    made.UpdateVTKObjects()
    algorithm = made.GetClientSideObject()
    assert [algorithm.GetNumberOfInputConnections(port) for port in (0, 1)] == [1, 1]
    made.Samples = None
    made.UpdateVTKObjects()
    assert [algorithm.GetNumberOfInputConnections(port) for port in (0, 1)] == [1, 0]
    made.Input = None
    made.UpdateVTKObjects()
    assert [algorithm.GetNumberOfInputConnections(port) for port in (0, 1)] == [0, 0]


def an_update_that_changes_nothing_reads_the_checkpoint_only():
    source, samples = source_of(surfaces.ball(size=4)), source_of(balls())
    trained("again.safetensors", Input=source, Samples=samples)
    model = content("again.safetensors")
    os.remove("again.safetensors")
    trained("again.safetensors", Input=source, Samples=samples)
    assert content("again.safetensors") == model


for path in glob.glob("*.checkpoint"):  # of an earlier run
    os.remove(path)
surfaces.run(
    properties_have_the_defaults_of_the_class_and_reach_it,
    the_model_is_that_of_the_class,
    a_time_series_gives_the_model_of_its_blocks,
    inputs_can_be_taken_away,
    an_update_that_changes_nothing_reads_the_checkpoint_only,
)

# SPDX-License-Identifier: BSD-3-Clause
"""Networks through their proxy, in pvpython: what the class gives, bit for bit, whatever the head."""

import numpy as np
import surfaces
from paraview.simple import *  # noqa: F403: as scripts of ParaView do
from proxies import check_properties, made_by, output_of, source_of
from surfacesynthesis import vtkPoissonNetFilter
from surfacesynthesis.conversion import describe, expected_tensors
from surfacesynthesis.safetensors import write_safetensors
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkMultiBlockDataSet

LoadPlugin(surfaces.plugin(), remote=False, ns=globals())

# property: (default, another value, what GetX() of the VTK class then returns)
PROPERTIES = {
    "ModelFileName": ("smoothed_curvature", "net.safetensors", "net.safetensors"),
    "InputNormalization": ("Model", "Unit Sphere", vtkPoissonNetFilter.UNIT_SPHERE),
    "ConditionArrayName": ("", "Time", "Time"),
    "SignalArrayName": ("", "Heat", "Heat"),
    "PredictionArrayName": ("Prediction", "Values", "Values"),
    "LabelArrayName": ("Label", "Part", "Part"),
    "ClassNamesArrayName": ("ClassNames", "Parts", "Parts"),
    "DisplacementArrayName": ("Displacement", "Way", "Way"),
    "ActiveResult": (1, 0, False),
}


def model(path, **config):
    """A model file with random weights."""
    metadata, network = describe({"n_blocks": 2, "C_width": 16, "cmlp_nlayers": 2, **config})
    random = np.random.default_rng(2)
    tensors = {name: random.uniform(-0.3, 0.3, shape) for name, shape in expected_tensors(network).items()}
    write_safetensors(path, tensors, {**metadata, "input_normalisation": "surface_area"})
    return path


def array_of(data, name):
    array = data.GetArray(name)
    assert array is not None, name
    return vtk_to_numpy(array)


def properties_have_the_defaults_of_the_class_and_reach_it():
    made = PoissonNet(Input=source_of(surfaces.ball()))
    check_properties(made, PROPERTIES)
    assert list(made.Conditions) == []
    made.Conditions = [0.5, -2.0]
    made.UpdateVTKObjects()
    algorithm = made.GetClientSideObject()
    assert [algorithm.GetCondition(k) for k in range(algorithm.GetNumberOfConditions())] == [0.5, -2.0]
    made.InputNormalisation = "Surface Area"  # the former name
    made.UpdateVTKObjects()
    assert algorithm.GetInputNormalization() == vtkPoissonNetFilter.SURFACE_AREA


def classes_of_cells_are_those_of_the_class():
    path = model("faces.safetensors", head="linear", outputs_at="faces", last_activation="log_softmax",
                 classes=["head", "arm", "leg"])
    armadillo = surfaces.armadillo()
    found = output_of(PoissonNet(Input=source_of(armadillo), ModelFileName=path))
    expected = made_by(vtkPoissonNetFilter(), armadillo, ModelFileName=path)
    for name in ("Prediction", "Label"):
        assert np.array_equal(array_of(found.GetCellData(), name), array_of(expected.GetCellData(), name)), name
    names = found.GetFieldData().GetAbstractArray("ClassNames")
    assert [names.GetValue(k) for k in range(3)] == ["head", "arm", "leg"]


def conditions_and_positions_are_those_of_the_class():
    path = model("positions.safetensors", head="njf", extra_features=2)
    made = PoissonNet(Input=source_of(surfaces.ball()), ModelFileName=path, Conditions=[0.25, 1.0])
    algorithm = vtkPoissonNetFilter()
    algorithm.SetNumberOfConditions(2)
    for conditions in ([0.25, 1.0], [0.5, 0.0]):
        made.Conditions = conditions
        for k, condition in enumerate(conditions):
            algorithm.SetCondition(k, condition)
        found, expected = output_of(made), made_by(algorithm, surfaces.ball(), ModelFileName=path)
        for name in ("Prediction", "Displacement"):
            assert np.array_equal(array_of(found.GetPointData(), name), array_of(expected.GetPointData(), name)), name
    made.UpdatePropertyInformation()
    assert made.GetProperty("NumberOfModelLoads").GetData() == 1
    assert made.GetProperty("NumberOfFactorizations").GetData() == 1


def blocks_and_labels_of_a_whole_surface():
    path = model("whole.safetensors", head="linear", outputs_at="global_mean", last_activation="log_softmax", C_out=4)
    blocks = vtkMultiBlockDataSet()
    blocks.SetBlock(0, surfaces.ball(8))
    blocks.SetBlock(1, surfaces.ball(12))
    found = output_of(PoissonNet(Input=source_of(blocks), ModelFileName=path))
    for k in range(2):
        expected = made_by(vtkPoissonNetFilter(), blocks.GetBlock(k), ModelFileName=path)
        assert np.array_equal(array_of(found.GetBlock(k).GetFieldData(), "Prediction"),
                              array_of(expected.GetFieldData(), "Prediction"))


surfaces.run(
    properties_have_the_defaults_of_the_class_and_reach_it,
    classes_of_cells_are_those_of_the_class,
    conditions_and_positions_are_those_of_the_class,
    blocks_and_labels_of_a_whole_surface,
)

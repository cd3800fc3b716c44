# SPDX-License-Identifier: BSD-3-Clause
"""The examples in ParaView on the pages of all filters are run, as scripts of their own: each makes its filter with the values
that it names, and a result. Values that need minutes are replaced by small ones, and the files that are read are small."""

import os
import pathlib
import sys

import page_inputs
import surfaces

sys.path.append(os.path.join(os.environ["SURFACE_SYNTHESIS_EXAMPLES"], os.pardir, "Documentation"))
import generate  # noqa: E402
from filter_examples import FILTERS  # noqa: E402

PROXIES = generate.proxies()
#: What a test cannot wait for: sizes and numbers of iterations.
SMALL = {
    "vtkIsotropicRemeshFilter": {"TargetNumberOfPoints": 2000},
    "vtkTextureAtlasFilter": {"Resolution": [256, 256]},
    "vtkDisplacementMapFilter": {"Resolution": [128, 128]},
    "vtkFieldLatentDecoder": {"Resolution": [128, 128]},
    "vtkFieldLatentTextureFilter": {"Resolution": [128, 128], "NumberOfPoints": 300, "NumberOfSteps": 3},
    "vtkFlowMatchingTrainer": {"Iterations": 2, "Width": 8, "Blocks": 2, "BatchSize": 2},
    "vtkMultiscaleMeshFitter": {"NumberOfLevels": 2, "IcosphereLevel": 1, "Iterations": 3, "Samples": 300},
    "vtkGeometricTextureTrainer": {"IterationsPerLevel": 2, "StartChannels": 8, "MinimumChannels": 8, "MaximumChannels": 8},
    "vtkFieldLatentTrainer": {"Iterations": 2, "BatchSize": 4, "Channels": 8, "DecoderWidth": 16},
    "vtkLatentDiffusionTrainer": {"Iterations": 2, "BatchSize": 1, "NumberOfTriangulations": 1, "NumberOfPoints": 200,
                                  "Channels": 8, "CoarseChannels": 8},
    "vtkPoseEnsembleFilter": {"NumberOfSamples": 2},
    "vtkElasticRestFilter": {"NumberOfSamples": 2, "NumberOfSurfacePoints": 120, "TimeStep": 0.1},
    "vtkGaussianMixtureFilter": {"NumberOfSamples": 3},
}  # fmt: skip


def elements_of(result, key):
    """The elements of a property, as the server manager has them."""
    found = result.SMProxy.GetProperty(key)
    return [found.GetElement(k) for k in range(found.GetNumberOfElements())]


def size_of(result, port):
    """Rows of a table, points of anything else."""
    information = result[port].GetDataInformation()
    return information.GetNumberOfRows() if information.GetDataSetTypeAsString() == "vtkTable" else information.GetNumberOfPoints()


def faults_of(name, example):
    """Runs an example; returns what is wrong."""
    lines = generate.example_in_paraview(name, PROXIES[name], example).splitlines()
    if lines[-1] != "result.UpdatePipeline()":
        return ["the last line does not update the result"]
    model = example.properties.get("ModelFileName", "")
    if model.endswith(".safetensors"):
        pathlib.Path(model).unlink(missing_ok=True)
    names, errors = {"__name__": "__main__"}, []

    def note(_caller, _event, text):
        errors.append(text)

    note.CallDataType = "string0"
    exec("\n".join(lines[:-1]), names)
    result = names["result"]
    result.GetClientSideObject().AddObserver("ErrorEvent", note)
    exec(lines[-1], names)
    for key, value in example.properties.items():
        wanted = list(value) if isinstance(value, (list, tuple)) else [value]
        if elements_of(result, key) != wanted:
            errors.append(f"{key} is {elements_of(result, key)}, not {wanted}")
    if model.endswith(".safetensors") and not os.path.isfile(model):
        errors.append(f"{model} was not written")
    if size_of(result, 0) == 0:
        errors.append("the result is empty")
    return errors


def each_filter_of_the_menu_has_an_example():
    assert set(FILTERS) == set(PROXIES) and len(FILTERS) > 20
    assert set(SMALL) <= set(FILTERS)


def all_examples_run():
    page_inputs.write_inputs(surfaces.ball(12), surfaces.ball(6), surfaces.armadillo())
    faults = {}
    for name, example in FILTERS.items():
        found = faults_of(name, example._replace(properties={**example.properties, **SMALL.get(name, {})}))
        if found:
            faults[name] = found
    assert not faults, faults


def an_example_that_fails_is_found():
    assert faults_of("vtkPoissonNetFilter", FILTERS["vtkPoissonNetFilter"]._replace(properties={"ModelFileName": "none"}))
    example = FILTERS["vtkFieldLatentTrainer"]
    assert faults_of("vtkFieldLatentTrainer", example._replace(properties={**example.properties, "DatasetFileName": "none"}))
    try:
        faults_of("vtkTopologyReport", FILTERS["vtkTopologyReport"]._replace(file="missing.stl"))
    except RuntimeError:
        return
    raise AssertionError("a file that is missing is not found")


surfaces.run(each_filter_of_the_menu_has_an_example, all_examples_run, an_example_that_fails_is_found)

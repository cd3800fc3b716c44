# SPDX-License-Identifier: BSD-3-Clause
"""The metrics of ensembles through their proxy, in pvpython."""

import surfaces
from paraview import servermanager
from paraview.simple import *  # noqa: F403: as scripts of ParaView do
from proxies import check_properties, errors_of, made_by, source_of
from surfacesynthesis import vtkEnsembleMetrics
from vtkmodules.vtkCommonDataModel import vtkMultiBlockDataSet

LoadPlugin(surfaces.plugin(), remote=False, ns=globals())

# property: (default, another value, what GetX() of the VTK class then returns)
PROPERTIES = {
    "ArrayName": ("", "Noise", "Noise"),
    "Distance": ("Mean L2", "RMS", 1),
    "RemoveCentroid": (0, 1, True),
}
METRICS = ("MMD", "ReverseMMD", "COV", "OneNearestNeighbourAccuracy", "MeanError")


def balls(*centers):
    blocks = vtkMultiBlockDataSet()
    for number, center in enumerate(centers):
        blocks.SetBlock(number, surfaces.ball(size=4, center=center))
    return blocks


def metrics_of(generated, reference, **options):
    return EnsembleMetrics(Input=source_of(generated), Reference=source_of(reference), **options)


def properties_have_the_defaults_of_the_class_and_reach_it():
    check_properties(metrics_of(balls(0.0), balls(1.0)), PROPERTIES)


def tables_are_those_of_the_class():
    generated, reference = balls(0.0, 4.0), balls(1.0, 10.0, 0.5)
    made = metrics_of(generated, reference, Distance="RMS")
    made.UpdatePipeline()
    algorithm = vtkEnsembleMetrics()
    algorithm.SetInputDataObject(1, reference)
    made_by(algorithm, generated, Distance=1)
    for port, rows in ((0, 1), (1, 2)):
        found = servermanager.Fetch(made, idx=port)
        expected = algorithm.GetOutputDataObject(port)
        assert found.IsA("vtkTable") and found.GetNumberOfRows() == expected.GetNumberOfRows() == rows
        assert found.GetNumberOfColumns() == expected.GetNumberOfColumns() >= 5
        for column in range(found.GetNumberOfColumns()):
            for row in range(rows):
                assert found.GetValue(row, column) == expected.GetValue(row, column), (row, column)
    made.UpdatePropertyInformation()
    for name in METRICS:
        assert made.GetProperty(name).GetData() == getattr(algorithm, "Get" + name)(), name
    assert algorithm.GetMMD() > 0.0


def samples_of_the_noise_filter_are_compared():
    noises = [
        MaternNoise(Input=source_of(surfaces.ball(size=4)), NumberOfSamples=4, Seed=seed, CorrelationRange=2.0)
        for seed in (1, 2)
    ]
    made = EnsembleMetrics(Input=noises[0], Reference=noises[1], ArrayName="MaternNoise")
    table = servermanager.Fetch(made)
    assert table.GetValueByName(0, "NumberOfGenerated").ToInt() == 4
    assert table.GetValueByName(0, "MMD").ToDouble() > 0.0


def the_source_may_be_given_and_taken_away():
    made = metrics_of(balls(0.0), balls(1.0, 3.0))
    made.Source = source_of(surfaces.ball(size=4))
    made.UpdatePipeline()
    assert made.GetClientSideObject().GetNumberOfInputConnections(2) == 1
    made.Source = None
    made.UpdatePipeline()
    algorithm = made.GetClientSideObject()
    assert [algorithm.GetNumberOfInputConnections(port) for port in range(3)] == [1, 1, 0]
    assert algorithm.GetMMD() > 0.0


def errors_are_reported_once():
    made = metrics_of(balls(0.0), surfaces.ball(size=5))
    errors = errors_of(made)
    assert len(errors) == 1 and "one triangulation" in errors[0], errors


surfaces.run(
    properties_have_the_defaults_of_the_class_and_reach_it,
    tables_are_those_of_the_class,
    samples_of_the_noise_filter_are_compared,
    the_source_may_be_given_and_taken_away,
    errors_are_reported_once,
)

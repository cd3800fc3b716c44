# SPDX-License-Identifier: BSD-3-Clause
"""Rest states of soft bodies through their proxy, in pvpython."""

import surfaces
from paraview.simple import *  # noqa: F403: as scripts of ParaView do
from proxies import check_properties, made_by, output_of, source_of
from surfacesynthesis import tetrahedralize, vtkElasticRestFilter

LoadPlugin(surfaces.plugin(), remote=False, ns=globals())

# property: (default, another value, what GetX() of the VTK class then returns)
PROPERTIES = {
    "Seed": (0, 7, 7),
    "NumberOfSamples": (6, 3, 3),
    "FirstSample": (0, 2, 2),
    "Spread": (1.25, 0.5, 0.5),
    "MemoryLimit": (0, 500, 500),
    "NumberOfSurfacePoints": (500, 80, 80),
    "LengthUnit": (0.0, 0.001, 0.001),
    "YoungsModulus": (1e4, 2e4, 2e4),
    "PoissonsRatio": (0.4, 0.3, 0.3),
    "Density": (1e3, 900.0, 900.0),
    "Friction": (0.5, 0.2, 0.2),
    "Gravity": (9.81, 1.6, 1.6),
    "Damping": (0.5, 1.0, 1.0),
    "DropHeight": (0.1, 0.3, 0.3),
    "MinimumSpin": (3.14159265358979, 1.0, 1.0),
    "MaximumSpin": (9.42477796076938, 12.0, 12.0),
    "RandomOrientation": (1, 0, False),
    "Align": (1, 0, False),
    "SelfContact": (1, 0, False),
    "TimeStep": (0.04, 0.02, 0.02),
    "MaximumTime": (10.0, 5.0, 5.0),
    "DisplacementArrayName": ("Displacement", "Way", "Way"),
}
QUICK = {"NumberOfSamples": 2, "NumberOfSurfacePoints": 80, "MaximumTime": 0.3}


def assert_same_states(found, expected):
    assert found.GetNumberOfBlocks() == expected.GetNumberOfBlocks() == 2
    for k in range(2):
        arrays = [surfaces.array(blocks.GetBlock(k), "Displacement") for blocks in (found, expected)]
        surfaces.assert_same(*arrays, f"displacements of sample {k}")


def properties_have_the_defaults_of_the_class_and_reach_it():
    check_properties(ElasticRest(Input=source_of(surfaces.long_ball())), PROPERTIES)


def states_are_those_of_the_class():
    proxy = ElasticRest(Input=source_of(surfaces.long_ball()), Spread=0.0, **QUICK)
    found = output_of(proxy)
    assert_same_states(found, made_by(vtkElasticRestFilter(), surfaces.long_ball(), **QUICK))
    assert abs(surfaces.array(found.GetBlock(0), "Displacement")).max() > 0.1, "it has fallen"
    proxy.UpdatePropertyInformation()
    assert proxy.GetProperty("NumberOfPreparations").GetData() == 1


def tetrahedra_can_be_given_and_taken_away():
    grid = tetrahedralize(surfaces.long_ball(6))
    proxy = ElasticRest(Input=source_of(surfaces.long_ball()), Tetrahedra=source_of(grid), Spread=0.0, **QUICK)
    algorithm = vtkElasticRestFilter()
    algorithm.SetTetrahedraData(grid)
    assert_same_states(output_of(proxy), made_by(algorithm, surfaces.long_ball(), **QUICK))
    proxy.Tetrahedra = None
    assert_same_states(output_of(proxy), made_by(vtkElasticRestFilter(), surfaces.long_ball(), **QUICK))


def shapes_can_be_given_and_taken_away():
    dropped = ElasticRest(Input=source_of(surfaces.long_ball()), Spread=0.0, **QUICK)
    proxy = ElasticRest(Input=source_of(surfaces.long_ball()), Shapes=dropped, Spread=0.0, **QUICK)
    algorithm = vtkElasticRestFilter()
    algorithm.SetShapesData(made_by(vtkElasticRestFilter(), surfaces.long_ball(), **QUICK))
    assert_same_states(output_of(proxy), made_by(algorithm, surfaces.long_ball(), **QUICK))
    proxy.Shapes = None
    assert_same_states(output_of(proxy), made_by(vtkElasticRestFilter(), surfaces.long_ball(), **QUICK))


surfaces.run(
    properties_have_the_defaults_of_the_class_and_reach_it,
    states_are_those_of_the_class,
    tetrahedra_can_be_given_and_taken_away,
    shapes_can_be_given_and_taken_away,
)

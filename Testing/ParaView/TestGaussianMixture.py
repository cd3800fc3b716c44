# SPDX-License-Identifier: BSD-3-Clause
"""Mixtures of Gaussians through their proxy, in pvpython."""

import surfaces
from paraview.simple import *  # noqa: F403: as scripts of ParaView do
from proxies import check_properties, made_by, output_of, source_of
from surfacesynthesis import vtkGaussianMixtureFilter
from vtkmodules.vtkCommonDataModel import vtkMultiBlockDataSet

LoadPlugin(surfaces.plugin(), remote=False, ns=globals())

# property: (default, another value, what GetX() of the VTK class then returns)
PROPERTIES = {
    "NumberOfCenters": (3, 5, 5),
    "Width": (0.08, 0.1, 0.1),
    "Separation": (4.0, 2.5, 2.5),
    "Seed": (0, 7, 7),
    "NumberOfSamples": (1, 3, 3),
    "FirstSample": (0, 2, 2),
    "ActiveResult": (1, 0, False),
    "MemoryLimit": (0, 500, 500),
    "OutputArrayName": ("Mixture", "Bumps", "Bumps"),
}


def properties_have_the_defaults_of_the_class_and_reach_it():
    check_properties(GaussianMixture(Input=source_of(surfaces.ball())), PROPERTIES)


def the_former_name_of_centers_reaches_the_class():
    made = GaussianMixture(Input=source_of(surfaces.ball()), NumberOfCentres=2)
    made.UpdateVTKObjects()
    assert made.GetClientSideObject().GetNumberOfCenters() == 2
    made.NumberOfCenters = 4
    made.UpdateVTKObjects()
    assert made.GetClientSideObject().GetNumberOfCenters() == 4


def samples_are_those_of_the_class():
    proxy = GaussianMixture(Input=source_of(surfaces.ball()), NumberOfCenters=2, Seed=3, NumberOfSamples=2,
                            FirstSample=4)  # fmt: skip
    found = output_of(proxy)
    expected = made_by(vtkGaussianMixtureFilter(), surfaces.ball(), NumberOfCenters=2, Seed=3, NumberOfSamples=2,
                       FirstSample=4)  # fmt: skip
    for name in ("Mixture_4", "Mixture_5"):
        surfaces.assert_same(surfaces.array(found, name), surfaces.array(expected, name), name)
    assert (surfaces.array(found, "Mixture_4") != surfaces.array(found, "Mixture_5")).any()
    proxy.UpdatePropertyInformation()
    assert proxy.GetProperty("NumberOfFactorizations").GetData() == 1
    assert 0.2 < proxy.GetProperty("StandardDeviation").GetData() < 0.4, "0.08 sqrt(4 pi), about"


def blocks_differ_and_a_bad_one_is_left_empty():
    blocks = vtkMultiBlockDataSet()
    for number, mesh in enumerate((surfaces.ball(size=8), surfaces.fin(), surfaces.ball(size=8))):
        blocks.SetBlock(number, mesh)
    proxy = GaussianMixture(Input=source_of(blocks))
    proxy.UpdateVTKObjects()
    errors = []

    def note(_caller, _event, text):
        errors.append(text)

    note.CallDataType = "string0"
    proxy.GetClientSideObject().AddObserver("ErrorEvent", note)
    found = output_of(proxy)
    first, last = (surfaces.array(found.GetBlock(k), "Mixture") for k in (0, 2))
    assert (first != last).any()
    assert found.GetBlock(1) is None or found.GetBlock(1).GetNumberOfPoints() == 0
    assert len(errors) == 1 and "Block 2" in errors[0] and "non-manifold edge" in errors[0], errors


surfaces.run(
    properties_have_the_defaults_of_the_class_and_reach_it,
    the_former_name_of_centers_reaches_the_class,
    samples_are_those_of_the_class,
    blocks_differ_and_a_bad_one_is_left_empty,
)

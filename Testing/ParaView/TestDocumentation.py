# SPDX-License-Identifier: BSD-3-Clause
"""Every property of a filter's header is in its server-manager XML, with its default, range and words.

Needs neither VTK nor ParaView. Usage: TestDocumentation.py <folder of the repository>
"""

import os
import re
import sys

from server_manager_xml import is_base, is_former, proxy_of

# header, or that of the class and those of its bases; XML; how many properties and results at least; properties of the XML
# that are methods of VTK's own; properties of a base class that the XML leaves out
TRAINER = "Filters/Training/vtkModelTrainer.h"
SAMPLER = "Filters/FlowMatching/vtkFlowMatchingSampler.h"
FILTERS = (
    ("Filters/FieldLatents/vtkFieldLatentDecoder.h", "Wrapping/ParaView/FieldLatentDecoder.xml", 5, 3,
     {"Target", "InstalledModels", "Resolution"}),
    ("Filters/FieldLatents/vtkFieldLatentEncoder.h", "Wrapping/ParaView/FieldLatentEncoder.xml", 5, 2,
     {"TextureImage", "InstalledModels"}),
    ("Filters/FieldLatents/vtkFieldLatentTextureFilter.h", "Wrapping/ParaView/FieldLatentTexture.xml", 17, 4,
     {"TextureImage", "InstalledModels", "InstalledAutoencoders", "NumberOfPoints", "Resolution", "TimestepValues"}),
    (("Filters/FlowMatching/vtkFlowMatchingDeformer.h", SAMPLER), "Wrapping/ParaView/FlowMatchingDeformer.xml", 13, 3,
     {"TimestepValues", "InstalledModels", "NormalizationCenter"}, {"SignalArrayName"}),
    (SAMPLER, "Wrapping/ParaView/FlowMatchingSampler.xml", 11, 3,
     {"TimestepValues", "InstalledModels", "NormalizationCenter"}),
    ("Filters/Ensembles/vtkEnsembleLayoutFilter.h", "Wrapping/ParaView/EnsembleLayout.xml", 6, 0, set()),
    ("Filters/Statistics/vtkEnsembleMetrics.h", "Wrapping/ParaView/EnsembleMetrics.xml", 3, 5, {"Reference", "Source"}),
    ("Filters/Statistics/vtkEnsembleStatistics.h", "Wrapping/ParaView/EnsembleStatistics.xml", 3, 0, {"Quantiles"}),
    ("Filters/Statistics/vtkShapeModelSampler.h", "Wrapping/ParaView/ShapeModelSampler.xml", 5, 0,
     {"Shapes", "Coefficients"}),
    ("Filters/Ensembles/vtkSkinningFilter.h", "Wrapping/ParaView/Skinning.xml", 3, 0, {"Bones", "Pose"}),
    ("Filters/Statistics/vtkSurfaceDistance.h", "Wrapping/ParaView/SurfaceDistance.xml", 2, 4, {"Second"}),
    ("Filters/Meshing/vtkLabelSurfaceFilter.h", "Wrapping/ParaView/LabelSurfaces.xml", 4, 0,
     {"SelectInputScalars", "Labels"}),
    (("Filters/Training/vtkFieldLatentTrainer.h", TRAINER), "Wrapping/ParaView/FieldLatentTrainer.xml", 28, 4,
     {"StopBackground"}),
    (("Filters/Training/vtkFlowMatchingTrainer.h", TRAINER), "Wrapping/ParaView/FlowMatchingTrainer.xml", 33, 3,
     {"Samples", "Milestones", "StopBackground"}),
    ("Filters/Statistics/vtkGeometricTextureDistance.h", "Wrapping/ParaView/GeometricTextureDistance.xml", 5, 2,
     {"Reference"}),
    ("Filters/Statistics/vtkGeometricTextureFeatures.h", "Wrapping/ParaView/GeometricTextureFeatures.xml", 5, 11, {"Bare"}),
    ("Filters/GeometricTexture/vtkGeometricTextureFromExample.h", "Wrapping/ParaView/GeometricTextureFromExample.xml", 16, 8,
     {"Example", "InstalledExamples", "PlainExample", "SecondExample", "SecondPlainExample"}),
    ("Filters/GeometricTexture/vtkGeometricTextureSynthesizer.h", "Wrapping/ParaView/GeometricTextureSynthesizer.xml", 23, 5,
     {"TimestepValues", "InstalledModels"}),
    (("Filters/Training/vtkGeometricTextureTrainer.h", TRAINER), "Wrapping/ParaView/GeometricTextureTrainer.xml", 25, 2,
     {"IterationsOfLevels", "ReferenceFileNames", "TemplateMesh", "StopBackground"}),
    (("Filters/Training/vtkLatentDiffusionTrainer.h", TRAINER), "Wrapping/ParaView/LatentDiffusionTrainer.xml", 34, 4,
     {"TextureImage", "StopBackground"}),
    (TRAINER, "Wrapping/ParaView/ModelTrainer.xml", 9, 2, {"StopBackground"}),
    ("Filters/Training/vtkMultiscaleMeshFitter.h", "Wrapping/ParaView/MultiscaleMeshFitter.xml", 16, 1,
     {"GivenTemplate", "StopBackground"}),
    ("Filters/Meshing/vtkIsotropicRemeshFilter.h", "Wrapping/ParaView/IsotropicRemesh.xml", 8, 1, set()),
    ("Filters/Ensembles/vtkPoseEnsembleFilter.h", "Wrapping/ParaView/PoseEnsemble.xml", 13, 1, {"Template"}),
    ("Filters/Ensembles/vtkElasticRestFilter.h", "Wrapping/ParaView/ElasticRest.xml", 21, 1,
     {"Tetrahedra", "Shapes", "UpDirection"}),
    ("Filters/Meshing/vtkSurfaceRepairFilter.h", "Wrapping/ParaView/SurfaceRepair.xml", 8, 1, set()),
    ("Filters/Meshing/vtkTetrahedralizeFilter.h", "Wrapping/ParaView/Tetrahedralize.xml", 11, 0, set()),
    ("Filters/Meshing/vtkDisplacementMapFilter.h", "Wrapping/ParaView/DisplacementMap.xml", 4, 7, {"Resolution", "Detailed"}),
    ("Filters/Meshing/vtkTextureAtlasFilter.h", "Wrapping/ParaView/TextureAtlas.xml", 2, 5, {"Resolution"}),
    ("Filters/Meshing/vtkTopologyReport.h", "Wrapping/ParaView/TopologyReport.xml", 1, 1, set()),
    ("Filters/Meshing/vtkVDBSurfaceFilter.h", "Wrapping/ParaView/VDBSurface.xml", 12, 1, {"SelectInputScalars"}),
    ("Filters/Ensembles/vtkGaussianMixtureFilter.h", "Wrapping/ParaView/GaussianMixture.xml", 7, 2, set()),
    ("Filters/Noise/vtkMaternNoiseFilter.h", "Wrapping/ParaView/MaternNoise.xml", 16, 5, {"Observations"}),
    ("Filters/Noise/vtkMaternParameterEstimator.h", "Wrapping/ParaView/MaternParameterEstimator.xml", 5, 6, {"Observations"}),
    ("Filters/PoissonNet/vtkPoissonNetFilter.h", "Wrapping/ParaView/PoissonNet.xml", 8, 2, {"Conditions", "InstalledModels"}),
)
#: Defaults of ParaView that are not those of the classes, by class and property.
DEFAULTS_OF_PARAVIEW = {
    # first results that show something on coarse sources, on data with scalars and on scans
    ("vtkMaternNoiseFilter", "Refinement"): "1",
    ("vtkMaternNoiseFilter", "ActiveResult"): "1",
    ("vtkGaussianMixtureFilter", "ActiveResult"): "1",
    ("vtkPoissonNetFilter", "ActiveResult"): "1",
    ("vtkFlowMatchingSampler", "ActiveResult"): "1",
    ("vtkSurfaceRepairFilter", "ActiveResult"): "1",
    ("vtkPoseEnsembleFilter", "Spread"): "1.25",
    ("vtkElasticRestFilter", "Spread"): "1.25",
    ("vtkGeometricTextureSynthesizer", "StartLevel"): "-1",
    ("vtkGeometricTextureSynthesizer", "TargetPreparation"): "2",
    ("vtkGeometricTextureSynthesizer", "TextureScale"): "0",
    # the window is frozen during an update
    ("vtkModelTrainer", "TimeBudget"): "2",
    ("vtkFieldLatentTrainer", "TimeBudget"): "2",
    ("vtkLatentDiffusionTrainer", "TimeBudget"): "2",
    ("vtkFlowMatchingTrainer", "TimeBudget"): "2",
    ("vtkGeometricTextureTrainer", "TimeBudget"): "2",
    ("vtkMultiscaleMeshFitter", "TimeBudget"): "2",
}
#: Defaults that a class gives to properties of its base.
DEFAULTS_OF_CLASSES = {
    ("vtkFieldLatentTrainer", "LearningRate"): "1e-3",
    ("vtkFlowMatchingTrainer", "LearningRate"): "0.02",
    ("vtkLatentDiffusionTrainer", "LearningRate"): "1e-3",
}
GROUP = re.compile(r"/\*\*(?P<comment>.*?)\*/\s*(?P<body>(?:[^/\n][^\n]*\n)+)", re.DOTALL)
SETTER = re.compile(
    r"vtkSet(?P<clamp>Clamp)?Macro\((?P<name>\w+), \w+(?:, (?P<low>[^,)]+), (?P<high>[^,)]+))?\)|void Set(?P<text>\w+)\(const char\* name\)")
GETTER = re.compile(r"(?:bool|int(?= Get\w+\(\) const;)|double|vtkTypeInt64|const char\*) Get(?P<name>\w+)\(\) const(?:;| \{)")


def spaced(text):
    """The label of a property in the panel: ModelFileName is Model File Name there."""
    return re.sub(r"(?<=[a-z])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", " ", text)


def plain(text):
    """Words only: the header writes PER_VERTEX, IsoValue, vtkWarpVector and "Default 1.", the XML Per Vertex, Iso Value and
    Warp By Vector."""
    text = re.sub(r"\n\s*\*", "\n", text)
    text = re.sub(r"\bvtkWarpVector\b", "Warp By Vector", text)
    text = re.sub(r"\b[A-Z]{2,}(?:_[A-Z]+)*\b", lambda found: found.group().replace("_", " ").title(), text)
    text = text.replace("é", "e").replace("(the default) ", "")
    text = spaced(re.sub(r"\(GetInstalled\w+\(\)\)", "", text))
    return " ".join(text.lower().split())


def first_sentence(text):
    return re.split(r"(?<=[.;:])\s|\.$", plain(text), maxsplit=1)[0].rstrip(".;: ")


def properties_of_header(path):
    """For each property that can be set: comment, bounds and default; and the names of those that can be read only."""
    with open(path, encoding="utf-8") as file:
        header = file.read()
    enumerators = {name: value for name, value in re.findall(r"^\s+([A-Z][A-Z_0-9]*) = (-?\d+)", header, re.MULTILINE)}
    defaults = dict(re.findall(r"^  (?:bool|int|double|std::string) (\w+)(?: = ([^;]+))?;", header, re.MULTILINE))
    settable, readable = {}, {}
    for group in GROUP.finditer(header):
        if "VTK_DEPRECATION" in group["body"]:
            continue
        found = SETTER.search(group["body"])
        if found:
            name = found["name"] or found["text"]
            low, high = (enumerators.get(found[end], found[end]) if found["clamp"] else None for end in ("low", "high"))
            default = {"false": "0", "true": "1"}.get(defaults[name], defaults[name].strip('"'))
            settable[name] = (group["comment"], (low, high), enumerators.get(default, default))
        else:
            for name in GETTER.findall(group["body"]):
                readable[name] = group["comment"]
    return settable, readable


def check(headers, xml, at_least_settable, at_least_readable, inherited, left_out=()):
    header = headers[0]
    settable, readable = {}, {}
    for path in headers:
        for found, properties in zip((settable, readable), properties_of_header(path)):
            found.update(properties)
    for name in left_out:
        del settable[name]
    assert len(settable) >= at_least_settable and len(readable) >= at_least_readable, (settable, readable)
    proxy = proxy_of(xml)
    assert proxy.get("class") == os.path.splitext(os.path.basename(header))[0]
    properties = {element.get("name"): element for element in proxy if element.tag.endswith("Property")}
    for name, element in properties.items():
        text = element.findtext("Documentation") or ""
        assert len(text.split()) >= 2, f"{name} is not documented"
    for name, (comment, ends, default) in settable.items():
        element = properties.pop(name, None)
        assert element is not None, f"{name} is in {header} and not in {xml}"
        assert element.get("command") == "Set" + name
        default = {**DEFAULTS_OF_CLASSES, **DEFAULTS_OF_PARAVIEW}.get((proxy.get("class"), name), default)
        same_default = element.get("default_values") == default or (
            not element.tag.startswith("String") and float(element.get("default_values")) == float(default))
        assert same_default, f"{name}: default {element.get('default_values')}, {default} in the header"
        check_range(name, element, *ends)
        sentence = first_sentence(element.findtext("Documentation"))
        assert sentence in plain(comment), f"{name}: {sentence!r} is not in the header, which says {plain(comment)!r}"
    for name in readable:
        element = properties.pop(name, None)
        assert element is not None, f"{name} is in {header} and not in {xml}"
        assert element.get("command") == "Get" + name and element.get("information_only") == "1", name
        sentence = first_sentence(element.findtext("Documentation"))
        assert sentence in plain(readable[name]), f"{name}: {sentence!r} is not in the header"
    for name in [name for name, element in properties.items() if is_former(element)]:
        successor = re.fullmatch(r"Former name of (\w+)\.", properties.pop(name).findtext("Documentation"))
        assert successor and successor[1] in {*settable, *readable}, f"{name} has no successor"
    inputs = set() if is_base(xml) else {"Input"}
    assert set(properties) == inputs | {"Execute"} | inherited, f"not in the header: {sorted(properties)}"
    print(f"{xml}: {len(settable)} properties and {len(readable)} results as in {header}")


def check_range(name, element, low, high):
    """The lower end of a range, or both of an enumeration."""
    if low is None:
        return
    domain = element.find("IntRangeDomain") if element.find("IntRangeDomain") is not None else element.find(
        "DoubleRangeDomain")
    entries = [int(entry.get("value")) for entry in element.findall("EnumerationDomain/Entry")]
    if domain is not None:
        assert float(domain.get("min")) == float(low), f"{name}: at least {domain.get('min')}, {low} in the header"
    elif entries:
        assert entries == list(range(int(low), int(high) + 1)), f"{name}: {entries}"
    else:  # the range comes from the data; it begins at 0
        assert element.find("BoundsDomain").get("mode") == "scaled_extent" and float(low) == 0.0, name


if __name__ == "__main__":
    for headers, xml, *counts in FILTERS:
        headers = [headers] if isinstance(headers, str) else headers
        headers = [os.path.join(sys.argv[1], header) for header in headers]
        check(headers, os.path.join(sys.argv[1], xml), *counts)

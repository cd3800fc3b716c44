# SPDX-License-Identifier: BSD-3-Clause
"""Gives the page of each filter, beside its documentation in the sources: when to use it, its picture, and one example.

The example in C++ and in ParaView is made of ``file``, ``inputs`` and ``properties`` (names of the server-manager XML); the one
in Python and the command say the same. The tests Python.FilterPages and Build.PageExamples compare them with what there is;
ParaView.PageExamples runs those in ParaView.
"""

import collections

#: when: a sentence or two; picture: a file below Examples; file: that the filter reads, of a format that VTK, ParaView and
#: surfacesynthesis read; properties: of the XML; inputs: pairs of the name of a further input and its file.
Example = collections.namedtuple("Example", "when picture file properties python command inputs", defaults=((),))

_PARAVIEW = "ParaView/Pictures/"

FILTERS = {
    "vtkTopologyReport": Example(
        "Before anything else: to know whether a surface is closed and valid, and which filter repairs it.",
        _PARAVIEW + "TopologyReport.png", "scan.stl", {},
        'mesh = ss.read_mesh("scan.stl")\nreport = ss.topology_report(mesh)\nprint(report)', "report scan.stl"),
    "vtkVDBSurfaceFilter": Example(
        "For scans and for surfaces that nothing else repairs: the result is always closed and manifold, at the resolution of "
        "the voxels.", _PARAVIEW + "VDBSurface.png", "head.mha", {"LargestComponent": 1, "FillCavities": 1},
        'volume = ss.read_volume("head.mha")\nmesh = ss.vdb_surface(volume, largest_component=True, fill_cavities=True)\n'
        'ss.write_mesh(mesh, "skin.vtp")', "surface head.mha skin.vtp --largest-component --fill-cavities"),
    "vtkLabelSurfaceFilter": Example(
        "To make surfaces of the regions of an atlas or a segmentation.",
        "Gallery/atlas.png", "labels.mha", {"NamesFileName": "names.txt"},
        'volume = ss.read_volume("labels.mha")\nregions = ss.label_surfaces(volume, names="names.txt")\n'
        'ss.write_mesh(regions, "regions.vtm")', "label-surfaces labels.mha regions.vtm --names names.txt"),
    "vtkSurfaceRepairFilter": Example(
        "When the points that are good must stay where they are. Where too much is broken, use vtkVDBSurfaceFilter.",
        _PARAVIEW + "SurfaceRepair.png", "scan.stl", {"HoleFilling": 2, "KeepLargestComponent": 1},
        'mesh = ss.read_mesh("scan.stl")\nmesh = ss.repair(mesh, holes="all", largest_component=True)\n'
        'ss.write_mesh(mesh, "valid.stl")', "repair scan.stl valid.stl --holes all --largest-component"),
    "vtkIsotropicRemeshFilter": Example(
        "Before filters that assume even triangles, before tetrahedra, and to choose the resolution of a result.",
        _PARAVIEW + "IsotropicRemesh.png", "scan.ply", {"TargetNumberOfPoints": 20000},
        'mesh = ss.read_mesh("scan.ply")\nmesh = ss.remesh(mesh, points=20000)\nss.write_mesh(mesh, "even.ply")',
        "remesh scan.ply even.ply --points 20000"),
    "vtkTextureAtlasFilter": Example(
        "When a texture image is to be made for a surface without texture coordinates.",
        _PARAVIEW + "TextureAtlas.png", "scan.stl", {"Resolution": [2048, 2048]},
        'mesh = ss.read_mesh("scan.stl")\nmesh = ss.texture_atlas(mesh, resolution=2048)\nss.write_mesh(mesh, "scan.obj")',
        "texture-atlas scan.stl scan.obj --resolution 2048"),
    "vtkDisplacementMapFilter": Example(
        "When a renderer is to show the relief of a detailed surface on a plain one that it subdivides. Overhangs need the "
        "displacement vectors; a height map is enough without.",
        "Gallery/displacement_maps.png", "plain.vtp", {"Resolution": [2048, 2048]},
        'mesh = ss.read_mesh("plain.vtp")\ndetailed = ss.read_mesh("detailed.ply")\n'
        'maps = ss.displacement_map(mesh, detailed, resolution=2048)\nmaps.write("height.png", "vectors.tif")',
        "displacement-map plain.vtp detailed.ply height.png vectors.tif --resolution 2048", (("Detailed", "detailed.ply"),)),
    "vtkTetrahedralizeFilter": Example(
        "For finite elements inside a closed surface.", _PARAVIEW + "TetrahedralizeSurface.png", "part.stl", {"QualityRatio": 1.5},
        'mesh = ss.read_mesh("part.stl")\ngrid = ss.tetrahedralize(mesh, quality_ratio=1.5)\nss.write_mesh(grid, "part.vtu")',
        "tetrahedralize part.stl part.vtu --quality-ratio 1.5"),
    "vtkMaternNoiseFilter": Example(
        "For random fields on surfaces: material properties, rough surfaces, uncertain shapes, and the noise from which "
        "generative models start. The correlation range is in the units of the mesh.",
        "Gallery/triangulations.png", "part.stl", {"CorrelationRange": 5.0, "NumberOfSamples": 8, "Seed": 1},
        'mesh = ss.read_mesh("part.stl")\nmesh = ss.matern_noise(mesh, range=5.0, samples=8, seed=1)\n'
        'ss.write_mesh(mesh, "fields.vtp")', "noise part.stl fields.vtp --range 5 --samples 8 --seed 1"),
    "vtkMaternParameterEstimator": Example(
        "When fields were measured and others like them are wanted: it gives the range and the deviation for "
        "vtkMaternNoiseFilter, with intervals.", _PARAVIEW + "MaternParameterEstimator.png", "cortex.vtp",
        {"ObservationArray": "Thickness"},
        'mesh = ss.read_mesh("cortex.vtp")\nestimate = ss.estimate_matern(mesh, observation_array="Thickness")\n'
        'for name, parameter in estimate.items():\n    print(name, parameter)', "estimate cortex.vtp --observation-array Thickness"),
    "vtkPoissonNetFilter": Example(
        "To apply a trained network to a surface: labels of parts, predicted fields or shapes.",
        "Gallery/predicted_curvature.png", "body.ply", {"ModelFileName": "smoothed_curvature"},
        'mesh = ss.read_mesh("body.ply")\nmesh = ss.poisson_net(mesh, "smoothed_curvature")\n'
        'ss.write_mesh(mesh, "curvature.vtp")', "poisson-net body.ply curvature.vtp --model smoothed_curvature"),
    "vtkFlowMatchingDeformer": Example(
        "For new shapes like those of a training: poses of one body, variants of one organ.",
        "Gallery/deformations.png", "armadillo.ply", {"ModelFileName": "armadillo_poses", "NumberOfSamples": 4, "Seed": 3},
        'mesh = ss.read_mesh("armadillo.ply")\nposes = ss.deform(mesh, "armadillo_poses", samples=4, seed=3)\n'
        'ss.write_mesh(poses, "poses.vtm")', "deform armadillo.ply poses.vtm --model armadillo_poses --samples 4 --seed 3"),
    "vtkFlowMatchingSampler": Example(
        "For new fields like those of a training, where a Gaussian random field is not enough.",
        "Gallery/signals.png", "bunny.ply", {"ModelFileName": "bunny_mixtures", "Seed": 3},
        'mesh = ss.read_mesh("bunny.ply")\nmesh = ss.sample_signal(mesh, "bunny_mixtures", seed=3)\n'
        'ss.write_mesh(mesh, "mixture.vtp")', "sample bunny.ply mixture.vtp --model bunny_mixtures --seed 3"),
    "vtkGeometricTextureSynthesizer": Example(
        "To give a smooth surface the relief of another one.",
        "Gallery/textures.png", "bunny.ply", {"ModelFileName": "flow_spikes", "StartLevel": 1, "Seed": 1},
        'mesh = ss.read_mesh("bunny.ply")\nmesh = ss.geometric_texture(mesh, "flow_spikes", start_level=1, seed=1)\n'
        'ss.write_mesh(mesh, "spiky.ply")', "geometric-texture bunny.ply spiky.ply --model flow_spikes --start-level 1 --seed 1"),
    "vtkGeometricTextureFromExample": Example(
        "To give a surface the relief of another one at once, from a piece of a scan for instance. Where many surfaces are to get "
        "one texture, or more than the example shows is wanted, train vtkGeometricTextureSynthesizer.",
        "Gallery/scan_textures.png", "bunny.ply", {"ExampleFileName": "mountains", "Seed": 1, "Subdivisions": 1},
        'mesh = ss.read_mesh("bunny.ply")\n'
        'mesh = ss.geometric_texture_from_example(mesh, "mountains", seed=1, subdivisions=1)\nss.write_mesh(mesh, "rocky.ply")',
        "geometric-texture-from-example bunny.ply mountains rocky.ply --seed 1 --subdivisions 1"),
    "vtkFieldLatentEncoder": Example(
        "To carry a texture to another triangulation, and to prepare one for training.",
        _PARAVIEW + "FieldLatentEncoder.png", "duck.obj", {"ModelFileName": "field_latents"},
        'mesh, image = ss.read_textured_mesh("duck.obj")  # and duck.png, which it names\n'
        'mesh = ss.encode_texture(mesh, image, model="field_latents")\nss.write_mesh(mesh, "latents.vtp")',
        "encode-texture duck.obj latents.vtp --model field_latents", (("TextureImage", "duck.png"),)),
    "vtkFieldLatentDecoder": Example(
        "To make a texture image of latent vectors, at any resolution.",
        _PARAVIEW + "FieldLatentDecoder.png", "latents.vtp", {"ModelFileName": "field_latents", "Resolution": [2048, 2048]},
        'mesh = ss.read_mesh("latents.vtp")  # of encode_texture()\n'
        'mesh, image = ss.decode_texture(mesh, model="field_latents", resolution=2048)\n'
        'ss.write_textured_mesh(mesh, image, "decoded.obj")',
        "decode-texture latents.vtp decoded.obj --model field_latents --resolution 2048"),
    "vtkFieldLatentTextureFilter": Example(
        "For new textures like that of one textured surface, on any surface.",
        "Gallery/latent_textures.png", "bunny.ply", {"ModelFileName": "coat", "Seed": 1},
        'mesh = ss.read_mesh("bunny.ply")\nmesh, image, latents = ss.sample_texture(mesh, "coat", seed=1)\n'
        'ss.write_textured_mesh(mesh, image, "spotted.obj")', "sample-texture bunny.ply spotted.obj --model coat --seed 1"),
    "vtkFlowMatchingTrainer": Example(
        "When there are tens to thousands of samples of shapes or fields on one or several surfaces.",
        _PARAVIEW + "FlowMatchingTrainer.png", None,
        {"DatasetFileName": "poses.safetensors", "ModelFileName": "model.safetensors", "Iterations": 3000},
        '# a file of write_signal_dataset(), or of the command "dataset poses" or "dataset import"\n'
        'ss.train_flow_matching(dataset="poses.safetensors", model="model.safetensors", iterations=3000)',
        "train flow-matching poses.safetensors model.safetensors --iterations 3000"),
    "vtkMultiscaleMeshFitter": Example(
        "Before vtkGeometricTextureTrainer: it makes the levels from which a relief is learned.",
        _PARAVIEW + "MultiscaleMeshFitter.png", "bark.ply", {"NumberOfLevels": 5, "DatasetFileName": "levels.safetensors"},
        'mesh = ss.read_mesh("bark.ply")\nfitted = ss.fit_levels(mesh, levels=5, dataset="levels.safetensors")',
        "levels bark.ply levels.safetensors --levels 5"),
    "vtkGeometricTextureTrainer": Example(
        "To learn the relief of one surface, of which a patch of a few wavelengths is enough.",
        _PARAVIEW + "GeometricTextureTrainer.png", None,
        {"DatasetFileName": "levels.safetensors", "ModelFileName": "bark.safetensors"},
        '# a file of fit_levels()\n'
        'ss.train_geometric_texture(dataset="levels.safetensors", model="bark.safetensors")',
        "train geometric-texture levels.safetensors bark.safetensors"),
    "vtkFieldLatentTrainer": Example(
        "Seldom: the installed autoencoder field_latents serves for all textures. For images of another kind, train one.",
        _PARAVIEW + "FieldLatentTrainer.png", None,
        {"DatasetFileName": "textures.safetensors", "ModelFileName": "latents.safetensors"},
        '# a file of texture_dataset()\n'
        'ss.train_field_latents(dataset="textures.safetensors", model="latents.safetensors")',
        "train field-latents textures.safetensors latents.safetensors"),
    "vtkLatentDiffusionTrainer": Example(
        "To learn the texture of one surface, with labels and directions where the texture follows some.",
        _PARAVIEW + "LatentDiffusionTrainer.png", "duck.obj", {"ModelFileName": "feathers.safetensors", "NumberOfTriangulations": 64},
        'mesh, image = ss.read_textured_mesh("duck.obj")  # and duck.png, which it names\n'
        'ss.train_latent_diffusion(mesh, image, model="feathers.safetensors", triangulations=64)',
        "train latent-diffusion duck.obj feathers.safetensors --triangulations 64", (("TextureImage", "duck.png"),)),
    "vtkPoseEnsembleFilter": Example(
        "For training data without a data set: random poses of one shape.",
        "Gallery/poses.png", "armadillo.ply", {"NumberOfSamples": 100, "Seed": 1},
        'mesh = ss.read_mesh("armadillo.ply")\nposes = ss.poses(mesh, samples=100, seed=1)\n'
        'ss.write_signal_dataset("poses.safetensors", [(mesh, poses)], "Position")',
        "dataset poses armadillo.ply poses.safetensors --samples 100 --seed 1"),
    "vtkElasticRestFilter": Example(
        "For training data of soft bodies, or to lay soft tissue down: shapes after random drops on a floor; and to make rest states "
        "of the samples of a model (Shapes, settle()).",
        "Gallery/rest_states.png", "bunny.ply", {"NumberOfSamples": 100, "Seed": 1},
        'mesh = ss.read_mesh("bunny.ply")\nstates = ss.rest_states(mesh, samples=100, seed=1)\n'
        'ss.write_signal_dataset("rest.safetensors", [(mesh, states)], "Position")',
        "dataset rest-states bunny.ply rest.safetensors --samples 100 --seed 1"),
    "vtkGaussianMixtureFilter": Example(
        "For training data of signals with a known distribution, to test a training.",
        "Gallery/mixtures.png", "bunny.ply", {"NumberOfSamples": 100, "Seed": 1},
        'mesh = ss.read_mesh("bunny.ply")\nsignals = ss.gaussian_mixtures(mesh, samples=100, seed=1)\n'
        'ss.write_signal_dataset("mixtures.safetensors", [(mesh, signals)], "Mixture")',
        "dataset mixtures bunny.ply mixtures.safetensors --samples 100 --seed 1"),
    "vtkSkinningFilter": Example(
        "To pose a body model that comes with a skeleton and weights, for training data of poses or for one pose.",
        "Gallery/skinning.png", "body.vtp", {"SkinningMethod": 1},
        'mesh = ss.read_mesh("body.vtp")\n'
        'mesh = ss.skin(mesh, "bones.csv", "pose.csv", skinning_method="dual_quaternion")\nss.write_mesh(mesh, "posed.vtp")', "skin body.vtp posed.vtp --bones bones.csv --pose pose.csv",
        (("Bones", "bones.csv"), ("Pose", "pose.csv"))),
    "vtkEnsembleLayoutFilter": Example(
        "To look at the samples of an ensemble side by side.",
        _PARAVIEW + "EnsembleLayout.png", "poses.vtm", {"Spacing": 0.2},
        'ensemble = ss.read_mesh("poses.vtm")\nensemble = ss.ensemble_layout(ensemble, spacing=0.2)\n'
        'ss.write_mesh(ensemble, "row.vtm")', None),
    "vtkEnsembleMetrics": Example(
        "To judge generated samples against samples that were held back from the training.",
        _PARAVIEW + "EnsembleMetrics.png", "generated.vtm", {"ArrayName": "Field"},
        'generated = ss.read_mesh("generated.vtm")\nreference = ss.read_mesh("reference.vtm")\n'
        'metrics = ss.ensemble_metrics(generated, reference, array="Field")\nprint(metrics)',
        "metrics --generated generated.vtm --reference reference.vtm --array Field", (("Reference", "reference.vtm"),)),
    "vtkEnsembleStatistics": Example(
        "To describe how the shapes or signals of a group vary: mean, deviation, quantiles and modes.",
        "Gallery/shape_model.png", "shapes.vtm", {"NumberOfModes": 5},
        'shapes = ss.read_mesh("shapes.vtm")\nstatistics = ss.ensemble_statistics(shapes, modes=5)\n'
        'ss.write_mesh(statistics.surface, "model.vtp")', "statistics shapes.vtm model.vtp --modes 5"),
    "vtkShapeModelSampler": Example(
        "To make random shapes of a group, and to find the coefficients of a new one.",
        "Gallery/shape_model.png", "model.vtp", {"NumberOfSamples": 12, "Seed": 1},
        'model = ss.read_mesh("model.vtp")  # of ensemble_statistics()\nshapes = ss.shape_model(model, samples=12, seed=1)\n'
        'ss.write_mesh(shapes, "random.vtm")', "shape-model model.vtp random.vtm --samples 12 --seed 1"),
    "vtkSurfaceDistance": Example(
        "To compare a segmentation with a reference, or a surface with its simplification.",
        _PARAVIEW + "SurfaceDistance.png", "segmented.stl", {"NumberOfSamples": 100000},
        'mesh = ss.read_mesh("segmented.stl")\nreference = ss.read_mesh("reference.ply")\n'
        'distance = ss.surface_distance(mesh, reference)\nprint(distance)',
        "distance segmented.stl reference.ply", (("Second", "reference.ply"),)),
    "vtkGeometricTextureDistance": Example(
        "To compare the relief of a synthesized surface with the one that was learned.",
        _PARAVIEW + "GeometricTextureDistance.png", "synthesized.ply", {"NumberOfProjections": 256},
        'mesh = ss.read_mesh("synthesized.ply")\nreference = ss.read_mesh("original.ply")\n'
        'distance = ss.geometric_texture_distance(mesh, reference, projections=256)\nprint(distance)',
        "geometric-texture-distance synthesized.ply original.ply --projections 256", (("Reference", "original.ply"),)),
    "vtkGeometricTextureFeatures": Example(
        "To see whether the peaks of a synthesized texture are as many, as even and as separate as those that were learned.",
        "Gallery/texture_features.png", "synthesized.ply", {"MergedSaddle": 0.5},
        'mesh = ss.read_mesh("synthesized.ply")\nbare = ss.read_mesh("target.ply")\n'
        'features = ss.geometric_texture_features(mesh, bare, merged_saddle=0.5)\nprint(features)',
        "geometric-texture-features synthesized.ply --bare target.ply --merged-saddle 0.5", (("Bare", "target.ply"),)),
}  # fmt: skip

#: What was measured of accuracy, bias and time, and where: files of the sources.
LIMITS = {
    "vtkIsotropicRemeshFilter": [
        "A brain to 60,974 triangles in 8.1 s on two threads (Testing/Benchmarks/README.md).",
        "The number of points is met within about 2 % where curves allow it (TargetNumberOfPoints)."],
    "vtkDisplacementMapFilter": [
        "Spikes on a bear from maps of 1024 x 1024 texels: vectors differ by 0.7 % of the height of the texture on average, 2.0 % at the "
        "95th percentile; a surface displaced by heights lies 1.0 % and 3.3 % away. Knobs, which lean over: vectors 1.2 % and 3.6 %, "
        "heights 4.5 % and 21 % (Examples/README.md).",
        "7 s for a million texels of which half show the surface, of 80,000 triangles, on a busy machine."],
    "vtkTextureAtlasFilter": [
        "36 microseconds for a triangle of the armadillo, 52,000 triangles (Testing/Benchmarks/README.md)."],
    "vtkSurfaceRepairFilter": [
        "A loss of area, volume or components beyond 5 % (MaximumLoss) is a warning, with Strict an error."],
    "vtkMaternNoiseFilter": [
        "Standard deviation, without VarianceCorrection: within 5 % on closed surfaces where edges are shorter than about a tenth "
        "of the range and parts are wider than the range; too large by a factor of 1.41 at a straight open boundary, and larger on "
        "thin parts (StandardDeviation).",
        "Deviations of the spectral coefficients 2, 50 and 500 over 100,000 samples agree with 1 / (lambda + tau) within 0.7 % on "
        "three triangulations of 2,001 to 26,002 vertices; that of one number per vertex changes by a factor of 3.6 between them "
        "(Examples/README.md)."],
    "vtkFlowMatchingDeformer": [
        "armadillo_poses on 2,501 points: spread 0.94 (other poses of the data: 1.01), coverage 0.557 (0.560), 1-nearest-neighbor "
        "accuracy 0.540 (0.498; 0.5 is best). On 5,087 points, dense on one side, unseen: 1.03, 0.623, 0.513 "
        "(Examples/Training/README.md).",
        "The samples lie 0.0030 and 0.0033 from the space of poses, the poses of the data 0.0009 and 0.0007, in roots of the area."],
    "vtkFlowMatchingSampler": [
        "bunny_mixtures on 2,003 points: spread 0.97 (other mixtures: 1.00), coverage 0.600 (0.630), 1-nearest-neighbor accuracy "
        "0.725 (0.575): the samples can be told from the data (Examples/Training/README.md).",
        "The samples have a distance of 0.095 from the space of mixtures, the data 0.007."],
    "vtkFlowMatchingTrainer": [
        "armadillo_poses took 69 minutes of one processor core, in eight trainings (Examples/Training/README.md)."],
    "vtkGeometricTextureSynthesizer": [
        "Each surface in the picture took less than half a second (README.md); 0.33 s for 158,000 triangles and 3.45 s for a million, in "
        "151 and 961 MiB (Testing/Benchmarks/README.md).",
        "Printable: knobs on a plane and on a saddle of 80,000 triangles, two seeds each, have 156 to 361 pairs of triangles that "
        "intersect before, none after, and 100.0 % of their height (Printable)."],
    "vtkGeometricTextureFromExample": [
        "9 to 17 s for each surface in the picture, of 80,000 triangles, on a busy machine with two threads (Examples/README.md).",
        "Patches are about three features wide: order beyond, as that of the rows of plates on a shell, is lost."],
    "vtkGeometricTextureDistance": [
        "About 10 seconds on one thread for 128 directions and 300,000 triangles."],
    "vtkGeometricTextureFeatures": [
        "Without a bare surface the smoothed one follows the relief: cones of a radius of a twentieth of the root of the area are "
        "measured 15 % too low; counts of separate peaks stay.",
        "A labyrinth has few peaks that are not merged: there the length of walls says more (Examples/Training/README.md)."],
    "vtkGaussianMixtureFilter": ["Some thousand centers a second for 2,000 points."],
    "vtkFieldLatentDecoder": ["64 bytes of memory for each texel of the image."],
    "vtkTopologyReport": [
        "At most 17 s and 1.0 GB for 3 million triangles, on a busy machine (Testing/Benchmarks/README.md)."],
    "vtkVDBSurfaceFilter": [
        "At most 121 s and 1.2 GB for a surface of 3 million triangles at a diameter of 540 voxels, on a busy machine "
        "(Testing/Benchmarks/README.md).",
        "Details below the size of a voxel are lost: the surface lies on a grid of samples of the distance."],
    "vtkLabelSurfaceFilter": [
        "The 116 regions of the AAL atlas, 7 million samples, in 2 s of processor time; their volumes differ from those of the samples "
        "by 1.5e-8 at most, relative to them (0.01 % is asked).",
        "4,096 labels at most. More than 32 labels of which less than 40 % of adjacent samples agree are refused as gray values: 9 to "
        "24 % agree in the scans of Debian's mricron-data, 82 to 98 % in its label maps."],
    "vtkTetrahedralizeFilter": [
        "About a second for 10,000 triangles, and as much again for each 30,000 tetrahedra, on one thread.",
        "3 million triangles took 547 s at most, on a busy machine (Testing/Benchmarks/README.md)."],
    "vtkMaternParameterEstimator": [
        "A noise deviation below a thousandth of that of the field is given as 0, with that thousandth as its upper bound.",
        "The intervals of 95 % are those of the observed information, which hold for many observations; OperatorPower is not estimated."],
    "vtkPoissonNetFilter": [
        "At most 369 s and 4.0 GB for smoothed_curvature on 3 million triangles, on a busy machine (Testing/Benchmarks/README.md).",
        "Five blocks of width 128 on 110,600 faces at 87 to 93 % of the rate of matrix products, in 3.9 to 4.3 s on one thread "
        "(Testing/Benchmarks/README.md)."],
    "vtkEnsembleMetrics": [
        "Time grows with the square of the number of samples and with the number of points: N + M samples of V points take "
        "O((N + M)^2 V).",
        "1-nearest-neighbor accuracy of two samples of one distribution is 0.5 on average; 0.490 for two sets of poses of the "
        "armadillo (Examples/Training/README.md)."],
    "vtkEnsembleStatistics": [
        "1,000 shapes of 100,000 points, 1.1 GiB of coordinates: mean and deviation in 14 s of processor time, three quantiles in 14 s, "
        "ten modes in 34 s, all 999 modes in 79 s; beside the samples 0, 1, 132 and 4,553 MiB, most of the last for the modes "
        "themselves (Testing/Benchmarks/README.md).",
        "Modes with less than 1e-12 of the largest variance are left out: single samples do not have them."],
    "vtkShapeModelSampler": [
        "N samples have at most N - 1 modes: shapes that these do not span are not made. Samples are Gaussian in the coefficients, so "
        "that shapes of bent limbs, as poses, are not met."],
    "vtkSurfaceDistance": [
        "Two concentric spheres of 88,800 triangles, with radii of 0.5 and 0.55: a mean of 0.049995, a maximum of 0.05, in 5.4 s of "
        "processor time for 100,000 samples each.",
        "The maximum is that of the samples, and so a lower bound of the Hausdorff distance."],
    "vtkSkinningFilter": [
        "8,000 poses of a body of 2,501 points, 163 bones and 8 influences in 36 s of a busy machine (Examples/Training/README.md).",
        "The body and its skeleton must be given: the filter fits neither bones nor weights to a surface."],
    "vtkEnsembleLayoutFilter": ["Samples are moved only: memory and time are those of a copy of their points."],
    "vtkElasticRestFilter": [
        "Edges of the body may pass through each other, and it slides on itself without friction. Parts of a surface that the "
        "simulated mesh leaves off follow it without a weight of their own. Linear tetrahedra are stiffer than "
        "the body: a beam of eight across its height bends 11 % less than theory, of fourteen 4 %.",
        "Shapes may be of any quality, of about the size of the body; those far from any shape of it, such as random points, take "
        "seconds each."],
    "vtkPoseEnsembleFilter": [
        "About 60 ms of one processor for each sample on 1,500 points and 300 ms on 5,000.",
        "At most 423 s and 5.5 GB for a sample of 3 million triangles, on a busy machine (Testing/Benchmarks/README.md)."],
    "vtkFieldLatentEncoder": [
        "92 % of the rate of matrix products, and 3 MiB beyond the start (Testing/Benchmarks/README.md).",
        "With field_latents textures come back at 28.9 dB from 30,000 points and at 24.8 dB from 5,000, means of ten surfaces: 2.1 and "
        "2.0 dB better than colors of points. Of flat colors with sharp borders fitted colors are as good or better "
        "(Examples/Training/README.md)."],
    "vtkFieldLatentTextureFilter": [
        "Samples of coat differ from the texture by 0.0241, 0.0221 and 0.0235 at scales of 8, 16 and 32 pixels; the texture on another "
        "triangulation by 0.0132, 0.0145 and 0.0164, noise by 0.1486, 0.1220 and 0.1111 (Examples/Training/README.md)."],
    "vtkFieldLatentTrainer": [
        "field_latents took 25 minutes of one of two busy cores, 40,000 iterations of 48 rings (Examples/Training/README.md)."],
    "vtkLatentDiffusionTrainer": [
        "coat takes half an hour of one core, 0.09 s a step; tissue took 37 minutes, 0.28 s a step (Examples/Training/README.md)."],
    "vtkGeometricTextureTrainer": [
        "Distances of synthesized from learned textures on three shapes: spikes 0.028 to 0.056, labyrinth 0.025 to 0.043, knobs 0.025 "
        "to 0.058; those of the bare targets are 0.108 to 0.240 (Examples/Training/README.md)."],
    "vtkMultiscaleMeshFitter": [
        "81,920 triangles at a mean distance of 0.004 to 0.020 % of the diagonal from scans, whole and cropped, with normals that differ "
        "by 2 to 9 degrees and no self-intersection, in a minute of one core: template SURFACE (Examples/Training/README.md).",
        "At most 595 s and 1.0 GB from 3 million to 81,920 triangles, on a busy machine (Testing/Benchmarks/README.md)."],
}  # fmt: skip

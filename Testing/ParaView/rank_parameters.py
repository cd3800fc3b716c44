# SPDX-License-Identifier: BSD-3-Clause
"""Parameters of the filters in TestRanks.py, in one process and on several ranks."""

SAMPLES = 7
RANGE = 24.0  # world units of the armadillo
MIXTURES = {"NumberOfCenters": 2, "Seed": 5, "NumberOfSamples": 2}
GENERATED = {"ModelFileName": "mixture.safetensors", "Seed": 5, "NumberOfSteps": 2}
POSES = {"Spread": 0.0, "NumberOfSamples": 3, "NumberOfHandles": 2, "NumberOfIterations": 5, "MaximumAngle": 30.0}
TRAINING = {"SignalArrayName": "Mixture", "Width": 8, "Blocks": 1, "ComplexLayers": 1, "BatchSize": 2, "Iterations": 2}
TEXTURED = {"ModelFileName": "texture.safetensors", "Seed": 5, "StartLevel": 0, "TargetPreparation": 0, "TextureScale": 1.0}
FROM_EXAMPLE = {"Seed": 3, "Subdivisions": 0, "NumberOfScales": 1}
FITTED = {"NumberOfLevels": 2, "IcosphereLevel": 1, "Iterations": 2, "Samples": 50, "LearningRate": 1e-4}
TEXTURE_TRAINING = {"IterationsPerLevel": 2, "Layers": 3, "StartChannels": 4, "MinimumChannels": 4, "MaximumChannels": 4}
NOISE = {"CorrelationRange": RANGE, "NumberOfSamples": SAMPLES, "Seed": 11}

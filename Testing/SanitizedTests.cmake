# SPDX-License-Identifier: BSD-3-Clause
#
# Which tests run under sanitizers; read by SurfaceSynthesisTesting.cmake.
#
#   surfsynth_thread_words     ThreadSanitizer runs the tests whose suite or name has one of these words, and no others
#   surfsynth_unsanitized      patterns of tests that no sanitizer runs
#   surfsynth_test_filter      the argument of --gtest_filter in this tree, empty without sanitizers

# Several threads, or one that waits for another.
set(surfsynth_thread_words Thread AtOnce Abort Stop Cancel Progress Parallel Background BlockCache)

set(surfsynth_unsanitized
  # They measure: distributions, convergence, accuracy, what is learnt.
  "*AtThePapersSizes*"
  "*CentersAreUniform*"
  "*CodesOfAFlatColor*"
  "*CorrelationAtTheRange*"
  "*DeviationAskedFor*"
  "*EverywhereAfterCorrection*"
  "*GradientsDoNotGrow*"
  "*InsideACube*"
  "*IsWhiteOnCoarse*"
  "*KolmogorovSmirnov*"
  "*MaternOnSphere*"
  "*OfTheSphereConverge*"
  "*OnADecimatedScan*"
  "*StandardErrorIs*"
  "*StiffnessIs*LocallyRefinedSphere"
  "*TailsHave*"
  "*ThreadsTenTimes*"
  "*ValuesAgreeWithTheDense*"
  "*WrongTexturesApart*"
  "*CoupledFlow.*/1"
  "*CoupledFlow.*/2"
  "*CoupledFlow.LosesTheEye*"
  "*FractionalField.CorrectedDeviation*"
  "*FractionalField.SphericalHarmonics*"
  "*VolumeFieldOfPower.HasTheSpectrum*"
  "CoherentNoise.FieldsOnOther*"
  "ComponentCoupling.DoesNotDepend*"
  "ComponentCoupling.FindsAmongMany*"
  "CoupledNoise.HasACovariance*"
  "DisplacedSurface.SampledDeviations*"
  "DisplacementMap.CorrespondencesAgree*"
  "DisplacementMap.DisplacedSubdivision*"
  "DisplacementMap.LargerSphere*"
  "Elasticity.BallIsIndented*"
  "Elasticity.CantileverBends*"
  "ExampleSynthesis.ABlendIsEach*"
  "ExampleSynthesis.FeaturesAre*"
  "ExampleSynthesis.HeightsDeviate*"
  "ExampleSynthesis.SizesChange*"
  "ExampleSynthesis.TexturesFollow*"
  "ExampleSynthesis.UnitsDoNot*"
  "FlowMatchingTraining.EveryLimit*"
  "FlowMatchingTraining.One*Learnt*"
  "FlowMatchingTraining.TheCosineSchedule*"
  "IsotropicRemesh.NumberOfPointsIsMetWithinTwoPerCent"
  "LatentDenoisingNetwork.DerivativesAreThoseOfDifferences"
  "LatentDenoisingNetwork.GivesTheResults*"
  "LatentDenoisingNetwork.HasTheDerivatives*"
  "LatentDiffusionTrainer.LossesFall*"
  "LatentDiffusionTrainer.MuonLearns*"
  "LatticeNoise.DrawsHave*"
  "LatticeNoise.HasTheSameIntegrals*"
  "MaternEstimation.Intervals*"
  "MaternEstimation.LikelihoodIsThat*"
  "MaternEstimation.LikelihoodOfSmoother*"
  "MaternEstimation.StandardErrors*"
  "MeshingReproducibility.BitsDoNotDependOnThreadsInTenRepeats"
  "OnSphere.GradientOfWholeNetworks"
  "PoissonNetEvaluator.EqualsTheDifferentiableNetworkInEveryVariant"
  "PoissonOperators.WithAShiftByMass*"
  "PoseEnsemble.LimbsKeepTheirThickness"
  "PoseEnsemble.WithATemplateOtherTriangulationsGetTheSamePoses"
  "RationalPower.Errors*"
  "TangentNoise.CoarseParts*"
  "TrainProgram.ErrorsAre*"
  "TrainProgram.HelpNames*"
  "TrainProgram.Suggests*"
  "TrainProgram.TrainsADiffusion*"
  "TrainProgram.TrainsAGeometricTexture"
  "TrainProgram.TrainsFieldLatents*"
  "TrainProgram.WrongArguments*"
  "VDBSurfaceImages.SmoothedNoise*"
  "VolumeField.HasSamplesWith*"
  "VolumeField.HasTheDeviationOf*"
  "VolumeField.IsStretched*"
  # Malformed inputs of meshing between good blocks, which the same inputs alone cover.
  "*BetweenGoodBlocksToIsotropicRemesh*"
  "*BetweenGoodBlocksToPoseEnsemble*"
  "*BetweenGoodBlocksToSurfaceRepair*"
  "*BetweenGoodBlocksToTetrahedra*"
  "*BetweenGoodBlocksToTextureAtlas*"
  "*BetweenGoodBlocksToVDBSurface*"
)
# Repeat what others run: for every number of threads with AddressSanitizer, at length with ThreadSanitizer.
set(surfsynth_without_asan "MultigridSolver.AColumnHas*" "VDBSurfaceReproducibility.AnyNumber*")
set(surfsynth_without_tsan "ElasticRest.HasTheSameBits*" "ExampleSynthesis.SeedsDecide*" "MultigridSolver.AColumnHas*"
  "FieldLatentCaching.ProgressIs*" "FlowMatchingCaching.ProgressIs*"
  "GeometricTextureFromExample.AbortsAndGoesOn")

set(surfsynth_test_filter)
if (CMAKE_CXX_FLAGS MATCHES "-fsanitize=thread")
  list(TRANSFORM surfsynth_thread_words REPLACE "(.+)" "*\\1*" OUTPUT_VARIABLE patterns)
  list(JOIN patterns ":" surfsynth_test_filter)
  list(APPEND surfsynth_unsanitized ${surfsynth_without_tsan})
elseif (CMAKE_CXX_FLAGS MATCHES "-fsanitize=")
  list(APPEND surfsynth_unsanitized ${surfsynth_without_asan})
endif ()
if (CMAKE_CXX_FLAGS MATCHES "-fsanitize=")
  list(JOIN surfsynth_unsanitized ":" patterns)
  string(APPEND surfsynth_test_filter "-${patterns}")
endif ()

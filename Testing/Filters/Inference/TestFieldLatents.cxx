// SPDX-License-Identifier: BSD-3-Clause
// Field latents: model files, and the evaluators of encoder and decoder. TestFieldLatentNetworks compares with LibTorch.
#include "InstructionSets.h"
#include "ModelFileChecks.h"
#include "RandomFieldLatents.h"
#include "SparseModels.h"
#include "ThrownText.h"

#include "Core/Common/Errors.h"
#include "Core/Common/Parallel.h"
#include "Inference/Common/MatrixProduct.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <complex>
#include <cstdio>
#include <functional>
#include <limits>
#include <numeric>

using namespace surfsynth;
using namespace surfsynth::test;
using surfsynthtest::TextOf;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

namespace
{
using Complex = std::complex<float>;

constexpr const char* Path = "FieldLatents.safetensors";

const ModelFileKind Kind{ Path, "field_latents",
  [](const std::string& path) { WriteFieldLatents(path, RandomFieldLatents()); },
  [](const std::string& path) { ReadFieldLatents(path); } };

/// Message of reading the file of a small model after @p change.
std::string MessageAfter(const std::function<void(Tensors&, Metadata&)>& change)
{
  return test::MessageAfter(Kind, change);
}

/// The same after the text @p from in the description has become @p to.
std::string MessageWith(const std::string& from, const std::string& to) { return test::MessageWith(Kind, from, to); }

/// Multiplies complex number @p column of each row by the number of the row's factor.
void Turn(FieldLatentMatrix& rows, std::int64_t column, const std::function<Complex(std::int64_t row)>& factor)
{
  for (Eigen::Index row = 0; row < rows.rows(); ++row)
  {
    const Complex turned = factor(row) * Complex(rows(row, 2 * column), rows(row, 2 * column + 1));
    rows(row, 2 * column) = turned.real();
    rows(row, 2 * column + 1) = turned.imag();
  }
}

/// A turn of the frame of a vertex.
Complex FrameTurn(std::int64_t vertex) { return std::polar(1.0F, 0.7F + 1.3F * static_cast<float>(vertex)); }

void TurnLatents(FieldLatentMatrix& latents)
{
  for (Eigen::Index j = 0; j < latents.cols() / 2; ++j)
  {
    Turn(latents, j, FrameTurn);
  }
}

float Difference(const FieldLatentMatrix& a, const FieldLatentMatrix& b) { return (a - b).cwiseAbs().maxCoeff(); }

FieldLatentModel WithCoordinates(FieldLatentCoordinates coordinates)
{
  FieldLatentOptions options = TinyFieldLatents();
  options.Coordinates = coordinates;
  return RandomFieldLatents(options);
}
/// Equations 5 and 18 for one corner in float64: [18], from three tangent vectors.
Eigen::VectorXd DecoderInput(const Eigen::RowVectorXf& latent, std::complex<double> logarithm)
{
  Eigen::VectorXd input(18);
  Eigen::Index pair = 6;
  const auto vector = [&](Eigen::Index j) { return std::complex<double>(latent[2 * j], latent[2 * j + 1]); };
  for (Eigen::Index i = 0; i < 3; ++i)
  {
    const std::complex<double> c = logarithm * std::conj(vector(i));
    input[i] = c.real();
    input[3 + i] = c.imag();
    for (Eigen::Index j = i; j < 3; ++j, ++pair)
    {
      const std::complex<double> product = vector(i) * std::conj(vector(j));
      input[pair] = product.real();
      input[pair + 6] = product.imag();
    }
  }
  return input;
}

/// The neural field in float64.
Eigen::VectorXd NeuralField(const FieldLatentModel& model, Eigen::VectorXd x)
{
  for (std::int64_t layer = 0; layer <= model.Options.DecoderLayers; ++layer)
  {
    const std::string name = "decoder.layers." + std::to_string(layer);
    const ModelTensor& weight = model.Tensors.at(name + ".weight");
    const Eigen::Map<const FieldLatentMatrix> matrix(weight.Values.data(), weight.Shape[0], weight.Shape[1]);
    x = (matrix.cast<double>() * x).eval();
    x += Eigen::Map<const Eigen::VectorXf>(model.Tensors.at(name + ".bias").Values.data(), x.size()).cast<double>();
    if (layer < model.Options.DecoderLayers)
    {
      x = (x.array() / (1.0 + (-x.array()).exp())).matrix().eval();
    }
  }
  return x;
}
} // namespace

TEST(MatrixProduct, BlocksAndTransposesAreThoseOfTheDefinition)
{
  const FieldLatentMatrix a = RandomLatents(5, 4);
  const FieldLatentMatrix b = RandomLatents(6, 4).array() * 2.0F;
  for (const bool transposeA : { false, true })
  {
    for (const bool transposeB : { false, true })
    {
      // Blocks of 3 x 4 and 4 x 2, which begin at row 1 and column 1.
      const auto left = [&](Eigen::Index r, Eigen::Index k) { return transposeA ? a(1 + k, 1 + r) : a(1 + r, 1 + k); };
      const auto right = [&](Eigen::Index k, Eigen::Index c) { return transposeB ? b(1 + c, 1 + k) : b(1 + k, 1 + c); };
      FieldLatentMatrix c = FieldLatentMatrix::Constant(3, 5, 9.0F);
      MultiplyBlocks({ &a(1, 1), 8, transposeA }, { &b(1, 1), 8, transposeB }, &c(0, 2), 5, 3, 4, 2);
      MultiplyBlocks({ &a(1, 1), 8, transposeA }, { &b(1, 1), 8, transposeB }, &c(0, 2), 5, 3, 4, 2, true);
      for (Eigen::Index r = 0; r < 3; ++r)
      {
        for (Eigen::Index column = 0; column < 2; ++column)
        {
          float sum = 0.0F;
          for (Eigen::Index k = 0; k < 4; ++k)
          {
            sum += left(r, k) * right(k, column);
          }
          EXPECT_NEAR(c(r, 2 + column), 2.0F * sum, 1e-5F);
        }
        EXPECT_EQ(c(r, 0), 9.0F);
        EXPECT_EQ(c(r, 4), 9.0F);
      }
    }
  }
}

TEST(FieldLatentOptions, ShapesFollowTheSizes)
{
  const auto paper = ExpectedFieldLatentTensors(FieldLatentOptions::Paper());
  EXPECT_EQ(paper.size(), 8U + 8U * 12U + 8U + 12U);
  EXPECT_THAT(paper.at("encoder.lift.weight"), ElementsAre(256, 3));
  EXPECT_THAT(paper.at("encoder.layers.7.attention.out.weight"), ElementsAre(2, 128, 128));
  EXPECT_THAT(paper.at("encoder.mean.out.weight"), ElementsAre(2, 8, 128));
  EXPECT_THAT(paper.at("decoder.layers.0.weight"), ElementsAre(512, 88));
  EXPECT_THAT(paper.at("decoder.layers.5.weight"), ElementsAre(3, 512));
  FieldLatentOptions barycentric = FieldLatentOptions::Small();
  barycentric.Coordinates = FieldLatentCoordinates::Barycentric;
  EXPECT_THAT(ExpectedFieldLatentTensors(barycentric).at("decoder.layers.0.weight"), ElementsAre(128, 72));
}

TEST(FieldLatentOptions, OptionsOutOfTheirRangeAreNamed)
{
  FieldLatentOptions options;
  options.Heads = 7;
  EXPECT_THAT(
    TextOf<InvalidInput>([&] { CheckOptions(options); }), HasSubstr("Heads is 7; expected a divisor of the 128"));
  options = {};
  options.LatentDimension = 0;
  EXPECT_THAT(
    TextOf<InvalidInput>([&] { CheckOptions(options); }), HasSubstr("LatentDimension is 0; expected 1 to 256"));
}

TEST(FieldLatentModel, WhatIsWrittenIsRead)
{
  FieldLatentModel model = WithCoordinates(FieldLatentCoordinates::Barycentric);
  model.Metadata["note"] = "kept";
  WriteFieldLatents(Path, model);
  const FieldLatentModel read = ReadFieldLatents(Path);
  EXPECT_TRUE(read.Options == model.Options);
  EXPECT_EQ(read.Iterations, 7);
  EXPECT_EQ(read.Metadata.at("note"), "kept");
  ASSERT_EQ(read.Tensors.size(), model.Tensors.size());
  for (const auto& [name, tensor] : model.Tensors)
  {
    EXPECT_EQ(read.Tensors.at(name).Shape, tensor.Shape) << name;
    EXPECT_EQ(read.Tensors.at(name).Values, tensor.Values) << name;
  }
  EXPECT_EQ(read.Description(),
    "field latents of dimension 3: encoder of 2 layers with 12 channels, 6 samples in a ring; decoder of 2 layers with "
    "10 channels, barycentric coordinates; 7 iterations");
}

TEST(FieldLatentModel, FilesThatDoNotFitAreNamed)
{
  ExpectMetadataAreChecked(Kind);
  ExpectKeysAreNeeded(Kind,
    { "latent_dimension", "channels", "encoder_layers", "heads", "samples_per_ring", "decoder_layers", "decoder_width",
      "iterations", "coordinates" });
  EXPECT_THAT(MessageWith("\"logarithmic\"", "\"polar\""), HasSubstr("expected \"logarithmic\" or \"barycentric\""));
  EXPECT_THAT(MessageWith("\"heads\":3", "\"heads\":5"), HasSubstr("Heads is 5; expected a divisor"));
  EXPECT_THAT(MessageWith("\"channels\":12", "\"channels\":15"), HasSubstr("the tensors are not those"));
  EXPECT_THAT(MessageAfter([](Tensors& tensors, Metadata&) { tensors.erase("decoder.layers.2.bias"); }),
    HasSubstr("\"decoder.layers.2.bias\" [3] is missing"));
  EXPECT_THAT(MessageAfter([](Tensors& tensors, Metadata&) {
    tensors["decoder.layers.2.bias"] = TensorData::FromFloat32(
      { 3 }, { 0.0F, std::numeric_limits<float>::quiet_NaN(), 0.0F });
  }),
    AllOf(HasSubstr("FormatError"), HasSubstr("decoder.layers.2.bias")));
  EXPECT_THAT(MessageAfter([](Tensors& tensors, Metadata&) {
    tensors["decoder.layers.2.bias"] = TensorData::FromInt64({ 3 }, { 1, 2, 3 });
  }),
    AllOf(HasSubstr("ModelMismatch"), HasSubstr("decoder.layers.2.bias")));
  EXPECT_THROW(ReadFieldLatents("nowhere.safetensors"), InvalidInput);
  std::remove(Path);
}

TEST(FieldLatentModel, ModelsMadeByHandAreChecked)
{
  FieldLatentModel model = RandomFieldLatents();
  model.Tensors.begin()->second.Values.pop_back();
  EXPECT_THAT(TextOf<InvalidInput>([&] { CheckModel(model); }), HasSubstr("finite ones"));
  model = RandomFieldLatents();
  model.Options.EncoderLayers = 3;
  EXPECT_THAT(TextOf<InvalidInput>([&] { FieldLatentEncoder encoder(model); }), HasSubstr("encoder.layers.2"));
}

TEST(FieldLatentEncoder, MeansTurnWithTheFramesAndDeviationsDoNot)
{
  const FieldLatentEncoder encoder(RandomFieldLatents());
  FieldLatentRings rings = RandomRings(20, 6, 4);
  const FieldLatentCodes codes = encoder.Encode(rings);
  for (std::int64_t v = 0; v < rings.NumberOfVertices(); ++v)
  {
    for (std::int64_t k = rings.Offsets[v]; k < rings.Offsets[v + 1]; ++k)
    {
      const Complex turned = FrameTurn(v) * Complex(rings.Logarithms(k, 0), rings.Logarithms(k, 1));
      rings.Logarithms.row(k) << turned.real(), turned.imag();
    }
  }
  const FieldLatentCodes turned = encoder.Encode(rings);
  FieldLatentMatrix expected = codes.Mean;
  TurnLatents(expected);
  EXPECT_GT(codes.Mean.cwiseAbs().maxCoeff(), 0.05F);
  EXPECT_LT(Difference(turned.Mean, expected), 1e-5F);
  EXPECT_LT(Difference(turned.LogDeviation, codes.LogDeviation), 1e-5F);
}

TEST(FieldLatentEncoder, TheOrderOfSamplesMakesNoDifference)
{
  const FieldLatentEncoder encoder(RandomFieldLatents());
  FieldLatentRings rings = RandomRings(10, 7);
  const FieldLatentCodes codes = encoder.Encode(rings);
  for (std::int64_t v = 0; v < rings.NumberOfVertices(); ++v)
  {
    const FieldLatentMatrix logarithms = rings.Logarithms.middleRows(rings.Offsets[v], 7).colwise().reverse();
    const FieldLatentMatrix colors = rings.Colors.middleRows(rings.Offsets[v], 7).colwise().reverse();
    rings.Logarithms.middleRows(rings.Offsets[v], 7) = logarithms;
    rings.Colors.middleRows(rings.Offsets[v], 7) = colors;
  }
  const FieldLatentCodes reversed = encoder.Encode(rings);
  EXPECT_LT(Difference(reversed.Mean, codes.Mean), 1e-5F);
  EXPECT_LT(Difference(reversed.LogDeviation, codes.LogDeviation), 1e-5F);
}

TEST(FieldLatentEncoder, ARingIsTheSameAloneAndAmongOthersOfOtherSizes)
{
  const FieldLatentEncoder encoder(RandomFieldLatents());
  // One ring with more samples than a tile has tokens and attention has queries at once, one without any.
  FieldLatentRings rings = RandomRings(9, 100, 3);
  std::vector<std::int64_t> offsets = { 0, 700 };
  for (const std::int64_t more : { 0, 5, 100, 150, 202 })
  {
    offsets.push_back(700 + more);
  }
  offsets.push_back(rings.Offsets.back());
  rings.Offsets = offsets;
  const FieldLatentCodes codes = encoder.Encode(rings);
  for (std::size_t v = 0; v + 1 < offsets.size(); ++v)
  {
    FieldLatentRings alone;
    const std::int64_t size = offsets[v + 1] - offsets[v];
    alone.Offsets = { 0, size };
    alone.Logarithms = rings.Logarithms.middleRows(offsets[v], size);
    alone.Colors = rings.Colors.middleRows(offsets[v], size);
    const FieldLatentCodes code = encoder.Encode(alone);
    EXPECT_LT(Difference(code.Mean, codes.Mean.row(static_cast<Eigen::Index>(v))), 1e-5F) << v;
    EXPECT_LT(Difference(code.LogDeviation, codes.LogDeviation.row(static_cast<Eigen::Index>(v))), 1e-5F) << v;
    if (size == 0)
    {
      EXPECT_EQ(code.Mean.cwiseAbs().maxCoeff(), 0.0F);
    }
  }
}

TEST(FieldLatentEncoder, BitsDoNotDependOnThreads)
{
  const FieldLatentEncoder encoder(RandomFieldLatents());
  const FieldLatentRings rings = RandomRings(300, 10, 5);
  const FieldLatentCodes one = [&] {
    const ThreadScope threads(1);
    return encoder.Encode(rings);
  }();
  const ThreadScope threads(3);
  const FieldLatentCodes three = encoder.Encode(rings);
  EXPECT_EQ(three.Mean, one.Mean);
  EXPECT_EQ(three.LogDeviation, one.LogDeviation);
}

TEST(FieldLatentEncoder, InstructionSetsAgree)
{
  const FieldLatentRings rings = RandomRings(20, 9, 4);
  const FieldLatentTexels texels = RandomTexels(50, 20);
  std::vector<FieldLatentMatrix> results;
  ForEachInstructionSet([&](InstructionSet) {
    const FieldLatentModel model = RandomFieldLatents();
    const FieldLatentCodes codes = FieldLatentEncoder(model).Encode(rings);
    results.push_back(codes.Mean);
    results.push_back(codes.LogDeviation);
    results.push_back(FieldLatentDecoder(model).Decode(RandomLatents(20, 3), texels));
  });
  for (std::size_t k = 3; k < results.size(); ++k)
  {
    EXPECT_LT(Difference(results[k], results[k % 3]), 1e-5F) << k;
  }
}

TEST(FieldLatentEncoder, RingsThatDoNotFitAreNamed)
{
  const FieldLatentEncoder encoder(RandomFieldLatents());
  const auto refusal = [&](const std::function<void(FieldLatentRings&)>& change) {
    FieldLatentRings rings = RandomRings(3, 4);
    change(rings);
    return TextOf<InvalidInput>([&] { encoder.Encode(rings); });
  };
  EXPECT_THAT(refusal([](FieldLatentRings& rings) { rings.Colors.conservativeResize(11, 3); }),
    HasSubstr("the logarithms are [12, 2] and the colors [11, 3]"));
  EXPECT_THAT(refusal([](FieldLatentRings& rings) { rings.Offsets[1] = 9; }), HasSubstr("that never decrease"));
  EXPECT_THAT(refusal([](FieldLatentRings& rings) { rings.Offsets.clear(); }), HasSubstr("the 0 offsets"));
  EXPECT_THAT(refusal([](FieldLatentRings& rings) { rings.Colors(2, 1) = std::numeric_limits<float>::infinity(); }),
    HasSubstr("not finite"));
  EXPECT_THAT(refusal([](FieldLatentRings& rings) { rings.Colors.setConstant(3e38F); }),
    HasSubstr("a latent code is not finite"));
  EXPECT_EQ(encoder.Encode({}).Mean.rows(), 0);
}

TEST(FieldLatentEncoder, ReportsProgressAndStops)
{
  const FieldLatentEncoder encoder(RandomFieldLatents());
  const FieldLatentRings rings = RandomRings(500, 10);
  const ThreadScope threads(1);
  double last = 0.0;
  encoder.Encode(rings, [&](double done) {
    EXPECT_GE(done, last);
    last = done;
    return true;
  });
  EXPECT_EQ(last, 1.0);
  EXPECT_THROW(encoder.Encode(rings, [](double) { return false; }), Cancelled);
}

TEST(FieldLatentEncoder, ReportsProgressWithinARingOfVeryManySamples)
{
  const FieldLatentEncoder encoder(RandomFieldLatents());
  FieldLatentRings rings = RandomRings(1, 2000);
  for (const int count : { 1, 2 })
  {
    const ThreadScope threads(count);
    int reports = 0;
    encoder.Encode(rings, [&](double) { return ++reports > 0; });
    EXPECT_GT(reports, 20) << "one tile of many blocks of queries";
    reports = 0;
    EXPECT_THROW(encoder.Encode(rings, [&](double) { return ++reports < 5; }), Cancelled);
    EXPECT_EQ(reports, 5) << "stops within the tile";
    rings = RandomRings(2, 2000);
  }
}

TEST(FieldLatentDecoder, PredictionsAreThoseOfTheEquations)
{
  for (const FieldLatentCoordinates coordinates :
    { FieldLatentCoordinates::Logarithmic, FieldLatentCoordinates::Barycentric })
  {
    const FieldLatentModel model = WithCoordinates(coordinates);
    const FieldLatentMatrix latents = RandomLatents(9, 3);
    const FieldLatentTexels texels = RandomTexels(400, 9); // several tiles
    const FieldLatentMatrix colors = FieldLatentDecoder(model).Decode(latents, texels);
    for (const Eigen::Index q : { 0, 170, 399 })
    {
      Eigen::VectorXd expected = Eigen::VectorXd::Zero(3);
      Eigen::VectorXd blended = Eigen::VectorXd::Zero(12);
      for (Eigen::Index k = 0; k < 3; ++k)
      {
        const std::complex<double> logarithm(texels.Logarithms(q, 2 * k), texels.Logarithms(q, 2 * k + 1));
        const Eigen::VectorXd input = DecoderInput(latents.row(texels.Corners(q, k)), logarithm);
        const double weight = texels.Barycentric(q, k);
        blended += weight * input.tail(12);
        if (coordinates == FieldLatentCoordinates::Logarithmic)
        {
          expected += weight * NeuralField(model, input);
        }
      }
      if (coordinates == FieldLatentCoordinates::Barycentric)
      {
        expected = NeuralField(model, blended);
      }
      EXPECT_LT((colors.row(q).transpose().cast<double>() - expected).norm(), 1e-5) << q;
    }
  }
}

TEST(FieldLatentDecoder, ColorsDoNotDependOnFramesAndThreads)
{
  const FieldLatentDecoder decoder(RandomFieldLatents());
  FieldLatentMatrix latents = RandomLatents(30, 3);
  FieldLatentTexels texels = RandomTexels(1000, 30);
  const FieldLatentMatrix colors = [&] {
    const ThreadScope threads(1);
    return decoder.Decode(latents, texels);
  }();
  const ThreadScope threads(3);
  EXPECT_EQ(decoder.Decode(latents, texels), colors);
  TurnLatents(latents);
  for (std::int64_t k = 0; k < 3; ++k)
  {
    Turn(texels.Logarithms, k, [&](std::int64_t q) { return FrameTurn(texels.Corners(q, k)); });
  }
  EXPECT_LT(Difference(decoder.Decode(latents, texels), colors), 1e-5F);
}

TEST(FieldLatentDecoder, TexelsThatDoNotFitAreNamed)
{
  const FieldLatentDecoder decoder(RandomFieldLatents());
  const auto refusal = [&](const std::function<void(FieldLatentMatrix&, FieldLatentTexels&)>& change) {
    FieldLatentMatrix latents = RandomLatents(8, 3);
    FieldLatentTexels texels = RandomTexels(5, 8);
    change(latents, texels);
    return TextOf<InvalidInput>([&] { decoder.Decode(latents, texels); });
  };
  using Latents = FieldLatentMatrix;
  using Texels = FieldLatentTexels;
  EXPECT_THAT(refusal([](Latents& latents, Texels&) { latents.conservativeResize(8, 4); }),
    HasSubstr("the latent codes are [8, 4]; expected [V, 6]"));
  EXPECT_THAT(refusal([](Latents&, Texels& texels) { texels.Logarithms.resize(0, 6); }),
    HasSubstr("the logarithms are [0, 6]; expected [5, 6]"));
  EXPECT_THAT(refusal([](Latents&, Texels& texels) { texels.Barycentric.resize(5, 2); }),
    HasSubstr("the barycentric coordinates are [5, 2]; expected [5, 3]"));
  EXPECT_THAT(refusal([](Latents&, Texels& texels) { texels.Corners(1, 1) = 8; }), HasSubstr("to 8; expected 0 to 7"));
  EXPECT_THAT(refusal([](Latents&, Texels& texels) { texels.Corners(1, 1) = -1; }), HasSubstr("vertices -1 to"));
  EXPECT_THAT(refusal([](Latents& latents, Texels&) { latents(3, 3) = std::numeric_limits<float>::quiet_NaN(); }),
    HasSubstr("not finite"));
  EXPECT_THAT(
    refusal([](Latents& latents, Texels&) { latents.setConstant(1e30F); }), HasSubstr("a color is not finite"));
  EXPECT_EQ(decoder.Decode(RandomLatents(8, 3), {}).rows(), 0);
  EXPECT_THROW(decoder.Decode(RandomLatents(8, 3), RandomTexels(5, 8), [](double) { return false; }), Cancelled);
}

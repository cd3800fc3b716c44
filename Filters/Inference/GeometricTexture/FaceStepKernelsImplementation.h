// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// The body of the kernels for steps of trainings on triangles, included once for each instruction set by a file that
/// defines SURFSYNTH_KERNELS (the table to define). Includes no standard header, as in ActivationKernelsImplementation.h.
#pragma once

#include "Inference/GeometricTexture/FaceStepKernels.h"

namespace surfsynth
{

namespace
{
using Size = std::int64_t;
using Place = std::uint8_t;

constexpr float Slope = 0.2F;     // of LeakyReLU below 0
constexpr float Steepness = 5.0F; // of its inverse

inline float SlopeAt(float activated) { return activated > 0.0F ? 1.0F : Slope; }
/// What LeakyReLU was applied to.
inline float BeforeActivation(float activated) { return activated > 0.0F ? activated : Steepness * activated; }

/// Three rows.
struct ThreeRows
{
  const float* A;
  const float* B;
  const float* C;
};

ThreeRows RowsOf(const LookingFaces& faces, Size face, const StridedRows& products)
{
  const std::int32_t* rows = faces.Rows + 3 * face;
  return { products.Data + rows[0] * products.Stride, products.Data + rows[1] * products.Stride,
    products.Data + rows[2] * products.Stride };
}

/// Largest of three rows and its place, plus the bias and, with @p HasOwn, plus @p own.
template <bool HasOwn>
void LargestOf(const ThreeRows& rows, const float* __restrict__ own, const float* __restrict__ bias, Size width,
  float* __restrict__ out, Place* __restrict__ places)
{
  const float* __restrict__ a = rows.A;
  const float* __restrict__ b = rows.B;
  const float* __restrict__ c = rows.C;
  for (Size k = 0; k < width; ++k)
  {
    const float two = b[k] > a[k] ? b[k] : a[k];
    const std::int32_t placeOfTwo = b[k] > a[k] ? 1 : 0;
    places[k] = static_cast<Place>(c[k] > two ? 2 : placeOfTwo);
    float sum = bias[k];
    if constexpr (HasOwn)
    {
      sum += own[k];
    }
    out[k] = sum + (c[k] > two ? c[k] : two);
  }
}

void Largest(const LookingFaces& faces, const StridedRows& products, const StridedRows& own, const float* bias,
  float* out, Place* places)
{
  const Size width = faces.Width;
  for (Size f = faces.First; f < faces.First + faces.Count; ++f, out += width, places += width)
  {
    const ThreeRows rows = RowsOf(faces, f, products);
    if (own.Data)
    {
      LargestOf<true>(rows, own.Data + f * own.Stride, bias, width, out, places);
    }
    else
    {
      LargestOf<false>(rows, nullptr, bias, width, out, places);
    }
  }
}

/// The value where @p found is @p place, else 0.
inline float Where(Place found, std::int32_t place, float value)
{
  return static_cast<std::int32_t>(found) == place ? value : 0.0F;
}

void TakeAtPlaces(const float* __restrict__ a, const float* __restrict__ b, const float* __restrict__ c,
  const Place* __restrict__ places, Size width, float* __restrict__ out)
{
  for (Size k = 0; k < width; ++k)
  {
    out[k] += Where(places[k], 0, a[k]) + Where(places[k], 1, b[k]) + Where(places[k], 2, c[k]);
  }
}

void AtPlaces(
  const LookingFaces& faces, const StridedRows& products, const StridedRows& own, const Place* places, float* out)
{
  const Size width = faces.Width;
  for (Size f = faces.First; f < faces.First + faces.Count; ++f, out += width, places += width)
  {
    const float* __restrict__ itself = own.Data ? own.Data + f * own.Stride : nullptr;
    for (Size k = 0; k < width; ++k)
    {
      out[k] = itself ? itself[k] : 0.0F;
    }
    const ThreeRows rows = RowsOf(faces, f, products);
    TakeAtPlaces(rows.A, rows.B, rows.C, places, width, out);
  }
}

void CopyWhere(const float* __restrict__ values, const Place* __restrict__ places, std::int32_t place, Size width,
  float* __restrict__ out)
{
  for (Size k = 0; k < width; ++k)
  {
    out[k] = Where(places[k], place, values[k]);
  }
}

/// Values and kept places of a triangle that looks at a row, and which of its three rows that is.
struct RowUse
{
  const float* Values;
  const Place* Places;
  std::int32_t Which;
};

void SumOfThree(const RowUse& a, const RowUse& b, const RowUse& c, Size width, float* __restrict__ out)
{
  const float* __restrict__ x = a.Values;
  const float* __restrict__ y = b.Values;
  const float* __restrict__ z = c.Values;
  const Place* __restrict__ ofX = a.Places;
  const Place* __restrict__ ofY = b.Places;
  const Place* __restrict__ ofZ = c.Places;
  for (Size k = 0; k < width; ++k)
  {
    out[k] = Where(ofX[k], a.Which, x[k]) + Where(ofY[k], b.Which, y[k]) + Where(ofZ[k], c.Which, z[k]);
  }
}

void SumAtPlaces(const SeenRows& rows, const Place* places, const StridedRows& values, float* out, Size stride)
{
  const Size width = rows.Width;
  const auto useOf = [&](Size entry) {
    const Size face = rows.Faces[entry];
    return RowUse{ values.Data + face * values.Stride, places + face * width, rows.Places[entry] };
  };
  for (Size row = rows.First; row < rows.First + rows.Count; ++row, out += stride)
  {
    const Size entry = rows.Uses * row;
    if (rows.Uses == 3)
    {
      SumOfThree(useOf(entry), useOf(entry + 1), useOf(entry + 2), width, out);
    }
    else
    {
      const RowUse use = useOf(entry);
      CopyWhere(use.Values, use.Places, use.Which, width, out);
    }
  }
}

void AddGradientSums(const float* __restrict__ gradients, const float* __restrict__ activated, Size rows, Size width,
  double* __restrict__ sums)
{
  for (Size row = 0; row < rows; ++row, gradients += width, activated += width)
  {
    for (Size k = 0; k < width; ++k)
    {
      const float h = gradients[k] * SlopeAt(activated[k]);
      sums[k] += static_cast<double>(h);
      sums[width + k] += static_cast<double>(h * BeforeActivation(activated[k]));
    }
  }
}

void NormGradient(const float* __restrict__ gradients, const float* __restrict__ activated, const NormMeans& means,
  Size rows, Size width, float* __restrict__ out, Size stride)
{
  const float* __restrict__ scale = means.Scale;
  const float* __restrict__ mean = means.Gradient;
  const float* __restrict__ meanTimes = means.GradientTimes;
  for (Size row = 0; row < rows; ++row, gradients += width, activated += width, out += stride)
  {
    for (Size k = 0; k < width; ++k)
    {
      const float h = gradients[k] * SlopeAt(activated[k]);
      out[k] = scale[k] * (h - mean[k] - BeforeActivation(activated[k]) * meanTimes[k]);
    }
  }
}

void AddDirectionSums(const float* __restrict__ directions, const float* __restrict__ gradients,
  const float* __restrict__ activated, Size rows, Size width, double* __restrict__ sums)
{
  for (Size row = 0; row < rows; ++row, directions += width, gradients += width, activated += width)
  {
    for (Size k = 0; k < width; ++k)
    {
      const float u = directions[k];
      sums[k] += static_cast<double>(u);
      sums[width + k] += static_cast<double>(u * BeforeActivation(activated[k]));
      sums[2 * width + k] += static_cast<double>(u * gradients[k] * SlopeAt(activated[k]));
    }
  }
}

void NormSecondGradient(const float* __restrict__ directions, const float* __restrict__ gradients,
  const float* __restrict__ activated, const NormMeans& means, Size rows, Size width, float* __restrict__ byGradients,
  float* __restrict__ byValues, Size stride)
{
  const float* __restrict__ scale = means.Scale;
  const float* __restrict__ h1 = means.Gradient;
  const float* __restrict__ hn = means.GradientTimes;
  const float* __restrict__ u1 = means.Direction;
  const float* __restrict__ un = means.DirectionTimes;
  const float* __restrict__ uh = means.DirectionProduct;
  for (Size row = 0; row < rows; ++row)
  {
    for (Size k = 0; k < width; ++k)
    {
      const float n = BeforeActivation(activated[k]);
      const float h = gradients[k] * SlopeAt(activated[k]);
      const float u = directions[k];
      byGradients[k] = SlopeAt(activated[k]) * scale[k] * (u - u1[k] - n * un[k]);
      // The norm's derivative of -r (h mean(u n) + u mean(h n)), less r n times the mean of h's product with that of u.
      const float centered = un[k] * (h1[k] - h) + hn[k] * (u1[k] - u);
      const float along = 3.0F * un[k] * hn[k] + u1[k] * h1[k] - uh[k];
      byValues[k] = scale[k] * scale[k] * (centered + n * along);
    }
    directions += width;
    gradients += width;
    activated += width;
    byGradients += width;
    byValues += stride;
  }
}
} // namespace

extern const FaceStepKernels SURFSYNTH_KERNELS = { Largest, AtPlaces, SumAtPlaces, AddGradientSums, NormGradient,
  AddDirectionSums, NormSecondGradient };

} // namespace surfsynth

// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Atlas/GutterFill.h"

#include "Core/Common/LargeArray.h"
#include "Core/Common/Parallel.h"

#include <cstdlib>
#include <limits>

namespace surfsynth
{

namespace
{
constexpr std::int32_t None = std::numeric_limits<std::int32_t>::min();

/// Finds the row of the nearest texel with a place in each column, for all texels.
void FindRows(const AtlasRaster& raster, LargeArray<std::int32_t>& rows)
{
  const std::int64_t width = raster.Width;
  ParallelFor(width, 64, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t j = 0; j < raster.Height; ++j)
    {
      for (std::int64_t i = begin; i < end; ++i)
      {
        const std::int64_t texel = j * width + i;
        const std::int32_t above = j > 0 ? rows[texel - width] : None;
        rows[texel] = raster.Kinds[texel] != TexelKind::Empty ? static_cast<std::int32_t>(j) : above;
      }
    }
    for (std::int64_t j = raster.Height - 2; j >= 0; --j)
    {
      for (std::int64_t i = begin; i < end; ++i)
      {
        const std::int64_t texel = j * width + i;
        const std::int32_t below = rows[texel + width];
        const bool nearer = below != None && (rows[texel] == None || below - j < j - rows[texel]);
        rows[texel] = nearer ? below : rows[texel];
      }
    }
  });
}

/// The nearest columns of one row: the lower envelope of the parabolas (x - i)^2 + g(i)^2.
class RowEnvelope
{
public:
  explicit RowEnvelope(int width)
    : Columns(static_cast<std::size_t>(width))
    , Starts(static_cast<std::size_t>(width))
  {}

  /// Builds the envelope of row @p j.
  /// @param rows [width], rows of the nearest texels in each column
  void Build(const std::int32_t* rows, std::int64_t j, int width)
  {
    this->Count = 0;
    for (int i = 0; i < width; ++i)
    {
      if (rows[i] == None)
      {
        continue;
      }
      const auto squared = [&](int column) { return (j - rows[column]) * (j - rows[column]); };
      std::int64_t start = 0;
      while (this->Count > 0)
      {
        // The first column that is nearer to the new parabola than to the last one.
        const std::int64_t last = this->Columns[this->Count - 1];
        const std::int64_t numerator = i * std::int64_t(i) - last * last + squared(i) - squared(int(last));
        const std::int64_t denominator = 2 * (i - last);
        start = numerator < 0 ? 0 : numerator / denominator + 1;
        if (start > this->Starts[this->Count - 1])
        {
          break;
        }
        --this->Count;
        start = 0;
      }
      if (start < width)
      {
        this->Columns[this->Count] = i;
        this->Starts[this->Count] = start;
        ++this->Count;
      }
    }
  }

  /// Calls visit(i, nearest column) for each column of the row, ascending; not at all for an empty envelope.
  template <typename Visit>
  void ForColumns(int width, const Visit& visit) const
  {
    std::size_t at = 0;
    for (int i = 0; i<width&& this->Count> 0; ++i)
    {
      while (at + 1 < this->Count && this->Starts[at + 1] <= i)
      {
        ++at;
      }
      visit(i, this->Columns[at]);
    }
  }

private:
  std::vector<int> Columns;         ///< of the parabolas of the envelope, ascending
  std::vector<std::int64_t> Starts; ///< the column from which each is the lowest
  std::size_t Count = 0;
};
} // namespace

void FillGutter(AtlasRaster& raster, int width)
{
  const bool all = width == AtlasRasterOptions::WholeImage;
  const std::int64_t reach = all ? std::numeric_limits<std::int64_t>::max() : std::int64_t(width) * width;
  LargeArray<std::int32_t> rows(raster.Places.size());
  FindRows(raster, rows);
  ParallelFor(raster.Height, 16, [&](std::int64_t begin, std::int64_t end) {
    RowEnvelope envelope(raster.Width);
    for (std::int64_t j = begin; j < end; ++j)
    {
      const std::int32_t* nearestRows = rows.data() + j * raster.Width;
      envelope.Build(nearestRows, j, raster.Width);
      envelope.ForColumns(raster.Width, [&](int i, int column) {
        const std::int64_t texel = j * raster.Width + i;
        const std::int64_t row = nearestRows[column];
        const std::int64_t across = i - column;
        // Texels that were empty before are never read: each thread writes to its own.
        if (raster.Kinds[texel] == TexelKind::Empty && across * across + (j - row) * (j - row) <= reach)
        {
          raster.Places[texel] = raster.Places[row * raster.Width + column];
          raster.Kinds[texel] = TexelKind::Gutter;
        }
      });
    }
  });
}

} // namespace surfsynth

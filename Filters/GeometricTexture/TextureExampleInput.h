// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Example of an input port, or of a file, of vtkGeometricTextureFromExample.
#pragma once

#include "Core/Common/Progress.h"
#include "Core/Mesh/TriangleMesh.h"
#include "Inference/GeometricTexture/GeometricTextureExample.h"
#include "Inference/GeometricTexture/TextureExampleFile.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>

class vtkInformationVector;

namespace surfsynth
{

/// Words for an example in messages.
struct TextureExampleWords
{
  std::string Textured; ///< "The example on port 1"
  std::string Plain;    ///< "The plain example on port 2"
  std::string FileName; ///< "ExampleFileName"
};

/// Example that a filter has on an input port or in a file, and its patches, which are kept until it changes.
class TextureExampleInput
{
public:
  explicit TextureExampleInput(TextureExampleWords words)
    : Words(std::move(words))
  {}

  /// Reads the example. @param plain port of the one without texture, which may have no connection
  /// @param orientationArrayName array of the directions; "" for none
  /// @param smoothingLength of the form of an example without a plain one, world units; 0 for a tenth of the root of the area
  /// @throws InvalidInput when it is no surface, or one that does not meet GeometricTextureExample::Requirements()
  void Read(vtkInformationVector* textured, vtkInformationVector* plain, const std::string& orientationArrayName,
    double smoothingLength);
  /// Takes the example of a file.
  /// @param isOriented true where the direction of its texture is needed
  /// @param smoothingLength of the form of an example without a plain one, world units; 0 for that of the file
  /// @throws InvalidInput when it has no direction and needs one
  void Read(const std::shared_ptr<const TextureExampleFile>& file, bool isOriented, double smoothingLength);
  /// Forgets the example and its patches.
  void Clear();
  /// Counts the scales of the example that Read() has read. @throws InvalidInput, SolverFailure
  ExampleScaleCounts Scales();
  /// Returns the patches of the example that Read() has read, at so many scales, above 0. Those of another number are dropped
  /// first.
  /// @throws InvalidInput, SolverFailure, Cancelled
  std::shared_ptr<const GeometricTextureExample> Patches(int scales, const Progress& progress);

private:
  /// Inputs that the form and the patches depend on.
  struct Key
  {
    std::uint64_t Textured = 0;                     ///< hash
    std::uint64_t Plain = 0;                        ///< hash; 0 without a plain example
    std::shared_ptr<const TextureExampleFile> File; ///< null for an example on a port
    double SmoothingLength = 0.0;
    PointMatrix Directions;

    bool operator==(const Key& other) const;
  };

  void FindForm();
  const std::string& Source() const { return this->Known.File ? this->Words.FileName : this->Words.Textured; }

  TextureExampleWords Words;
  Key Known; ///< what was read last
  TriangleMesh Textured;
  std::optional<TriangleMesh> Form; ///< the plain example, or the smooth form once it is needed
  double Margin = 0.0;              ///< around boundaries, in which the form is none
  std::shared_ptr<const GeometricTextureExample> Cut;
  int CutScales = 0;
  std::optional<ExampleScaleCounts> Counts;
};

} // namespace surfsynth

// SPDX-License-Identifier: BSD-3-Clause
/// @file
/// Diffusion model of field latents and the autoencoder that it belongs to. Private to the module.
#pragma once

#include "FileCache.h"

#include "Inference/FieldLatents/FieldLatentDecoder.h"
#include "Inference/FieldLatents/FieldLatentEncoder.h"
#include "Inference/FieldLatents/FieldLatentModel.h"
#include "Inference/FieldLatents/LatentDiffusionModel.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

namespace surfsynth
{

/// Both models of a filter, read when their files have changed.
class LatentModelPair
{
public:
  LatentModelPair();

  /// Reads the files, or the installed models of these names, where they have changed.
  /// @throws InvalidInput when the diffusion model belongs to another autoencoder; the errors of the readers.
  void Read(const std::string& diffusion, const std::string& autoencoder);

  /// Diffusion model of the last Read(); null before.
  const std::shared_ptr<const LatentDiffusionModel>& Diffusion() const { return this->Model; }
  const FieldLatentEncoder& Encoder() const { return *this->Encoding; }
  const FieldLatentDecoder& Decoder() const { return *this->Decoding; }
  /// Number of files of diffusion models read.
  std::int64_t NumberOfLoads() const { return this->File.NumberOfLoads(); }

private:
  void RequirePair(const std::string& diffusion, const std::string& autoencoder) const;

  FileCache<LatentDiffusionModel> File;
  FileCache<FieldLatentModel> AutoencoderFile;
  std::shared_ptr<const LatentDiffusionModel> Model;
  std::shared_ptr<const FieldLatentModel> Autoencoder;
  std::string AutoencoderFingerprint;
  std::optional<FieldLatentDecoder> Decoding; ///< of Autoencoder
  std::optional<FieldLatentEncoder> Encoding; ///< of Autoencoder
};

} // namespace surfsynth

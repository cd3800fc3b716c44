// SPDX-License-Identifier: BSD-3-Clause
#include "LatentModelPair.h"

#include "Core/Common/Errors.h"
#include "IO/Weights/InstalledModels.h"

namespace surfsynth
{

LatentModelPair::LatentModelPair()
  : File([](const std::string& path) { return ReadLatentDiffusion(path); },
      "A diffusion model of field latents in safetensors format is needed, as vtkLatentDiffusionTrainer writes it.")
  , AutoencoderFile([](const std::string& path) { return ReadFieldLatents(path); },
      "An autoencoder of field latents in safetensors format is needed (AutoencoderFileName), as vtkFieldLatentTrainer "
      "writes it.")
{}

void LatentModelPair::Read(const std::string& diffusion, const std::string& autoencoder)
{
  this->Model = this->File.Get(ExistingModelPath(diffusion));
  const auto found = this->AutoencoderFile.Get(ExistingModelPath(autoencoder));
  if (found != this->Autoencoder)
  {
    this->Decoding.reset(); // first, so that the weights of two models are never held
    this->Encoding.reset();
    this->Autoencoder = found;
    this->AutoencoderFingerprint = Fingerprint(*found);
    this->Decoding.emplace(*found);
    this->Encoding.emplace(*found);
  }
  this->RequirePair(diffusion, autoencoder);
}

void LatentModelPair::RequirePair(const std::string& diffusion, const std::string& autoencoder) const
{
  const std::string advice =
    "The autoencoder that made the latents of its training is needed (AutoencoderFileName is \"" + autoencoder + "\").";
  if (!this->Model->Autoencoder.empty() && this->Model->Autoencoder != this->AutoencoderFingerprint)
  {
    throw InvalidInput("The diffusion model \"" + diffusion + "\" belongs to the autoencoder with the fingerprint " +
      this->Model->Autoencoder + ", not to that with " + this->AutoencoderFingerprint + ". " + advice);
  }
  const std::int64_t dimension = this->Model->Options.LatentDimension;
  if (dimension != this->Autoencoder->Options.LatentDimension)
  {
    throw InvalidInput("The diffusion model \"" + diffusion + "\" has latents of dimension " +
      std::to_string(dimension) + ", the autoencoder of dimension " +
      std::to_string(this->Autoencoder->Options.LatentDimension) + ". " + advice);
  }
}

} // namespace surfsynth

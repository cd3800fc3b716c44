// SPDX-License-Identifier: BSD-3-Clause
#include "ModelCache.h"

#include "Core/Common/Errors.h"

#include <system_error>

namespace surfsynth
{

std::shared_ptr<const PoissonNetModel> ModelCache::Get(const std::string& path)
{
  std::error_code error;
  const auto time = std::filesystem::last_write_time(path, error);
  if (error)
  {
    this->Model.reset();
    throw InvalidInput("The model file \"" + path + "\" cannot be read: " + error.message() +
      ". A PoissonNet in safetensors format is "
      "needed; \"python3 -m surfacesynthesis convert\" makes one of a PyTorch checkpoint.");
  }
  const auto size = std::filesystem::file_size(path, error); // of what is no file: the reader says so
  if (!this->Model || path != this->Path || time != this->Time || size != this->Size)
  {
    this->Model.reset(); // first, so that two models are never held, and none after an error
    this->Model = std::make_shared<const PoissonNetModel>(ReadPoissonNet(path));
    this->Path = path;
    this->Time = time;
    this->Size = size;
    ++this->Loads;
  }
  return this->Model;
}

} // namespace surfsynth

// SPDX-License-Identifier: BSD-3-Clause
#include "Core/Common/Errors.h"
#include "IO/Weights/InstalledModels.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

using namespace surfsynth;
using testing::AllOf;
using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;
using testing::IsEmpty;

namespace
{
namespace fs = std::filesystem;

ModelPredicate HasArchitecture(const std::string& wanted)
{
  return [wanted](const std::map<std::string, std::string>& metadata) {
    const auto found = metadata.find("architecture");
    return found != metadata.end() && found->second == wanted;
  };
}
} // namespace

TEST(InstalledModels, LieInTheBuildThatTheLibraryLiesIn)
{
  ASSERT_TRUE(fs::is_directory(InstalledModelsFolder())) << InstalledModelsFolder();
  EXPECT_THAT(InstalledModels(HasArchitecture("geometric_texture")),
    ElementsAre("flow_knobs", "flow_labyrinth", "flow_spikes", "knobs", "labyrinth", "spikes"));
  EXPECT_THAT(
    InstalledModels(HasArchitecture("geometric_texture_example")), ElementsAre("cortex", "mane", "mountains"));
  EXPECT_THAT(InstalledModels(HasArchitecture("poissonnet")), ElementsAre("smoothed_curvature"));
  EXPECT_THAT(InstalledModels(HasArchitecture("field_latents")), ElementsAre("field_latents"));
  EXPECT_THAT(InstalledModels(HasArchitecture("field_latent_diffusion")), ElementsAre("coat", "tissue", "wood"));
  EXPECT_THAT(InstalledModels(HasArchitecture("other")), IsEmpty());
}

TEST(InstalledModels, NamesStandForTheirFiles)
{
  EXPECT_THAT(ModelPath("knobs"), EndsWith("knobs.safetensors"));
  EXPECT_TRUE(fs::exists(ModelPath("knobs")));
  for (const char* path : { "", "missing", "knobs.safetensors", "./knobs", "/tmp/knobs" })
  {
    EXPECT_EQ(ModelPath(path), path);
  }
}

TEST(InstalledModels, AnotherFolderIsNamedByTheEnvironmentAndMayHoldAnything)
{
  const fs::path folder = fs::path(testing::TempDir()) / "surfsynth_models";
  fs::create_directories(folder / "folder.safetensors");
  std::ofstream(folder / "broken.safetensors") << "no model";
  ::setenv("SURFACE_SYNTHESIS_MODELS", folder.c_str(), 1);
  EXPECT_EQ(InstalledModelsFolder(), folder.string());
  EXPECT_THAT(InstalledModels(HasArchitecture("poissonnet")), IsEmpty());
  ::setenv("SURFACE_SYNTHESIS_MODELS", (folder / "missing").c_str(), 1);
  EXPECT_THAT(InstalledModels(HasArchitecture("poissonnet")), IsEmpty());
  EXPECT_EQ(ModelPath("knobs"), "knobs");
  try
  {
    ExistingModelPath("knobs");
    ADD_FAILURE() << "accepted";
  }
  catch (const InvalidInput& error)
  {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("no installed model \"knobs\""), HasSubstr("no file of this name")));
  }
  EXPECT_EQ(ExistingModelPath("folder/knobs"), "folder/knobs") << "files are judged by their readers";
  ::unsetenv("SURFACE_SYNTHESIS_MODELS");
  fs::remove_all(folder);
}

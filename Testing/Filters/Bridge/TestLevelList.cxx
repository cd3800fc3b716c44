// SPDX-License-Identifier: BSD-3-Clause
//
// Lists of generator levels as users write them.
#include "ThrownText.h"

#include "LevelList.h"

#include "Core/Common/Errors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

using surfsynth::InvalidInput;
using surfsynth::ReadLevelList;
using surfsynthtest::TextOf;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(LevelList, NumbersStandBetweenBlanksAndCommas)
{
  EXPECT_THAT(ReadLevelList("0 2, 3", "Levels"), ElementsAre(0, 2, 3));
  EXPECT_THAT(ReadLevelList(",7,,\t12\n", "Levels"), ElementsAre(7, 12));
  EXPECT_THAT(ReadLevelList("2 2 0", "Levels"), ElementsAre(2, 2, 0)) << "in the order of the text";
}

TEST(LevelList, AnEmptyTextIsAnEmptyList)
{
  EXPECT_THAT(ReadLevelList("", "Levels"), IsEmpty());
  EXPECT_THAT(ReadLevelList(" , ", "Levels"), IsEmpty());
}

TEST(LevelList, TheErrorNamesPropertyAndWord)
{
  for (const char* word : { "-1", "two", "3x", "1.5", "99999999999999999999" })
  {
    EXPECT_THAT(TextOf<InvalidInput>([&] { ReadLevelList(std::string("0 ") + word, "LevelsWithoutNoise"); }),
      AllOf(HasSubstr("LevelsWithoutNoise"), HasSubstr(std::string("\"") + word + "\""), HasSubstr("from 0 on")))
      << word;
  }
}

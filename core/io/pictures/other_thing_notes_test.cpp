#include "core/io/pictures/other_thing_notes.h"

#include <gtest/gtest.h>

#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::other_thing_notes_test {

TEST(OtherThingNotes, IsReadAsItWasWrittenAndIsEmptyWithoutAFile) {
  const TestingFolder folder;
  EXPECT_TRUE(ReadOtherThingNotes(folder.path()).empty());
  WriteOtherThingNotes(folder.path(), {});
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  const OtherThingNotes notes = {{"a \"1\".jpg", "it shows another thing"}, {"b.png", ""}};
  WriteOtherThingNotes(folder.path(), notes);
  EXPECT_EQ(ReadOtherThingNotes(folder.path()), notes);
}

TEST(OtherThingNotes, DamagedFileIsAnInputError) {
  const TestingFolder folder;
  WriteFile(folder.path() / "other_things.json", "[1]");
  EXPECT_THROW(ReadOtherThingNotes(folder.path()), InputError);
}

}  // namespace keypose::other_thing_notes_test

#include "studio/project/originals.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "studio/project/testing/photographs.h"

namespace keypose::studio::originals_test {

using ::testing::UnorderedElementsAre;

TEST_F(Photographs, RawFilesCountWhereNoOtherPhotographHasTheirStem) {
  for (const char* name : {"a.CR2", "b.jpg", "b.CR2", "c.HEIC", "Thumbs.db", "shoot.json", "d.x3f"})
    Put(name);
  EXPECT_THAT(OriginalPhotographs(photos()), UnorderedElementsAre("a.CR2", "b.jpg", "c.HEIC"));
}

}  // namespace keypose::studio::originals_test

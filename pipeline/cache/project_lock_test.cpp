#include "pipeline/cache/project_lock.h"

#include <gtest/gtest.h>

#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::pipeline::project_lock_test {

TEST(ProjectLock, OneRunAtATimeAndTheHolderIsNamed) {
  const TestingFolder own;
  EXPECT_EQ(LockHolder(own.path()), "");
  {
    const ProjectLock lock(own.path(), "keypose run");
    EXPECT_NE(LockHolder(own.path()).find("keypose run"), std::string::npos);
    EXPECT_THROW(Unlock(own.path(), false), LockedError);
  }
  EXPECT_EQ(LockHolder(own.path()), "");
  const ProjectLock next(own.path(), "keypose clean");
  EXPECT_NE(LockHolder(own.path()).find("keypose clean"), std::string::npos);
}

}  // namespace keypose::pipeline::project_lock_test

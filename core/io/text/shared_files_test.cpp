#include "core/io/text/shared_files.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include "core/io/text/files.h"
#include "core/testing/folder.h"

namespace keypose::shared_files_test {

class SharedFiles : public ::testing::Test, public TestingFolder {
 protected:
  void TearDown() override { ::unsetenv("KEYPOSE_TEST_NET_ONNX"); }
};

TEST_F(SharedFiles, AVariableNamesAnotherPlace) {
  EXPECT_FALSE(FindSharedFile("test-net.onnx"));
  EXPECT_EQ(SharedFileVersion("test-net.onnx"), "not installed");
  const auto file = Put("other.onnx", "weights");
  ::setenv("KEYPOSE_TEST_NET_ONNX", file.c_str(), 1);
  EXPECT_EQ(FindSharedFile("test-net.onnx"), file);
}

TEST_F(SharedFiles, TheVersionIsTheFirstWordBesideIt) {
  const auto file = Put("other.onnx", "weights");
  ::setenv("KEYPOSE_TEST_NET_ONNX", file.c_str(), 1);
  EXPECT_EQ(SharedFileVersion("test-net.onnx"), "not installed");
  Put("other.onnx.sha256", "0123abcd  other.onnx\n");
  EXPECT_EQ(SharedFileVersion("test-net.onnx"), "0123abcd");
}

}  // namespace keypose::shared_files_test

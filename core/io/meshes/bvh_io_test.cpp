#include "core/io/meshes/bvh_io.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "core/values/errors.h"

namespace keypose::bvh_io_test {

const char* const kClip =
    "HIERARCHY\nROOT Hips\n{\n\tOFFSET 0 0 0\n"
    "\tCHANNELS 6 Xposition Yposition Zposition Zrotation Yrotation Xrotation\n"
    "\tJOINT Knee\n\t{\n\t\tOFFSET 0 -2 0\n\t\tCHANNELS 3 Zrotation Xrotation Yrotation\n"
    "\t\tEnd Site\n\t\t{\n\t\t\tOFFSET 0 -1 0\n\t\t}\n\t}\n}\n"
    "MOTION\nFrames: 2\nFrame Time: 0.04\n"
    "1 2 3 90 0 0 0 0 0\n0 0 0 0 0 0 0 90 0\n";

TEST(Bvh, ChannelsTurnInTheirOrder) {
  const MotionClip clip = ParseBvh(kClip, "clip.bvh");
  ASSERT_EQ(clip.joints.size(), 3u);
  EXPECT_EQ(clip.frame_count(), 2);
  EXPECT_DOUBLE_EQ(clip.frame_time_s, 0.04);
  // Turned by 90 degrees about z, the leg that hangs along -y points along +x.
  const std::vector<Rigid3> first = JointFrames(clip, 0);
  EXPECT_LT((first[1].translation - Eigen::Vector3d(3, 2, 3)).norm(), 1e-12);
  EXPECT_LT((first[2].translation - Eigen::Vector3d(4, 2, 3)).norm(), 1e-12);
  // The knee turns about x: the end, along -y, goes to -z.
  const std::vector<Rigid3> second = JointFrames(clip, 1);
  EXPECT_LT((second[2].translation - Eigen::Vector3d(0, -2, -1)).norm(), 1e-12);
}

TEST(Bvh, WrittenClipReadsTheSame) {
  const MotionClip clip = ParseBvh(kClip, "clip.bvh");
  const MotionClip again = ParseBvh(BvhText(clip), "again");
  ASSERT_EQ(again.joints.size(), clip.joints.size());
  for (std::size_t j = 0; j < clip.joints.size(); ++j) {
    EXPECT_EQ(again.joints[j].name, clip.joints[j].name);
    EXPECT_EQ(again.joints[j].parent, clip.joints[j].parent);
    EXPECT_EQ(again.joints[j].channels, clip.joints[j].channels);
  }
  EXPECT_EQ(again.values, clip.values);
}

TEST(Bvh, FilesOfOtherProgramsReadTheSame) {
  std::string text = "# exported\n" + std::string(kClip);
  text.insert(text.find("MOTION"), "// the numbers\n");
  text.replace(text.find("Xposition"), 9, "XPosition");
  for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += 2)
    text.replace(at, 1, "\r\n");
  const MotionClip plain = ParseBvh(kClip, "clip.bvh"),
                   other = ParseBvh("\xEF\xBB\xBF" + text, "other.bvh");
  EXPECT_EQ(other.values, plain.values);
  ASSERT_EQ(other.joints.size(), plain.joints.size());
  for (std::size_t j = 0; j < plain.joints.size(); ++j) {
    EXPECT_EQ(other.joints[j].name, plain.joints[j].name);
    EXPECT_EQ(other.joints[j].channels, plain.joints[j].channels);
  }
}

TEST(Bvh, DamagedFilesNameTheLine) {
  const std::string text = kClip;
  const auto fault = [](const std::string& damaged) {
    try {
      ParseBvh(damaged, "clip.bvh");
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("none");
  };
  EXPECT_NE(fault(text.substr(0, text.size() - 20)).find("line 1"), std::string::npos);
  EXPECT_NE(fault("hello").find("HIERARCHY"), std::string::npos);
  std::string odd = text;
  odd.replace(odd.find("Xposition"), 9, "Xposltion");
  EXPECT_NE(fault(odd).find("line 5: 'Xposltion' is not a channel"), std::string::npos);
  std::string huge = text;
  huge.replace(huge.find("Frames: 2"), 9, "Frames: 9000000");
  EXPECT_NE(fault(huge).find("9000000"), std::string::npos);
}

}  // namespace keypose::bvh_io_test

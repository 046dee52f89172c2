#include "core/io/meshes/bvh_io.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "core/io/text/files.h"
#include "core/testing/paths.h"
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

TEST(Bvh, ARoundedFrameTimeIsThatOfItsRate) {
  const auto read = [](const std::string& time) {
    std::string text = kClip;
    const std::size_t at = text.find("0.04");
    return ParseBvh(text.replace(at, 4, time), "clip.bvh").frame_time_s;
  };
  EXPECT_EQ(read("0.0333333"), 1.0 / 30);
  EXPECT_EQ(read("0.033333"), 1.0 / 30);
  EXPECT_EQ(read("0.0083333"), 1.0 / 120);
  EXPECT_EQ(read("0.0333667"), 0.0333667) << "29.97 pictures a second";
  EXPECT_EQ(read("0.5"), 0.5);
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
  EXPECT_NE(fault(text.substr(0, text.size() - 10)).find("line 20"), std::string::npos);
  EXPECT_NE(fault("hello").find("HIERARCHY"), std::string::npos);
  std::string odd = text;
  odd.replace(odd.find("Xposition"), 9, "Xposltion");
  EXPECT_NE(fault(odd).find("line 5: 'Xposltion' is not a channel"), std::string::npos);
  std::string huge = text;
  huge.replace(huge.find("Frames: 2"), 9, "Frames: 9000000");
  EXPECT_NE(fault(huge).find("9000000"), std::string::npos);
}

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
  return text;
}

void ExpectSamePlaces(const MotionClip& a, const MotionClip& b, const std::string& what) {
  ASSERT_EQ(a.joints.size(), b.joints.size()) << what;
  ASSERT_EQ(a.frame_count(), b.frame_count()) << what;
  for (int f = 0; f < a.frame_count(); ++f)
    for (std::size_t j = 0; j < a.joints.size(); ++j) {
      const Rigid3 x = JointFrames(a, f)[j], y = JointFrames(b, f)[j];
      EXPECT_LT((x.translation - y.translation).norm(), 1e-12) << what << " " << j;
      EXPECT_LT(x.rotation.angularDistance(y.rotation), 1e-9) << what << " " << j;
    }
}

// The format has no standard; these are the spellings that programs write, each of the whole clip.
TEST(Bvh, EverySpellingIsTheSameClip) {
  const std::string text = kClip;
  const MotionClip plain = ParseBvh(text, "clip.bvh");
  const std::vector<std::pair<std::string, std::string>> spellings{
      {"brace on the line", Replaced(Replaced(text, "\n{", " {"), "\n\t{", " {")},
      {"brace without space", Replaced(text, "Hips\n{", "Hips{")},
      {"label without space", Replaced(text, "Frames: 2", "Frames:2")},
      {"spaces before the colon", Replaced(text, "Frames: 2", "Frames : 2")},
      {"number behind the colon", Replaced(text, "Frame Time: 0.04", "Frame Time:.04")},
      {"one word", Replaced(text, "Frame Time: 0.04", "FrameTime: 4e-2")},
      {"plus signs", Replaced(text, "1 2 3 90", "+1 +2 +3.0 +90")},
      {"exponents", Replaced(text, "1 2 3 90", "1e0 2E+00 0.3e1 9.0e+001")},
      {"no zero before the point", Replaced(text, "OFFSET 0 -1 0", "OFFSET .0 -1. 0")},
      {"upper case", Replaced(Replaced(text, "End Site", "END SITE"), "JOINT", "Joint")},
      {"lower case",
       Replaced(Replaced(text, "HIERARCHY\nROOT", "hierarchy\nroot"), "OFFSET", "offset")},
      {"named end", Replaced(text, "End Site", "End Site Toe Tip")},
      {"end on one line",
       Replaced(text, "End Site\n\t\t{\n\t\t\tOFFSET 0 -1 0\n\t\t}", "End Site {OFFSET 0 -1 0}")},
      {"tabs between numbers", Replaced(text, "1 2 3 90", "1\t2\t3\t90")},
      {"carriage returns", Replaced(text, "\n", "\r\n")},
      {"byte order mark", "\xEF\xBB\xBF" + text},
      {"comments", Replaced(text, "MOTION", "# a\n// b\nMOTION # c")},
      {"empty lines at the end", text + "\n\n  \n"},
      {"a frame over two lines", Replaced(text, "1 2 3 90", "1 2 3\n90")},
      {"scale channels of 1",
       Replaced(Replaced(Replaced(text, "CHANNELS 6", "CHANNELS 9"), "Yrotation Xrotation\n",
                         "Yrotation Xrotation Xscale Yscale Zscale\n"),
                "1 2 3 90 0 0 0 0 0\n0 0 0 0 0 0 0 90 0",
                "1 2 3 90 0 0 1 1 1 0 0 0\n0 0 0 0 0 0 1 1 1 0 90 0")},
      {"places in position channels",
       Replaced(Replaced(Replaced(text, "OFFSET 0 -2 0", "OFFSET 0 0 0"),
                         "CHANNELS 3 Zrotation Xrotation Yrotation",
                         "CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation"),
                "1 2 3 90 0 0 0 0 0\n0 0 0 0 0 0 0 90 0",
                "1 2 3 90 0 0 0 -2 0 0 0 0\n0 0 0 0 0 0 0 -2 0 0 90 0")},
  };
  for (const auto& [what, spelled] : spellings) {
    ASSERT_NE(spelled, text) << what;
    std::vector<std::string> notes;
    ExpectSamePlaces(ParseBvh(spelled, what, &notes), plain, what);
    EXPECT_TRUE(notes.empty()) << what;
  }
}

TEST(Bvh, JointsWithoutOffsetRestWhereTheFirstFrameHasThem) {
  std::string text = Replaced(kClip, "OFFSET 0 -2 0", "OFFSET 0 0 0");
  text = Replaced(text, "CHANNELS 3 Zrotation Xrotation Yrotation",
                  "CHANNELS 6 Zrotation Xrotation Yrotation Xposition Yposition Zposition");
  text = Replaced(text, "1 2 3 90 0 0 0 0 0\n0 0 0 0 0 0 0 90 0",
                  "1 2 3 90 0 0 0 0 0 5 -2 7\n0 0 0 0 0 0 0 90 0 5 -2 8");
  const MotionClip clip = ParseBvh(text, "clip.bvh");
  EXPECT_EQ(clip.joints[1].offset, Eigen::Vector3d(5, -2, 7));
  EXPECT_EQ(JointFrames(clip, 1)[1].translation, Eigen::Vector3d(5, -2, 8));
}

TEST(Bvh, SeveralRootsAreSeveralTrees) {
  const std::string prop =
      "ROOT Prop\n{\nOFFSET 4 0 0\nCHANNELS 3 Zrotation Xrotation Yrotation\n"
      "End Site\n{\nOFFSET 1 0 0\n}\n}\n";
  std::string text = Replaced(kClip, "MOTION", prop + "MOTION");
  text = Replaced(text, "1 2 3 90 0 0 0 0 0\n0 0 0 0 0 0 0 90 0",
                  "1 2 3 90 0 0 0 0 0 90 0 0\n0 0 0 0 0 0 0 90 0 0 0 0");
  const MotionClip clip = ParseBvh(text, "clip.bvh");
  ASSERT_EQ(clip.joints.size(), 5u);
  EXPECT_EQ(clip.joints[3].parent, -1);
  const std::vector<Rigid3> first = JointFrames(clip, 0);
  EXPECT_LT((first[2].translation - Eigen::Vector3d(4, 2, 3)).norm(), 1e-12);
  EXPECT_LT((first[4].translation - Eigen::Vector3d(4, 1, 0)).norm(), 1e-12);
  ExpectSamePlaces(ParseBvh(BvhText(clip), "again"), clip, "written");
}

TEST(Bvh, EvenScaleMovesWhatHangsOnTheJoint) {
  std::string text = Replaced(kClip, "CHANNELS 6", "CHANNELS 9");
  text = Replaced(text, "Yrotation Xrotation\n", "Yrotation Xrotation Xscale Yscale Zscale\n");
  const std::string rows = "1 2 3 90 0 0 0 0 0\n0 0 0 0 0 0 0 90 0";
  const MotionClip clip = ParseBvh(
      Replaced(text, rows, "1 2 3 90 0 0 1.5 1.5 1.5 0 0 0\n0 0 0 0 0 0 2 2 2 0 90 0"), "clip.bvh");
  // as in ChannelsTurnInTheirOrder, the leg one and a half, and two times as long
  EXPECT_LT((JointFrames(clip, 0)[2].translation - Eigen::Vector3d(5.5, 2, 3)).norm(), 1e-12);
  EXPECT_LT((JointFrames(clip, 1)[2].translation - Eigen::Vector3d(0, -4, -2)).norm(), 1e-12);
  EXPECT_EQ(clip.joints[1].offset, Eigen::Vector3d(0, -3, 0));
  try {
    ParseBvh(Replaced(text, rows, "1 2 3 90 0 0 1 1 1 0 0 0\n0 0 0 0 0 0 1 2 1 0 90 0"),
             "clip.bvh");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("joint Hips is scaled by 1 to 2 in frame 1"),
              std::string::npos)
        << error.what();
  }
}

TEST(Bvh, APositionThatAJointHasTwiceIsRefusedAndARotationIsNot) {
  const auto with = [](const char* channels) {
    return ParseBvh(
        Replaced(kClip, "Xposition Yposition Zposition Zrotation Yrotation Xrotation", channels),
        "clip.bvh");
  };
  EXPECT_THROW(with("Xposition Xposition Zposition Zrotation Yrotation Xrotation"), InputError);
  EXPECT_NO_THROW(with("Xposition Yposition Zposition Zrotation Xrotation Zrotation"));
}

TEST(Bvh, OneFrameOffIsSaidAndTwoAreRefused) {
  for (const auto& [said, found] :
       {std::pair("Frames: 3", "says that it has 3 frames, but has 2"),
        std::pair("Frames: 1", "says that it has 1 frames, but has 2")}) {
    std::vector<std::string> notes;
    EXPECT_EQ(ParseBvh(Replaced(kClip, "Frames: 2", said), "clip.bvh", &notes).frame_count(), 2);
    ASSERT_EQ(notes.size(), 1u);
    EXPECT_NE(notes[0].find(found), std::string::npos) << notes[0];
  }
  EXPECT_THROW(ParseBvh(Replaced(kClip, "Frames: 2", "Frames: 4"), "clip.bvh"), InputError);
  EXPECT_THROW(ParseBvh(Replaced(kClip, "Frames: 2", "Frames: 0"), "clip.bvh"), InputError);
  const std::string clip = kClip, empty = clip.substr(0, clip.find("Frame Time"));
  EXPECT_THROW(
      ParseBvh(Replaced(empty, "Frames: 2", "Frames: 1") + "Frame Time: 0.04\n", "clip.bvh"),
      InputError)
      << "one frame is said, and none is there";
  EXPECT_EQ(ParseBvh(Replaced(empty, "Frames: 2", "Frames: 0") + "Frame Time: 0.04\n", "clip.bvh")
                .frame_count(),
            0);
}

TEST(Bvh, WhatIsNotReadIsNamed) {
  const auto fault = [](const std::string& text) {
    try {
      ParseBvh(text, "clip.bvh");
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("none");
  };
  for (const auto& [from, to, words] : std::vector<std::array<std::string, 3>>{
           {"0.04", "0,04", "'0,04' has a comma; export it again with decimal points"},
           {"Xposition", "Wrotation", "'Wrotation' is not a channel"},
           {"CHANNELS 6", "CHANNELS 12", "12 is not a usable count"},
           {"OFFSET 0 -1 0\n", "", "a joint has no OFFSET"},
           {"0.04", "0", "the time of a frame must be positive"},
           {"Frames: 2", "Poses: 2", "'Frames:' was expected"},
           {"1 2 3 90", "1 2 nan 90", "'nan' is not a number"},
           {"1 2 3 90", "1 2 +-3 90", "'+-3' is not a number"},
           {"ROOT", "SEGMENT", "'ROOT' was expected, not 'SEGMENT'"}})
    EXPECT_NE(fault(Replaced(kClip, from, to)).find(words), std::string::npos)
        << from << " -> " << to << ": " << fault(Replaced(kClip, from, to));
}

TEST(Bvh, ReportedFilesHaveTheirJointsInTheirPlaces) {
  const std::filesystem::path folder = DataFolder() / "reports" / "21_bvh_kinds";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not there";
  const nlohmann::json truth =
      nlohmann::json::parse(ReadFile(folder / "truth_joint_places_y_up.json"));
  for (const char* file : {"plain.bvh", "brace_on_the_line.bvh", "plus_signs.bvh"}) {
    const MotionClip clip = ReadBvh(folder / file);
    for (const auto& [frame, places] : truth.items())
      for (const auto& [joint, place] : places.items()) {
        const Eigen::Vector3d at(place[0], place[1], place[2]);
        const Rigid3 found = JointFrames(clip, std::stoi(frame))[clip.Find(joint)];
        EXPECT_LT((found.translation - at).norm(), 1e-4) << file << " " << frame << " " << joint;
      }
  }
}

}  // namespace keypose::bvh_io_test

#include "core/io/meshes/clip_kind.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/meshes/bvh_io.h"
#include "core/values/errors.h"

namespace keypose::clip_kind_test {

using ::testing::HasSubstr;
using std::string_literals::operator""s;

/// @param motion  the rows of numbers: three places, three turns
std::string Clip(const std::string& root, const std::string& motion) {
  return "HIERARCHY\nROOT " + root +
         "\n{\nOFFSET 0 0 0\nCHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation "
         "Yrotation\nEnd Site\n{\nOFFSET 0 1 0\n}\n}\nMOTION\nFrames: 2\nFrame Time: 0.04\n" +
         motion;
}

/// Of letters below U+0800, as UTF-8.
std::string Utf16(const std::string& text, bool big, bool marked) {
  std::string wide = !marked ? "" : big ? "\xfe\xff" : "\xff\xfe";
  for (std::size_t i = 0; i < text.size(); ++i) {
    unsigned letter = static_cast<unsigned char>(text[i]);
    if (letter >= 0x80)
      letter = (letter & 0x1f) << 6 | (static_cast<unsigned char>(text[++i]) & 0x3f);
    const char high = static_cast<char>(letter >> 8), low = static_cast<char>(letter & 0xff);
    wide += big ? high : low;
    wide += big ? low : high;
  }
  return wide;
}

TEST(ClipKind, Utf16IsReadInBothOrders) {
  const std::string text = Clip(
      "H\xc3\xbc"
      "fte",
      "1 2 3 0 90 0\n4 5 6 0 0 30\n");
  for (const bool big : {false, true})
    for (const bool marked : {false, true}) {
      const MotionClip clip = ParseBvh(Utf16(text, big, marked), "clip.bvh");
      ASSERT_EQ(clip.frame_count(), 2);
      EXPECT_EQ(clip.joints[0].name,
                "H\xc3\xbc"
                "fte");
      EXPECT_EQ(clip.values(1, 5), 30);
    }
}

TEST(ClipKind, ClipsOfOtherKindsAreNamed) {
  const std::vector<std::pair<std::string, std::string>> kinds{
      {"\x02\x50\x1e\0\0\0"s, "is C3D: places of markers"},
      {"Kaydara FBX Binary  \0"s, "is FBX; import it into Blender"},
      {"; FBX 7.4.0 project file\n", "is FBX"},
      {"# AST/ASF file\n:version 1.10\n:units\n:bonedata\n", "is ASF"},
      {"#!OML:ASF x\n:FULLY-SPECIFIED\n:DEGREES\n1\n", "is AMC"},
      {"PathFileType\t4\t(X/Y/Z)\n", "is TRC: places of markers"},
      {"[Header]\nFileType htr\n", "is HTR"}};
  for (const auto& [bytes, words] : kinds) {
    try {
      ParseBvh(bytes, "walk");
      ADD_FAILURE() << words;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("walk " + words));
    }
  }
}

TEST(ClipKind, TurnsThatMayBeRadiansAreSaid) {
  const auto notes = [](const std::string& motion) {
    std::vector<std::string> said;
    ParseBvh(Clip("Hips", motion), "clip.bvh", &said);
    return said;
  };
  const auto said = notes("0 0 0 0 1.57 -3.1\n0 9 0 0.1 0.2 3.1\n");
  ASSERT_EQ(said.size(), 1u);
  EXPECT_THAT(said[0], HasSubstr("are they radians?"));
  EXPECT_TRUE(notes("0 0 0 0 1.57 -3.1\n0 9 0 0.1 0.2 7\n").empty());
  EXPECT_TRUE(notes("0 0 0 0 1.57 -3.1\n0 9 0 0 1.57 -3.1\n").empty()) << "it stands still";
}

}  // namespace keypose::clip_kind_test

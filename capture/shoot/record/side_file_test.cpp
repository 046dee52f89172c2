#include "capture/shoot/record/side_file.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/values/errors.h"

namespace keypose::capture::shoot::side_file_test {

SideFile Example() {
  SideFile side;
  side.pose = "standing";
  side.plan = {.rings_deg = {12, 40.5}, .angles = 32, .flips = 1};
  side.camera = "Canon EOS 80D";
  side.turntable = "grbl";
  side.white = CarriedWhite{{1.08, 1, 0.93}, "card.jpg:1,2,3,4"};
  PhotographEntry entry;
  entry.shot = {1, 2, 3};
  entry.file = "lying_r2_a034.jpg", entry.raw = "lying_r2_a034.cr2";
  entry.time = 1714744999, entry.width = 6000, entry.height = 4000;
  entry.settings = {0.02, 8, 100, 60, 96};
  entry.crispness = 0.61, entry.exposure = 118.2, entry.light = 0.25, entry.clipped = 0.001;
  entry.mask_fraction = 0.14, entry.touches_border = true;
  entry.findings = {{"blurred", "the photograph is blurred", "shoot it again"}};
  side.photographs[entry.shot] = entry;
  side.rings = {{0, 1, 0.4, {11.25}, {{"missing", "an angle is missing", "shoot it"}}},
                {1, 1, {}, {}, {}}};
  side.skipped = {{0, 1, 1}};
  return side;
}

TEST(SideFile, ComesBackAsItWasWritten) {
  const std::string text = SideFileText(Example());
  const SideFile back = ParseSideFile(text, "shoot.json");
  EXPECT_EQ(SideFileText(back), text);
  const PhotographEntry& entry = back.photographs.at({1, 2, 3});
  EXPECT_EQ(entry.time, 1714744999);
  EXPECT_EQ(entry.settings.exposure_s, 0.02);
  EXPECT_EQ(entry.findings, Example().photographs.begin()->second.findings);
  EXPECT_EQ(back.FindRing(0, 1)->moved_px, 0.4);
  EXPECT_FALSE(back.FindRing(1, 1)->moved_px);
  EXPECT_EQ(back.FindRing(1, 2), nullptr);
}

TEST(SideFile, HasTheFieldsThatAreDocumented) {
  const auto root = nlohmann::json::parse(SideFileText(Example()));
  const auto& entry = root.at("photographs").at("lying_r2_a034");
  EXPECT_EQ(entry.at("angle_deg"), 33.75);
  EXPECT_EQ(entry.at("tilt_deg"), 40.5);
  EXPECT_EQ(entry.at("flip"), 1);
  EXPECT_EQ(entry.at("time"), "2024-05-03T14:03:19Z");
  EXPECT_EQ(entry.at("settings").at("iso"), 100);
  EXPECT_EQ(root.at("white_balance").at("gains").at(0), 1.08);
  EXPECT_EQ(root.at("skipped").at(0), "r1_a011");
}

TEST(SideFile, ThatIsDamagedIsRefusedWithItsName) {
  const std::string good = SideFileText(Example());
  const auto replaced = [&](const std::string& what, const std::string& by) {
    std::string text = good;
    const std::size_t at = text.find(what);
    EXPECT_NE(at, std::string::npos) << what;
    return text.replace(at, what.size(), by);
  };
  for (const std::string& text :
       {std::string(), good.substr(0, good.size() / 2), std::string(300, '['),
        replaced("\"schema\": 1", "\"schema\": 2"), replaced("lying_r2_a034\"", "r9_a000\""),
        replaced("\"lying_r2_a034.jpg\"", "\"../../secret.jpg\""),
        replaced("\"angles\": 32", "\"angles\": 0"), replaced("2024-05", "20x4-05"),
        replaced("1.08", "-1"), replaced("\"flip\": 1", "\"flip\": []").substr(0, 40)}) {
    try {
      ParseSideFile(text, "photos/standing/shoot.json");
      ADD_FAILURE() << text.substr(0, 80);
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("photos/standing/shoot.json"), std::string::npos);
    }
  }
}

}  // namespace keypose::capture::shoot::side_file_test

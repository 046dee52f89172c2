#include "core/io/project/known_points_io.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/pictures/image_io.h"
#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::known_points_io_test {

using ::testing::HasSubstr;

class KnownPointsFile : public ::testing::Test, public TestingFolder {
 protected:
  KnownPoints Read(const std::string& text) {
    WriteFile(path() / "points.json", text);
    return ReadKnownPoints(path() / "points.json");
  }
  void ExpectFault(const std::string& text, const std::string& said) {
    try {
      Read(text);
      ADD_FAILURE() << text;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr(said)) << text;
    }
  }
};

const char* const kPoints =
    R"("points": [{"name": "a", "place": [100, 0, 5]}, {"name": "b", "place": [0, 30, 0]}])";
const char* const kCameras = R"("cameras": [{"name": "cam1", "size": [640, 480]}])";

TEST_F(KnownPointsFile, PlacesBecomeMetresAndTheTextReadsBack) {
  const KnownPoints points =
      Read(std::string(R"({"schema": 1, "unit": "cm", )") + kPoints + ", " + kCameras +
           R"(, "clicks": [{"camera": "cam1", "point": "b",
                                                   "pixel": [10.5, 479]}]})");
  ASSERT_EQ(points.points.size(), 2u);
  EXPECT_LT((points.points[0].place - Eigen::Vector3d(1, 0, 0.05)).norm(), 1e-12);
  ASSERT_EQ(points.cameras.size(), 1u);
  EXPECT_EQ(points.cameras[0].width, 640);
  ASSERT_EQ(points.cameras[0].clicks.size(), 1u);
  EXPECT_EQ(points.cameras[0].clicks[0].point, 1);
  const KnownPoints again = Read(KnownPointsText(points));
  EXPECT_EQ(again.points[1].name, "b");
  EXPECT_EQ(again.points[1].place, points.points[1].place);
  EXPECT_EQ(again.cameras[0].clicks[0].pixel, Eigen::Vector2d(10.5, 479));
}

TEST_F(KnownPointsFile, SizeComesFromThePicture) {
  WriteImage(path() / "set.png", Image8(64, 48, 1));
  const KnownPoints points =
      Read(std::string(R"({"schema": 1, )") + kPoints +
           R"(, "cameras": [{"name": "c", "picture": "set.png"}], "clicks": []})");
  EXPECT_EQ(points.cameras[0].width, 64);
  EXPECT_EQ(points.cameras[0].height, 48);
}

TEST_F(KnownPointsFile, FaultsAreNamed) {
  const std::string head = std::string(R"({"schema": 1, )") + kPoints + ", " + kCameras;
  ExpectFault("[]", "holds no object");
  ExpectFault(R"({"schema": 3})", "`schema` must be 1");
  ExpectFault(R"({"schema": 1, "unit": "inch"})", "`unit` must be m, cm or mm");
  ExpectFault(R"({"schema": 1})", "`points` must be a list");
  ExpectFault(R"({"schema": 1, "points": [{"name": "a", "place": [1, 2]}]})", "place");
  ExpectFault(std::string(R"({"schema": 1, )") + kPoints + R"(, "cameras": [{"name": "c"}]})",
              "needs `size`");
  ExpectFault(head + R"(, "clicks": [{"camera": "cam2", "point": "a", "pixel": [1, 1]}]})",
              "camera 'cam2', which is not in `cameras`");
  ExpectFault(head + R"(, "clicks": [{"camera": "cam1", "point": "z", "pixel": [1, 1]}]})",
              "point 'z', which is not in `points`");
  ExpectFault(head + R"(, "clicks": [{"camera": "cam1", "point": "a", "pixel": [700, 1]}]})",
              "cam1");
  ExpectFault(head + R"(, "clicks": [{"camera": "cam1", "point": "a", "pixel": [7, 1]},
                                     {"camera": "cam1", "point": "a", "pixel": [8, 1]}]})",
              "second one of 'a'");
}

}  // namespace keypose::known_points_io_test

#include "core/io/project/metashape_io.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/io/project/poses_io.h"
#include "core/io/project/rig_calibration.h"
#include "core/testing/folder.h"
#include "core/testing/paths.h"
#include "core/values/errors.h"

namespace keypose::metashape_io_test {

using Eigen::Vector2d;
using Eigen::Vector3d;

const std::string kAdjusted =
    "<calibration type=\"frame\" class=\"adjusted\"><resolution width=\"400\" "
    "height=\"300\"/><f>500</f>"
    "<cx>7.25</cx><cy>-4.5</cy><b1>1.5</b1><b2>-0.3</b2><k1>-0.05</k1><k2>0.02</k2><k3>-0.01</k3>"
    "<p1>0.0004</p1><p2>-0.0003</p2></calibration>";
const std::string kPlace = "<transform>1 0 0 5 0 1 0 6 0 0 1 7 0 0 0 1</transform>";

std::string Camera(const std::string& label, const std::string& inside = kPlace,
                   const std::string& attributes = "component_id=\"0\"") {
  return "<camera id=\"1\" sensor_id=\"0\" label=\"" + label + "\" " + attributes + ">" + inside +
         "</camera>";
}

std::string Document(const std::string& cameras, const std::string& calibrations = kAdjusted,
                     const std::string& components = "", const std::string& type = "frame") {
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<document version=\"2.0.0\"><chunk "
         "label=\"Chunk 1\">"
         "<sensors><sensor id=\"0\" label=\"Canon\" type=\"" +
         type + "\"><resolution width=\"400\" height=\"300\"/>" + calibrations +
         "</sensor></sensors><components>" + components + "</components><cameras>" + cameras +
         "</cameras></chunk></document>";
}

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
  return text;
}

std::string Fault(const std::string& text) {
  try {
    ParseMetashape(text, "cameras.xml");
  } catch (const InputError& error) {
    return error.what();
  }
  return "none";
}

// Appendix D of the manual: x' = x (1 + K1 r^2 + ...) + P1 (r^2 + 2 x^2) + 2 P2 x y,
// u = w / 2 + cx + x' f + x' B1 + y' B2.
Vector2d ByTheManual(double x, double y) {
  const double r2 = x * x + y * y, radial = 1 - 0.05 * r2 + 0.02 * r2 * r2 - 0.01 * r2 * r2 * r2;
  const double u = x * radial + 0.0004 * (r2 + 2 * x * x) - 2 * 0.0003 * x * y,
               v = y * radial - 0.0003 * (r2 + 2 * y * y) + 2 * 0.0004 * x * y;
  return {200 + 7.25 + u * 500 + u * 1.5 - v * 0.3, 150 - 4.5 + v * 500};
}

TEST(Metashape, LensesMapAsTheManualSays) {
  const Lens lens = ParseMetashape(Document(Camera("IMG0")), "cameras.xml").at(0).lens;
  EXPECT_LT((*lens.Project({0.3, -0.2, 1}) - ByTheManual(0.3, -0.2)).norm(), 1e-10);
  const Lens fisheye =
      ParseMetashape(Document(Camera("IMG0"), Replaced(kAdjusted, "frame", "fisheye")), "x")[0]
          .lens;
  const double r = std::hypot(0.3, 0.2), theta = std::atan(r);
  EXPECT_LT(
      (*fisheye.Project({0.3, -0.2, 1}) - ByTheManual(0.3 * theta / r, -0.2 * theta / r)).norm(),
      1e-10);
  const Lens equisolid =
      ParseMetashape(Document(Camera("IMG0"), Replaced(kAdjusted, "frame", "equisolid_fisheye")),
                     "x")[0]
          .lens;
  const double s = 2 * std::sin(theta / 2) / r;
  EXPECT_LT((*equisolid.Project({0.3, -0.2, 1}) - ByTheManual(0.3 * s, -0.2 * s)).norm(), 1e-10);
}

TEST(Metashape, TheAdjustedCalibrationCounts) {
  const std::string initial = Replaced(Replaced(kAdjusted, "adjusted", "initial"), "500", "450");
  for (const std::string& both : {initial + kAdjusted, kAdjusted + initial})
    EXPECT_EQ(ParseMetashape(Document(Camera("IMG0"), both), "x")[0].lens.fy, 500);
  EXPECT_EQ(ParseMetashape(Document(Camera("IMG0"), initial), "x")[0].lens.fy, 450);
  EXPECT_EQ(ParseMetashape(Document(Camera("IMG0"), Replaced(kAdjusted, " class=\"adjusted\"", "")),
                           "x")[0]
                .lens.fy,
            500);
}

TEST(Metashape, CamerasLieAsTheirTransformsSay) {
  const auto views = ParseMetashape(
      Document(Camera("IMG0", "<transform>0 0 1 5 1 0 0 6 0 1 0 7 0 0 0 1</transform>") +
               "<group label=\"g\">" + Camera("IMG1") + "</group>" + Camera("IMG2", "") +
               Camera("IMG3", kPlace, "enabled=\"false\"")),
      "cameras.xml");
  ASSERT_EQ(views.size(), 2u) << "without those that have no place or are switched off";
  EXPECT_EQ(views[0].camera_from_world.Inverse().translation, Vector3d(5, 6, 7));
  // what lies one before the camera along its axis is at (5, 6, 7) + (1, 0, 0)
  EXPECT_LT((views[0].camera_from_world * Vector3d(6, 6, 7) - Vector3d(0, 0, 1)).norm(), 1e-12);
  EXPECT_EQ(views[1].name, "IMG1");
}

TEST(Metashape, ComponentsAreJoinedByTheirTransforms) {
  const auto component = [](const std::string& id, const std::string& numbers) {
    return "<component id=\"" + id + "\"><transform><rotation>0 -1 0 1 0 0 0 0 1</rotation>" +
           numbers + "</transform></component>";
  };
  const std::string two = Camera("IMG0") + Camera("IMG1", kPlace, "component_id=\"1\"");
  const std::string first = component("0", "<translation>1 0 0</translation><scale>2</scale>"),
                    second = component("1", "<translation>3 0 0</translation><scale>4</scale>");
  const auto alone = ParseMetashape(Document(Camera("IMG0"), kAdjusted, first), "x");
  EXPECT_EQ(alone[0].camera_from_world.Inverse().translation, Vector3d(5, 6, 7))
      << "one component stays in its own frame";
  const auto views = ParseMetashape(Document(two, kAdjusted, first + second), "x");
  EXPECT_EQ(views[0].camera_from_world.Inverse().translation, Vector3d(5, 6, 7));
  // world: R (4 c) + (3, 0, 0) = (-21, 20, 28); back by R^T ((-21, 20, 28) - (1, 0, 0)) / 2
  EXPECT_LT((views[1].camera_from_world.Inverse().translation - Vector3d(10, 11, 14)).norm(),
            1e-12);
  EXPECT_NE(Fault(Document(two, kAdjusted, first)).find("IMG1 is in another component"),
            std::string::npos);
}

TEST(Metashape, WhatIsNotReadIsNamed) {
  for (const char* type : {"spherical", "cylindrical", "rpc"})
    EXPECT_NE(Fault(Document(Camera("IMG0"), Replaced(kAdjusted, "frame", type)))
                  .find(std::string("sensor Canon: the lens model of type ") + type),
              std::string::npos);
  EXPECT_NE(Fault(Document(Camera("IMG0"), Replaced(kAdjusted, "<k3>-0.01</k3>", "<k5>0.1</k5>")))
                .find("with k5"),
            std::string::npos);
  EXPECT_NE(
      Fault(Document(Camera("IMG0"), Replaced(kAdjusted, "<f>500</f>", "<fx>500</fx><fy>500</fy>")))
          .find("PhotoScan before 1.3"),
      std::string::npos);
  EXPECT_NE(Fault(Document(Camera("IMG0", kPlace + "<orientation>6</orientation>")))
                .find("turned by its EXIF orientation (6)"),
            std::string::npos);
  EXPECT_EQ(Fault(Document(Camera("IMG0", kPlace + "<orientation>1</orientation>"))), "none");
  EXPECT_NE(Fault(Document(Camera("IMG0", "", "master_id=\"2\""))).find("multi-camera system"),
            std::string::npos);
  EXPECT_NE(Fault(Document(Camera("IMG0", ""))).find("no camera with a place"), std::string::npos);
  EXPECT_NE(Fault(Document(Camera("IMG0"), "")).find("sensor Canon has no calibration"),
            std::string::npos);
  EXPECT_NE(Fault(Replaced(Document(Camera("IMG0")), "<f>500</f>", "<f>wide</f>"))
                .find("`f` is 'wide', not a number"),
            std::string::npos);
  EXPECT_NE(Fault("<document><chunk></chunk><chunk></chunk></document>").find("2 chunks"),
            std::string::npos);
  EXPECT_NE(Fault(Document(Camera("IMG0")).substr(0, 300)).find("not whole XML"),
            std::string::npos);
  EXPECT_NE(Fault(Document(Camera("IMG0", "<transform>1 0 0</transform>"))).find("16 numbers"),
            std::string::npos);
  EXPECT_NE(Fault(Document(Camera("IMG0", Replaced(kPlace, "1 0 0 5", "2 0 0 5"))))
                .find("its rotation is none"),
            std::string::npos);
}

TEST(Metashape, TheReportedFileIsReadRight) {
  const fs::path folder = DataFolder() / "reports" / "19_metashape_xml";
  if (!fs::exists(folder)) GTEST_SKIP() << folder << " is not there";
  const std::vector<View> truth = ReadPoses(DataFolder() / "reports/18_transforms_json/plain.json");
  const std::vector<View> views = ReadPoses(folder);
  ASSERT_EQ(views.size(), 6u);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(views[i].name + ".jpg", truth[i].name);
    EXPECT_LT((views[i].Center() - truth[i].Center()).norm(), 1e-9);
    EXPECT_LT(
        views[i].camera_from_world.rotation.angularDistance(truth[i].camera_from_world.rotation),
        1e-9);
  }
  EXPECT_LT((views[0].camera.Project({0.3, -0.2, 1}) - ByTheManual(0.3, -0.2)).norm(),
            kSameLens_px);
  EXPECT_EQ(ReadRigCalibration(folder / "cameras.xml").views.size(), 6u);
}

}  // namespace keypose::metashape_io_test

#include "core/io/project/metashape_write.h"

#include <gtest/gtest.h>

#include "core/io/project/metashape_io.h"
#include "core/values/errors.h"

namespace keypose::metashape_write_test {

View Tilted(const std::string& name, double fx) {
  View view;
  view.name = name;
  view.camera = {400, 300, fx, 500, 190.25, 155, 0.1, -0.02, 1e-3, 2e-3};
  view.camera_from_world = {Eigen::Quaterniond(0.9, 0.1, -0.3, 0.2).normalized(), {0.1, 0.2, 7}};
  return view;
}

TEST(MetashapeText, ComesBackAsTheSameLensAndPlace) {
  const std::vector<View> views{Tilted("a", 510), Tilted("b", 510), Tilted("c", 520)};
  const auto read = ParseMetashape(MetashapeText(views, {"a", "b", "c"}, "rest"), "cameras.xml");
  ASSERT_EQ(read.size(), 3u);
  const Eigen::Vector3d x(1, 0.3, -0.5);
  for (std::size_t v = 0; v < 3; ++v)
    EXPECT_LT((*read[v].lens.Project(read[v].camera_from_world * x) - views[v].Project(x)).norm(),
              1e-9);
  EXPECT_EQ(read[2].lens.fx, 520);
  EXPECT_EQ(read[2].lens.p1, 1e-3);
}

TEST(MetashapeText, NumbersAreMetashapes) {
  const std::string text = MetashapeText({Tilted("a", 510), Tilted("b", 510)}, {"a", "b"}, "rest");
  for (const char* number : {"<f>500</f>", "<b1>10</b1>", "<cx>-9.75</cx>", "<cy>5</cy>",
                             "<p1>0.002</p1>", "<p2>0.001</p2>"})
    EXPECT_NE(text.find(number), std::string::npos) << number;
  EXPECT_NE(text.find("<sensors next_id=\"1\">"), std::string::npos) << "one camera, one sensor";
}

TEST(MetashapeText, LabelsAreEscapedOrRefused) {
  const std::string label = "a<b>&\"c\" \u00fc";
  const auto read = ParseMetashape(MetashapeText({Tilted("a", 510)}, {label}, "x"), "cameras.xml");
  EXPECT_EQ(read[0].name, label);
  for (const char* bad : {"a\xff", "a\nb", "a\x01"})
    EXPECT_THROW(MetashapeText({Tilted("a", 510)}, {bad}, "x"), InputError);
}

}  // namespace keypose::metashape_write_test

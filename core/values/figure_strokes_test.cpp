#include "core/values/figure_strokes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

#include "core/values/errors.h"

namespace keypose::figure_strokes_test {

using Eigen::Vector2d;
using Eigen::Vector2i;
using Points = std::vector<Vector2d>;

std::string FaultOf(const std::string& text) {
  const auto problems = FigureTextProblems(text);
  return problems.empty() ? "" : problems.front();
}

TEST(FigureStrokes, ClickStrokeAndBackgroundAreRead) {
  const auto strokes =
      ParseFigureStrokes("IMG_0012.jpg:512,300 IMG_2.jpg:1,2-3.5,4-5,6;!IMG_0007.jpg:40,900");
  ASSERT_EQ(strokes.size(), 3u);
  EXPECT_EQ(strokes[0].picture, "IMG_0012.jpg");
  EXPECT_EQ(strokes[0].points, Points({{512, 300}}));
  EXPECT_TRUE(strokes[0].figure);
  EXPECT_EQ(strokes[1].points, Points({{1, 2}, {3.5, 4}, {5, 6}}));
  EXPECT_EQ(strokes[2].picture, "IMG_0007.jpg");
  EXPECT_FALSE(strokes[2].figure);
}

TEST(FigureStrokes, NoTextIsNoStroke) {
  EXPECT_TRUE(ParseFigureStrokes("").empty());
  EXPECT_TRUE(ParseFigureStrokes(" ; ;").empty());
  EXPECT_EQ(FigureText(std::vector<FigureStroke>{}), "");
}

TEST(FigureStrokes, NamesMayHaveSpaces) {
  const auto strokes = ParseFigureStrokes("front view.jpg:1,2 side view 2.jpg:3,4");
  ASSERT_EQ(strokes.size(), 2u);
  EXPECT_EQ(strokes[0].picture, "front view.jpg");
  EXPECT_EQ(strokes[1].picture, "side view 2.jpg");
}

TEST(FigureStrokes, AnyNameAndNumberSurvivesWriting) {
  std::uint32_t state = 5;
  const auto random = [&] { return (state = state * 1664525u + 1013904223u) >> 8; };
  const std::string letters = "ab :;%!-,.\n\x7f/é12AF";
  std::vector<FigureStroke> strokes;
  for (int i = 0; i < 400; ++i) {
    FigureStroke stroke;
    for (unsigned k = 0; k <= random() % 6; ++k)
      stroke.picture += letters.substr(random() % letters.size(), 1);
    for (unsigned k = 0; k <= random() % 4; ++k)
      stroke.points.emplace_back(random() / 997.0, std::ldexp(random(), -40));
    stroke.figure = random() % 2;
    strokes.push_back(stroke);
  }
  const auto again = ParseFigureStrokes(FigureText(strokes));
  ASSERT_EQ(again.size(), strokes.size());
  for (std::size_t i = 0; i < strokes.size(); ++i) {
    EXPECT_EQ(again[i].picture, strokes[i].picture);
    EXPECT_EQ(again[i].points, strokes[i].points);
    EXPECT_EQ(again[i].figure, strokes[i].figure);
  }
}

TEST(FigureStrokes, PercentSignsThatAreNoCodesStay) {
  EXPECT_EQ(ParseFigureStrokes("50%.jpg:1,2")[0].picture, "50%.jpg");
  EXPECT_EQ(ParseFigureStrokes("a%3Ab%zz.jpg:1,2")[0].picture, "a:b%zz.jpg");
}

TEST(FigureStrokes, TypedNamesAreTakenAsTheyAre) {
  const FigureStroke stroke = ParseTypedStroke("!at 12:30;%3A.jpg:7,8-9,10");
  EXPECT_EQ(stroke.picture, "!at 12:30;%3A.jpg");
  EXPECT_EQ(stroke.points, Points({{7, 8}, {9, 10}}));
  EXPECT_TRUE(stroke.figure);
  EXPECT_THROW(ParseTypedStroke("IMG.jpg"), UsageError);
  EXPECT_THROW(ParseTypedStroke(":3,4"), UsageError);
  EXPECT_THROW(ParseTypedStroke("a.jpg:3,4 b.jpg:x,6"), UsageError);
}

TEST(FigureStrokes, FaultsNameThePartAndTheForm) {
  EXPECT_EQ(FaultOf("a.jpg:1,2;!b.jpg:3,4"), "");
  for (const auto& [text, part, fault] : std::vector<std::array<const char*, 3>>{
           {"a.jpg:1,2; b.jpg", "'b.jpg'", "has no ':'"},
           {"a.jpg:1,2 :3,4", "':3,4'", "names no picture"},
           {"a.jpg:1", "'a.jpg:1'", "has no X,Y"},
           {"a.jpg:1,", "'a.jpg:1,'", "has no X,Y"},
           {"a.jpg:-1,2", "'a.jpg:-1,2'", "-1,2, which no picture has"},
           {"a.jpg:nan,2", "'a.jpg:nan,2'", "has no X,Y"},
           {"a.jpg:inf,2", "'a.jpg:inf,2'", "has no X,Y"},
           {"a.jpg:1,2-", "'a.jpg:1,2-'", "has no X,Y"},
           {"a.jpg:1,2-3,-4", "'a.jpg:1,2-3,-4'", "3,-4, which no picture has"},
           {"a.jpg:1,2x", "'a.jpg:1,2x'", "does not end"},
           {"a.jpg:1,2,3", "'a.jpg:1,2,3'", "does not end"},
           {"a.jpg:1,2000001", "'a.jpg:1,2000001'", "1,2000001, which no picture has"}}) {
    EXPECT_NE(FaultOf(text).find(part), std::string::npos) << text << ": " << FaultOf(text);
    EXPECT_NE(FaultOf(text).find(fault), std::string::npos) << text << ": " << FaultOf(text);
    EXPECT_NE(FaultOf(text).find("PICTURE:X,Y"), std::string::npos);
  }
  EXPECT_EQ(FaultOf("a\n" + std::string(300, 'b')).find('\n'), std::string::npos);
  EXPECT_LT(FaultOf(std::string(1000, 'b')).size(), 400u);
}

TEST(FigureStrokes, EndlessTextsAreRefused) {
  std::string text = "a.jpg:1,1";
  for (int i = 0; i < 10'000; ++i) text += "-1,1";
  EXPECT_NE(FaultOf(text).find("too many points"), std::string::npos);
  std::string many;
  for (int i = 0; i < 10'001; ++i) many += "a:1,1;";
  EXPECT_NE(FaultOf(many).find("too many points"), std::string::npos);
}

TEST(FigureStrokes, CapturedNamesAreFound) {
  const auto find = [](const std::string& picture, const std::vector<std::string>& names) {
    return IndexOfPicture({picture, {}, true}, names);
  };
  const std::vector<std::string> names = {"IMG_1.jpg", "IMG_1.png", "IMG_2.jpg", "lying_IMG_1.jpg",
                                          "upright_IMG_2.JPG"};
  EXPECT_EQ(find("IMG_1.png", names), 1);
  EXPECT_EQ(find("IMG_2.HEIC", names), 2);
  EXPECT_EQ(find("lying/IMG_1.jpg", names), 3);
  EXPECT_EQ(find("lying/IMG_1.CR2", names), 3);
  EXPECT_EQ(find("lying/IMG_2.NEF", {"IMG_2.jpg"}), 0);  // the only folder: capture leaves it out
  EXPECT_EQ(find("IMG_3.jpg", names), -1);
  EXPECT_EQ(find("IMG_1.HEIC", {"IMG_1.png"}), -1);
}

TEST(FigureStrokes, FilmedPlacesAreCameraAndFrame) {
  const auto place = FilmedPlaceOf({"cam2/114", {}, true});
  ASSERT_TRUE(place);
  EXPECT_EQ(place->camera, "cam2");
  EXPECT_EQ(place->frame, 114);
  for (const char* other : {"cam2", "/3", "cam2/", "cam2/-1", "cam2/3.jpg", "cam2/99999999999"})
    EXPECT_FALSE(FilmedPlaceOf({other, {}, true})) << other;
}

TEST(FigureStrokes, PlacesFollowThePictureThatCaptureWrote) {
  // A landscape of half the size.
  EXPECT_TRUE(InCaptured({100, 60}, {400, 300}, {200, 150}).isApprox(Vector2d(50, 30)));
  // A portrait, turned clockwise: what was at its upper left is at the upper right.
  EXPECT_TRUE(InCaptured({0, 0}, {300, 400}, {400, 300}).isApprox(Vector2d(400, 0)));
  EXPECT_TRUE(InCaptured({0.5, 0.5}, {300, 400}, {400, 300}).isApprox(Vector2d(399.5, 0.5)));
  EXPECT_TRUE(InCaptured({10, 390}, {300, 400}, {200, 150}).isApprox(Vector2d(5, 5)));
  for (const PictureSize captured : {PictureSize{300, 400}, {400, 300}, {120, 90}}) {
    const Vector2d at(123.25, 77);
    const Vector2d there = InCaptured(at, {300, 400}, captured);
    EXPECT_TRUE(InPhotograph(there, captured, {300, 400}).isApprox(at, 1e-12));
  }
}

TEST(FigureStrokes, PixelsAlongAStrokeAreJoinedAndInside) {
  const auto pixels = PixelsAlong({{0.5, 0.5}, {3.5, 0.5}, {3.5, 2.5}}, {10, 10});
  EXPECT_EQ(pixels, (std::vector<Vector2i>{{0, 0}, {1, 0}, {2, 0}, {3, 0}, {3, 1}, {3, 2}}));
  EXPECT_EQ(PixelsAlong({{4.9, 7.1}}, {10, 10}), (std::vector<Vector2i>{{4, 7}}));
  EXPECT_EQ(PixelsAlong({{10, 10}}, {10, 10}), (std::vector<Vector2i>{{9, 9}}));
  EXPECT_TRUE(PixelsAlong({{11, 2}}, {10, 10}).empty());
  const auto steep = PixelsAlong({{2.2, 0.1}, {5.7, 40.9}}, {10, 20});
  for (std::size_t i = 1; i < steep.size(); ++i)
    EXPECT_LE((steep[i] - steep[i - 1]).cwiseAbs().maxCoeff(), 1);
  EXPECT_EQ(steep.back().y(), 19);
  // Far beyond the picture, through it, and beside it.
  const auto across = PixelsAlong({{-9e8, 4.5}, {9e8, 4.5}}, {10, 20});
  EXPECT_EQ(across.size(), 10u);
  EXPECT_TRUE(PixelsAlong({{-9e8, 24.5}, {9e8, 24.5}}, {10, 20}).empty());
  EXPECT_TRUE(PixelsAlong({{-5, 2}, {2, -5}}, {10, 20}).empty());
}

}  // namespace keypose::figure_strokes_test

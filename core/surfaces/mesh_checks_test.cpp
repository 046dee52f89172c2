#include "core/surfaces/mesh_checks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "core/surfaces/shapes.h"
#include "core/values/errors.h"

namespace keypose::mesh_checks_test {

using ::testing::HasSubstr;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

std::string Fault(const std::function<void()>& check) {
  try {
    check();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(RequireUsable, NamesTheFault) {
  Mesh nan = MakeIcosphere(1);
  nan.points(7, 1) = kNan;
  try {
    RequireUsable(nan, "register: source");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("vertex 7"), std::string::npos);
    EXPECT_EQ(std::string(error.what()).find("cleanup"), std::string::npos)
        << "which refuses such files itself";
  }
  EXPECT_THROW(RequireUsable(Mesh{}, "source"), InputError);
}

TEST(RequireIndices, NamesTheFaceTheVertexAndTheCount) {
  Mesh box = MakeBox(1, 1, 1);
  EXPECT_EQ(Fault([&] { RequireIndices(8, box.faces, "box.ply"); }), "");
  box.faces(3, 1) = 8;
  const std::string fault = Fault([&] { RequireIndices(8, box.faces, "box.ply"); });
  EXPECT_THAT(fault, HasSubstr("box.ply: face 3 names vertex 8, but there are 8"));
  box.faces(3, 1) = -1;
  EXPECT_THAT(Fault([&] { RequireIndices(8, box.faces, "box.ply"); }), HasSubstr("vertex -1"));
}

TEST(RequireVertex, SaysWhoNamesItAndHowManyThereAre) {
  const auto check = [](int vertex) {
    return Fault([&] { RequireVertex(vertex, 8, "the floor", "the keys have", "; count again"); });
  };
  EXPECT_EQ(check(0), "");
  EXPECT_EQ(check(7), "");
  EXPECT_EQ(check(8), "the floor names vertex 8, but the keys have 8 vertices; count again");
  EXPECT_THAT(check(-1), HasSubstr("vertex -1"));
}

TEST(RequireOnePerVertex, SaysBothCounts) {
  const auto check = [](int count) {
    return Fault([&] { RequireOnePerVertex(count, 8, "the map has", "values", "the box", ""); });
  };
  EXPECT_EQ(check(8), "");
  EXPECT_EQ(check(7), "the map has 7 values, but the box has 8 vertices");
}

TEST(RequireArea, RefusesWhatLiesOnALine) {
  Mesh flat = MakeBox(1, 1, 1);
  EXPECT_EQ(Fault([&] { RequireArea(flat, "flat.obj"); }), "");
  flat.points.rightCols(2).setZero();
  EXPECT_THAT(Fault([&] { RequireArea(flat, "flat.obj"); }), HasSubstr("flat.obj: "));
}

TEST(RequireExtent, RefusesOnePlace) {
  Mesh mesh = MakeBox(1, 1, 1);
  EXPECT_EQ(Fault([&] { RequireExtent(mesh, "target"); }), "");
  mesh.points.setConstant(3);
  EXPECT_THAT(Fault([&] { RequireExtent(mesh, "target"); }), HasSubstr("coincide"));
}

TEST(RequireNotNegative, RefusesNegativeAndNotFinite) {
  EXPECT_EQ(Fault([] { RequireNotNegative(0, "a softness that"); }), "");
  for (const double bad : {-1e-300, kInfinity, kNan})
    EXPECT_EQ(Fault([&] { RequireNotNegative(bad, "a softness that"); }),
              "a softness that is negative or not finite");
}

TEST(RequireUsableLandmarks, NamesTheLandmarkAndTheVertex) {
  std::vector<LandmarkGoal> goals(2);
  goals[1].name = "tail";
  EXPECT_EQ(Fault([&] { RequireUsable(goals, 5, "register"); }), "");
  goals[1].source.vertices[2] = -4;
  EXPECT_THAT(Fault([&] { RequireUsable(goals, 5, "register"); }),
              HasSubstr("register: landmark 'tail' is on vertex -4, but the source has 5"));
  goals[1].source.vertices[2] = 4;
  goals[1].target[0] = kNan;
  EXPECT_THAT(Fault([&] { RequireUsable(goals, 5, "register"); }),
              HasSubstr("'tail' is not finite"));
}

TEST(RequireStiffness, NamesTheVertexOrTheCounts) {
  EXPECT_EQ(Fault([] { RequireStiffness({}, 3, "register"); }), "");
  Eigen::VectorXd stiffness = Eigen::VectorXd::Ones(3);
  EXPECT_EQ(Fault([&] { RequireStiffness(stiffness, 3, "register"); }), "");
  EXPECT_THAT(Fault([&] { RequireStiffness(stiffness, 4, "register"); }),
              HasSubstr("has 3 values, but the source has 4 vertices"));
  for (const double bad : {0.0, -1.0, kInfinity, kNan}) {
    stiffness[1] = bad;
    EXPECT_THAT(Fault([&] { RequireStiffness(stiffness, 3, "register"); }),
                HasSubstr("stiffness of vertex 1"));
  }
}

}  // namespace keypose::mesh_checks_test

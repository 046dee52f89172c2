#include "synth/rooms/room_score.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "core/pictures/fit_view.h"
#include "core/pictures/image_turns.h"
#include "core/values/angles.h"
#include "core/values/errors.h"
#include "synth/worlds/polygonize.h"

namespace keypose::synth::room_score_test {

using Eigen::Vector3d;

Scene Ring(int count) {
  Scene scene;
  for (int i = 0; i < count; ++i) {
    View view;
    view.name = "IMG_" + std::to_string(100 + i);
    view.camera.width = 100, view.camera.height = 80, view.camera.fx = view.camera.fy = 90;
    view.camera.cx = 50, view.camera.cy = 40;
    const double angle = 2 * kPi * i / count;
    view.camera_from_world =
        LookAt({0.6 * std::cos(angle), 0.6 * std::sin(angle), 0.3 + 0.02 * (i % 3)}, {0, 0, 0.1});
    scene.views.push_back(view);
  }
  return scene;
}

Similarity3 Somewhere() {
  Similarity3 way;
  way.scale = 3.7;
  way.rotation = Eigen::AngleAxisd(1.1, Vector3d(1, 2, -1).normalized()).toRotationMatrix();
  way.translation = {5, -2, 1};
  return way;
}

const Vector3d kMiddle(0, 0, 0.1);

TEST(RoomScore, SameCamerasInAnotherFrameAreAllRight) {
  const Scene truth = Ring(12);
  const RoomCameraScore score = ScoreRoomCameras(truth, Transformed(Somewhere(), truth), kMiddle);
  EXPECT_EQ(score.placed, 12);
  EXPECT_TRUE(score.wrong.empty());
  EXPECT_LT(score.median_deg, 1e-5);
  EXPECT_NEAR(score.truth_from_model.scale, 1 / 3.7, 1e-9);
}

TEST(RoomScore, WrongCamerasAreNamedAndDoNotSpoilTheOthers) {
  const Scene truth = Ring(12);
  Scene model = Transformed(Somewhere(), truth);
  for (const int i : {2, 3, 7, 8, 9})  // five of twelve see the figure turned by 40 degrees
    model.views[i].camera_from_world = Compose(
        model.views[i].camera_from_world,
        {Eigen::Quaterniond(Eigen::AngleAxisd(40 * kDegree, Vector3d::UnitY())), {0.4, 0, 0}});
  model.views.erase(model.views.begin() + 5);
  const RoomCameraScore score = ScoreRoomCameras(truth, model, kMiddle);
  EXPECT_EQ(score.placed, 11);
  EXPECT_EQ(score.missing, std::vector<std::string>{"IMG_105"});
  EXPECT_EQ(score.wrong,
            (std::vector<std::string>{"IMG_102", "IMG_103", "IMG_107", "IMG_108", "IMG_109"}));
  EXPECT_LT(score.median_over_distance, 1e-6);
}

TEST(RoomScore, TurnsTellTheMotionsApart) {
  const Scene figure = Ring(10);
  Scene room = figure;  // one tripod: the same camera ten times
  for (View& view : room.views) view.camera_from_world = figure.views[0].camera_from_world;
  EXPECT_EQ(AgreeingTurns(figure, Transformed(Somewhere(), figure)), 10);
  EXPECT_EQ(AgreeingTurns(room, Transformed(Somewhere(), figure)), 1);
  EXPECT_EQ(AgreeingTurns(room, Transformed(Somewhere(), room)), 10);
}

TEST(RoomScore, MasksAreComparedAtAnySize) {
  Image8 truth(100, 60, 1), half(50, 30, 1), shifted(100, 60, 1);
  for (int y = 10; y < 50; ++y)
    for (int x = 20; x < 60; ++x)
      *truth.at(x, y) = 255, *half.at(x / 2, y / 2) = 255, *shifted.at(x + 20, y) = 255;
  EXPECT_DOUBLE_EQ(MaskOverlap(truth, truth), 1);
  EXPECT_DOUBLE_EQ(MaskOverlap(truth, half), 1);
  EXPECT_NEAR(MaskOverlap(truth, shifted), 1.0 / 3, 1e-12);
  EXPECT_DOUBLE_EQ(MaskOverlap(Image8(9, 9, 1), Image8(9, 9, 1)), 1);
  EXPECT_THROW(MaskOverlap(truth, Image8(70, 60, 1)), InputError);
}

TEST(RoomScore, PortraitsThatCaptureTurnedAreComparedAsTheyLie) {
  const Scene model = Ring(12);
  Scene truth = model;
  for (const int i : {3, 8}) {
    View& view = truth.views[i];  // held the other way up: its top is this picture's left side
    std::swap(view.camera.width, view.camera.height);
    view.camera_from_world =
        Compose({Eigen::Quaterniond(Eigen::AngleAxisd(-kPi / 2, Vector3d::UnitZ())), {0, 0, 0}},
                view.camera_from_world);
  }
  // The picture of a point is rotated clockwise with the camera.
  const Vector3d point(0.03, 0.02, 0.12);
  const Vector3d lies = model.views[3].camera_from_world * point,
                 stands = truth.views[3].camera_from_world * point;
  EXPECT_NEAR(lies.x(), -stands.y(), 1e-12);
  EXPECT_NEAR(lies.y(), stands.x(), 1e-12);
  const RoomCameraScore score = ScoreRoomCameras(truth, Transformed(Somewhere(), model), kMiddle);
  EXPECT_TRUE(score.wrong.empty());
  EXPECT_LT(score.median_deg, 1e-5);
  Image8 portrait(60, 100, 1);
  for (int y = 5; y < 30; ++y)
    for (int x = 10; x < 20; ++x) *portrait.at(x, y) = 255;
  EXPECT_DOUBLE_EQ(MaskOverlap(portrait, QuarterTurned(portrait)), 1);
}

/// A round body that stands on z = 0, and if asked a slab that was left under it.
Mesh Body(double slab_radius, double slab_depth) {
  const auto distance = [=](const Vector3d& p) {
    const double body = std::max((p - Vector3d(0, 0, 0.07)).norm() - 0.09, -p.z());
    const double slab =
        std::max({p.head<2>().norm() - slab_radius, p.z() - 0.004, -slab_depth - p.z()});
    return slab_radius > 0 ? std::min(body, slab) : body;
  };
  return Polygonize(distance, {-0.15, -0.15, -0.05}, {0.15, 0.15, 0.18}, 0.006);
}

TEST(RoomScore, WhatIsLeftUnderAndBesideTheFigureIsMeasured) {
  const Mesh truth = Body(0, 0);
  const double diagonal =
      (truth.points.colwise().maxCoeff() - truth.points.colwise().minCoeff()).norm();
  const Similarity3 model_from_truth = Somewhere();
  const auto score = [&](const Mesh& mesh) {
    Mesh moved = mesh;
    moved.points = Transformed(model_from_truth, mesh.points);
    return ScoreBase(truth, moved, model_from_truth.Inverse());
  };
  const BaseScore same = score(truth);
  EXPECT_LT(same.below, 1e-3);
  EXPECT_LT(same.beside, 1e-3);
  EXPECT_LT(same.missing, 1e-3);
  const BaseScore under = score(Body(0.05, 0.02));
  EXPECT_NEAR(under.below, 0.02 / diagonal, 2e-3);
  const BaseScore around = score(Body(0.12, 0.0));
  EXPECT_GT(around.beside, 0.08);
  EXPECT_LT(around.below, 4e-3);
}

}  // namespace keypose::synth::room_score_test

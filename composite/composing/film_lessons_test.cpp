#include "composite/composing/film_lessons.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numeric>

#include "composite/composing/shot_geometry.h"
#include "composite/layer/linear_light.h"
#include "core/surfaces/shapes.h"

namespace keypose::composite::film_lessons_test {

/// A ball on a grey table before a camera that looks down on it, in a lamp from the left. It stands
/// beyond the picture's right border, so that its shadow is not seen, until the last frame.
class BallEntersLate : public ::testing::Test {
 protected:
  BallEntersLate() {
    for (int i = 0; i < 7; ++i) {
      Mesh ball = MakeIcosphere(2);
      ball.points *= 0.5;
      ball.points.col(2).array() += 0.5;
      ball.points.col(0).array() += i == 6 ? 0 : 3.2;
      ball.uvs = UvsX2::Constant(1, 2, 0.5);
      frames_.push_back(ball);
    }
    looks_.faces = frames_[0].faces, looks_.uvs = frames_[0].uvs;
    looks_.uv_faces = FacesX3::Zero(looks_.faces.rows(), 3);
    looks_.textures = {ImageF(1, 1, 3, 0.3f)};
    shot_.camera = {120, 90, 110, 110, 60, 45};
    for (int i = 0; i < 7; ++i) {
      ShotFrame frame;
      frame.frame = i, frame.pose = "here";
      frame.camera_from_world = LookAt({0, -2.5, 3.5}, {0, 0, 0});
      shot_.frames.push_back(frame);
    }
  }

  /// What a film in this light shows, without grain.
  ImageF Filmed(const ShotGeometry& geometry, int frame) const {
    const View view = geometry.ViewAt(frame);
    const PixelRays rays(view.camera);
    const Ground table = geometry.Table();
    const PointsX3 points = geometry.Points(frame);
    const RayScene scene(points, looks_.faces);
    const ImageF layer = RenderLayer(looks_.At(frame), points, scene, {}, view, rays, 2, &table),
                 kept = ShadowPicture(scene, table, lamp_, nullptr, view, rays);
    ImageF light(view.camera.width, view.camera.height, 3);
    for (std::size_t i = 0; i < light.data.size(); ++i)
      light.data[i] =
          layer.data[i / 3 * 4 + i % 3] + (1 - layer.data[i / 3 * 4 + 3]) * 0.4f * kept.data[i / 3];
    return LevelsOf(light);
  }

  std::vector<Mesh> frames_;
  Looks looks_;
  FilmedShot shot_;
  ShadowStrength lamp_{0.2, 0.5, {Eigen::Vector3d(-0.8, 0.2, 1).normalized(), 0.05}};
};

TEST_F(BallEntersLate, TheShadowIsLearntFromTheWholeShot) {
  std::vector<int> numbers(frames_.size());
  std::iota(numbers.begin(), numbers.end(), 0);
  const AnimationTimes times{12, 7, {}, {}};
  const ShotGeometry geometry(shot_, PlanFilm(shot_, numbers, times), frames_, times);
  Film film;
  film.read = [&](int i) { return Filmed(geometry, i); };
  film.given_plate = LevelsOf(ImageF(120, 90, 3, 0.4f));
  for (int i = 0; i < 7; ++i) film.pictures.push_back({i, i, i, true, true});
  const FilmLessons lessons = LearnFromFilm(geometry, looks_, film, {}, nullptr);
  EXPECT_GT(lessons.shadow.explained, 0.8);
  EXPECT_NEAR(lessons.shadow.strength.lamp, 0.5, 0.1);
  EXPECT_GT(lessons.shadow.strength.light.direction.dot(lamp_.light.direction), 0.99);
}

}  // namespace keypose::composite::film_lessons_test

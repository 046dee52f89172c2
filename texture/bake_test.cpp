#include "texture/bake.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>

#include "core/errors.h"
#include "core/geometry.h"
#include "core/io/colmap_io.h"
#include "core/io/files.h"
#include "core/io/image_io.h"
#include "core/io/image_set.h"
#include "core/io/mesh_io.h"
#include "core/parallel.h"
#include "core/render.h"
#include "texture/bake_atlas.h"
#include "texture/bake_gain.h"
#include "texture/bake_labels.h"
#include "texture/bake_max_flow.h"
#include "texture/bake_paint.h"
#include "texture/bake_quality.h"
#include "texture/bake_seams.h"
#include "texture/bake_split.h"

namespace keypose::texture {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3f;

/// A sphere as six n x n patches, each a chart of a 3 x 2 layout with margins; vertices are shared across the charts' seams.
Mesh PatchSphere(int n, double radius = 1, const Vector3d& center = Vector3d::Zero()) {
  std::vector<Vector3d> points;
  std::vector<Vector2d> uvs;
  std::vector<Eigen::Vector3i> faces, uv_faces;
  std::map<std::array<long, 3>, int> known;
  const auto vertex = [&](const Vector3d& cube) {
    const std::array<long, 3> key = {std::lround(cube.x() * 1e6), std::lround(cube.y() * 1e6), std::lround(cube.z() * 1e6)};
    const auto [it, added] = known.try_emplace(key, static_cast<int>(points.size()));
    if (added) points.push_back(center + radius * cube.normalized());
    return it->second;
  };
  for (int side = 0; side < 6; ++side) {
    const int axis = side / 2;
    const double sign = side % 2 ? -1 : 1;
    std::vector<int> v, t;
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) {
        Vector3d cube;
        cube[axis] = sign;
        // Equal angles, so that the faces are of about one size; swapped on the back so that all face outwards.
        cube[(axis + 1) % 3] = std::tan((2.0 * i / n - 1) * M_PI / 4) * sign;
        cube[(axis + 2) % 3] = std::tan((2.0 * j / n - 1) * M_PI / 4);
        v.push_back(vertex(cube));
        t.push_back(static_cast<int>(uvs.size()));
        uvs.emplace_back((side % 3 + 0.06 + 0.88 * i / n) / 3, (side / 3 + 0.06 + 0.88 * j / n) / 2);
      }
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const int a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
        for (const Eigen::Vector3i& q : {Eigen::Vector3i(a, b, d), Eigen::Vector3i(a, d, c)}) {
          faces.emplace_back(v[q[0]], v[q[1]], v[q[2]]);
          uv_faces.emplace_back(t[q[0]], t[q[1]], t[q[2]]);
        }
      }
  }
  Mesh mesh;
  mesh.points.resize(points.size(), 3);
  for (std::size_t i = 0; i < points.size(); ++i) mesh.points.row(i) = points[i];
  mesh.uvs.resize(uvs.size(), 2);
  for (std::size_t i = 0; i < uvs.size(); ++i) mesh.uvs.row(i) = uvs[i];
  mesh.faces.resize(faces.size(), 3);
  mesh.uv_faces.resize(faces.size(), 3);
  for (std::size_t i = 0; i < faces.size(); ++i) {
    mesh.faces.row(i) = faces[i];
    mesh.uv_faces.row(i) = uv_faces[i];
  }
  return mesh;
}

/// Linear colour of a surface point seen from an eye.
using Paint = std::function<Vector3f(const Vector3d& x, const Vector3d& eye)>;

Vector3f Smooth(const Vector3d& x, const Vector3d&) {
  return Vector3f(0.35f + 0.25f * static_cast<float>(std::sin(4 * x.x() + 1)),
                  0.4f + 0.25f * static_cast<float>(std::cos(5 * x.y() - 2 * x.z())),
                  0.3f + 0.2f * static_cast<float>(std::sin(3 * x.z() + 2 * x.x())));
}

Vector3f Checker(const Vector3d& x, const Vector3d&) {
  const int parity = static_cast<int>(std::floor(x.x() * 2 + 100.3) + std::floor(x.y() * 2 + 100.3) + std::floor(x.z() * 2 + 100.3)) % 2;
  return parity ? Vector3f(0.5f, 0.35f, 0.2f) : Vector3f(0.12f, 0.2f, 0.3f);
}

View At(const Vector3d& eye, int size) {
  View view;
  view.camera.width = size * 4 / 3;
  view.camera.height = size;
  view.camera.fx = view.camera.fy = 1.55 * size;
  view.camera.cx = size * 2 / 3.0 + 1.5;
  view.camera.cy = size / 2.0 - 2.5;
  view.camera.k1 = -0.08;
  view.camera.p1 = 0.002;
  view.camera_from_world = LookAt(eye, Vector3d::Zero());
  return view;
}

bool AwayFromCheckerEdges(const Vector3d& x) {
  double nearest = 1;
  for (int k = 0; k < 3; ++k) nearest = std::min(nearest, std::abs(x[k] * 2 + 100.3 - std::round(x[k] * 2 + 100.3)) / 2);
  return nearest > 0.02;
}

/// Two rings of cameras around the unit sphere, and one above and below.
std::vector<View> AllRound(int size, int around = 8) {
  std::vector<View> views;
  for (int ring = 0; ring < 2; ++ring)
    for (int i = 0; i < around; ++i) {
      const double a = 2 * M_PI * (i + 0.5 * ring) / around, e = ring ? 0.6 : -0.6;
      views.push_back(At(4 * Vector3d(std::cos(a) * std::cos(e), std::sin(a) * std::cos(e), std::sin(e)), size));
    }
  views.push_back(At({0.01, 0, 4}, size));
  views.push_back(At({0.01, 0, -4}, size));
  for (std::size_t i = 0; i < views.size(); ++i) views[i].name = "view_" + std::to_string(i) + ".png";
  return views;
}

/// Photographs by 2 x 2 rays a pixel on the mesh; background is white, so that bleeding would show.
std::vector<Photograph> Shoot(const Mesh& mesh, const std::vector<View>& views, const Paint& paint) {
  const RayScene scene(mesh.points, mesh.faces);
  std::vector<Photograph> photographs(views.size());
  for (std::size_t v = 0; v < views.size(); ++v) {
    const Camera& c = views[v].camera;
    Photograph& photograph = photographs[v];
    photograph.image = Image8(c.width, c.height, 3);
    photograph.mask = Image8(c.width, c.height, 1);
    const Vector3d eye = views[v].Center();
    ParallelFor(c.height, [&](std::int64_t y) {
      for (int x = 0; x < c.width; ++x) {
        Vector3f sum = Vector3f::Zero();
        int hits = 0;
        for (int s = 0; s < 4; ++s) {
          const Vector3d ray = c.Unproject({x + (s % 2 + 0.5) / 2, static_cast<double>(y) + (s / 2 + 0.5) / 2});
          const Vector3d direction = views[v].camera_from_world.rotation.conjugate() * ray;
          const RayScene::Hit hit = scene.Cast(eye, direction);
          sum += hit.face < 0 ? Vector3f::Ones() : paint(eye + hit.distance * direction, eye);
          hits += hit.face >= 0;
        }
        for (int k = 0; k < 3; ++k) photograph.image.at(x, static_cast<int>(y))[k] = SrgbOf(sum[k] / 4);
        *photograph.mask.at(x, static_cast<int>(y)) = hits >= 2 ? 255 : 0;
      }
    });
  }
  return photographs;
}

BakeOptions Small() {
  BakeOptions options;
  options.texture_size = 384;
  return options;
}

BakeResult BakeAll(const Mesh& mesh, const std::vector<View>& views, const std::vector<Photograph>& photographs,
                   const BakeOptions& options = Small()) {
  return Bake(
      mesh, views, [&](int i) { return photographs[i]; }, options);
}

/// 8-bit PSNR of the texture against the paint, over texels in triangles for which `where` holds.
double PsnrAgainst(
    const Mesh& mesh, const Image8& texture, const Paint& truth,
    const std::function<bool(const Vector3d&)>& where = [](const Vector3d&) { return true; }) {
  const Atlas atlas = RasterizeAtlas(mesh, texture.width);
  double sum = 0, count = 0;
  for (std::size_t texel = 0; texel < atlas.face.size(); ++texel) {
    if (!atlas.inside[texel]) continue;
    const Vector3d w = atlas.Weights(texel).cast<double>();
    Vector3d x = Vector3d::Zero();
    for (int k = 0; k < 3; ++k) x += w[k] * mesh.points.row(mesh.faces(atlas.face[texel], k)).transpose();
    if (!where(x)) continue;
    const Vector3f color = truth(x, Vector3d::Zero());
    for (int k = 0; k < 3; ++k) sum += std::pow(texture.data[3 * texel + k] - static_cast<double>(SrgbOf(color[k])), 2), ++count;
  }
  EXPECT_GT(count, 1000);
  return Psnr(sum, count);
}

TEST(Bake, PaintedSphereComesBack) {
  const Mesh mesh = PatchSphere(12);
  const std::vector<View> views = AllRound(240);
  const BakeResult result = BakeAll(mesh, views, Shoot(mesh, views, Smooth));
  EXPECT_EQ(result.unseen_texels(), 0);
  EXPECT_GT(result.mean_views_per_texel, 4);
  EXPECT_GT(PsnrAgainst(mesh, result.texture, Smooth), 42);
  for (const ViewQuality& q : result.quality) {
    EXPECT_TRUE(q.used);
    EXPECT_GT(q.pixels, 1000);
    EXPECT_GT(q.psnr_db, 42);
  }
}

TEST(Bake, CheckerComesBack) {
  const Mesh mesh = PatchSphere(24);
  const std::vector<View> views = AllRound(300);
  BakeOptions options = Small();
  options.texture_size = 512;
  const BakeResult result = BakeAll(mesh, views, Shoot(mesh, views, Checker), options);
  // Hard edges are a pixel wide in the photographs too: away from them nothing may differ, on them only a part of the step.
  EXPECT_GT(PsnrAgainst(mesh, result.texture, Checker), 33);
  EXPECT_GT(PsnrAgainst(mesh, result.texture, Checker, AwayFromCheckerEdges), 45);
}

/// Mean squared difference of neighbouring texels of one chart: a blurred edge has less of it than a sharp one.
double EdgeEnergy(const Mesh& mesh, const Image8& texture) {
  const Atlas atlas = RasterizeAtlas(mesh, texture.width);
  double sum = 0, count = 0;
  for (std::size_t i = 1; i < atlas.face.size(); ++i)
    if (atlas.inside[i] && atlas.inside[i - 1]) sum += std::pow(texture.data[3 * i] - texture.data[3 * i - 3], 2), ++count;
  return sum / count;
}

TEST(Bake, DetailStaysSharpWhenCamerasAreAPixelOff) {
  const Mesh mesh = PatchSphere(12);
  const std::vector<View> truth = AllRound(240);
  const std::vector<Photograph> photographs = Shoot(mesh, truth, Checker);
  std::vector<View> off = truth;
  for (std::size_t v = 0; v < off.size(); ++v) {
    off[v].camera.cx += 1.3 * std::sin(5.0 * static_cast<double>(v));
    off[v].camera.cy += 1.3 * std::cos(7.0 * static_cast<double>(v));
  }
  const double exact = EdgeEnergy(mesh, BakeAll(mesh, truth, photographs).texture);
  EXPECT_GT(EdgeEnergy(mesh, BakeAll(mesh, off, photographs).texture), 0.85 * exact);  // the mean of these views has 0.6 of it
}

/// Colours a little to both sides of the middles of the mesh's edges: mean difference over edges between two views, and over the rest.
std::pair<double, double> JumpsAtBordersAndWithin(const Mesh& mesh, const ImageF& texture, const std::vector<int>& labels) {
  std::map<std::pair<int, int>, std::vector<std::pair<int, Vector3f>>> sides;  // edge: face, colour
  for (int f = 0; f < mesh.face_count(); ++f)
    for (int k = 0; k < 3; ++k) {
      const int a = mesh.faces(f, k), b = mesh.faces(f, (k + 1) % 3);
      const Eigen::RowVector2d uv = 0.42 * (mesh.uvs.row(mesh.uv_faces(f, k)) + mesh.uvs.row(mesh.uv_faces(f, (k + 1) % 3))) +
                                    0.16 * mesh.uvs.row(mesh.uv_faces(f, (k + 2) % 3));
      const int x = static_cast<int>(uv[0] * texture.width), y = static_cast<int>((1 - uv[1]) * texture.height);
      sides[{std::min(a, b), std::max(a, b)}].emplace_back(f, Eigen::Map<const Vector3f>(texture.at(x, y)));
    }
  double sum[2] = {0, 0}, count[2] = {0, 0};
  for (const auto& [edge, s] : sides) {
    if (s.size() != 2) continue;
    const int within = labels[s[0].first] == labels[s[1].first];
    sum[within] += (s[0].second.cwiseSqrt() - s[1].second.cwiseSqrt()).norm();
    ++count[within];
  }
  EXPECT_GT(count[0], 50);
  return {sum[0] / count[0], sum[1] / count[1]};
}

/// What BakeAll does of all views, with the labels kept.
struct PaintedSphere {
  std::vector<int> labels;
  ImageF texture;
};
PaintedSphere PaintAll(const Mesh& mesh, const std::vector<View>& views, const std::vector<Photograph>& photographs, double to_mean) {
  const RayScene scene(mesh.points, mesh.faces);
  const Atlas atlas = RasterizeAtlas(mesh, 512);
  std::vector<BakeView> loaded;
  for (std::size_t v = 0; v < views.size(); ++v) loaded.emplace_back(views[v], photographs[v], mesh, scene, BakeViewOptions());
  const std::vector<Vector3f> gains(views.size(), Vector3f::Ones());
  PaintResult result = PaintTexels(Witnesses(mesh, loaded, gains, std::vector<char>(views.size(), 1), 512, 75, 3), atlas, to_mean, nullptr);
  return {result.labels, FinishTexture(atlas, std::move(result.painting), 4)};
}

TEST(PaintTexels, BordersBetweenViewsShowNoMoreThanTheInside) {
  const Mesh mesh = PatchSphere(20);
  const std::vector<View> views = AllRound(240);
  // The lamp stands still while the sphere turns, and every photograph has another exposure.
  const Paint lit = [](const Vector3d& x, const Vector3d& eye) {
    const double shade = 0.75 + 0.25 * x.normalized().dot((eye + Vector3d(0, 0, 3)).normalized());
    return (Smooth(x, eye) * static_cast<float>(shade * (1 + 0.15 * std::sin(7 * eye.x() + 3 * eye.y())))).eval();
  };
  const std::vector<Photograph> photographs = Shoot(mesh, views, lit);
  for (const double to_mean : {0.0, 1.0}) {
    const PaintedSphere painted = PaintAll(mesh, views, photographs, to_mean);
    const auto [borders, within] = JumpsAtBordersAndWithin(mesh, painted.texture, painted.labels);
    EXPECT_LT(borders, 1.2 * within) << "to_mean " << to_mean;
  }
}

TEST(LevelSeams, ViewsThatDifferByAConstantMeetHalfWay) {
  const Mesh mesh = PatchSphere(6);
  std::vector<FaceViews> faces(mesh.face_count());
  std::vector<int> labels(mesh.face_count());
  for (int f = 0; f < mesh.face_count(); ++f) {
    labels[f] = mesh.points(mesh.faces(f, 0), 2) + mesh.points(mesh.faces(f, 1), 2) + mesh.points(mesh.faces(f, 2), 2) > 0;
    faces[f].mean = Vector3f(0.4f, 0.4f, 0.4f);
    for (const int view : {0, 1}) {
      const Vector3f color = Vector3f::Constant(view ? 0.6f : 0.3f);
      faces[f].candidates.push_back({view, 1, color.cwiseSqrt(), color, 1, 1});
    }
  }
  const auto shares = VertexShares(mesh, labels);
  for (const double to_mean : {0.0, 1000.0})
    for (const auto& list : LevelSeams(mesh, faces, labels, shares, to_mean)) {
      if (list.size() < 2) continue;
      // At the border both end at one colour; pulled hard, at the mean.
      EXPECT_NEAR(0.3 + list[0].color[1], 0.6 + list[1].color[1], 0.02);
      if (to_mean > 0) {
        EXPECT_NEAR(0.3 + list[0].color[1], 0.4, 1e-3);
      }
    }
}

TEST(Bake, PhotographsFarFinerThanTheAtlasAreAveragedNotAliased) {
  const Mesh mesh = PatchSphere(12);
  const std::vector<View> views = AllRound(360, 4);
  const Paint noisy = [](const Vector3d& x, const Vector3d&) {
    const float s = static_cast<float>(0.3 + 0.25 * std::sin(120 * x.x()) * std::sin(120 * x.y()) * std::sin(120 * x.z()));
    return Vector3f(s, s, s);
  };
  BakeOptions options = Small();
  options.texture_size = 64;
  const BakeResult result = BakeAll(mesh, views, Shoot(mesh, views, noisy), options);
  const Paint mean = [](const Vector3d&, const Vector3d&) { return Vector3f(0.3f, 0.3f, 0.3f); };
  EXPECT_GT(PsnrAgainst(mesh, result.texture, mean), 27);  // the noise itself is at 19 dB
}

TEST(Bake, OccluderIsNotPaintedOnWhatItHides) {
  Mesh mesh = PatchSphere(12);
  Mesh ball = PatchSphere(8, 0.3, {1.6, 0, 0});
  const int first = mesh.vertex_count(), first_uv = static_cast<int>(mesh.uvs.rows()), first_face = mesh.face_count();
  const auto append = [](auto& to, const auto& rows) {
    to.conservativeResize(to.rows() + rows.rows(), to.cols());
    to.bottomRows(rows.rows()) = rows;
  };
  mesh.uvs.col(0) *= 0.5;
  ball.uvs.col(0) = ball.uvs.col(0) * 0.5 + UvsX2::Constant(ball.uvs.rows(), 2, 0.5).col(0);
  append(mesh.points, ball.points);
  append(mesh.uvs, ball.uvs);
  append(mesh.faces, FacesX3((ball.faces.array() + first).matrix()));
  append(mesh.uv_faces, FacesX3((ball.uv_faces.array() + first_uv).matrix()));
  const Paint paint = [](const Vector3d& x, const Vector3d&) {
    return x.norm() < 1.1 ? Vector3f(0.1f, 0.5f, 0.1f) : Vector3f(0.6f, 0.05f, 0.05f);
  };
  const std::vector<View> views = AllRound(240);
  const BakeResult result = BakeAll(mesh, views, Shoot(mesh, views, paint));
  const Atlas atlas = RasterizeAtlas(mesh, 384);
  int wrong = 0;
  for (std::size_t texel = 0; texel < atlas.face.size(); ++texel) {
    if (!atlas.inside[texel]) continue;
    const bool is_ball = atlas.face[texel] >= first_face;
    wrong += (result.texture.data[3 * texel] > result.texture.data[3 * texel + 1]) != is_ball;
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_LT(result.unseen_texels(), result.texels / 10);
}

TEST(Bake, WanderingHighlightIsAbsentFromTheMap) {
  const Mesh mesh = PatchSphere(12);
  const std::vector<View> views = AllRound(180, 12);
  // The lamp sits above the camera, so that its reflection wanders over the sphere with the view.
  const Paint glossy = [](const Vector3d& x, const Vector3d& eye) {
    const Vector3d n = x.normalized(), half = ((eye + Vector3d(0, 0, 2)).normalized() + eye.normalized()).normalized();
    return (Smooth(x, eye) + Vector3f::Constant(n.dot(half) > 0.985 ? 0.6f : 0.0f)).cwiseMin(1.0f).eval();
  };
  const std::vector<Photograph> photographs = Shoot(mesh, views, glossy);
  const BakeResult robust = BakeAll(mesh, views, photographs);
  BakeOptions trusting = Small();
  trusting.strictness = 0;
  EXPECT_GT(PsnrAgainst(mesh, robust.texture, Smooth), 32);
  EXPECT_LT(PsnrAgainst(mesh, BakeAll(mesh, views, photographs, trusting).texture, Smooth), 30);
}

TEST(Bake, BackgroundBehindOneWrongMaskIsOutvoted) {
  const Mesh mesh = PatchSphere(12);
  const std::vector<View> views = AllRound(240);
  std::vector<Photograph> photographs = Shoot(mesh, views, Smooth);
  for (int y = 90; y < 150; ++y)
    for (int x = 130; x < 190; ++x) photographs[3].image.at(x, y)[0] = photographs[3].image.at(x, y)[1] = 240;
  EXPECT_GT(PsnrAgainst(mesh, BakeAll(mesh, views, photographs).texture, Smooth), 36);
}

TEST(Bake, MaskedPixelsAreNotPainted) {
  const Mesh mesh = PatchSphere(12);
  const std::vector<View> views = {At({4, 0, 0}, 240)};
  std::vector<Photograph> photographs = Shoot(mesh, views, [](const Vector3d&, const Vector3d&) { return Vector3f(0.2f, 0.4f, 0.2f); });
  const BakeResult before = BakeAll(mesh, views, photographs);
  for (int y = 0; y < 240; ++y)
    for (int x = 0; x < 160; ++x) {
      *photographs[0].mask.at(x, y) = 0;
      photographs[0].image.at(x, y)[0] = 255;
    }
  const BakeResult after = BakeAll(mesh, views, photographs);
  EXPECT_NEAR(static_cast<double>(after.seen_texels) / static_cast<double>(before.seen_texels), 0.5, 0.06);
  for (std::size_t i = 0; i < after.texture.data.size(); i += 3) ASSERT_LT(after.texture.data[i], after.texture.data[i + 1]);
}

TEST(Bake, UnseenTexelsAreCountedAndInpaintedFromWhatTheyTouch) {
  const Mesh mesh = PatchSphere(16);
  const std::vector<View> views = {At({4, 0, 0}, 300)};
  // Red above, blue below: the unseen back must follow, smoothly.
  const Paint halves = [](const Vector3d& x, const Vector3d&) {
    return x.z() > 0 ? Vector3f(0.5f, 0.1f, 0.1f) : Vector3f(0.1f, 0.1f, 0.5f);
  };
  const BakeResult result = BakeAll(mesh, views, Shoot(mesh, views, halves));
  // Seen where the angle to the eye is below max_angle: cos(angle) = (4 cos t - 1) / sqrt(17 - 8 cos t) = cos 75.
  double cap = 0;
  for (double t = 0; t < M_PI; t += 1e-4)
    if ((4 * std::cos(t) - 1) / std::sqrt(17 - 8 * std::cos(t)) > std::cos(75 * M_PI / 180)) cap = t;
  const double seen = static_cast<double>(result.seen_texels) / static_cast<double>(result.texels);
  EXPECT_NEAR(seen, (1 - std::cos(cap)) / 2, 0.03);
  EXPECT_EQ(result.unseen_texels() + result.seen_texels, result.texels);
  EXPECT_GT(PsnrAgainst(mesh, result.texture, halves, [](const Vector3d& x) { return x.x() < 0.1 && std::abs(x.z()) > 0.6; }), 14);
  EXPECT_GT(PsnrAgainst(mesh, result.texture, halves, [](const Vector3d& x) { return x.x() > 0.4 && std::abs(x.z()) > 0.1; }), 38);
}

TEST(Bake, GuttersContinueTheChart) {
  const Mesh mesh = PatchSphere(8);
  const std::vector<View> views = AllRound(160);
  BakeOptions options = Small();
  options.gutter = 8;
  const BakeResult result = BakeAll(mesh, views, Shoot(mesh, views, Smooth), options);
  const Atlas atlas = RasterizeAtlas(mesh, 384);
  for (int y = 20; y < 380; ++y)
    for (int x = 20; x < 380; ++x) {
      if (atlas.face[y * 384 + x] >= 0 || atlas.face[y * 384 + x - 4] < 0) continue;  // four texels right of a chart
      for (int k = 0; k < 3; ++k) ASSERT_NEAR(result.texture.at(x, y)[k], result.texture.at(x - 4, y)[k], 14) << x << " " << y;
    }
}

TEST(Bake, HeldOutPhotographsArePredictedAndStillPainted) {
  const Mesh mesh = PatchSphere(12);
  const std::vector<View> views = AllRound(240);
  const std::vector<Photograph> photographs = Shoot(mesh, views, Smooth);
  const BakeResult result = BakeAll(mesh, views, photographs);
  int held_out = 0;
  for (const ViewQuality& q : result.quality) {
    held_out += q.held_out;
    EXPECT_TRUE(q.used);
    EXPECT_GT(q.ssim, 0.98);
    if (!q.held_out) continue;
    EXPECT_GT(q.held_out_psnr_db, 38);
    EXPECT_LT(q.held_out_psnr_db, q.psnr_db);
    EXPECT_GT(q.held_out_psnr_gain_db, 38);
    EXPECT_GT(q.held_out_ssim, 0.97);
  }
  EXPECT_EQ(held_out, 3);
  BakeOptions options = Small();
  options.leave_out = true;
  const BakeResult without = BakeAll(mesh, views, photographs, options);
  for (std::size_t v = 0; v < views.size(); ++v) {
    EXPECT_NE(without.quality[v].held_out, without.quality[v].used);
    // Nothing of the photograph may be in what predicts it: both ways of measuring paint the same texture.
    if (without.quality[v].held_out) {
      EXPECT_EQ(without.quality[v].held_out_psnr_db, result.quality[v].held_out_psnr_db);
    }
  }
  const std::vector<View> few(views.begin(), views.begin() + 8);
  for (const ViewQuality& q : BakeAll(mesh, few, photographs).quality) EXPECT_FALSE(q.held_out);
}

TEST(Ssim, IsOneForEqualImagesAndFollowsTheFormulaForAConstantShift) {
  ImageF a(40, 30, 1), b(40, 30, 1);
  for (std::size_t i = 0; i < a.data.size(); ++i) a.data[i] = 100, b.data[i] = 130;
  const std::vector<char> all(a.data.size(), 1);
  EXPECT_NEAR(Ssim(a, a, all), 1, 1e-6);
  const double c1 = 2.55 * 2.55;
  EXPECT_NEAR(Ssim(a, b, all), (2 * 100 * 130 + c1) / (100 * 100 + 130 * 130 + c1), 1e-4);
  std::vector<char> narrow(a.data.size(), 0);
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 10; ++x) narrow[y * 40 + x] = 1;
  EXPECT_EQ(Ssim(a, b, narrow), 0);  // no window of 11 fits
}

TEST(MinCut, EqualsTheBestOfAllCuts) {
  std::uint32_t state = 7;
  const auto random = [&](int below) { return static_cast<int>((state = state * 1664525u + 1013904223u) >> 16) % below; };
  for (int round = 0; round < 50; ++round) {
    constexpr int kNodes = 8;
    std::int64_t source[kNodes], sink[kNodes], arc[kNodes][kNodes] = {};
    MinCut cut(kNodes);
    for (int i = 0; i < kNodes; ++i) cut.AddTerminals(i, source[i] = random(10), sink[i] = random(10));
    for (int e = 0; e < 14; ++e) {
      const int a = random(kNodes), b = random(kNodes), forward = random(8), backward = random(8);
      if (a == b) continue;
      cut.AddEdge(a, b, forward, backward);
      arc[a][b] += forward;
      arc[b][a] += backward;
    }
    const auto cost = [&](unsigned with_source) {
      std::int64_t sum = 0;
      for (int i = 0; i < kNodes; ++i) {
        sum += with_source >> i & 1 ? sink[i] : source[i];
        for (int j = 0; j < kNodes; ++j) sum += (with_source >> i & 1) && !(with_source >> j & 1) ? arc[i][j] : 0;
      }
      return sum;
    };
    std::int64_t least = cost(0);
    for (unsigned s = 1; s < 1u << kNodes; ++s) least = std::min(least, cost(s));
    EXPECT_EQ(cut.Solve(), least);
    unsigned chosen = 0;
    for (int i = 0; i < kNodes; ++i) chosen |= static_cast<unsigned>(cut.WithSource(i)) << i;
    EXPECT_EQ(cost(chosen), least);
  }
}

TEST(ChooseLabels, OneViewThatIsNearlyTheBestEverywhereTakesAll) {
  const Mesh mesh = PatchSphere(6);
  std::vector<std::vector<LabelCandidate>> candidates(mesh.face_count());
  const Vector3f grey = Vector3f::Constant(0.5f);
  // View 5 is 5 % worse than whichever of nine others is best; but on one patch it is a thousandth as good.
  for (int f = 0; f < mesh.face_count(); ++f) {
    candidates[f].push_back({f % 5, 1.0, grey, grey, 1, 1});
    candidates[f].push_back({5, f < 72 ? 0.001 : 0.95, grey, grey, 1, 1});
  }
  const std::vector<int> labels = ChooseLabels(mesh, candidates);
  for (int f = 0; f < mesh.face_count(); ++f) EXPECT_EQ(labels[f], f >= 72 ? 5 : f % 5) << f;
  candidates[100].clear();
  EXPECT_EQ(ChooseLabels(mesh, candidates)[100], -1);
}

TEST(SplitLargeFaces, KeepsTheSurfaceAndItsLayout) {
  const Mesh mesh = PatchSphere(3);
  const std::vector<View> views = AllRound(240);
  const Mesh split = SplitLargeFaces(mesh, views);
  ASSERT_GT(split.face_count(), mesh.face_count());
  EXPECT_TRUE(CheckClosed(split).closed());
  EXPECT_NEAR(SurfaceArea(split.points, split.faces), SurfaceArea(mesh.points, mesh.faces), 1e-9);
  const Atlas before = RasterizeAtlas(mesh, 128), after = RasterizeAtlas(split, 128);
  for (std::size_t t = 0; t < before.face.size(); ++t) {
    ASSERT_EQ(before.inside[t], after.inside[t]);
    if (!before.inside[t]) continue;
    Vector3d x = Vector3d::Zero(), y = Vector3d::Zero();
    for (int k = 0; k < 3; ++k) {
      x += static_cast<double>(before.Weights(t)[k]) * mesh.points.row(mesh.faces(before.face[t], k)).transpose();
      y += static_cast<double>(after.Weights(t)[k]) * split.points.row(split.faces(after.face[t], k)).transpose();
    }
    ASSERT_LT((x - y).norm(), 1e-5);
  }
}

TEST(Bake, ATexelIsTheSameSpotInEveryPose) {
  const Mesh rest = PatchSphere(16);
  // The other pose: same vertices, faces and layout, bent and twisted. Paint sticks to the clay, so it is looked up at rest.
  Mesh bent = rest;
  for (int v = 0; v < bent.vertex_count(); ++v) {
    const Vector3d x = rest.points.row(v);
    const double turn = 0.5 * x.z();
    bent.points.row(v) << x.x() * std::cos(turn) - x.y() * std::sin(turn) + 0.3 * x.z() * x.z(),
        x.x() * std::sin(turn) + x.y() * std::cos(turn), 1.15 * x.z();
  }
  const std::vector<View> views = AllRound(240);
  const RayScene bent_scene(bent.points, bent.faces);
  const Paint on_bent = [&](const Vector3d& x, const Vector3d& eye) {
    const RayScene::Foot foot = bent_scene.ClosestPoint(x);
    Vector3d at_rest = Vector3d::Zero();
    for (int k = 0; k < 3; ++k) at_rest += foot.barycentric[k] * rest.points.row(rest.faces(foot.face, k)).transpose();
    return Smooth(at_rest, eye);
  };
  const BakeResult a = BakeAll(rest, views, Shoot(rest, views, Smooth)), b = BakeAll(bent, views, Shoot(bent, views, on_bent));
  double sum = 0;
  for (std::size_t i = 0; i < a.texture.data.size(); ++i) sum += std::pow(a.texture.data[i] - static_cast<double>(b.texture.data[i]), 2);
  EXPECT_GT(Psnr(sum, static_cast<double>(a.texture.data.size())), 38);
}

TEST(AdviseTextureSize, DoublesWithTheFocalLength) {
  const Mesh mesh = PatchSphere(12);
  std::vector<View> views = AllRound(240);
  const int size = AdviseTextureSize(mesh, views);
  // From 3 radii away a pixel is 1 / 124 of the radius. A quarter of the way round, 195 pixels, has 29 % of the layout's width, 44 % of its
  // height.
  EXPECT_EQ(size, 512);
  for (View& view : views) view.camera.fx *= 2, view.camera.fy *= 2;
  EXPECT_EQ(AdviseTextureSize(mesh, views), 2 * size);
}

TEST(HarmonizeGains, FindsOneAndOnePointTwo) {
  const Mesh mesh = PatchSphere(12);
  const std::vector<View> views = {At({4, 0, 0}, 240), At({3, 2.6, 0}, 240)};
  std::vector<Photograph> photographs = Shoot(mesh, {views[0]}, Smooth);
  photographs.push_back(Shoot(mesh, {views[1]}, [](const Vector3d& x, const Vector3d& eye) { return (1.2f * Smooth(x, eye)).eval(); })[0]);
  const BakeResult result = BakeAll(mesh, views, photographs);
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(result.gains[0][k] / result.gains[1][k], 1.2, 0.012);
    EXPECT_NEAR(result.gains[0][k] * result.gains[1][k], 1, 0.02);  // exposed between the two
  }
}

TEST(Bake, SameBitsAtOneAndTwoThreads) {
  const Mesh mesh = PatchSphere(8);
  const std::vector<View> views = AllRound(120);
  const std::vector<Photograph> photographs = Shoot(mesh, views, Checker);
  SetThreadCount(1);
  const BakeResult one = BakeAll(mesh, views, photographs);
  SetThreadCount(2);
  const BakeResult two = BakeAll(mesh, views, photographs);
  SetThreadCount(0);
  EXPECT_EQ(one.texture.data, two.texture.data);
  EXPECT_EQ(one.seen_texels, two.seen_texels);
  for (std::size_t v = 0; v < views.size(); ++v) {
    EXPECT_EQ(one.gains[v], two.gains[v]);
    EXPECT_EQ(one.quality[v].psnr_db, two.quality[v].psnr_db);
  }
}

template <class Function>
std::string InputErrorOf(const Function& function) {
  try {
    function();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no InputError";
}

TEST(Bake, MeshWithoutUsableUvsIsAnInputError) {
  const std::vector<View> views = {At({4, 0, 0}, 60)};
  Mesh mesh = PatchSphere(4);
  const std::vector<Photograph> photographs = Shoot(mesh, views, Smooth);
  Mesh bare = mesh;
  bare.uvs.resize(0, 2);
  bare.uv_faces.resize(0, 3);
  EXPECT_THAT(InputErrorOf([&] { BakeAll(bare, views, photographs); }), testing::HasSubstr("no texture coordinates"));
  Mesh tiled = mesh;
  tiled.uvs(tiled.uv_faces(7, 1), 0) = 1.5;
  EXPECT_THAT(InputErrorOf([&] { BakeAll(tiled, views, photographs); }), testing::HasSubstr("outside 0..1"));
  Mesh damaged = mesh;
  damaged.uv_faces(5, 2) = 100000;
  EXPECT_THAT(InputErrorOf([&] { BakeAll(damaged, views, photographs); }), testing::HasSubstr("face 5"));
}

TEST(Bake, MeshOutOfEveryViewIsAnInputError) {
  const Mesh mesh = PatchSphere(4);
  std::vector<View> views = {At({4, 0, 0}, 60)};
  const std::vector<Photograph> photographs = Shoot(mesh, views, Smooth);
  Mesh away = mesh;
  away.points.col(1).array() += 50;
  EXPECT_THAT(InputErrorOf([&] { BakeAll(away, views, photographs); }), testing::HasSubstr("none of the 1 views"));
  EXPECT_THAT(InputErrorOf([&] { BakeAll(mesh, {}, {}); }), testing::HasSubstr("no views"));
  views[0].camera.width = 61;
  EXPECT_THAT(InputErrorOf([&] { BakeAll(mesh, views, photographs); }), testing::HasSubstr("pixels"));
}

/// The stage's program on files; @return its exit code.
int RunBake(const std::filesystem::path& folder, const std::string& texture = "texture.png", const std::string& options = "") {
  const std::string f = folder.string();
  const std::string command = std::string(KEYPOSE_BIN_DIR) + "/keypose-bake --mesh " + f + "/mesh.obj --images " + f + "/images --model " +
                              f + "/model --texture_size 128 --texture " + f + "/" + texture + " " + options + " --report " + f +
                              "/report.json > " + f + "/log 2>&1";
  return std::system(command.c_str()) >> 8;
}

TEST(BakeStage, PaintsFromFilesAndNamesTheViewThatHasNoImage) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "keypose_bake_stage";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder / "images/masks");
  const Mesh mesh = PatchSphere(6);
  Scene scene{AllRound(90, 4), {}};
  const std::vector<Photograph> photographs = Shoot(mesh, scene.views, Smooth);
  ImageSet set;
  set.folder = folder / "images";
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    const std::string name = scene.views[v].name, mask = "masks/" + name + ".png";
    WriteImage(set.folder / name, photographs[v].image);
    WriteImage(set.folder / mask, photographs[v].mask);
    CapturedImage image;
    image.name = name;
    image.mask = mask;
    image.width = photographs[v].image.width;
    image.height = photographs[v].image.height;
    set.images.push_back(image);
  }
  std::sort(set.images.begin(), set.images.end(), [](const CapturedImage& a, const CapturedImage& b) { return a.name < b.name; });
  WriteImageSet(set);
  WriteMesh(folder / "mesh.obj", mesh);
  std::filesystem::create_directories(folder / "model");
  WriteColmapModel(folder / "model", scene);
  ASSERT_EQ(RunBake(folder), 0) << ReadFile(folder / "log");
  EXPECT_GT(PsnrAgainst(mesh, ReadImage(folder / "texture.png", 3), Smooth), 34);
  EXPECT_THAT(ReadFile(folder / "report.json"), testing::HasSubstr("\"unseen_fraction\""));
  ASSERT_EQ(RunBake(folder, "texture.exr"), 0) << ReadFile(folder / "log");
  EXPECT_EQ(ReadFile(folder / "texture.exr").substr(0, 4), "v/1\x01");
  ASSERT_EQ(RunBake(folder, "texture.tif"), 0) << ReadFile(folder / "log");
  EXPECT_GT(PsnrAgainst(mesh, ReadImage(folder / "texture.tif", 3), Smooth), 34);
  EXPECT_EQ(RunBake(folder, "texture.exr", "--bits 8"), 2);
  scene.views[2].name = "elsewhere.png";
  WriteColmapModel(folder / "model", scene);
  std::filesystem::remove(folder / "texture.png");
  EXPECT_EQ(RunBake(folder), 3);
  EXPECT_THAT(ReadFile(folder / "log"), testing::HasSubstr("elsewhere.png"));
  EXPECT_FALSE(std::filesystem::exists(folder / "texture.png"));
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace keypose::texture

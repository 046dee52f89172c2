// Windows in a slab: the handles through which photographs see stay.
#include "cleanup/repair/see_through.h"

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <map>
#include <set>
#include <tuple>

#include "cleanup/repair/handle_loops.h"
#include "cleanup/repair/handles.h"
#include "cleanup/strategies/cleanup.h"
#include "core/io/meshes/mesh_io.h"
#include "core/io/text/files.h"
#include "core/pictures/render.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/ray_scene.h"
#include "core/surfaces/shapes.h"
#include "core/testing/folder.h"
#include "core/testing/paths.h"
#include "core/testing/shots.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::cleanup::see_through_test {

namespace fs = std::filesystem;
using Cell = std::tuple<int, int, int>;

constexpr int kWide = 21, kHigh = 9,
              kDeep = 2;  // cells of the slab; it stands upright and is seen from the front, -y

/// Cells [x0, x1) x [z0, z1) that are open.
struct Window {
  int x0, x1, z0, z1;
  Eigen::RowVector3d Middle() const { return {(x0 + x1) / 2.0, kDeep / 2.0, (z0 + z1) / 2.0}; }
};
const Window kNarrow = {3, 6, 3, 6}, kBroad = {9, 16, 2, 7}, kThird = {17, 20, 3, 6};

/// The boundary of an upright slab of unit cells with windows, each square in two triangles.
Mesh Slab(const std::vector<Window>& windows) {
  std::set<Cell> cells;
  for (int x = 0; x < kWide; ++x)
    for (int y = 0; y < kDeep; ++y)
      for (int z = 0; z < kHigh; ++z) {
        bool open = false;
        for (const Window& w : windows)
          open = open || (x >= w.x0 && x < w.x1 && z >= w.z0 && z < w.z1);
        if (!open) cells.insert({x, y, z});
      }
  std::map<Cell, int> ids;
  std::vector<Eigen::RowVector3d> points;
  std::vector<Eigen::RowVector3i> faces;
  const auto corner = [&](const Eigen::Vector3i& p) {
    const auto [it, is_new] = ids.try_emplace({p[0], p[1], p[2]}, SizeOf(points));
    if (is_new) points.push_back(p.cast<double>().transpose());
    return it->second;
  };
  for (const auto& [x, y, z] : cells)
    for (int axis = 0; axis < 3; ++axis)
      for (const int side : {0, 1}) {
        Eigen::Vector3i next(x, y, z);
        next[axis] += 2 * side - 1;
        if (cells.contains({next[0], next[1], next[2]})) continue;
        const Eigen::Vector3i base = Eigen::Vector3i(x, y, z) + side * Eigen::Vector3i::Unit(axis),
                              u = Eigen::Vector3i::Unit((axis + 1) % 3),
                              v = Eigen::Vector3i::Unit((axis + 2) % 3);
        const int a = corner(base), b = corner(base + u), c = corner(base + u + v),
                  d = corner(base + v);
        faces.push_back(side ? Eigen::RowVector3i(a, b, c) : Eigen::RowVector3i(a, c, b));
        faces.push_back(side ? Eigen::RowVector3i(a, c, d) : Eigen::RowVector3i(a, d, c));
      }
  Mesh mesh;
  mesh.points.resize(std::ssize(points), 3);
  mesh.faces.resize(std::ssize(faces), 3);
  for (std::size_t i = 0; i < points.size(); ++i) mesh.points.row(i) = points[i];
  for (std::size_t i = 0; i < faces.size(); ++i) mesh.faces.row(i) = faces[i];
  return mesh;
}

MaskShot Photograph(const Mesh& truth, const std::vector<double>& azimuths_deg) {
  std::vector<View> views;
  for (const double azimuth : azimuths_deg) {
    views.push_back(FitView(truth.points, azimuth, 5, 320, 240));
    views.back().name = "IMG_" + std::to_string(1000 + views.size()) + ".png";
  }
  return MasksOf(truth, std::move(views));
}

std::vector<SightLine> LinesOf(const MaskShot& shot) {
  return LinesThroughHoles(shot.views, shot.masks);
}

bool Open(const Mesh& mesh, const Window& window) {
  const RayScene scene(mesh.points, mesh.faces);
  const Eigen::Vector3d middle = window.Middle().transpose();
  return !scene.Occluded(middle - Eigen::Vector3d(0, 50, 0), {0, 1, 0}, 0, 100);
}

TEST(HandlesSeenThrough, CountsTheWindowsThatTheMasksShow) {
  const Mesh both = Slab({kNarrow, kBroad});
  ASSERT_TRUE(CheckClosed(both).closed());
  ASSERT_EQ(Genus(both), 2);
  EXPECT_EQ(HandlesSeenThrough(both, LinesOf(Photograph(both, {-20, 0, 15}))), 2);
  EXPECT_EQ(HandlesSeenThrough(both, LinesOf(Photograph(Slab({kNarrow}), {-20, 0, 15}))), 1);
  EXPECT_EQ(HandlesSeenThrough(both, LinesOf(Photograph(Slab({}), {-20, 0, 15}))), 0);
  const Mesh three = Slab({kNarrow, kBroad, kThird});
  EXPECT_EQ(HandlesSeenThrough(three, LinesOf(Photograph(three, {-20, 0, 15}))), 3);
}

TEST(HandlesSeenThrough, OneViewIsNotBelieved) {
  const Mesh slab = Slab({kNarrow});
  EXPECT_EQ(HandlesSeenThrough(slab, LinesOf(Photograph(slab, {0}))), 0);
  EXPECT_EQ(HandlesSeenThrough(slab, LinesOf(Photograph(slab, {0, 10}))), 1);
}

TEST(HandlesSeenThrough, HolesOfMasksOverASolidSurfaceAreNoHandles) {
  const Mesh closed = Slab({});
  const std::vector<SightLine> lines = LinesOf(Photograph(Slab({kNarrow}), {-10, 0, 10}));
  EXPECT_EQ(HandlesSeenThrough(closed, lines), 0);
  EXPECT_EQ(ViewsWithClosedWindow(closed, lines), (std::vector<int>{0, 1, 2}));
  EXPECT_TRUE(ViewsWithClosedWindow(Slab({kNarrow}), lines).empty());
}

TEST(WithoutHandles, KeepsTheNarrowWindowThatIsSeenAndFillsTheBroadOne) {
  // By loop length alone, the result would be the opposite.
  const Mesh both = Slab({kNarrow, kBroad});
  const Mesh by_length = WithoutHandles(both, 1).mesh;
  EXPECT_FALSE(Open(by_length, kNarrow) && !Open(by_length, kBroad));
  const HandlesResult result =
      WithoutHandles(both, 1, LinesOf(Photograph(Slab({kNarrow}), {-15, 0, 15})));
  EXPECT_EQ(result.cut, 1);
  EXPECT_EQ(Genus(result.mesh), 1);
  EXPECT_TRUE(Open(result.mesh, kNarrow));
  EXPECT_EQ(HandlesSeenThrough(result.mesh, LinesOf(Photograph(Slab({kNarrow}), {-15, 0, 15}))), 1);
}

TEST(MakeClosedManifold, PhotographsDecideWhichHandlesStay) {
  const Mesh both = Slab({kNarrow, kBroad});
  const std::vector<SightLine> lines = LinesOf(Photograph(Slab({kNarrow}), {-15, 0, 15}));
  CleanupOptions options;
  options.faces = 3000;
  const CleanupResult result = MakeClosedManifold(both, options, nullptr, lines);
  EXPECT_EQ(result.genus, 1);
  EXPECT_EQ(result.handles_cut, 1);
  EXPECT_EQ(result.handles_seen_through, 1);
  EXPECT_TRUE(Open(result.mesh, kNarrow));
  const CleanupResult again = MakeClosedManifold(result.mesh, options, nullptr, lines);
  EXPECT_EQ(again.strategy, "as-is");
  EXPECT_EQ(again.mesh.points, result.mesh.points);
  EXPECT_EQ(MakeClosedManifold(both, options).genus, 0);
}

TEST(MakeClosedManifold, GenusForcesTheNumberOfHandles) {
  const Mesh both = Slab({kNarrow, kBroad});
  CleanupOptions options;
  options.faces = 3000;
  for (const int genus : {0, 1, 2}) {
    options.genus = genus;
    EXPECT_EQ(MakeClosedManifold(both, options).genus, genus);
  }
  options.genus = 3;
  EXPECT_THROW(MakeClosedManifold(both, options), InputError);
}

TEST(CleanupProgram, LooksThroughHandlesAndWarnsWithoutPhotographs) {
  const TestingFolder own;
  const fs::path folder = own.path();
  WriteShot(folder, Photograph(Slab({kNarrow}), {-15, 0, 15}));
  WriteMesh(folder / "slab.ply", Slab({kNarrow, kBroad}));
  const std::string at = folder.string();
  const auto run = [&](const std::string& more) {
    const std::string command = BinFolder() + "/keypose-cleanup --surface " + at +
                                "/slab.ply --clean " + at + "/clean.ply --report " + at +
                                "/report.json " + more + " > " + at + "/log 2>&1";
    return WEXITSTATUS(std::system(command.c_str()));
  };
  ASSERT_EQ(run("--images " + at + "/images --model " + at + "/model"), 0)
      << ReadFile(folder / "log");
  const Mesh seen = ReadMesh(folder / "clean.ply");
  EXPECT_EQ(Genus(seen), 1);
  EXPECT_TRUE(Open(seen, kNarrow));
  ASSERT_EQ(run(""), 0);
  EXPECT_EQ(Genus(ReadMesh(folder / "clean.ply")), 0);
  EXPECT_NE(ReadFile(folder / "report.json").find("--genus 2"), std::string::npos)
      << "the warning says how to keep them";
  ASSERT_EQ(run("--genus 2"), 0);
  EXPECT_EQ(Genus(ReadMesh(folder / "clean.ply")), 2);
  EXPECT_EQ(run("--genus 3"), 3);
  EXPECT_EQ(run("--images " + at + "/images"), 2);
}

}  // namespace keypose::cleanup::see_through_test

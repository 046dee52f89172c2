// A tube of 100,000 vertices and 40 bones: weights, and its poses.
#include <benchmark/benchmark.h>

#include <Eigen/Geometry>

#include "armature/skinning/bone_heat.h"
#include "armature/skinning/skin.h"
#include "core/surfaces/shapes.h"

namespace keypose::armature {
namespace {

constexpr int kBones = 40;

Mesh Tube() { return MakeCylinder(0.1, 4, 100, 1000); }

std::vector<SkinBone> BonesOfTube() {
  std::vector<SkinBone> bones;
  for (int b = 0; b < kBones; ++b)
    bones.push_back({"", {0, 0, 4.0 * b / kBones}, {0, 0, 4.0 * (b + 1) / kBones}});
  return bones;
}

void Heat(benchmark::State& state) {
  const Mesh mesh = Tube();
  const auto bones = BonesOfTube();
  for (auto _ : state) benchmark::DoNotOptimize(HeatWeights(mesh, bones));
  state.counters["vertices"] = mesh.vertex_count();
}
BENCHMARK(Heat)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime();

void Pose(benchmark::State& state) {
  const Mesh mesh = Tube();
  const Skin skin(mesh.points, HeatWeights(mesh, BonesOfTube()).weights, kBones);
  std::vector<Rigid3> motions(kBones);
  for (int b = 0; b < kBones; ++b)
    motions[b].rotation = Eigen::AngleAxisd(0.02 * b, Eigen::Vector3d::UnitX());
  PointsX3 points;
  for (auto _ : state) {
    skin.Pose(motions, &points);
    benchmark::DoNotOptimize(points.data());
  }
  state.counters["vertices"] = mesh.vertex_count();
}
BENCHMARK(Pose)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime();

}  // namespace
}  // namespace keypose::armature

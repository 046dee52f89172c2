#include "synth/commands/pair_command.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "core/io/meshes/mesh_io.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"
#include "synth/worlds/clay_pair.h"
#include "synth/worlds/testing/pair_options.h"

namespace keypose::synth::pair_command_test {

using Eigen::Vector3d;

TEST(PairCommand, FilesComeBackAsTheyWereMade) {
  const TestingFolder own;
  const fs::path folder = own.path();
  PairCommand command{folder, Options(120, 8)};
  command.pair.holes = 2;
  RunPair(command);
  const ClayPair pair = MakeClayPair(command.pair);
  const Mesh source = ReadMesh(folder / "source.ply"), target = ReadMesh(folder / "target.ply"),
             truth = ReadMesh(folder / "truth.ply");
  EXPECT_EQ(source.points, pair.source.points);
  EXPECT_EQ(target.points, pair.target.points);
  EXPECT_EQ(target.faces, pair.target.faces);
  EXPECT_EQ(truth.points, pair.truth);
  EXPECT_EQ(truth.faces, source.faces);
  const auto picks = ReadLandmarkPairs(
      {folder / "source_landmarks.json", folder / "target_landmarks.json"}, source, target);
  ASSERT_EQ(picks.size(), 13u);
  EXPECT_LT((PositionOf(picks[4].target, target) - PositionOf(pair.picks[4].target, target)).norm(),
            1e-12);
  // Snapping to a vertex costs at most half an edge.
  for (const LandmarkPair& pick : ReadLandmarkPairs({folder / "landmarks.txt"}, source, target)) {
    int corner = 0;
    pick.source.barycentric.maxCoeff(&corner);
    const Vector3d place = pair.truth.row(source.faces(pick.source.face, corner));
    EXPECT_LT((PositionOf(pick.target, target) - place).norm(), 1.2 * MeanEdge(target));
  }
  command.pair.shape.places = 0;
  RunPair(command);
  EXPECT_FALSE(fs::exists(folder / "landmarks.txt"));
  EXPECT_FALSE(fs::exists(folder / "source_landmarks.json"));
  EXPECT_THROW(RunPair({"/dev/null/x", Options(60)}), DiskError);
}

}  // namespace keypose::synth::pair_command_test

// Real meshes with known correspondence. Skipped without the data.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "core/io/meshes/mesh_io.h"
#include "core/io/project/landmarks_io.h"
#include "core/io/text/files.h"
#include "core/testing/paths.h"
#include "register/landmarks/landmarks.h"
#include "register/nricp/nricp.h"
#include "register/quality/registration_quality.h"

namespace keypose::registration::pairs_test {

class Pairs : public ::testing::TestWithParam<const char*> {};

TEST_P(Pairs, AreFiniteAndLieOnTheTarget) {
  const std::filesystem::path folder = DataFolder() / "pairs" / GetParam();
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not here; set KEYPOSE_DATA";
  const Mesh source = ReadMesh(folder / "source.obj"), target = ReadMesh(folder / "target.obj");
  std::vector<PickedPair> picked;
  for (const LandmarkPair& p : ReadLandmarkPairs({folder / "landmarks.txt"}, source, target))
    if (picked.size() < 12)
      picked.push_back(
          {p.name, p.source.face, p.target.face, p.source.barycentric, p.target.barycentric});
  ASSERT_EQ(picked.size(), 12u);
  const NricpResult result =
      RegisterNricp(source, target, CheckLandmarks(picked, source, target).goals, {}, {});
  EXPECT_TRUE(result.points.allFinite());
  EXPECT_EQ(result.analyses, 1);
  EXPECT_EQ(result.alignment.method, "procrustes");
  const RegistrationQuality q = MeasureRegistration(source, result.points, target);
  EXPECT_LT(q.surface_rms, 0.01);  // measured: 0.004 to 0.006
  EXPECT_LT(q.flipped, source.face_count() / 5);
}

INSTANTIATE_TEST_SUITE_P(Data, Pairs,
                         ::testing::Values("faust_000_008", "horse_to_camel", "wolf_rest_1"));

}  // namespace keypose::registration::pairs_test

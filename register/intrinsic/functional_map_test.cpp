#include "register/intrinsic/functional_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "deform/levels/geodesics.h"
#include "register/intrinsic/spectral.h"
#include "register/testing/limbed_bodies.h"

namespace keypose::registration::functional_map_test {

/// Small integers, so that products are exact and there are many ties.
Eigen::MatrixXf WholeNumbers(Eigen::Index rows, Eigen::Index columns, unsigned seed) {
  Eigen::MatrixXf numbers(rows, columns);
  for (Eigen::Index i = 0; i < numbers.size(); ++i)
    numbers.data()[i] = static_cast<float>((seed = seed * 1664525u + 1013904223u) >> 29);
  return numbers;
}

TEST(NearestRows, AreThoseOfAllDistancesAndTheFirstOfEquals) {
  for (const Eigen::Index rows : {1, 7, 130, 300}) {
    const Eigen::MatrixXf a = WholeNumbers(rows, 3, 1), b = WholeNumbers(260, 3, 2);
    const PointMaps maps = NearestRows(a, b);
    const auto expect_nearest = [](const Eigen::MatrixXf& from, const Eigen::MatrixXf& to,
                                   const std::vector<int>& map) {
      for (Eigen::Index i = 0; i < from.rows(); ++i) {
        Eigen::Index nearest = 0;
        (to.rowwise() - from.row(i)).rowwise().squaredNorm().minCoeff(&nearest);
        ASSERT_EQ(map[i], nearest) << "row " << i << " of " << from.rows();
      }
    };
    expect_nearest(a, b, maps.forward);
    expect_nearest(b, a, maps.backward);
  }
}

TEST(NearestRows, GiveRowsThatExistEvenWhereNothingIsANumber) {
  Eigen::MatrixXf a = WholeNumbers(150, 4, 3), b = WholeNumbers(90, 4, 4);
  a.row(140).setConstant(std::numeric_limits<float>::quiet_NaN());
  b.row(5).setConstant(std::numeric_limits<float>::infinity());
  for (int all = 0; all < 2; ++all) {
    const PointMaps maps = NearestRows(a, b);
    EXPECT_THAT(maps.forward,
                ::testing::Each(::testing::AllOf(::testing::Ge(0), ::testing::Lt(90))));
    EXPECT_THAT(maps.backward,
                ::testing::Each(::testing::AllOf(::testing::Ge(0), ::testing::Lt(150))));
    a.setConstant(std::numeric_limits<float>::quiet_NaN());
  }
}

TEST(RefineMaps, ReturnsToTheIdentityFromACoarseStart) {
  const Mesh body = LimbedBody(kQuadruped, 3);
  const Spectrum spectrum = LaplaceSpectrum(body.points, body.faces, 60);
  const SpectralPoints points{spectrum.functions.cast<float>(), spectrum.areas.cast<float>()};
  const GeodesicGraph graph(body.points, body.faces);
  const std::vector<int> seeds = graph.FarthestPoints(60);
  std::vector<int> nearest;
  graph.From(seeds, &nearest);
  PointMaps start;
  for (const int s : nearest) start.forward.push_back(seeds[s]);
  start.backward = start.forward;
  const PointMaps refined = RefineMaps(points, points, start, {10, 15, 20, 30, 40, 50, 60});
  int exact = 0;
  for (std::size_t v = 0; v < refined.forward.size(); ++v)
    exact += refined.forward[v] == static_cast<int>(v);
  EXPECT_GT(exact, 0.95 * static_cast<double>(refined.forward.size()));
}

}  // namespace keypose::registration::functional_map_test

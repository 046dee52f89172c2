#include "interpolate/surface/paper_arap.h"

#include <gtest/gtest.h>

#include "interpolate/surface/arap.h"
#include "interpolate/surface/testing/bent_sheets.h"

namespace keypose::interpolation::paper_arap_test {

TEST(Arap, ReducedSystemEqualsThePapersTetrahedra) {
  const Keys keys;
  const ArapInterpolator reduced(keys.mesh.points, keys.u, keys.mesh.faces, PaperOptions());
  const PaperInterpolator paper(keys.mesh.points, keys.u, keys.mesh.faces);
  for (double t : {0.0, 0.1, 0.5, 0.8, 1.0}) EXPECT_LT(Gap(reduced.At(t), paper.At(t)), 1e-9);
}

}  // namespace keypose::interpolation::paper_arap_test

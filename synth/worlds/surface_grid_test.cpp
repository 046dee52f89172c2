#include "synth/worlds/surface_grid.h"

#include <gtest/gtest.h>

#include "core/values/errors.h"
#include "synth/worlds/limbed_shapes.h"

namespace keypose::synth::surface_grid_test {

TEST(Tessellate, TooFewVerticesThrowInputError) {
  LimbedShapeOptions options;
  const LimbedShape thing = MakeLimbedShape(options);
  EXPECT_THROW(Tessellate(PosedSurface(thing.clay, thing.pose, 0.004), 20, 1), InputError);
}

}  // namespace keypose::synth::surface_grid_test

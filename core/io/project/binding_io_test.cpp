#include "core/io/project/binding_io.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/surfaces/shapes.h"
#include "core/values/errors.h"

namespace keypose::binding_io_test {

TEST(BindingFrom, PointsFarOutsideOfTheMeshAreAnInputError) {
  nlohmann::json binding = BindingJson<nlohmann::json>(BindTo(MakeIcosphere(2)));
  EXPECT_NO_THROW(BindingFrom(binding, "picks.json"));
  binding["shape"][0] = "237772 0 0 0 0 1";
  EXPECT_THROW(BindingFrom(binding, "picks.json"), InputError);
}

}  // namespace keypose::binding_io_test

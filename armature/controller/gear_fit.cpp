#include "armature/controller/gear_fit.h"

#include <fmt/format.h>

#include <cmath>

#include "core/values/errors.h"

namespace keypose::armature {

GearFit FitGear(const std::vector<KnownAngle>& known) {
  double mean_value = 0, mean_read = 0;
  const auto count = static_cast<double>(known.size());
  for (const KnownAngle& angle : known) {
    mean_value += angle.value / count;
    mean_read += angle.read / count;
  }
  double both = 0, square = 0;
  for (const KnownAngle& angle : known) {
    both += (angle.value - mean_value) * (angle.read - mean_read);
    square += (angle.value - mean_value) * (angle.value - mean_value);
  }
  if (known.size() < 2 || !(square > 1e-12))
    throw InputError("two different known angles are needed at least; the zero position is one");
  GearFit fit;
  fit.gear = both / square;
  if (!(fit.gear > 0.5 && fit.gear < 1.5))
    throw InputError(
        fmt::format("what was read is {:.3g} times what is known: the scale in the "
                    "description is wrong, or its sign",
                    fit.gear));
  fit.offset = mean_read - fit.gear * mean_value;
  double sum = 0;
  for (const KnownAngle& angle : known) {
    const double left = angle.read - fit.gear * angle.value - fit.offset;
    sum += left * left / count;
  }
  fit.residual = std::sqrt(sum);
  return fit;
}

}  // namespace keypose::armature
